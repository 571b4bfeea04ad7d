"""Velocity ramps: time, peak and reach follow from the limits."""

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from achse.motion.profiles.profile import plan_to_position
from achse.motion.profiles.ramps import (
    append_ramp,
    append_velocity_ramp,
    bounded,
    cube_root,
    highest_velocity,
    ramp_peak,
    ramp_time,
    reachable_velocity,
)
from achse.motion.profiles.segments import MAX_SEGMENTS, end_state

sizes = st.floats(1e-3, 1e6)


@given(st.floats(1e-75, 1e75))
def test_a_cube_root_cubed_is_the_number(x: float) -> None:
    """Of distances times the root of a jerk; both are bounded."""
    assert cube_root(x) ** 3 == pytest.approx(x, rel=1e-14)


def test_a_ramp_with_and_without_a_phase_at_the_limit() -> None:
    """100 mm/s with 1000 mm/s³: 500 mm/s² are just not met, 200 mm/s² are held for 0.3 s."""
    assert (ramp_time(100.0, 500.0, 1e3), ramp_peak(100.0, 500.0, 1e3)) == pytest.approx(
        (2.0 * 0.1**0.5, 1e5**0.5)
    )
    assert (ramp_time(100.0, 200.0, 1e3), ramp_peak(100.0, 200.0, 1e3)) == pytest.approx(
        (0.7, 200.0)
    )


@given(sizes, sizes, sizes)
def test_a_ramp_ends_at_its_velocity_in_its_time(change: float, limit: float, jerk: float) -> None:
    time, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = append_ramp(time, jerks, 0, change, 0.0, limit, jerk, jerk)
    _, v, a = end_state(time, jerks, n, 0.0, 0.0, 0.0)
    assert v == pytest.approx(change, rel=1e-9)
    assert a == pytest.approx(0.0, abs=1e-9 * limit)
    assert sum(time[:n]) == pytest.approx(ramp_time(change, limit, jerk), rel=1e-9)


def test_a_ramp_down_takes_the_deceleration() -> None:
    time, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = append_velocity_ramp(time, jerks, 0, 1.0, 100.0, 0.0, 0.0, (1e6, 200.0, 1e3))
    assert sum(time[:n]) == pytest.approx(ramp_time(100.0, 200.0, 1e3))
    assert end_state(time, jerks, n, 0.0, 100.0, 0.0)[1:] == pytest.approx((0.0, 0.0), abs=1e-9)


@given(sizes, sizes, sizes, sizes)
def test_the_way_of_a_ramp_reaches_its_velocity(
    lowest: float, change: float, limit: float, jerk: float
) -> None:
    """The way is the mean velocity times the time, as the ramp is point symmetric."""
    way = (lowest + 0.5 * change) * ramp_time(change, limit, jerk)
    highest = lowest + change
    assert highest_velocity(way, lowest, limit, jerk) == pytest.approx(highest, rel=1e-6)
    assert reachable_velocity(way, lowest, 0.0, limit, jerk) == pytest.approx(highest, rel=1e-6)


@given(sizes, sizes, sizes, sizes, st.floats(-2.0, 1.0), st.booleans())
def test_velocity_in_reach_does_not_depend_on_where_a_ramp_is_entered(
    lowest: float, change: float, limit: float, jerk: float, share: float, turns: bool
) -> None:
    """A ramp entered on its first jerk line, or on that line before its begin, ends the same.

    One that turns begins below 0; it is entered after the turn.
    """
    if turns:
        lowest = -min(lowest, 0.4 * change)
    tau = share * ramp_peak(change, limit, jerk) / jerk
    v = lowest + 0.5 * jerk * tau * tau
    assume(v >= 0.0 and (tau > 0.0 or lowest >= 0.0))
    way = (lowest + 0.5 * change) * ramp_time(change, limit, jerk)
    passed = tau * (lowest + jerk * tau * tau / 6.0)
    assume(abs(passed) < 1e6 * way)
    reached = reachable_velocity(way - passed, v, jerk * tau, limit, jerk)
    if reached == -1.0:  # by rounding, where the ramp is all release
        assert lowest + change <= (v + 0.5 * jerk * tau * tau) * (1.0 + 1e-9)
    else:
        assert reached == pytest.approx(lowest + change, rel=1e-5)


@given(st.floats(0.0, 0.45), sizes, sizes, sizes)
def test_way_of_a_ramp_that_turns_reaches_its_velocity(
    share: float, change: float, limit: float, jerk: float
) -> None:
    lowest = -share * change
    way = (lowest + 0.5 * change) * ramp_time(change, limit, jerk)
    assert highest_velocity(way, lowest, limit, jerk) == pytest.approx(lowest + change, rel=1e-6)


def test_velocity_in_reach_of_no_way() -> None:
    assert reachable_velocity(0.0, 7.0, 0.0, 1e3, 1e3) == 7.0
    assert reachable_velocity(0.0, 0.0, 0.0, 1e3, 1e3) == 0.0
    # -100 mm/s² are released in 0.1 s, from 10 to 5 mm/s: 2/3 mm
    assert reachable_velocity(0.66, 10.0, -100.0, 1e3, 1e3) == -1.0
    assert reachable_velocity(0.67, 10.0, -100.0, 1e3, 1e3) == pytest.approx(5.0, abs=0.2)


@given(
    *(sizes, sizes, sizes, sizes, st.floats(-1.0, 1.0), st.sampled_from((1.0, -1.0))),
    st.one_of(sizes, st.floats(-3.0, 3.0).map(lambda swings: (swings,))),
)
@example(100.0, 300.0, 400.0, 1e3, -0.2, 1.0, (0.5,))
@example(100.0, 300.0, 400.0, 1e3, -0.2, -1.0, (-0.5,))
@example(100.0, 300.0, 400.0, 1e3, 0.2, 1.0, (0.5,))
@example(1e-3, 0.5, 0.5, 1e3, -0.5, 1.0, (0.0,))
def test_ramp_of_any_state_ends_at_its_velocity(
    v: float,
    acc: float,
    dec: float,
    jerk: float,
    share: float,
    sign: float,
    goal: float | tuple[float],
) -> None:
    """In the travel frame: a negative acceleration can be released before v = 0.

    The goal is anywhere, or some times as far as the way in which the acceleration is released.
    """
    a = share * (acc if share > 0.0 else min(dec, (2.0 * jerk * v) ** 0.5))
    if isinstance(goal, tuple):
        goal = max(v + goal[0] * a * a / (2.0 * jerk), 0.0)
    time, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = append_velocity_ramp(time, jerks, 0, sign, v, a, goal, (acc, dec, jerk))
    largest = max(v, goal, a * a / jerk)
    _, end, rest = end_state(time, jerks, n, 0.0, sign * v, sign * a)
    assert sign * end == pytest.approx(goal, abs=1e-9 * largest)
    assert rest == pytest.approx(0.0, abs=1e-9 * max(acc, dec))
    state = 0.0, sign * v, sign * a
    for t, j in zip(time[:n], jerks[:n], strict=True):
        assert t >= 0.0
        state = end_state([t], [j], 1, *state)
        assert -dec * (1.0 + 1e-9) <= sign * state[2] <= acc * (1.0 + 1e-9)


def test_too_short_to_release_the_acceleration() -> None:
    assert reachable_velocity(0.0, 10.0, 100.0, 1e3, 1e3) == -1.0


def test_limits_that_no_axis_has_count_as_the_bounds() -> None:
    assert (bounded(1e-12), bounded(5.0), bounded(1e20)) == (1e-9, 5.0, 1e12)


@pytest.mark.parametrize(
    "case",
    [
        (390.5568513606846, 104.45050677456842, 581.2680698229168, 390.67689624727353,
         104.78382313944036, 38.835138, 581.2680698229168, 466.09616791202114, 506834.65410684893),
        (-834.6886729792603, -41.357522017249536, -683.4820067725678, -835.9316840739216,
         50.33071570314278, 18.58980490458199, 683.4820067725678, 14.08569523211829,
         26030.177768364043),
    ],
)  # fmt: skip
def test_rise_that_the_present_acceleration_just_reaches_ends_without_acceleration(
    case: tuple[float, ...],
) -> None:
    """Found by `achse swarm --plans`: what was left for a weaker ramp was rounding."""
    p, v, a, target, end, top, acc, dec, jerk = case
    times, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    count = plan_to_position(times, jerks, p, v, a, target, end, top, acc, dec, jerk)
    end_p, end_v, end_a = end_state(times, jerks, count, p, v, a)
    assert (end_p, abs(end_v)) == pytest.approx((target, end), rel=1e-9)
    assert end_a == pytest.approx(0.0, abs=1e-9 * acc)


@pytest.mark.parametrize(
    "case",
    [
        (0.19033503462474377, -118.60742456022106, 25122.487718507, 0.1549810509713149,
         9766.087181778017, 2160.9966248152127, 198955.24785428395),
        (-10.685877823134389, 24877.990175362964, -46701.506142296, 2.373270702044192,
         10566.188637279312, 106593.57137636156, 37227453.80298242),
        (2.0641751260153744e-05, -0.12505650205360438, 0.015604634889299, 1e-6,
         0.021942523212424736, 0.11682442109660647, 398.10932586264545),
    ],
)  # fmt: skip
def test_deceleration_that_leads_almost_to_the_velocity_bends_no_hours_after_it(
    case: tuple[float, ...],
) -> None:
    """Found by `achse swarm --plans`: a rise by rounding left 1e-14 mm/s² for days of a creep."""
    v, a, target, top, acc, dec, jerk = case
    for nearly in (1.0 - 1e-15, 1.0, 1.0 + 1e-15, 1.0 + 1e-12, 1.0 - 1e-12):
        times, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
        count = plan_to_position(times, jerks, 0.0, v, a, target, 0.0, top * nearly, acc, dec, jerk)
        end_p, end_v, _ = end_state(times, jerks, count, 0.0, v, a)
        assert end_v == pytest.approx(0.0, abs=1e-10 * top)
        assert end_p == pytest.approx(target, rel=1e-10)


def test_table_has_room_for_a_brake_far_weaker_than_what_it_takes_away() -> None:
    """A crossing, a bring-in, a brake by way of 0, and the way back to a higher velocity."""
    v, a, target = 0.00188138592015777, -1568.1238914705038, 4930.958960936803
    limits = 32.63719757997046, 797.2982612164834, 0.005370139354924111, 34288.35882115229
    times, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    count = plan_to_position(times, jerks, 0.0, v, a, target, 28.283999039695676, *limits)
    end_p, end_v, _ = end_state(times, jerks, count, 0.0, v, a)
    assert (end_p, end_v) == pytest.approx((target, 28.283999039695676), rel=1e-9)
