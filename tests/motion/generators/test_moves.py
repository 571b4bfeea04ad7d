"""Moves: one cycle along the table, with what runs on top."""

from typing import Any

import pytest

from achse.motion import MotionPhase, commands
from achse.motion.generators import moves


def test_a_step_goes_on_along_the_table(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, 50.0)
    rig.seconds(1.0)
    p, v = rig.axis.set_position, rig.axis.set_velocity
    moves.step(rig.axis, rig.dt)
    assert rig.axis.set_position == pytest.approx(p + v * rig.dt)


def test_a_compensation_runs_on_top(rig: Any) -> None:
    commands.start(rig.axis, 1, 500.0, 50.0)
    rig.seconds(1.0)
    compensation = commands.Compensation(1, 100.0, 100.0, 10.0, 50.0, 10.0, 200.0)
    assert commands.start_superposition(rig.axis, compensation)[0] == 0
    for _ in range(100):
        moves.step(rig.axis, rig.dt)
    assert rig.axis.set_velocity > 50.0


def test_reversing_is_a_move_until_its_target(rig: Any) -> None:
    assert commands.start_reversing(rig.axis, 1, 1.0, -1.0, 50.0, 0.5) == 0
    for _ in range(2000):
        moves.step(rig.axis, rig.dt)
        if rig.axis.set_motion_phase == MotionPhase.REVERSING:
            break
    assert rig.axis.set_position == 1.0
