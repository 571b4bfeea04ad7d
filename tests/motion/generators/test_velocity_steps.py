"""Velocity steps: jumps and pauses."""

from typing import Any

import pytest

from achse.motion import CommandState, MotionPhase, StateBit, commands

A, J, V = 1500.0, 15_000.0, 200.0
DYNAMICS = {"default_acceleration": A, "default_deceleration": A, "default_jerk": J}


def cycles(seconds: float, dt: float) -> int:
    return round(seconds / dt)


def test_velocity_steps_jump_and_pause(rig: Any) -> None:
    axis = rig.axis
    axis.controller.following_error_position_monitoring_enable = 0
    assert commands.start_velocity_steps(axis, 1, 80.0, -50.0, 0.1, 0.05, 2) == 0
    sequence = [80.0] * 50 + [0.0] * 25 + [-50.0] * 50 + [0.0] * 25
    position = axis.set_position
    for velocity in sequence * 2:
        rig.run(1)
        position += velocity * rig.dt
        assert axis.set_velocity == velocity
        assert axis.set_acceleration == 0.0
        assert axis.set_position == pytest.approx(position, abs=1e-9)
        assert rig.has(StateBit.HAS_JOB)
        assert rig.has(StateBit.CONTINUOUS_MOTION)
        assert rig.has(StateBit.POSITIVE_DIRECTION) == (velocity > 0.0)
        assert rig.has(StateBit.NEGATIVE_DIRECTION) == (velocity < 0.0)
    rig.run(1)
    assert rig.has(StateBit.NOT_MOVING)
    assert axis.set_command_state == CommandState.DONE
    assert axis.set_position == pytest.approx(2 * (80.0 - 50.0) * 0.1)
    rig.seconds(1.0)
    assert rig.has(StateBit.IN_TARGET_POSITION)


def test_velocity_steps_without_pause_or_end(rig: Any) -> None:
    rig.axis.controller.following_error_position_monitoring_enable = 0
    commands.start_velocity_steps(rig.axis, 1, 80.0, -80.0, 0.02, 0.0, 0)
    trace = rig.trace(4000)
    assert [v for _, v, _ in trace[1:41]] == [80.0] * 10 + [-80.0] * 10 + [80.0] * 10 + [-80.0] * 10
    assert rig.axis.set_motion_phase == MotionPhase.VELOCITY_STEPS


def test_the_override_scales_velocity_steps(rig: Any) -> None:
    rig.axis.controller.following_error_position_monitoring_enable = 0
    rig.axis.velocity_override = 250_000
    commands.start_velocity_steps(rig.axis, 1, 80.0, -50.0, 0.1, 0.05, 0)
    rig.run(1)
    assert rig.axis.set_velocity == 20.0
    rig.axis.velocity_override = 0
    rig.run(1)
    assert rig.axis.set_velocity == 0.0


def test_a_stop_of_velocity_steps_is_a_ramp(make_rig: Any) -> None:
    rig = make_rig(**DYNAMICS, controller_following_error_position_monitoring_enable=0)
    axis = rig.axis
    commands.start_velocity_steps(axis, 1, 180.0, -50.0, 1.0, 0.0, 0)
    rig.run(100)
    p = axis.set_position
    commands.stop(axis)
    took = rig.until_rest()
    assert took == pytest.approx((180.0 / A + A / J) / rig.dt, abs=1)
    assert axis.set_position == pytest.approx(p + 180.0 * (180.0 / A + A / J) / 2.0, abs=0.01)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)
