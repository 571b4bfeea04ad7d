"""Blocks that cannot be run: moves before them are made, then the program fails at their begin."""

import logging
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.gcode.canon import Origin
from achse.gcode.state.tool_table import ToolParameter, ToolType
from achse.motion import commands
from achse.motion.channels.program_fault import PlaceKind, ProgramFault, named_block
from achse.motion.channels.states import InterpreterState as State
from tests.motion.channels.conftest import ProgramRig, drawn_dynamics

HERE = Origin("part.nc", 3, 20, 30, 4)


def test_a_fault_names_its_block_and_where_it_resumes() -> None:
    fault = ProgramFault(0x4110, HERE, HERE, (1.0, 2.0, 3.0))
    assert str(fault).startswith("part.nc:3 (N30): error: 0x4110")
    assert (fault.resumes_at(skip=False), fault.resumes_at(skip=True)) == (4, 5)
    before = ProgramFault(0x4110, HERE, Origin("part.nc", 1, 0, 10, 2), (1.0,))
    assert before.resumes_at(skip=False) == before.resumes_at(skip=True) == 2
    assert fault.registers_of_retry((7.0, 8.0, 9.0), (1.0, 5.0, 3.0)) == [7.0, 5.0, 9.0]
    assert named_block(Origin("", 1, 0, 0, 1)) == "program:1"


def test_moves_before_a_faulty_block_are_made(program: Any, caplog: Any) -> None:
    """The error comes when the axes are at its begin, with block, line and position."""
    channel = program.channel
    assert program.run("N10 G1 X10 F6000\nN20 Y10\nN30 [Z\nM30") == 0
    program.until(lambda: program.at()[0] > 1.0)
    assert (channel.state, channel.error_code) == (State.WAITING, 0)
    with caplog.at_level(logging.INFO, "achse.channel"):
        program.until_state(State.ABORTED)
    assert program.at() == [10.0, 10.0, 0.0]
    place = channel.place
    assert (place.kind, place.origin.line, place.origin.block) == (PlaceKind.FAULT, 3, 30)
    assert place.position == pytest.approx((10.0, 10.0, 0.0))
    assert channel.block_number == 30
    assert "part.nc:3 (N30): axes at rest at X10.000 Y10.000 Z0.000" in caplog.text


def test_a_retry_away_from_its_block_names_the_place(program: Any, caplog: Any) -> None:
    channel, axis = program.channel, program.nc.axis(1)
    assert program.run("N10 G1 X50 F6000\nN20 X100\nM30") == 0
    program.until(lambda: program.at()[0] > 60.0)
    commands.set_external_error(axis, 0x4650)
    program.until_state(State.ABORTED)
    assert channel.place.origin.block == 20
    assert program.group.reset() == 0
    program.until(lambda: channel.retry() == 0, 5.0)
    program.until(lambda: channel.search_result is not None)
    program.cycle(3)
    place = channel.place
    assert channel.state is State.SEARCHING
    assert (place.kind, place.origin.line, channel.block_number) == (PlaceKind.FOUND, 2, 20)
    assert place.position == (50.0, 0.0, 0.0)
    assert "waiting at part.nc:2 (N20) (0x4171): expected axes at X50.000" in caplog.text


@pytest.mark.parametrize("skip", [False, True])
def test_moves_that_compensation_holds_back_are_made_by_the_retry(program: Any, skip: bool) -> None:
    """Where a held move ends depends on the block at fault, so a retry begins with that move."""
    channel = program.channel
    tool = channel.data.tools[1]
    tool[ToolParameter.TYPE], tool[ToolParameter.RADIUS] = ToolType.END_MILL, 2.0
    text = "N10 G42 G1 X10 F6000 D1\nN20 X30\nN30 X=R1 Y20 F=R2\nN40 X0\nN50 G40 Y40\nM30"
    assert program.run(text) == 0
    program.until_state(State.ABORTED)
    assert channel.place.origin.block == 30
    stopped = program.at()
    channel.data.registers[1], channel.data.registers[2] = 30.0, 3000.0
    assert (channel.skip() if skip else channel.retry()) == 0
    least = program.at()[0]
    while channel.state is not State.READY:
        assert channel.state is not State.ABORTED
        program.cycle()
        least = max(least, program.at()[0])
    assert stopped[0] < 30.0 < least


FAULTS = ("[X", "G99", "G2 X{x} B0.001", "G1 X1000", "M200", "L77", "F=R1 X{x}")


def _part(draw: Random) -> tuple[list[str], list[tuple[float, float]]]:
    """Blocks in X and Y, one more for each end, and these ends."""
    lines, ends = [], [(0.0, 0.0)]
    for number in range(1, draw.randint(2, 7)):
        x, y = round(draw.uniform(-20, 20), 3), round(draw.uniform(-20, 20), 3)
        kind = draw.choice(("G0", "G1", "G1", "G1 G9"))
        lines.append(f"N{10 * number} {kind} X{x} Y{y} F{draw.choice((600, 6000, 60_000))}")
        ends.append((x, y))
        if draw.random() < 0.4:
            lines.append(draw.choice(("R3=R3+1", "M7", "G4 X0.02", "@714", "H3 S4")))
    return lines, ends


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1))
def test_a_faulty_block_anywhere_is_left_at_its_begin(seed: int) -> None:
    """Blocks, fault, dynamics, smoothing, table, single blocks, overrides and stops are drawn."""
    draw = Random(seed)
    with TemporaryDirectory() as folder:
        rig = ProgramRig(
            Path(folder),
            **drawn_dynamics(draw),
            encoder_soft_limit_max=500.0,
            encoder_soft_limit_max_enable=1,
        )
        channel, group = rig.channel, rig.group
        group.max_commands_per_cycle = draw.choice((1, 2, 20))
        group.single_block_mode = draw.choice((0, 0, 1))
        before, ends = _part(draw)
        fault = draw.choice(FAULTS).format(x=ends[-1][0] + 9.0)
        smoothing = f"#set paramVertexSmoothing({draw.randint(2, 5)};1;{draw.uniform(0.1, 3):.2f})#"
        lines = [smoothing] * draw.randint(0, 1) + ["G1 F6000", *before, f"N900 {fault}"]
        assert rig.run("\n".join([*lines, "N910 G1 Y3 F6000", "M30"])) == 0
        for _ in range(20_000):
            if channel.state is State.ABORTED:
                break
            if channel.state is State.SINGLE_STOP and group.stands:
                assert channel.start() == 0
            if draw.random() < 0.01:
                channel.override = draw.choice((200_000, 1_000_000))
                group.emergency_stop(draw.choice((0.0, 1e4)), draw.choice((0.0, 1e5)))
            elif group.emergency_stop_active and group.stands:
                group.step_on()
            rig.cycle()
        assert channel.state is State.ABORTED
        assert rig.at()[:2] == pytest.approx(list(ends[-1]), abs=1e-6)
        place = channel.place
        assert place is not None
        assert (place.origin.line, place.origin.block) == (len(lines), 900)
        assert channel.error_code
        group.single_block_mode = 0
        group.step_on()
        channel.override = 1_000_000
        assert channel.skip() == 0
        rig.finish()
        assert rig.at()[:2] == pytest.approx([ends[-1][0], 3.0], abs=1e-6)


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1))
def test_skipped_blocks_stay_skipped_until_the_next_start(seed: int) -> None:
    """Faults between drawn moves, some twice in a subroutine, retries before skips are drawn."""
    draw = Random(seed)
    with TemporaryDirectory() as folder:
        rig: Any = ProgramRig(
            Path(folder), encoder_soft_limit_max=500.0, encoder_soft_limit_max_enable=1
        )
        channel, lines, faulty = rig.channel, ["G1 F60000"], []
        rig.write("N1 R4=R4+1\nN2 [X\nN3 G1 Z=R4\nM17", "L5.nc")
        x = 0.0
        for number in range(10, 10 * draw.randint(3, 6), 10):
            kind, x = draw.choice(("[X", "G99", "G1 X1000", "L5 P2")), round(draw.uniform(1, 9), 2)
            lines += [f"N{number} {kind}", f"N{number + 1} X{x} F60000"]
            faulty += [2, 2] if kind == "L5 P2" else [number]
        text = "\n".join([*lines, "M30"])
        assert rig.run(text) == 0

        def stopped_block() -> int:
            rig.until_state(State.ABORTED)
            assert channel.place is not None
            block: int = channel.place.origin.block
            return block

        for block in faulty:
            for _ in range(draw.randint(0, 1)):
                assert (stopped_block(), channel.retry()) == (block, 0)
            assert (stopped_block(), channel.skip()) == (block, 0)
        rig.finish()
        assert rig.at() == [x, 0.0, float(faulty.count(2))]
        assert rig.run(text) == 0
        assert stopped_block() == faulty[0]
