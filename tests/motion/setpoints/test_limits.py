"""Soft limits: every table ends before them, and what has no table is stopped before them."""

from math import inf, nextafter
from typing import Any

import pytest

from achse.codes.axis import StartType
from achse.codes.nc.choices import MotionPhase
from achse.motion import commands
from achse.motion.setpoints.dynamics import fastest, fault_deceleration
from achse.motion.setpoints.limits import (
    TOLERANCE,
    adapt_limits,
    highest_rest,
    limit_ahead,
    lowest_rest,
    passes,
    running_into,
    table_passes,
)

V = 100.0


def limited(make_rig: Any, limit: float, **values: float) -> Any:
    return make_rig(encoder_soft_limit_max=limit, encoder_soft_limit_max_enable=1, **values)


def highest_until_rest(rig: Any) -> float:
    highest = float(rig.axis.set_position)
    for _ in range(20_000):
        rig.run(1)
        highest = max(highest, rig.axis.set_position)
        if rig.axis.set_motion_phase == MotionPhase.NONE:
            break
    return highest


@pytest.mark.parametrize("kind", [StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE])
def test_an_endless_move_rests_at_its_soft_limit(make_rig: Any, kind: StartType) -> None:
    rig = make_rig(
        encoder_soft_limit_max=60.0, encoder_soft_limit_max_enable=1,
        encoder_soft_limit_min=-60.0, encoder_soft_limit_min_enable=1,
    )  # fmt: skip
    axis = rig.axis
    assert commands.universal_start(axis, kind, 0.0, V) == 0
    seen = 0.0
    while not axis.error_code:
        rig.run(1)
        seen = max(seen, abs(axis.set_velocity))
    assert seen == pytest.approx(V)
    assert (abs(axis.set_position), axis.set_velocity) == (60.0, 0.0)
    assert axis.error_code == (0x4463 if kind == StartType.ENDLESS_POSITIVE else 0x4462)
    rig.until_rest()


def test_short_section_compensation_counts_against_the_limits(make_rig: Any) -> None:
    rig = limited(make_rig, 60.0, encoder_soft_limit_min=-60.0, encoder_soft_limit_min_enable=1)
    axis = rig.axis
    axis.compensating, axis.superposed.distance = 1, 2.0
    axis.superposed.position = 1.5
    axis.superposed.sign = 1.0
    assert (lowest_rest(axis), highest_rest(axis)) == (-60.0, 59.5)
    axis.superposed.sign = -1.0
    assert (lowest_rest(axis), highest_rest(axis)) == (-59.5, 60.0)
    axis.compensating = 0
    assert (lowest_rest(axis), highest_rest(axis)) == (-60.0, 60.0)


def test_only_an_axis_that_moves_outward_runs_into_a_limit(make_rig: Any) -> None:
    rig = limited(make_rig, 60.0, encoder_soft_limit_min=-60.0, encoder_soft_limit_min_enable=1)
    axis = rig.axis
    for sign in (1.0, -1.0):
        axis.set_position = sign * 61.0
        assert running_into(axis, 0.0, rig.dt) == 0
        assert running_into(axis, sign * 1.0, rig.dt) == sign
        assert running_into(axis, sign * 0.5, rig.dt) == sign
        assert running_into(axis, sign * -1.0, rig.dt) == 0
        axis.set_position = sign * 59.5
        axis.set_acceleration = 0.0
        rest = 60.0 - 59.5
        fast = (2.0 * rest * fault_deceleration(axis)) ** 0.5
        assert running_into(axis, sign * 0.5 * fast, rig.dt) == 0
        assert running_into(axis, sign * fast, rig.dt) == sign
        axis.set_acceleration = sign * 0.9
        between = 0.5 + (0.5**2 + 1.4**2) / (4.0 * fault_deceleration(axis))
        axis.set_position = sign * (60.0 - between)
        assert running_into(axis, sign * 0.5, 1.0) == sign


@pytest.mark.parametrize("weak", [1.0, 50.0, 500.0])
@pytest.mark.parametrize("begin", range(300, 1100, 50))
def test_a_weak_halt_rests_before_the_limit(make_rig: Any, weak: float, begin: int) -> None:
    """The halt begins while a steep move is on its way to its target at the limit."""
    rig = limited(make_rig, 60.0)
    axis = rig.axis
    assert commands.universal_start(axis, 1, 60.0, V, 1500.0, 1500.0, 1e5) == 0
    rig.until(lambda axis: axis.set_position > 0.05 * begin)
    assert commands.universal_start(axis, 8192, 0.0, 0.0, 0.0, weak, 10.0 * weak) == 0
    assert highest_until_rest(rig) <= 60.0 + TOLERANCE
    assert axis.error_code == 0
    assert axis.set_velocity == 0.0


def test_weak_new_dynamics_do_not_lead_across_the_limit(make_rig: Any) -> None:
    rig = limited(make_rig, 60.0)
    assert commands.start(rig.axis, 1, 60.0, V) == 0
    rig.until(lambda axis: axis.set_acceleration < -100.0)
    assert commands.new_dynamics(rig.axis, 10.0, 10.0) == 0
    assert highest_until_rest(rig) <= 60.0 + TOLERANCE
    assert (rig.axis.set_position, rig.axis.error_code) == (60.0, 0)


def test_a_turn_with_weak_dynamics_does_not_lead_across_the_limit(make_rig: Any) -> None:
    rig = limited(make_rig, 60.0)
    assert commands.start(rig.axis, 1, 60.0, V) == 0
    rig.until(lambda axis: axis.set_position > 35.0)
    assert commands.universal_start(rig.axis, 1, 0.0, V, 10.0, 10.0, 100.0) == 0
    assert highest_until_rest(rig) <= 60.0 + TOLERANCE
    assert (rig.axis.set_position, rig.axis.error_code) == (0.0, 0)


def test_a_limit_that_comes_too_late_is_reported_and_braked_for(make_rig: Any) -> None:
    """From V without acceleration the default ramp takes V^1.5 / j^0.5 mm."""
    rig = make_rig(encoder_soft_limit_max=60.0)
    axis = rig.axis
    assert commands.universal_start(axis, 3, 0.0, V, 0.0, 20.0, 0.0) == 0
    rig.until(lambda axis: axis.set_position > 55.0)
    begin = axis.set_position
    axis.encoder.soft_limit_max_enable = 1
    rig.run(1)
    assert axis.error_code == 0x4463
    assert highest_until_rest(rig) == pytest.approx(begin + V**1.5 / 2250.0**0.5, abs=1e-6)


def test_a_limit_that_comes_in_time_ends_the_move(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max=200.0)
    axis = rig.axis
    assert commands.start(axis, 1, 500.0, V) == 0
    rig.until(lambda axis: axis.set_position > 100.0)
    axis.encoder.soft_limit_max_enable = 1
    rig.until(lambda axis: axis.error_code)
    assert (axis.error_code, axis.set_position, axis.set_velocity) == (0x4463, 200.0, 0.0)


def test_a_limit_that_goes_lets_the_move_go_on(make_rig: Any) -> None:
    rig = limited(make_rig, 60.0)
    axis = rig.axis
    assert commands.start(axis, 3, 0.0, V) == 0
    rig.until(lambda axis: axis.set_position > 50.0)
    assert axis.set_velocity < V
    axis.encoder.soft_limit_max_enable = 0
    rig.seconds(1.0)
    assert axis.set_velocity == pytest.approx(V)
    assert axis.error_code == 0


def test_a_limit_beyond_which_a_stopping_axis_is(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max=10.0)
    axis = rig.axis
    assert commands.start(axis, 3, 0.0, V) == 0
    rig.until(lambda axis: axis.set_position > 55.0)
    assert commands.universal_start(axis, 8192, 0.0, 0.0, 0.0, 20.0, 100.0) == 0
    rig.run(10)
    begin = axis.set_position
    axis.encoder.soft_limit_max_enable = 1
    rig.run(1)
    assert axis.error_code == 0x4463
    assert highest_until_rest(rig) < begin + V**1.5 / 2250.0**0.5


def test_the_way_back_from_beyond_a_limit_is_free(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max=10.0)
    axis = rig.axis
    assert commands.start(axis, 1, 50.0, V) == 0
    rig.until_rest()
    axis.encoder.soft_limit_max_enable = 1
    assert commands.start(axis, 1, 60.0, V) == 0x4461
    assert commands.start(axis, 1, 0.0, V) == 0
    rig.until_rest()
    assert (axis.set_position, axis.error_code) == (0.0, 0)


def test_a_renamed_position_moves_the_limit(make_rig: Any) -> None:
    rig = limited(make_rig, 100.0)
    axis = rig.axis
    assert commands.start(axis, 3, 0.0, V) == 0
    rig.seconds(0.5)
    assert commands.set_actual_position_on_the_fly(axis, 2, 0, 20.0) == 0
    rig.until(lambda axis: axis.error_code)
    assert (axis.error_code, axis.set_position) == (0x4463, 100.0)


def test_a_segment_end_velocity_ends_at_the_limit(make_rig: Any) -> None:
    rig = limited(make_rig, 60.0)
    axis = rig.axis
    assert commands.universal_start(axis, 1, 59.9, V, segment_end_velocity=V) == 0
    rig.until(lambda axis: axis.error_code)
    assert (axis.error_code, axis.set_position) == (0x4463, 60.0)


def test_a_command_waits_until_an_endless_move_has_its_velocity(make_rig: Any) -> None:
    rig = limited(make_rig, 500.0)
    axis = rig.axis
    assert commands.universal_start(axis, 3, 0.0, V) == 0
    assert commands.universal_start(axis, 1, 80.0, V, buffer_mode=1) == 0
    rig.until(lambda axis: axis.buffer_count == 0)
    assert axis.set_velocity == pytest.approx(V)
    rig.until_rest()
    assert (axis.set_position, axis.error_code) == (80.0, 0)


@pytest.mark.parametrize("velocity", [10.0, 100.0, 1000.0])
def test_an_external_set_point_is_stopped_before_the_limit(make_rig: Any, velocity: float) -> None:
    limit = 60.0 + velocity**2 / 3000.0
    rig = limited(make_rig, limit, controller_following_error_position_monitoring_enable=0)
    axis = rig.axis
    assert commands.start_external_setpoint(axis, 1, 0.0) == 0
    axis.external_set_velocity = velocity
    while not axis.error_code:
        axis.external_set_position += velocity * rig.dt
        rig.run(1)
    assert axis.error_code == 0x4463
    rig.until_rest()
    assert limit - 2.0 * velocity * rig.dt <= axis.set_position <= limit + TOLERANCE


@pytest.mark.parametrize("way", [0.2, -0.2])
def test_external_positions_without_their_velocity_keep_the_limit(
    make_rig: Any, way: float
) -> None:
    rig = limited(make_rig, 60.0, controller_following_error_position_monitoring_enable=0)
    axis = rig.axis
    axis.encoder_soft_limit_min_enable, axis.encoder_soft_limit_min = 1, -60.0
    assert commands.start_external_setpoint(axis, 1, 0.0) == 0
    for _ in range(400):
        axis.external_set_position += way
        rig.run(1)
    assert axis.error_code == (0x4463 if way > 0.0 else 0x4462)
    assert 59.0 < abs(axis.set_position) <= 60.0 + TOLERANCE


def test_a_compensation_keeps_the_limit(make_rig: Any) -> None:
    rig = limited(make_rig, 100.0)
    axis = rig.axis
    assert commands.start(axis, 3, 0.0, V) == 0
    rig.seconds(0.5)
    compensation = commands.Compensation(3, 1000.0, 1000.0, 30.0, V, 20.0, 400.0)
    assert commands.start_superposition(axis, compensation)[0] in (0, 0x4243)
    assert highest_until_rest(rig) <= 100.0 + TOLERANCE
    assert axis.error_code == 0x4463


def test_a_delayed_reaction_does_not_pass_the_limit(make_rig: Any) -> None:
    rig = limited(make_rig, 60.0, error_reaction_mode=1, error_reaction_delay=0.5)
    axis = rig.axis
    assert commands.start(axis, 3, 0.0, V) == 0
    cycles = rig.until(lambda axis: axis.delayed_error_code)
    assert (axis.set_position, axis.set_velocity, axis.error_code) == (60.0, 0.0, 0)
    cycles = rig.until(lambda axis: axis.error_code)
    assert cycles * rig.dt == pytest.approx(0.5, abs=0.004)
    assert axis.set_position == 60.0


def test_limits_in_force(make_rig: Any) -> None:
    axis = make_rig(encoder_soft_limit_max=5.0, encoder_soft_limit_min=-5.0).axis
    axis.encoder.soft_limit_min_enable = 1
    adapt_limits(axis)
    assert (lowest_rest(axis), highest_rest(axis)) == (-5.0, float("inf"))


def test_a_velocity_step_towards_a_limit_does_not_begin(make_rig: Any) -> None:
    """100 mm/s take 100² / 3000 mm; the pause between two steps lets a limit come in between."""
    rig = make_rig(encoder_soft_limit_max=12.0)
    axis = rig.axis
    assert commands.start_velocity_steps(axis, 1, V, -V, 0.1, 0.1, 0) == 0
    rig.until(lambda axis: axis.set_velocity < 0.0)
    rig.until(lambda axis: axis.set_velocity == 0.0)
    axis.encoder_soft_limit_max_enable = 1
    rig.until(lambda axis: axis.error_code)
    assert axis.error_code == 0x4463
    assert highest_until_rest(rig) <= 12.0


@pytest.mark.parametrize("override", [990_000, 1_000_000])
def test_a_smaller_maximum_holds_whatever_the_override(make_rig: Any, override: int) -> None:
    rig = make_rig(velocity_override=override)
    assert commands.start(rig.axis, 1, 1000.0, 300.0) == 0
    rig.seconds(0.1)
    rig.axis.max_velocity = 150.0
    assert max(state[1] for state in rig.trace(3000)) <= 150.0 * (1.0 + 1e-9)


def test_a_weak_command_under_a_compensation_keeps_the_limit(make_rig: Any) -> None:
    """The command that waited has a tenth of the deceleration that both motions need."""
    rig = limited(make_rig, 100.0, default_deceleration=100.0)
    axis = rig.axis
    assert commands.universal_start(axis, 3, 0.0, V, 1500.0, 5000.0, 1e5) == 0
    rig.until(lambda axis: axis.set_position > 20.0)
    compensation = commands.Compensation(3, 1000.0, 1000.0, 50.0, V, 5.0, 60.0)
    assert commands.start_superposition(axis, compensation)[0] in (0, 0x4243)
    rig.run(25)
    assert commands.universal_start(axis, 1, 0.0, V, 100.0, 100.0, 1e5, 1) == 0
    assert highest_until_rest(rig) <= 100.0 + TOLERANCE


@pytest.mark.parametrize(
    ("low", "high", "in_force"),
    [
        (None, None, (-inf, inf, 0)),
        (-60.0, None, (-60.0, inf, 1)),
        (None, 60.0, (-inf, 60.0, 1)),
        (-60.0, 60.0, (-60.0, 60.0, 1)),
        (-1e15, 1e15, (-inf, inf, 0)),
        (-9.9e14, 9.9e14, (-9.9e14, 9.9e14, 1)),
    ],
)
def test_limits_in_force_are_enabled_and_no_farther_than_1e15(
    rig: Any, low: float | None, high: float | None, in_force: tuple[float, float, int]
) -> None:
    axis, encoder = rig.axis, rig.axis.encoder
    encoder.soft_limit_min, encoder.soft_limit_min_enable = low or 0.0, int(low is not None)
    encoder.soft_limit_max, encoder.soft_limit_max_enable = high or 0.0, int(high is not None)
    adapt_limits(axis)
    assert (axis.limits.low, axis.limits.high, axis.limits.active) == in_force


def test_only_a_changed_limit_is_watched_again(make_rig: Any) -> None:
    rig = limited(make_rig, 60.0, encoder_soft_limit_min=-60.0, encoder_soft_limit_min_enable=1)
    axis, encoder = rig.axis, rig.axis.encoder
    axis.profile.fastest, axis.limits.recheck = fastest(axis), 0
    adapt_limits(axis)
    assert axis.limits.recheck == 0
    for owner, name, value in (
        (encoder, "soft_limit_min", -61.0),
        (encoder, "soft_limit_max", 61.0),
        (axis, "max_velocity", 0.5 * fastest(axis)),
    ):
        setattr(owner, name, value)
        axis.limits.recheck = 0
        adapt_limits(axis)
        assert axis.limits.recheck == 1
        axis.profile.fastest = fastest(axis)


@pytest.mark.parametrize("position", [0.0, 4e9])
@pytest.mark.parametrize("beyond", [0.0, 15.0, -15.0])
def test_table_passes_a_limit_by_more_than_the_rounding_of_its_position(
    rig: Any, position: float, beyond: float
) -> None:
    """An axis that is beyond a limit already may stay where it is."""
    axis = rig.axis
    axis.set_position = position + beyond
    axis.limits.low, axis.limits.high = position - 10.0, position + 10.0
    tolerance = TOLERANCE + 1e-12 * abs(axis.set_position)
    high = max(axis.limits.high, axis.set_position) + tolerance
    low = min(axis.limits.low, axis.set_position) - tolerance
    for n in range(3):
        axis.profile.time[n] = axis.profile.jerk[n] = 0.0
    for place, limit in (
        (high, 0),
        (nextafter(high, inf), 1),
        (low, 0),
        (nextafter(low, -inf), -1),
    ):
        assert passes(axis, 0, 1, place, 0.0, 0.0) == limit
        axis.profile.index, axis.profile.count = 1, 2
        axis.profile.position = place
        axis.profile.velocity = axis.profile.acceleration = 0.0
        assert table_passes(axis) == limit
    axis.profile.time[0], axis.profile.jerk[0] = 1.0, 6e9
    assert passes(axis, 0, 1, position, 0.0, 0.0) == 1
    assert passes(axis, 1, 2, position, 0.0, 0.0) == 0


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("acceleration", [0.0, 512.0, -512.0])
@pytest.mark.parametrize("position", [0.0, 4e9])
def test_axis_brakes_where_it_could_not_rest_before_a_limit(
    rig: Any, sign: float, acceleration: float, position: float
) -> None:
    """The way of one cycle, with the velocity that it then has, and that of the fault ramp."""
    axis, dt, v = rig.axis, 2.0**-9, 32.0
    faster = v + max(acceleration, 0.0) * dt
    rest = v * dt + faster * faster / (2.0 * fault_deceleration(axis))
    tolerance = TOLERANCE + 1e-12 * position
    axis.limits.low, axis.limits.high = -inf, inf
    for far, limit in ((0.9, 0), (1.1, sign)):
        name = "high" if sign > 0.0 else "low"
        setattr(axis.limits, name, sign * (position + rest - far * tolerance))
        assert limit_ahead(axis, sign * position, sign * v, sign * acceleration, dt) == limit
    assert limit_ahead(axis, sign * position, -sign * v, 0.0, dt) == 0


def test_axis_that_can_just_rest_at_a_limit_need_not_brake(rig: Any) -> None:
    axis, dt, v = rig.axis, 2.0**-9, 32.0
    rest = v * dt + v * v / (2.0 * fault_deceleration(axis))
    limit = rest - TOLERANCE
    while limit + TOLERANCE < rest:
        limit = nextafter(limit, inf)
    assert limit + TOLERANCE == rest
    axis.limits.high = limit
    assert limit_ahead(axis, 0.0, v, 0.0, dt) == 0
    axis.limits.high = inf
    assert limit_ahead(axis, 0.0, v, 0.0, dt) == limit_ahead(axis, 0.0, v, inf, dt) == 0
    axis.limits.high = limit - 1e-15
    assert limit_ahead(axis, 0.0, v, 0.0, dt) == 1
