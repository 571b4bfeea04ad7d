"""External set points: followed exactly, checked, stopped by a ramp, on top of own motion."""

from math import cos, inf, nan, pi, sin
from random import Random
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import MotionPhase, MotionState, StateBit, commands

RADIUS = 20.0
OMEGA = pi
"""The external generator moves by RADIUS (1 - cos(OMEGA t))."""


def feed(rig: Any, cycle: int) -> None:
    """Values of the external generator for the end of cycle number `cycle`."""
    angle = OMEGA * cycle * rig.dt
    axis = rig.axis
    axis.external_set_position = RADIUS * (1.0 - cos(angle))
    axis.external_set_velocity = RADIUS * OMEGA * sin(angle)
    axis.external_set_acceleration = RADIUS * OMEGA**2 * cos(angle)


def run(rig: Any, begin: int, end: int) -> None:
    for cycle in range(begin + 1, end + 1):
        feed(rig, cycle)
        rig.run(1)


def started(rig: Any, end_position: float = 0.0) -> Any:
    assert commands.start_external_setpoint(rig.axis, 1, end_position) == 0
    return rig


def ramp_way(v: float, a: float, deceleration: float, jerk: float, dt: float = 1e-6) -> float:
    """Way of a stop from (v, a), by integrating its jerk; v > 0 and the full deceleration seen."""
    way = 0.0
    while v > 0.0:
        rest = a * a / (2.0 * jerk) if a < 0.0 else 0.0
        if v <= rest:
            a = min(a + jerk * dt, 0.0)
            if a == 0.0:
                break
        else:
            a = max(a - jerk * dt, -deceleration)
        v += a * dt
        way += v * dt
    return way


def test_the_set_point_is_the_external_one(rig: Any) -> None:
    started(rig)
    run(rig, 0, 400)
    axis, angle = rig.axis, OMEGA * 400 * rig.dt
    assert axis.set_position == RADIUS * (1.0 - cos(angle))
    assert axis.set_velocity == RADIUS * OMEGA * sin(angle)
    assert axis.set_acceleration == RADIUS * OMEGA**2 * cos(angle)
    assert axis.error_code == 0
    assert axis.setpoint_correction_counter == 0
    assert axis.motion_state == MotionState.EXTERNAL
    assert rig.has(StateBit.EXTERNAL_SETPOINT_ENABLED)
    assert rig.has(StateBit.HAS_JOB)
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert not rig.has(StateBit.NOT_MOVING)
    assert rig.has(StateBit.POSITIVE_DIRECTION)
    assert abs(axis.actual_position - axis.set_position) < 0.5


def test_the_direction_follows_the_velocity(rig: Any) -> None:
    started(rig)
    run(rig, 0, 700)  # the way back begins after one second
    assert rig.axis.set_velocity < 0.0
    assert rig.has(StateBit.NEGATIVE_DIRECTION)


def test_end_position_is_what_target_monitoring_expects(rig: Any) -> None:
    started(rig, 2.0 * RADIUS)
    assert rig.axis.target_position == 2.0 * RADIUS
    run(rig, 0, 400)
    assert not rig.has(StateBit.IN_TARGET_POSITION)
    run(rig, 400, 500)
    rig.axis.external_set_velocity = rig.axis.external_set_acceleration = 0.0
    rig.seconds(0.3)
    assert rig.has(StateBit.IN_TARGET_POSITION)
    assert rig.has(StateBit.EXTERNAL_SETPOINT_ENABLED)


@pytest.mark.parametrize("jump", [10.0, -10.0])
def test_a_jump_of_the_position_is_an_error_and_brakes_the_axis(rig: Any, jump: float) -> None:
    started(rig)
    run(rig, 0, 200)
    axis = rig.axis
    p, v, a = axis.set_position, axis.set_velocity, axis.set_acceleration
    axis.external_set_position += jump
    rig.run(1)
    assert NcError.of(axis.error_code) is NcError.of(0x4359)
    assert not rig.has(StateBit.EXTERNAL_SETPOINT_ENABLED)
    assert abs(axis.set_position - p) <= v * rig.dt * 1.1
    rig.until_rest()
    way = ramp_way(v, min(a, 0.0), axis.default_deceleration, axis.default_jerk)
    assert axis.set_position == pytest.approx(p + way, abs=1e-3)


def test_a_position_may_go_as_far_in_a_cycle_as_the_axis_can(rig: Any) -> None:
    started(rig)
    axis = rig.axis
    axis.controller.following_error_position_monitoring_enable = 0
    axis.external_set_position = axis.max_velocity * rig.dt
    rig.run(1)
    assert axis.error_code == 0
    axis.external_set_position += 1.01 * axis.max_velocity * rig.dt
    rig.run(1)
    assert axis.error_code == 0x4359


@pytest.mark.parametrize(
    ("value", "number", "error"),
    [
        ("external_set_velocity", 2000.1, 0x4359),
        ("external_set_acceleration", -100_001.0, 0x435B),
        ("external_set_position", nan, 0x422C),
        ("external_set_position", inf, 0x422C),
        ("external_set_velocity", nan, 0x422C),
        ("external_set_acceleration", nan, 0x422C),
        ("external_set_jerk", nan, 0x422C),
    ],
)
def test_values_beyond_the_limits_of_the_axis(
    rig: Any, value: str, number: float, error: int
) -> None:
    started(rig)
    run(rig, 0, 200)
    setattr(rig.axis, value, number)
    before = rig.axis.set_velocity
    rig.run(1)
    assert rig.axis.error_code == error
    assert rig.axis.set_velocity == pytest.approx(before, rel=0.02)
    rig.until_rest()


@pytest.mark.parametrize("value", ["external_set_torque", "external_set_torque_derivative"])
def test_a_torque_that_is_no_number(rig: Any, value: str) -> None:
    commands.set_drive_operation_mode(rig.axis, 1)
    started(rig)
    rig.run(5)
    setattr(rig.axis, value, nan)
    rig.run(2)
    assert rig.axis.error_code == 0x422C
    assert rig.axis.set_torque == 0.0
    rig.until_rest()


def test_checked_velocities_are_those_of_the_positions(make_rig: Any) -> None:
    rig = make_rig(setpoint_consistency_check=1)
    started(rig)
    run(rig, 0, 250)
    axis = rig.axis
    assert axis.setpoint_correction_counter == 0
    axis.external_set_position += 0.1  # at the velocity of 50 mm/s
    axis.external_set_velocity = 400.0
    before = axis.set_velocity
    rig.run(1)
    assert axis.setpoint_correction_counter == 1
    assert axis.set_velocity == pytest.approx(0.1 / rig.dt)
    assert axis.set_acceleration == pytest.approx((0.1 / rig.dt - before) / rig.dt)


def test_unchecked_velocities_are_taken_as_they_are(rig: Any) -> None:
    started(rig)
    rig.axis.external_set_position = 0.1
    rig.axis.external_set_velocity = -400.0
    rig.run(1)
    assert rig.axis.set_velocity == -400.0
    assert rig.axis.setpoint_correction_counter == 0


@pytest.mark.parametrize("end", ["stop", "halt", "disable", "external error"])
def test_what_ends_it_brakes_from_the_present_motion(rig: Any, end: str) -> None:
    started(rig)
    run(rig, 0, 200)
    axis = rig.axis
    p, v, a = axis.set_position, axis.set_velocity, axis.set_acceleration
    match end:
        case "stop":
            commands.stop(axis)
        case "halt":
            commands.universal_start(axis, 8192, 0.0, 0.0)
        case "disable":
            axis.control_dword = 6
        case _:
            commands.set_external_error(axis, 0x4466)
    error = {"disable": 0x4260, "external error": 0x4466}.get(end, 0)
    trace = rig.trace(2)
    assert axis.error_code == error
    assert not rig.has(StateBit.EXTERNAL_SETPOINT_ENABLED)
    assert abs(trace[1][1] - v) <= (abs(a) + axis.default_jerk * rig.dt) * rig.dt * 1.01
    rig.until_rest()
    way = ramp_way(v, min(a, 0.0), axis.default_deceleration, axis.default_jerk)
    assert axis.set_position == pytest.approx(p + way, abs=1e-3)


def test_a_soft_limit_ends_it(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max_enable=1, encoder_soft_limit_max=10.0)
    started(rig)
    run(rig, 0, 300)
    assert rig.axis.error_code == 0x4463
    assert not rig.has(StateBit.EXTERNAL_SETPOINT_ENABLED)


def test_a_withdrawn_feed_enable_ends_it(rig: Any) -> None:
    started(rig)
    run(rig, 0, 100)
    rig.axis.control_dword = 5
    run(rig, 100, 105)
    assert rig.axis.error_code == 0x4358


def test_own_motion_and_external_one_add_up(make_rig: Any) -> None:
    rig = make_rig(allow_motion_commands_with_external_setpoint=1)
    alone = make_rig()
    started(rig)
    run(rig, 0, 300)
    axis = rig.axis
    begin = axis.set_position
    assert commands.universal_start(axis, 2, 30.0, 100.0) == 0
    commands.universal_start(alone.axis, 2, 30.0, 100.0)
    for cycle in range(301, 900):
        feed(rig, cycle)
        rig.run(1)
        alone.run(1)
        outside = RADIUS * (1.0 - cos(OMEGA * cycle * rig.dt)) - begin
        assert axis.set_position == pytest.approx(begin + alone.axis.set_position + outside)
        assert axis.set_velocity == pytest.approx(
            alone.axis.set_velocity + axis.external_set_velocity, abs=1e-9
        )
        if alone.axis.set_motion_phase == MotionPhase.POSITIONING:
            assert axis.motion_state == MotionState.INTERNAL_AND_EXTERNAL
    assert axis.motion_state == MotionState.EXTERNAL
    assert axis.external.origin == pytest.approx(30.0)
    assert axis.error_code == 0


def test_a_command_that_waits_follows_on_top(make_rig: Any) -> None:
    rig = make_rig(
        allow_motion_commands_with_external_setpoint=1,
        position_range_monitoring_enable=0,
        target_position_monitoring_enable=0,
    )
    started(rig)
    axis = rig.axis
    assert commands.universal_start(axis, 2, 5.0, 100.0) == 0
    assert commands.universal_start(axis, 2, -15.0, 100.0, buffer_mode=1) == 0
    run(rig, 0, 1000)  # a whole turn: outside is at 0 again
    assert axis.set_motion_phase == MotionPhase.EXTERNAL
    assert axis.set_position == pytest.approx(-10.0)


def test_a_stop_ends_both(make_rig: Any) -> None:
    rig = make_rig(allow_motion_commands_with_external_setpoint=1)
    started(rig)
    run(rig, 0, 200)
    commands.universal_start(rig.axis, 3, 0.0, 100.0)
    run(rig, 200, 300)
    v = rig.axis.set_velocity
    commands.stop(rig.axis)
    rig.run(1)
    assert rig.axis.set_velocity == pytest.approx(v, rel=0.02)
    assert rig.axis.external_setpoint_active == 0
    rig.until_rest()
    assert rig.axis.error_code == 0


def test_in_torque_mode_the_torque_comes_from_outside(make_rig: Any) -> None:
    rig = make_rig(simulation_full_torque_acceleration=1000.0)
    axis = rig.axis
    assert commands.set_drive_operation_mode(axis, 1) == 0
    started(rig)
    axis.external_set_torque = 200.0
    rig.run(50)
    assert axis.set_torque == 200.0
    assert axis.machine.velocity == pytest.approx(0.2 * 1000.0 * 50 * rig.dt, rel=0.05)
    assert axis.set_position == axis.actual_position
    assert commands.stop_external_setpoint(axis) == 0
    rig.until_rest()
    assert (axis.set_torque, axis.drive_operation_mode, axis.error_code) == (0.0, 0, 0)


@pytest.mark.parametrize(
    ("direction", "error"), [(1, 0), (-1, 0x4357)], ids=["permitted", "not permitted"]
)
def test_the_fed_direction_counts_where_no_velocity_is_fed(
    make_rig: Any, direction: int, error: int
) -> None:
    rig = make_rig(
        control_dword=3,
        encoder_soft_limit_max_enable=1,
        encoder_soft_limit_max=5.0,
        controller_following_error_position_monitoring_enable=0,
    )
    started(rig)
    axis = rig.axis
    axis.external_set_direction = direction
    axis.external_set_position = direction * 0.1
    rig.run(2)
    assert axis.error_code == error
    if not error:
        assert rig.has(StateBit.POSITIVE_DIRECTION)
        assert axis.set_direction == 1.0
        for _ in range(60):
            axis.external_set_position += 0.1
            rig.run(1)
        assert axis.error_code == 0x4463


def test_positions_can_be_renamed_meanwhile(rig: Any) -> None:
    started(rig)
    run(rig, 0, 100)
    p = rig.axis.set_position
    assert commands.set_actual_position_on_the_fly(rig.axis, 2, 0, 100.0) == 0
    assert rig.axis.set_position == pytest.approx(p + 100.0)
    run(rig, 100, 200)
    expected = 100.0 + RADIUS * (1.0 - cos(OMEGA * 200 * rig.dt))
    assert rig.axis.set_position == pytest.approx(expected)
    assert rig.axis.error_code == 0


@pytest.mark.parametrize("seed", range(8))
def test_own_motion_beside_an_external_set_point_at_rest_ends_smoothly_at_a_soft_limit(
    rig: Any, seed: int
) -> None:
    """Decision 0218; the external set point may have moved before (swarm seed 20399)."""
    dice = Random(seed)
    axis = rig.axis
    axis.encoder_soft_limit_max = limit = dice.uniform(60.0, 400.0)
    axis.encoder_soft_limit_max_enable = 1
    axis.allow_motion_commands_with_external_setpoint = 1
    started(rig)
    if dice.random() < 0.5:
        run(rig, 0, round(2.0 * pi / OMEGA / rig.dt))
        axis.external_set_velocity = axis.external_set_acceleration = 0.0
        rig.run(1)
    velocity = dice.uniform(0.3, 1.0) * axis.max_velocity
    assert commands.universal_start(axis, 3, 0.0, velocity) == 0
    steepest, before = 0.0, 0.0
    for _ in range(200_000):
        rig.run(1)
        steepest = max(steepest, abs(axis.set_acceleration - before))
        before = axis.set_acceleration
        if axis.error_code:
            break
    rig.run(1000)
    assert axis.error_code == NcError.SOFT_LIMIT_MAX_PASSED
    assert axis.set_position == pytest.approx(limit, abs=1e-6)
    assert steepest <= axis.default_jerk * rig.dt * (1.0 + 1e-6)
