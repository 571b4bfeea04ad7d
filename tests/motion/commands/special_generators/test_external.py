"""Commands of external set points: mistakes, stops, the way into an endless move."""

from math import inf, nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import CommandState, MotionPhase, StateBit, commands

V = 100.0


def driven_from_outside(rig: Any, velocity: float = V, seconds: float = 0.5) -> Any:
    """The rig after `seconds` of external set points that speed up to a constant velocity."""
    axis = rig.axis
    assert commands.start_external_setpoint(axis, 1, 0.0) == 0
    v = 0.0
    for _ in range(round(seconds / rig.dt)):
        before, v = v, min(v + 500.0 * rig.dt, velocity)
        axis.external_set_position += 0.5 * (before + v) * rig.dt
        axis.external_set_velocity = v
        rig.run(1)
    assert axis.error_code == 0
    return rig


@pytest.mark.parametrize("kind", [0, 3, 5, 261])
def test_start_types(rig: Any, kind: int) -> None:
    rig.refuses(NcError.START_TYPE, commands.start_external_setpoint, kind, 0.0)


@pytest.mark.parametrize("position", [nan, inf])
def test_end_positions(rig: Any, position: float) -> None:
    rig.refuses(NcError.START_AXIS_DATA, commands.start_external_setpoint, 1, position)


def test_a_relative_end_position_counts_from_here(rig: Any) -> None:
    commands.set_actual_position(rig.axis, 1, 40.0)
    commands.start_external_setpoint(rig.axis, 2, 10.0)
    assert rig.axis.target_position == pytest.approx(50.0)


def test_stops_need_the_generator(rig: Any) -> None:
    error = NcError.EXTERNAL_GENERATOR_NOT_ACTIVE
    rig.refuses(error, commands.stop_external_setpoint)
    rig.refuses(error, commands.stop_external_setpoint_endless, 3, 0.0, V)


def test_a_stop_at_rest_ends_at_once(rig: Any) -> None:
    commands.start_external_setpoint(rig.axis, 1, 0.0)
    rig.run(10)
    assert commands.stop_external_setpoint(rig.axis) == 0
    rig.run(1)
    assert rig.axis.set_motion_phase == MotionPhase.NONE
    assert rig.axis.set_command_state == CommandState.DONE
    assert not rig.has(StateBit.HAS_BEEN_STOPPED)
    assert not rig.has(StateBit.EXTERNAL_SETPOINT_ENABLED)


def test_a_stop_in_motion_is_a_ramp(rig: Any) -> None:
    driven_from_outside(rig)
    axis = rig.axis
    p = axis.set_position
    assert commands.stop_external_setpoint(axis) == 0
    took = rig.until_rest()
    seconds = 2.0 * (V / axis.default_jerk) ** 0.5  # the deceleration is not reached
    assert took == pytest.approx(seconds / rig.dt, abs=1)
    assert axis.set_position == pytest.approx(p + 0.5 * V * seconds, abs=1e-6)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)
    assert axis.external_set_position != axis.set_position  # no longer followed


def test_an_endless_move_takes_over_without_a_jump(rig: Any) -> None:
    driven_from_outside(rig)
    axis = rig.axis
    p = axis.set_position
    number = axis.command_counter
    assert commands.stop_external_setpoint_endless(axis, 3, 0.0, V) == 0
    assert axis.command_counter == number + 1
    for cycle in range(1, 200):
        rig.run(1)
        assert axis.set_velocity == pytest.approx(V)
        assert axis.set_position == pytest.approx(p + V * cycle * rig.dt)
        assert not rig.has(StateBit.EXTERNAL_SETPOINT_ENABLED)
        assert rig.has(StateBit.CONTINUOUS_MOTION)
        assert rig.has(StateBit.CONSTANT_VELOCITY)
    assert axis.set_motion_phase == MotionPhase.ENDLESS


def test_an_endless_move_may_be_faster_or_the_other_way(rig: Any) -> None:
    driven_from_outside(rig)
    assert commands.stop_external_setpoint_endless(rig.axis, 4, 0.0, 150.0) == 0
    before = V
    for _ in range(500):
        rig.run(1)
        assert abs(rig.axis.set_velocity - before) <= 1500.0 * rig.dt * 1.000001
        before = rig.axis.set_velocity
    assert rig.axis.set_velocity == -150.0


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((1, 100.0, V), NcError.START_TYPE),
        ((8192, 0.0, 0.0), NcError.START_TYPE),
        ((3, 0.0, 0.0), NcError.SET_VELOCITY_NOT_ALLOWED),
        ((3, 0.0, V, -1.0), NcError.ACCELERATION_NOT_POSITIVE),
        ((3, 0.0, V, 0.0, 0.0, 0.0, 1), NcError.FUNCTION_NOT_AVAILABLE),
    ],
)
def test_a_wrong_endless_move_leaves_the_generator(
    rig: Any, arguments: tuple[Any, ...], error: NcError
) -> None:
    driven_from_outside(rig)
    rig.refuses(error, commands.stop_external_setpoint_endless, *arguments)


def test_motion_commands_are_refused_unless_allowed(make_rig: Any) -> None:
    rig = driven_from_outside(make_rig())
    error = NcError.EXTERNAL_GENERATOR_ACTIVE
    rig.refuses(error, commands.universal_start, 1, 10.0, V)
    rig.refuses(error, commands.start, 1, 10.0, V)
    rig = driven_from_outside(make_rig(allow_motion_commands_with_external_setpoint=1))
    assert commands.start(rig.axis, 2, 10.0, V) == 0
    rig.refuses(NcError.GROUP_BUSY, commands.start, 2, 10.0, V)


def test_an_own_move_goes_on_when_the_external_one_ends(make_rig: Any) -> None:
    rig = driven_from_outside(make_rig(allow_motion_commands_with_external_setpoint=1))
    axis = rig.axis
    commands.universal_start(axis, 2, 100.0, V)
    axis.external_set_velocity = 0.0
    rig.run(1)
    for _ in range(99):
        axis.external_set_position += V * rig.dt
        axis.external_set_velocity = V
        rig.run(1)
    v, target = axis.set_velocity, axis.target_position
    assert commands.stop_external_setpoint(axis) == 0
    rig.run(1)
    assert axis.set_velocity == pytest.approx(v, rel=0.05)
    assert not rig.has(StateBit.EXTERNAL_SETPOINT_ENABLED)
    rig.until_rest()
    assert axis.set_position == pytest.approx(target)
