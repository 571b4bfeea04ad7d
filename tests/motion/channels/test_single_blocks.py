"""Single blocks, by the channel (function 0x05) and by its 3D group (0x3000:6): each stays on
until it is written again."""

from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.motion.channels.states import InterpreterState as State
from achse.motion.channels.states import ProgramMode
from tests.motion.channels.conftest import ProgramRig, drawn_dynamics


def _rests(rig: Any, most: int = 9) -> list[float]:
    """X at each single stop, up to the end of the program."""
    rests = []
    for _ in range(most):
        rig.until(lambda: rig.channel.state in (State.SINGLE_STOP, State.READY))
        if rig.channel.state is State.READY:
            break
        rig.until(lambda: rig.group.stands)
        rests.append(rig.at()[0])
        assert rig.channel.start() == 0
        rig.cycle(2)
    assert rig.channel.state is State.READY
    return rests


@pytest.mark.parametrize("mode", [ProgramMode.DEFAULT, ProgramMode.SINGLE_BLOCK])
def test_single_block_of_the_group_outlasts_starts(program: Any, mode: ProgramMode) -> None:
    program.group.single_block_mode = 1
    assert program.channel.set_operation_mode(mode) == 0
    for ends in ("123", "987"):
        assert program.run("G01 F6000\n" + "".join(f"X{x}\n" for x in ends) + "M30\n") == 0
        assert _rests(program) == [float(x) for x in ends[:-1]]
        assert program.group.single_block_mode == 1
        assert program.channel.set_operation_mode(0) == 0
    program.channel.reset()
    program.cycle(3)
    assert program.group.single_block_mode == 1
    program.group.single_block_mode = 0
    program.run("G01 F6000\nX1\nX2\nM30\n")
    program.finish()


@pytest.mark.parametrize("by_group", [True, False])
def test_switching_single_block_off_starts_no_axis(program: Any, by_group: bool) -> None:
    """It waits for the start; then it runs to the end."""
    program.group.single_block_mode = int(by_group)
    program.channel.set_operation_mode(int(not by_group))
    program.run("G01 X5 F6000\nX10\nX15\nM30\n")
    program.until_state(State.SINGLE_STOP)
    program.group.single_block_mode = 0
    program.channel.set_operation_mode(0)
    program.cycle(300)
    assert (program.at()[0], program.channel.state) == (5.0, State.SINGLE_STOP)
    assert program.channel.start() == 0
    program.finish()
    assert program.at()[0] == 15.0


def _stops(rig: ProgramRig, draw: Random) -> None:
    """One program with drawn blocks, from wherever the axes are; it stops where it must."""
    x, text, ends = rig.at()[0], ["G90 G01 F6000"], []
    for _ in range(draw.randint(1, 5)):
        x = round(x + draw.choice((-1, 1)) * draw.uniform(0.01, 3.0), 3)
        text.append(f"X{x} F{draw.choice((60, 600, 6000, 60_000)):.0f}")
        ends.append(x)
        text += [draw.choice(("R1=R1+1", "M9", "#set paramC2ReductionFactor(1)#"))] * draw.randint(
            0, 2
        )
    assert rig.run("\n".join([*text, "M30"])) == 0
    expected = ends[:-1] if rig.group.single_block_mode or rig.channel.operation_mode == 1 else []
    if draw.random() < 0.3:
        rig.cycle(draw.randint(1, 40))
        rig.channel.stop()
        rig.until_state(State.IDLE)
        rig.channel.reset()
        rig.cycle(3)
    else:
        assert _rests(rig) == expected


@settings(max_examples=6)
@given(st.integers(0, 2**32 - 1))
def test_single_blocks_stay_as_they_were_written(seed: int) -> None:
    """Switches, programs, dynamics, overrides, stops and resets in any order."""
    draw = Random(seed)
    with TemporaryDirectory() as folder:
        rig = ProgramRig(
            Path(folder),
            **drawn_dynamics(draw),
        )
        rig.group.max_commands_per_cycle = draw.choice((1, 2, 20))
        group, channel = rig.group.single_block_mode, rig.channel.operation_mode
        for _ in range(draw.randint(2, 6)):
            if draw.random() < 0.5:
                group = rig.group.single_block_mode = draw.choice((0, 1))
            if draw.random() < 0.5:
                channel = draw.choice((ProgramMode.DEFAULT, ProgramMode.SINGLE_BLOCK))
                assert rig.channel.set_operation_mode(channel) == 0
            rig.channel.override = draw.choice((300_000, 1_000_000))
            _stops(rig, draw)
            assert (rig.group.single_block_mode, rig.channel.operation_mode) == (group, channel)
