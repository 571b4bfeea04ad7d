"""Lines taken at once are the same moves as one by one, whatever is around them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.gcode.canon import Canonical, LineMove
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.line_run import LineRun, read_points
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.offsets import ZeroShift
from achse.gcode.text.program import PartProgram
from tests.gcode.programs import with_tool

NUMBERS = st.sampled_from(["0", "1", "-2.5", "+.25", "10.", "3.14159", "007", "-0", "99999999999"])
WORDS = st.tuples(st.sampled_from("XYZ"), NUMBERS)
POINTS = st.lists(WORDS, min_size=1, max_size=3, unique_by=lambda each: each[0]).map(
    lambda words: " ".join(letter + number for letter, number in words)
)
LINES = st.one_of(
    POINTS,
    POINTS,
    st.tuples(st.integers(1, 99), POINTS).map(lambda parts: f"N{parts[0]}{parts[1]}"),
    POINTS.map(lambda text: f"{text} (note)"),
    POINTS.map(lambda text: f"/1 {text}"),
    st.tuples(st.sampled_from(["G0", "G1", "G2 B50", "G1 F100", "G9", "DelDTG"]), POINTS).map(
        " ".join
    ),
    st.sampled_from(
        [
            *("", " ", "N5", "(only words)", "G90", "G91", "G60", "G08", "G70", "G71", "F500"),
            *("G54", "G53", "G58 X1 Y2", "ROT Z30", "ROT", "FLIN", "FCONST", "D1", "D0", "M7"),
            *("R1=R1+1", "X=R1", "@100 K+9", "#set paramVeloMin(3)#", "Mirror X", "Mirror", "L3"),
            *("X 1 Y 2", "x3", "X1e5", "X--1", "X1 X2", "G41 D1 X5", "G40 X9", "M30", "S900"),
        ]
    ),
)


def _all(text: str, data: MachineData, at_once: int) -> tuple[list[Canonical], str, object]:
    """Commands, the error, the modal words: with runs of lines, or without (0)."""
    interpreter = Interpreter(PartProgram(text, "part.nc"), data)
    results: list[Canonical] = []
    error = ""
    try:
        while interpreter.blocks < 300:
            run = interpreter.lines(at_once) if at_once else None
            if run is not None:
                assert 1 <= len(run) <= at_once
                results.extend(run.moves())
                continue
            command = interpreter.advance(1)
            if command is not None:
                results.append(command)
            elif interpreter.state is RunState.DECODER_STOP:
                interpreter.go_ahead()
            elif interpreter.state is not RunState.RUNNING:
                break
    except GcodeError as refused:
        error = str(refused)
    path = interpreter.path
    end = path.axes, path.work, path.programmed, interpreter.origin, interpreter.blocks
    return results, error, (end, interpreter.modal)


@given(st.lists(LINES, min_size=1, max_size=30), st.integers(1, 20), st.booleans())
def test_runs_are_the_moves_that_single_blocks_make(
    lines: list[str], at_once: int, tool: bool
) -> None:
    text = "\n".join(["G1 F600", *lines])

    def data() -> MachineData:
        result = with_tool() if tool else MachineData()
        result.skip_mask = 2
        return result

    alone = _all(text, data(), 0)
    together = _all(text, data(), at_once)
    assert together == alone


def test_long_lists_of_points_are_runs() -> None:
    text = "F600\n" + "\n".join(f"N{n} X{n}.5 Z-{n}" for n in range(1, 100)) + "\nM30"
    interpreter = Interpreter(PartProgram(text, "part.nc"))
    assert interpreter.lines(50) is None, "zero shifts are not looked at yet"
    first = interpreter.advance()
    assert isinstance(first, LineMove)
    run = interpreter.lines(40)
    assert isinstance(run, LineRun)
    assert (len(run), run.ends[-1], run.velocity) == (40, (41.5, 0.0, -41.0), 10.0)
    assert (run.origin(0).block, run.origin(0).line, run.origin(0).counter) == (2, 3, 3)
    assert run.origin(39).block == 41
    assert text[run.origin(7).index :].startswith("N9 ")
    rest = interpreter.lines(1000)
    assert rest is not None
    assert len(rest) == 58
    assert interpreter.lines(1000) is None


def test_shifts_that_change_meanwhile_count() -> None:
    data = MachineData()
    text = "G54\nG1 F600 X1\nX2\nX3\nX4"
    interpreter = Interpreter(PartProgram(text), data)
    interpreter.advance()
    interpreter.advance()
    assert interpreter.lines(1) is not None
    data.shifts[ZeroShift.G54_FINE, 0] = 10.0
    assert interpreter.lines(1) is None
    move = interpreter.advance()
    assert isinstance(move, LineMove)
    assert move.end == (14.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("line", "known"),
    [
        ("X1", True),
        ("N10 X1 Y-.5Z+3.", True),
        ("  X 1   Z2 ", True),
        ("X", False),
        ("Y1 X1", False),
        ("N10", False),
        ("", False),
        ("X1 F5", False),
        ("/ X1", False),
        ("X1.2.3", False),
        ("X9999999999999", False),
    ],
)
def test_only_plain_lines_are_points(line: str, known: bool) -> None:
    assert bool(read_points([line], (0.0, 0.0, 0.0), False, 1e12)) is known


def test_a_point_beyond_the_limit_ends_the_run() -> None:
    points = read_points(["X6", "X6", "X1"], (0.0, 0.0, 0.0), True, 10.0)
    assert points == [(6.0, 0.0, 0.0)]
