"""The interpreter as a channel uses it: stops, budgets, skips, the default program."""

from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.canon import (
    ArcMove,
    DecoderStop,
    HomeAxis,
    LineMove,
    ProgramEnd,
    ProgramStop,
    StopKind,
)
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.text.program import PartProgram
from achse.gcode.vectors import turned
from tests.gcode.programs import ends, refused


def start(text: str, data: MachineData | None = None) -> Interpreter:
    return Interpreter(PartProgram(text, "part.nc"), data)


def test_a_decoder_stop_waits() -> None:
    data = MachineData()
    run = start("R1=5\n@714\nX=R1 F600\nM30", data)
    (stop,) = list(run)
    assert isinstance(stop, DecoderStop)
    assert stop.kind is StopKind.EMPTY
    assert run.state is RunState.DECODER_STOP
    assert run.advance() is None
    data.registers[1] = 7.0
    run.go_ahead()
    move = run.advance()
    assert isinstance(move, LineMove)
    assert move.end == (7.0, 0.0, 0.0)
    list(run)
    assert run.state is RunState.ENDED
    with pytest.raises(RuntimeError):
        run.go_ahead()


def test_positions_are_read_again() -> None:
    run = start("X10 F600\n@716\nG91 X1\n#get PathAxesPos(R1;R2;R3)#\nX=R2\n@717\nM30")
    list(run)
    with pytest.raises(ValueError, match="positions"):
        run.go_ahead()
    run.go_ahead((3.0, 4.0, 5.0), (9.0, 0.0, 0.0, 0.0, 0.0))
    move, stop = list(run)
    assert isinstance(move, LineMove)
    assert (move.start, move.end) == ((3.0, 4.0, 5.0), (4.0, 4.0, 5.0))
    assert move.auxiliary[0] == 9.0
    assert isinstance(stop, DecoderStop)
    assert stop.kind is StopKind.READ_POSITIONS
    run.go_ahead((4.0, 4.5, 5.0))
    assert run.data.registers.own[1:4] == [4.0, 4.5, 5.0]
    *_, external = list(run)
    assert isinstance(external, DecoderStop)
    assert external.kind is StopKind.EXTERNAL


def test_homing_is_followed_by_new_positions() -> None:
    home, stop = list(start("G74 Y"))
    assert isinstance(home, HomeAxis)
    assert home.axis == 1
    assert isinstance(stop, DecoderStop)
    assert stop.kind is StopKind.RESCAN
    assert refused("G74 X Y").word == "G74"


def test_an_endless_loop_blocks_no_other() -> None:
    run = start("N10 R1=R1+1\n@100 K-10")
    for calls in range(1, 6):
        assert run.advance(blocks=10) is None
        assert run.state is RunState.RUNNING
        assert run.blocks == 10 * calls


def test_an_error_comes_once_behind_the_commands_before_it() -> None:
    run = start("X1 F600\nX2 FOO")
    assert isinstance(run.advance(), LineMove)
    with pytest.raises(GcodeError) as error:
        run.advance()
    assert (error.value.index, error.value.line) == (8, 2)
    assert run.state is RunState.FAILED
    assert run.advance() is None


def test_single_block_in_the_interpreter() -> None:
    run = start("G90\nX1 F600\nX2\nM30", MachineData(single_block=True))
    assert [type(each) for each in run] == [LineMove, ProgramStop]
    assert run.state is RunState.SINGLE_STOP
    run.go_ahead()
    assert [type(each) for each in run] == [LineMove, ProgramStop]
    run.go_ahead()
    assert isinstance(list(run)[-1], ProgramEnd)


def test_blocks_are_skipped_by_mask() -> None:
    text = "F600\n/ X1\n/3 X2\nX3"
    assert ends(text) == [(1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (3.0, 0.0, 0.0)]
    assert ends(text, MachineData(skip_mask=0b1000)) == [(1.0, 0.0, 0.0), (3.0, 0.0, 0.0)]
    assert ends(text, MachineData(skip_mask=0b1001)) == [(3.0, 0.0, 0.0)]


def test_the_default_program_leaves_its_modal_words() -> None:
    default = PartProgram("G91 F1200\nM30", "DefaultGCode1.def")
    run = Interpreter(PartProgram("X1\nX1\nM30"), default_program=default)
    results = [each for each in run if isinstance(each, LineMove)]
    assert [move.end[0] for move in results] == [1.0, 2.0]
    assert results[0].velocity == 20.0
    for end in ("", "M17", "M02"):
        default = PartProgram(f"G91 F1200\n{end}")
        run = Interpreter(PartProgram("X1\nX1"), default_program=default)
        assert len([each for each in run if isinstance(each, LineMove)]) == 2


def test_a_program_starts_where_the_axes_are() -> None:
    run = Interpreter(PartProgram("G91 X1 F600"), positions=(5.0, 6.0, 7.0))
    move = run.advance()
    assert isinstance(move, LineMove)
    assert (move.start, move.end) == ((5.0, 6.0, 7.0), (6.0, 6.0, 7.0))


NUMBERS = st.floats(-500.0, 500.0).map(lambda value: f"{value:.3f}")
WORDS_AS_THEY_ARE = """
G0 G1 G2 G3 G17 G18 G19 G90 G91 G60 G09 G70 G71 CIP FLIN CFIN G41 G42 G40 D1 D2 M30 M7 M17 L1 L2
X Y Z CDON ROT MIRROR G54 G58 G53 @714 @100 @620 G04
"""
WORDS = st.one_of(
    st.sampled_from(WORDS_AS_THEY_ARE.split()),
    st.builds("{}{}".format, st.sampled_from("XYZIJKBUFSTHDP"), NUMBERS),
    st.builds("{}=R{}+{}".format, st.sampled_from("XYZIJB"), st.integers(0, 9), NUMBERS),
    st.builds("R{}={}*R{}".format, st.integers(0, 9), NUMBERS, st.integers(0, 9)),
    st.builds("N{}".format, st.integers(0, 5)),
    st.builds("K{}{}".format, st.sampled_from(("", "+", "-")), st.integers(0, 5)),
    st.builds("@{} R{} K{}".format, st.integers(100, 165), st.integers(0, 9), st.integers(0, 5)),
)
LINES = st.lists(WORDS, min_size=1, max_size=5).map(" ".join)


@given(st.lists(LINES, min_size=1, max_size=25).map("\n".join), st.integers(0, 65535))
def test_any_program_runs_ends_or_fails_with_its_place(text: str, mask: int) -> None:
    """Arcs close to 1e-9, moves join, nothing hangs, nothing but GcodeError comes out."""
    data = MachineData(skip_mask=mask)
    data.tools[1][1], data.tools[1][4] = 20.0, 1.5
    text = "F600\n" + text
    run = start(text, data)
    at = (0.0, 0.0, 0.0)
    try:
        for _ in range(300):
            command = run.advance(blocks=20)
            if isinstance(command, LineMove | ArcMove):
                assert command.start == at
                at = command.end
                assert len(command.auxiliary) == 5
            if isinstance(command, ArcMove):
                assert hypot(*command.normal) == pytest.approx(1.0)
                assert 0.0 < command.angle < 6.2832
                scale = max(1.0, command.radius, *map(abs, command.end))
                end = turned(
                    command.start, command.centre, command.normal, command.angle, command.rise
                )
                assert end == pytest.approx(command.end, abs=1e-9 * scale)
            if command is None:
                if run.state is RunState.DECODER_STOP:
                    run.go_ahead(at)
                elif run.state is not RunState.RUNNING:
                    break
    except GcodeError as error:
        failed = error
    else:
        return
    assert 1 <= failed.line <= text.count("\n") + 1
    assert failed.column >= 1
    assert failed.code in NcError
