"""Profiles reach their target inside every limit, from any state, compiled or not."""

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from achse.motion.profiles.profile import (
    END_VELOCITY_UNREACHABLE,
    LIMITS_INVALID,
    STATE_INVALID,
    plan_to_position,
    plan_to_velocity,
    stopping_distance,
    stopping_time,
)
from achse.motion.profiles.ramps import highest_velocity, reachable_velocity
from achse.motion.profiles.segments import (
    MAX_SEGMENTS,
    duration,
    end_state,
    segment_acceleration,
    segment_position,
    segment_velocity,
)
from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out

CASES = 100_000

OK = 0
BAD_TIME, BAD_JERK, TOO_FAST, TOO_STRONG, REVERSED_MOVING, WRONG_END = range(1, 7)


def violation(
    times: Sequence[float], jerks: Sequence[float], count: int, position: float, velocity: float,
    acceleration: float, target: float, end_velocity: float, top: float, acc: float, dec: float,
    jerk: float,
) -> int:  # fmt: skip
    """First broken promise of a profile, or OK: an observer that shares no formula with it.

    It walks the segments, looking at both ends and at the velocity extreme inside. Excused is only
    what no jerk-limited motion avoids: an excessive start acceleration while it is reduced, an
    excessive velocity until it was reduced, one crossing of v = 0 that the start state implies; and
    the rise to an end velocity above the limit, which goes on to the end.
    """
    p, v, a = position, velocity, acceleration
    farthest = max(1.0, abs(position), abs(target))
    fastest = abs(velocity)
    strongest = abs(acceleration)
    for i in range(count):
        if not (times[i] > 0.0 and times[i] < 1e300):
            return BAD_TIME
        if abs(jerks[i]) > jerk:
            return BAD_JERK
        p = segment_position(times[i], jerks[i], p, v, a)
        v = segment_velocity(times[i], jerks[i], v, a)
        a = segment_acceleration(times[i], jerks[i], a)
        farthest = max(farthest, abs(p))
        fastest = max(fastest, abs(v))
        strongest = max(strongest, abs(a))
    still = 1e-12 * fastest
    if abs(p - target) > 1e-9 * farthest:
        return WRONG_END
    arrival = target - position
    if arrival == 0.0:
        arrival = velocity if velocity != 0.0 else acceleration
    arrival = end_velocity if arrival >= 0.0 else -end_velocity
    if abs(v - arrival) > 1e-9 * max(top, abs(velocity)) or abs(a) > 1e-9 * strongest + 1e-99:
        return WRONG_END

    v, a = velocity, acceleration
    crossing = v * a < 0.0 and abs(v) - a * a / (2.0 * jerk) < -1e-13 * abs(v)
    implied = max(abs(v), abs(v + a * abs(a) / (2.0 * jerk)))
    slowed = False
    rising = False
    highest = max(top, end_velocity)
    inside = False
    side = 0.0
    leaving = 0.0
    for i in range(count):
        t, j = times[i], jerks[i]
        w = segment_velocity(t, j, v, a)
        b = segment_acceleration(t, j, a)
        low = min(v, w)
        high = max(v, w)
        if j != 0.0 and a * j < 0.0 and -a / j < t:
            extreme = segment_velocity(-a / j, j, v, a)
            low = min(low, extreme)
            high = max(high, extreme)
        if low < -still and high > still and not (crossing and i == 0):
            return REVERSED_MOVING
        settled = abs(v + a * abs(a) / (2.0 * jerk))
        if abs(v) <= top * (1.0 + 1e-9) and settled <= top * (1.0 + 1e-9):
            slowed = True
        if max(high, -low) > (highest if slowed else max(highest, implied)) * (1.0 + 1e-9):
            return TOO_FAST
        if slowed and max(high, -low) > top * (1.0 + 1e-9):
            rising = True
        if rising and abs(w) < abs(v) * (1.0 - 1e-9):
            return TOO_FAST
        travel = 1.0 if high > -low else -1.0
        growth = travel * a
        moving = max(high, -low) > still
        if crossing and i == 0:
            if a * j >= 0.0:
                return TOO_STRONG
        elif not moving:
            pass  # too short to have a direction; its ends are those of its neighbours
        elif inside or -dec * (1.0 + 1e-9) <= growth <= acc * (1.0 + 1e-9):
            inside = True
            if max(growth, travel * b) > acc * (1.0 + 1e-9):
                return TOO_STRONG
            if min(growth, travel * b) < -dec * (1.0 + 1e-9):
                return TOO_STRONG
        elif a * j >= 0.0:
            return TOO_STRONG
        if moving:
            if side * travel < 0.0 and leaving > 1e-9 * strongest:
                return REVERSED_MOVING
            side = 0.0 if crossing and i == 0 else travel
        leaving = abs(b)
        v, a = w, b
    return OK


class Case:
    """One situation, what was planned for it, and what the observer says to that."""

    arguments: list[float] = [0.0] * 9  # as `generate` makes them
    factor: float = 0.0
    times: list[float] = [0.0] * MAX_SEGMENTS
    jerks: list[float] = [0.0] * MAX_SEGMENTS
    results: list[float] = [0.0] * 5
    count: int = 0
    verdict: int = 0


CASE = lay_out("case", [Case], Slot)
GIVEN = 9


def plan_all(cases: Sequence[Case]) -> None:
    """Plan each case and let the observer look at it."""
    for i in range(len(cases)):
        c = cases[i]
        g = c.arguments
        p, v, a, target, end = g[0], g[1], g[2], g[3], g[4]
        top, acc, dec, jerk = g[5], g[6], g[7], g[8]
        n = plan_to_position(c.times, c.jerks, p, v, a, target, end, top, acc, dec, jerk)
        c.count = n
        if n >= 0:
            c.verdict = violation(c.times, c.jerks, n, p, v, a, target, end, top, acc, dec, jerk)


def ramp_all(cases: Sequence[Case]) -> None:
    """Plan the way to the largest velocity instead, and compute all that has a single result."""
    for i in range(len(cases)):
        c = cases[i]
        g, r = c.arguments, c.results
        v, a, dec, jerk = g[1], g[2], g[7], g[8]
        c.count = plan_to_velocity(c.times, c.jerks, v, a, g[5], g[6], dec, jerk)
        r[0], r[1], r[2] = end_state(c.times, c.jerks, c.count, g[0], v, a)
        r[3] = stopping_distance(v, a, dec, jerk)
        r[4] = stopping_time(v, a, dec, jerk)


def aim_all(cases: Sequence[Case]) -> None:
    """Put targets near where the axis would come to rest, where `factor` is not 0."""
    for i in range(len(cases)):
        g, factor = cases[i].arguments, cases[i].factor
        if factor != 0.0:
            g[3] = g[0] + factor * stopping_distance(g[1], g[2], g[7], g[8])


def run(function: Any, cases: Any, factors: Any = 0.0) -> Any:
    """The records after machine code of `function` worked on them, as floats and as integers."""
    memory = np.zeros((len(cases), CASE.words))
    memory[:, :GIVEN] = cases
    memory[:, GIVEN] = factors
    _machine_code(function)(memory.ctypes.data, len(cases))
    return memory, memory.view(np.int64)


def planned(cases: Any) -> Any:
    """Times, jerks, number of segments and verdict of each case."""
    floats, ints = run(plan_all, cases)
    return (
        *(floats[:, _column(name)] for name in ("times", "jerks")),
        *(ints[:, _column(name)] for name in ("count", "verdict")),
    )


def aim_near_stop(cases: Any, factors: Any) -> Any:
    cases[:] = run(aim_all, cases, factors)[0][:, :GIVEN]


@cache
def _machine_code(function: Any) -> Any:
    return Kernel(function.__name__, function, {Case: CASE}).function


def _column(name: Any) -> Any:
    slot = CASE.fields[name]
    return slice(slot.offset, slot.offset + slot.length) if slot.length else slot.offset


def generate(seed: Any, count: Any, wild: Any) -> Any:
    """Rows (p, v, a, target, end velocity, top, acc, dec, jerk) over decades, half near a stop.

    Not wild: starts up to about the limits; wild: velocity up to 100, acceleration
    up to 10 times beyond them (the latter implies 100 times the velocity, too).
    """
    rng = np.random.default_rng(seed)

    def decades(low: Any, high: Any) -> Any:
        return 10.0 ** rng.uniform(low, high, count)

    def sometimes(share: Any, value: Any) -> Any:
        return np.where(rng.random(count) < share, value, 0.0)

    top = decades(-3, 4)
    acc = top * decades(-2, 3)
    dec = np.where(rng.random(count) < 0.3, acc, acc * decades(-2, 2))
    jerk = np.sqrt(acc * dec) * decades(-2, 4)
    scale = np.where(rng.random(count) < 0.5, 1.0, decades(-9, 2 if wild else 0))
    velocity = sometimes(0.8, rng.uniform(-1.2, 1.2, count) * top * scale)
    scale = np.where(rng.random(count) < 0.5, 1.0, decades(-9, 1 if wild else 0))
    strongest = np.minimum(np.maximum(acc, dec), np.sqrt(2.0 * jerk * top))
    acceleration = sometimes(0.7, rng.uniform(-1.2, 1.2, count) * strongest * scale)
    position = sometimes(0.8, rng.choice([-1.0, 1.0], count) * decades(-9, 6))
    target = position + sometimes(0.98, rng.choice([-1.0, 1.0], count) * decades(-9, 6))
    nothing = np.zeros(count)
    cases = np.stack(
        [position, velocity, acceleration, target, nothing, top, acc, dec, jerk], axis=1
    )
    aim_near_stop(cases, sometimes(0.5, 1.0 + rng.normal(size=count) * decades(-13, 0.5)))
    return cases


def checked_counts(cases: Any) -> Any:
    """Plan all cases; every promise is kept. Their numbers of segments."""
    _, _, counts, verdicts = planned(cases)
    broken = np.flatnonzero(verdicts)
    assert len(broken) == 0, (len(broken), verdicts[broken[0]], cases[broken[0]].tolist())
    return counts


@pytest.mark.parametrize("wild", [False, True])
def test_generated_cases_arrive_without_breaking_a_limit(wild: Any) -> None:
    cases = generate(1, CASES, wild)
    counts = checked_counts(cases)
    assert counts.min() >= 0, cases[counts.argmin()].tolist()


def test_a_target_short_of_the_last_jerk_phase_is_reached_by_returning() -> None:
    """There v - a²/2j is zero but for rounding: braking on and releasing are the same."""
    cases = generate(6, CASES, False)
    rng = np.random.default_rng(7)
    jerk = cases[:, 8]
    strongest = np.minimum(cases[:, 7], np.sqrt(2.0 * jerk * cases[:, 5]))
    growth = -strongest * rng.uniform(0.0, 1.0, CASES)
    speed = growth * growth / (2.0 * jerk) * (1.0 + rng.integers(-3, 4, CASES) * 2.0**-53)
    sign = rng.choice([-1.0, 1.0], CASES)
    cases[:, 1], cases[:, 2] = sign * speed, sign * growth
    aim_near_stop(cases, 1.0 - np.abs(rng.normal(size=CASES)) * 10.0 ** rng.uniform(-9, 0.0))
    counts = checked_counts(cases)
    assert counts.min() >= 0, cases[counts.argmin()].tolist()


def test_generated_end_velocities_are_met_or_refused() -> None:
    cases = generate(2, CASES, False)
    cases[:, 4] = cases[:, 5] * np.random.default_rng(3).uniform(0.0, 1.0, CASES)
    counts = checked_counts(cases)
    assert set(counts[counts < 0]) == {END_VELOCITY_UNREACHABLE}
    assert (counts > 0).sum() > 0.3 * CASES


def test_an_end_velocity_above_the_limit_is_reached_by_a_last_rise() -> None:
    cases = generate(8, CASES, False)
    dice = np.random.default_rng(9)
    cases[:, 4] = cases[:, 5] * 10.0 ** dice.uniform(0.0, 2.0, CASES)
    # Many distances about that of the rise itself, where the last ramp has to be fitted in.
    rise = cases[:, 4] - cases[:, 5]
    time = rise / cases[:, 6] + np.sqrt(rise / cases[:, 8]) + cases[:, 6] / cases[:, 8]
    share = np.where(dice.random(CASES) < 0.5, 10.0 ** dice.uniform(-2.0, 2.0, CASES), 0.0)
    way = np.sign(cases[:, 1] + 1e-99) * share * time * cases[:, 4]
    cases[:, 3] = np.where(share > 0.0, cases[:, 0] + way, cases[:, 3])
    counts = checked_counts(cases)
    assert set(counts[counts < 0]) == {END_VELOCITY_UNREACHABLE}
    assert (counts > 0).sum() > 0.3 * CASES


def test_compiled_and_interpreted_results_are_bit_identical() -> None:
    cases = generate(4, 4000, True)
    cases[::3, 4] = 0.5 * cases[::3, 5]
    cases[::5, 4] = 3.0 * cases[::5, 5]
    times, jerks, counts, _ = planned(cases)
    ramps, ramp_counts = run(ramp_all, cases)
    for i, case in enumerate(cases.tolist()):
        t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
        assert plan_to_position(t, j, *case) == counts[i], case
        assert t == times[i].tolist(), case
        assert j == jerks[i].tolist(), case
        p, v, a, _, _, top, acc, dec, jerk = case
        t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
        n = plan_to_velocity(t, j, v, a, top, acc, dec, jerk)
        assert n == ramp_counts[i, _column("count")]
        assert t == ramps[i, _column("times")].tolist(), case
        stop = stopping_distance(v, a, dec, jerk), stopping_time(v, a, dec, jerk)
        expected = (*end_state(t, j, n, p, v, a), *stop)
        assert ramps[i, _column("results")].tolist() == list(expected)


def test_replanning_on_the_way_keeps_the_arrival_time() -> None:
    """A profile planned again from any of its own states is the rest of itself."""
    for case in generate(5, 2000, False).tolist():
        p, v, a, target, end, *limits = case
        t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
        n = plan_to_position(t, j, p, v, a, target, end, *limits)
        left = duration(t, n)
        ends = [end_state(t, j, i, p, v, a)[0] for i in range(n + 1)]
        farthest = max(abs(x) for x in ends)
        again, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
        for i in range(n):
            half = 0.5 * t[i]
            p, v, a = (
                segment_position(half, j[i], p, v, a),
                segment_velocity(half, j[i], v, a),
                segment_acceleration(half, j[i], a),
            )
            m = plan_to_position(again, jerks, p, v, a, target, end, *limits)
            # Position rounding s costs 4 (s / 2 jerk)^(1/3) for the way there from rest.
            rounding = 1e-14 * (farthest + abs(v) * left)
            late = duration(again, m) - (left - half)
            assert late <= 1e-6 * left + 16.0 * math.cbrt(rounding / limits[-1]), (case, i)
            p, v, a = (
                segment_position(half, j[i], p, v, a),
                segment_velocity(half, j[i], v, a),
                segment_acceleration(half, j[i], a),
            )
            left -= t[i]


# ---- properties in the interpreter

sizes = st.floats(-6.0, 6.0).map(lambda e: 10.0**e)
fractions = (st.floats(-1.0, 1.0) | st.floats(-1e-9, 1e-9)).map(
    lambda f: f if abs(f) > 1e-30 else 0.0  # subnormal numbers have no relative precision
)


@st.composite
def situations(draw: Any) -> Any:
    top = draw(st.floats(-3.0, 4.0).map(lambda e: 10.0**e))
    acc = top * draw(st.floats(-2.0, 3.0).map(lambda e: 10.0**e))
    dec = acc * draw(st.just(1.0) | st.floats(0.01, 100.0))
    jerk = acc * draw(st.floats(-2.0, 4.0).map(lambda e: 10.0**e))
    v = 3.0 * top * draw(fractions)
    a = 3.0 * min(max(acc, dec), math.sqrt(2.0 * jerk * top)) * draw(fractions)
    p = draw(fractions) * draw(sizes)
    target = draw(
        st.just(p)
        | st.builds(lambda f, s: p + f * s, fractions, sizes)
        | fractions.map(lambda f: p + (1.0 + f) * stopping_distance(v, a, dec, jerk))
    )
    return p, v, a, target, 0.0, top, acc, dec, jerk


@given(situations())
@settings(max_examples=50, deadline=None)
def test_any_situation_arrives_without_breaking_a_limit(case: Any) -> None:
    p, v, a, target, end, top, acc, dec, jerk = case
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_position(t, j, *case)
    assert 0 <= n <= MAX_SEGMENTS
    assert violation(t, j, n, p, v, a, target, end, top, acc, dec, jerk) == OK


@given(situations())
@settings(max_examples=25, deadline=None)
def test_the_mirrored_situation_gives_the_mirrored_profile(case: Any) -> None:
    p, v, a, target, end, *limits = case
    assume(p != target or v != 0.0 or a != 0.0)
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    u, k = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_position(t, j, p, v, a, target, end, *limits)
    assert plan_to_position(u, k, -p, -v, -a, -target, end, *limits) == n
    assert u == t
    assert [-x for x in k[:n]] == j[:n]


@given(situations(), fractions)
@settings(max_examples=37, deadline=None)
def test_a_velocity_ramp_ends_at_its_velocity_without_breaking_a_limit(
    case: Any, share: Any
) -> None:
    _, v, a, _, _, top, acc, dec, jerk = case
    goal = 2.0 * share * top
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_velocity(t, j, v, a, goal, acc, dec, jerk)
    p, w, b = end_state(t, j, n, 0.0, v, a)
    bound = max(abs(goal), abs(v), abs(v + a * abs(a) / (2.0 * jerk)))
    assert w == pytest.approx(goal, abs=1e-9 * max(bound, top))
    assert b == pytest.approx(0.0, abs=1e-9 * max(acc, dec, abs(a)))
    # A goal this close to standstill is standstill: the way there may cross zero by rounding.
    assume(goal == 0.0 or abs(goal) > 1e-9 * bound)
    # The observer wants positions: as if the ramp's own end had been the target.
    assume(goal * p >= 0.0)
    verdict = violation(t, j, n, 0.0, v, a, p, abs(goal), bound, acc, dec, jerk)
    assert verdict == OK


@given(situations())
@settings(max_examples=37, deadline=None)
def test_stopping_distance_and_time_are_those_of_the_stop(case: Any) -> None:
    _, v, a, _, _, _, _, dec, jerk = case
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    # An acceleration limit beyond the start acceleration leaves the stop one braking ramp.
    n = plan_to_velocity(t, j, v, a, 0.0, max(1e-6, 2.0 * abs(a)), dec, jerk)
    p, _, _ = end_state(t, j, n, 0.0, v, a)
    took = duration(t, n)
    scale = took * (abs(v) + a * a / jerk)
    assert stopping_distance(v, a, dec, jerk) == pytest.approx(
        p, rel=1e-9, abs=1e-9 * scale + 1e-99
    )
    assert stopping_time(v, a, dec, jerk) == pytest.approx(took, rel=1e-9, abs=1e-50)


# ---- named examples, expected values by hand


def test_a_long_move_has_the_seven_textbook_phases() -> None:
    """1000 mm at 200 mm/s, 500 mm/s², 2500 mm/s³: 0.2 s jerk, 0.2 s hold, cruise, mirrored."""
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_position(t, j, 0.0, 0.0, 0.0, 1000.0, 0.0, 200.0, 500.0, 500.0, 2500.0)
    assert n == 7
    # each ramp lasts 0.6 s and covers 100 mm/s * 0.6 s = 60 mm; 880 mm remain at 200 mm/s
    assert t[:7] == pytest.approx([0.2, 0.2, 0.2, 4.4, 0.2, 0.2, 0.2])
    assert j[:7] == [2500.0, 0.0, -2500.0, 0.0, -2500.0, 0.0, 2500.0]
    assert duration(t, n) == pytest.approx(5.6)


def test_a_short_move_is_jerk_only() -> None:
    """2 j t³ = distance for four equal phases: 0.002 mm at 1000 mm/s³ take 4 * 0.01 s."""
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_position(t, j, 5.0, 0.0, 0.0, 4.998, 0.0, 100.0, 1e4, 1e4, 1000.0)
    assert j[:n] == [-1000.0, 1000.0, 1000.0, -1000.0]
    assert t[:n] == pytest.approx([0.01] * 4)


def test_acceleration_and_deceleration_follow_the_direction_of_travel() -> None:
    for sign in (1.0, -1.0):
        t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
        n = plan_to_position(t, j, 0.0, 0.0, 0.0, sign * 1e3, 0.0, 200.0, 1000.0, 100.0, 1e4)
        assert t[:n] == pytest.approx([0.1, 0.1, 0.1, t[3], 0.01, 1.99, 0.01])
        assert j[0] == sign * 1e4


def test_a_target_behind_is_reached_through_rest() -> None:
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_position(t, j, 0.0, 100.0, 0.0, -50.0, 0.0, 200.0, 1000.0, 500.0, 1e4)
    p, v, a = end_state(t, j, 3, 0.0, 100.0, 0.0)
    assert p == pytest.approx(stopping_distance(100.0, 0.0, 500.0, 1e4))
    assert (v, a) == (pytest.approx(0.0, abs=1e-12), 0.0)
    assert end_state(t, j, n, 0.0, 100.0, 0.0)[0] == pytest.approx(-50.0, abs=1e-12)


def test_a_reduced_override_slows_down_with_the_deceleration() -> None:
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_position(t, j, 0.0, 200.0, 0.0, 1000.0, 0.0, 100.0, 1000.0, 500.0, 1e4)
    assert n == 7
    assert t[:3] == pytest.approx([0.05, 0.15, 0.05])  # 100 mm/s at 500 mm/s², 1e4 mm/s³
    assert end_state(t, j, 3, 0.0, 200.0, 0.0)[1:] == (pytest.approx(100.0), 0.0)


def test_between_braking_on_and_releasing_first_the_deceleration_is_eased() -> None:
    """From 100 mm/s with -400 mm/s² there are distances that neither alone can meet."""
    v, a, dec, jerk = 100.0, -400.0, 500.0, 4000.0
    brake_on = stopping_distance(v, a, dec, jerk)
    released = v - a * a / (2.0 * jerk)
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    release = segment_position(-a / jerk, jerk, 0.0, v, a)
    longest = release + stopping_distance(released, 0.0, dec, jerk)
    assert longest > brake_on * 1.01
    before = stopping_time(v, a, dec, jerk)
    for step in range(1, 20):
        target = brake_on + step / 20.0 * (longest - brake_on)
        n = plan_to_position(t, j, 0.0, v, a, target, 0.0, 200.0, 1000.0, dec, jerk)
        assert j[0] == jerk
        assert -400.0 < a + t[0] * j[0] < 0.0
        assert end_state(t, j, n, 0.0, v, a)[0] == pytest.approx(target, rel=1e-13)
        assert duration(t, n) > before
        before = duration(t, n)


def test_at_the_target_nothing_is_planned() -> None:
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    assert plan_to_position(t, j, 7.0, 0.0, 0.0, 7.0, 0.0, 100.0, 1e3, 1e3, 1e4) == 0
    assert plan_to_velocity(t, j, 50.0, 0.0, 50.0, 1e3, 1e3, 1e4) == 0
    assert plan_to_velocity(t, j, 0.0, 0.0, 0.0, 1e3, 1e3, 1e4) == 0


def test_a_velocity_ramp_through_zero_rests_between() -> None:
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_velocity(t, j, 100.0, 0.0, -100.0, 1000.0, 500.0, 1e4)
    assert n == 5  # the way back just touches its acceleration limit
    assert t[:5] == pytest.approx([0.05, 0.15, 0.05, 0.1, 0.1])
    assert end_state(t, j, 3, 0.0, 100.0, 0.0)[1:] == (pytest.approx(0.0, abs=1e-12), 0.0)
    assert end_state(t, j, n, 0.0, 100.0, 0.0)[1:] == (pytest.approx(-100.0), 0.0)


def test_an_end_velocity_above_the_limit_is_reached_just_before_the_target() -> None:
    """1000 mm at 100 mm/s, out at 300 mm/s: 500 mm/s² and 2500 mm/s³ give 0.4 and 0.6 s ramps."""
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_position(t, j, 0.0, 0.0, 0.0, 1000.0, 300.0, 100.0, 500.0, 500.0, 2500.0)
    cruise = (1000.0 - 50.0 * 0.4 - 200.0 * 0.6) / 100.0
    assert t[:n] == pytest.approx([0.2, 0.2, cruise, 0.2, 0.2, 0.2])
    assert end_state(t, j, 3, 0.0, 0.0, 0.0)[1:] == (pytest.approx(100.0), 0.0)
    assert end_state(t, j, n, 0.0, 0.0, 0.0) == pytest.approx((1000.0, 300.0, 0.0))


def test_where_both_ramps_do_not_fit_one_weaker_ramp_takes_the_way() -> None:
    """75 mm to 300 mm/s at a mean of 150 mm/s take 0.5 s; a strength of 750 mm/s² fits that."""
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    n = plan_to_position(t, j, 0.0, 0.0, 0.0, 75.0, 300.0, 100.0, 800.0, 800.0, 7500.0)
    assert duration(t, n) == pytest.approx(0.5)
    assert max(end_state(t, j, i, 0.0, 0.0, 0.0)[2] for i in range(n)) == pytest.approx(750.0)
    assert end_state(t, j, n, 0.0, 0.0, 0.0) == pytest.approx((75.0, 300.0, 0.0), abs=1e-9)


@given(situations())
@settings(max_examples=37, deadline=None)
def test_the_highest_velocity_is_that_of_a_ramp_over_the_distance(case: Any) -> None:
    _, v, _, _, _, top, acc, _, jerk = case
    lowest, change = abs(v), top
    time = 2.0 * math.sqrt(change / jerk)
    if change * jerk > acc * acc:
        time = change / acc + acc / jerk
    distance = (lowest + 0.5 * change) * time
    highest = highest_velocity(distance, lowest, acc, jerk)
    assert highest == pytest.approx(lowest + change, rel=1e-9)
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    state = 0.0, lowest, 0.0, distance
    limits = highest, acc, acc, jerk
    assert plan_to_position(t, j, *state, highest * (1.0 - 1e-9), *limits) > 0
    assert plan_to_position(t, j, *state, highest * (1.0 + 1e-9), *limits) < 0


@given(situations())
@settings(max_examples=37, deadline=None)
def test_the_reachable_velocity_is_reached_and_no_higher_one(case: Any) -> None:
    _, v, a, _, _, top, acc, dec, jerk = case
    v = max(abs(v), 1e-3 * top)
    a = min(max(a, -dec, -math.sqrt(2.0 * jerk * v)), acc)
    distance = top * math.sqrt(top / jerk)
    reachable = reachable_velocity(distance, v, a, acc, jerk)
    assume(reachable > 1e-6 * top)
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    fits = reachable * (1.0 - 1e-9)
    n = plan_to_position(t, j, 0.0, v, a, distance, fits, reachable, acc, dec, jerk)
    assert n > 0
    p, w, b = end_state(t, j, n, 0.0, v, a)
    assert (p, w) == pytest.approx((distance, fits), rel=1e-6)
    assert b == pytest.approx(0.0, abs=1e-6 * acc)
    more = reachable * (1.0 + 1e-6)
    assert plan_to_position(t, j, 0.0, v, a, distance, more, more, acc, dec, jerk) < 0


def test_bad_numbers_are_refused_by_name() -> None:
    t, j = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    good = [0.0, 0.0, 0.0, 10.0, 0.0, 100.0, 1e3, 1e3, 1e4]
    for index in (5, 6, 7, 8):
        for bad in (0.0, -1.0, math.nan, math.inf):
            case = list(good)
            case[index] = bad
            assert plan_to_position(t, j, *case) == LIMITS_INVALID
    for index in (0, 1, 2, 3):
        for bad in (math.nan, math.inf, -math.inf, 1e16):
            case = list(good)
            case[index] = bad
            assert plan_to_position(t, j, *case) == STATE_INVALID
    assert plan_to_velocity(t, j, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0) == LIMITS_INVALID
    wide = [0.0, 0.0, 0.0, 10.0, 0.0, 1e20, 1e20, 1e20, 1e30]
    assert plan_to_position(t, j, *wide) > 0
    assert end_state(t, j, plan_to_position(t, j, *wide), 0.0, 0.0, 0.0)[0] == pytest.approx(10.0)
    assert plan_to_velocity(t, j, math.nan, 0.0, 1.0, 1.0, 1.0, 1.0) == STATE_INVALID
    for end in (-1.0, math.inf, math.nan):
        case = list(good)
        case[4] = end
        assert plan_to_position(t, j, *case) == END_VELOCITY_UNREACHABLE
    too_short = [0.0, 0.0, 0.0, 1e-3, 99.0, 100.0, 1e3, 1e3, 1e4]
    assert plan_to_position(t, j, *too_short) == END_VELOCITY_UNREACHABLE
