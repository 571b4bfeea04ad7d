"""Changes of the running move: what they need and what they do."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import StateBit, commands

V = 200.0


def test_changes_need_a_running_move(rig: Any) -> None:
    rig.refuses(NcError.GROUP_BUSY, commands.new_end_position, 1, 50.0)
    rig.refuses(NcError.NO_MOTION, commands.new_dynamics, 1.0, 1.0, 1.0)


def test_switch_positions_lie_on_the_way(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.seconds(0.5)
    change = commands.new_end_position_and_velocity
    beside = NcError.ACTIVATION_POSITION_NOT_ON_WAY
    rig.refuses(beside, change, 10, 0, 0.0, 10.0, -5.0)
    rig.refuses(beside, change, 10, 0, 0.0, 10.0, 105.0)
    rig.refuses(NcError.JOB_START_TYPE, change, 9, 3, 0.0, 0.0, 90.0)
    rig.refuses(NcError.JOB_TYPE, change, 4, 1, 0.0, 0.0, 90.0)
    rig.refuses(NcError.JOB_START_TYPE, change, 1, 9, 0.0, 0.0, 90.0)
    rig.refuses(NcError.SET_VELOCITY_NOT_ALLOWED, change, 2, 0, 0.0, 0.0, 0.0)


def test_a_move_becomes_endless_and_positioned_again(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.run(100)
    assert commands.new_end_position(rig.axis, 3, 0.0) == 0
    rig.seconds(2.0)
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert commands.new_end_position(rig.axis, 1, 1000.0) == 0
    rig.until_rest()
    assert rig.axis.set_position == 1000.0


def test_new_dynamics_act_on_the_running_move(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    assert commands.new_dynamics(rig.axis, 500.0, 100.0, 1000.0) == 0
    commands.stop(rig.axis)
    distance, time = commands.stop_information(rig.axis, 0.0, 0.0)
    assert time == pytest.approx(V / 100.0 + 100.0 / 1000.0)
    assert distance == pytest.approx(V * time / 2.0)


def test_a_frozen_override_is_that_of_now(rig: Any) -> None:
    commands.start(rig.axis, 1, 400.0, V)
    rig.seconds(1.0)
    rig.axis.velocity_override = 400_000
    assert commands.freeze_override(rig.axis) == 0
    rig.until(lambda axis: axis.set_velocity == pytest.approx(0.4 * V))
    rig.seconds(0.5)
    assert rig.axis.set_velocity == pytest.approx(0.4 * V)
    rig.axis.velocity_override = 1_000_000
    rig.until(lambda axis: axis.set_velocity == pytest.approx(V))
    rig.until_rest()
    assert rig.axis.set_position == 400.0


def test_a_frozen_override_does_not_disturb_braking(rig: Any) -> None:
    commands.start(rig.axis, 1, 400.0, V)
    rig.until(lambda axis: axis.set_acceleration < 0.0)
    rig.run(20)
    rig.axis.velocity_override = 100_000
    commands.freeze_override(rig.axis)
    rig.until_rest()
    assert rig.axis.set_position == pytest.approx(400.0, abs=1e-9)
    assert commands.freeze_override(rig.axis) == 0
