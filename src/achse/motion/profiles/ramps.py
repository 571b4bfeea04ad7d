"""Velocity ramps: the time, peak and reach of a change between two velocities.

A ramp begins and ends without acceleration, or is entered on its own jerk line; acceleration and
jerk are limited. Plain functions in the language of `achse.native`.
"""

from collections.abc import MutableSequence
from math import sqrt
from typing import TypeAlias

from achse.motion.profiles.segments import append_segment

Limits: TypeAlias = tuple[float, float, float]  # max_acceleration, max_deceleration, max_jerk

NEGLIGIBLE = 1e-60  # distances below would underflow in the powers below; no axis knows them
CONVERGED = 4e-16
MAX_ITERATIONS = 40  # at most a dozen were ever needed

_SMALLEST_LIMIT = 1e-9  # with these bounds no intermediate result overflows;
_LARGEST_LIMIT = 1e12  # limits beyond count as the bound
_SMALL = 1e-4  # ratio of two accelerations below which the rounding error of the larger counts


def bounded(limit: float) -> float:
    """Return the limit, or the nearest one that can be computed with."""
    if limit < _SMALLEST_LIMIT:
        return _SMALLEST_LIMIT
    return limit if limit < _LARGEST_LIMIT else _LARGEST_LIMIT


def cube_root(x: float) -> float:
    """Cube root of x > 0: x^(1/4 + 1/16 + 1/64) by square roots, then Halley steps."""
    quarter = sqrt(sqrt(x))
    sixteenth = sqrt(sqrt(quarter))
    y = quarter * sixteenth * sqrt(sqrt(sixteenth))
    for _ in range(4):
        cube = y * y * y
        y = y * ((cube + 2.0 * x) / (2.0 * cube + x))
    return y


def ramp_time(change: float, limit: float, jerk: float) -> float:
    """Duration of the velocity ramp by `change` >= 0 between two states of zero acceleration."""
    if change * jerk <= limit * limit:
        return 2.0 * sqrt(change / jerk)
    return change / limit + limit / jerk


def ramp_peak(change: float, limit: float, jerk: float) -> float:
    """Largest acceleration on that ramp."""
    if change * jerk <= limit * limit:
        return sqrt(change * jerk)
    return limit


def append_change(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    n: int,
    a: float,
    peak: float,
    size: float,
    jerk: float,
) -> int:
    """Append the change of acceleration from `a` to `peak` >= 0, both in the sense of `jerk`.

    If the peak is small against `a`, the acceleration passes through exactly 0: otherwise the
    rounding error of `a` remains behind the peak and bends the rest of the profile, which may last
    hours. Behind a segment of the same jerk that segment is extended to 0, because the table has no
    room for another one.
    """
    if peak < -a * _SMALL:
        if n > 1 and seg_jerk[n - 1] == jerk:
            seg_time[n - 1] -= a / size
        else:
            n = append_segment(seg_time, seg_jerk, n, -a / size, jerk)
        a = 0.0
    return append_segment(seg_time, seg_jerk, n, (peak - a) / size, jerk)


def append_ramp(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    n: int,
    change: float,
    a: float,
    limit: float,
    size: float,
    jerk: float,
) -> int:
    """Append a velocity ramp entered with `a`, counted positive in the ramp's sense.

    `change` >= 0 is counted from the velocity where the entering jerk line crosses a = 0; `jerk` is
    that line's signed jerk, `size` its magnitude.
    """
    peak = ramp_peak(change, limit, size)
    n = append_change(seg_time, seg_jerk, n, a, peak, size, jerk)
    if peak == limit:
        n = append_segment(seg_time, seg_jerk, n, change / limit - limit / size, 0.0)
    return append_segment(seg_time, seg_jerk, n, peak / size, -jerk)


def append_velocity_ramp(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    n: int,
    sign: float,
    v: float,
    a: float,
    goal: float,
    limits: Limits,
) -> int:
    """Append the fastest ramp from (v, a) to (goal, 0); travel frame, both velocities >= 0."""
    acc, dec, jerk = limits
    swing = a * a / (2.0 * jerk)
    settled = v - swing if a < 0.0 else v + swing
    if goal > settled:
        change = goal - (v - swing)
        return append_ramp(seg_time, seg_jerk, n, change, a, acc, jerk, sign * jerk)
    change = v + swing - goal
    return append_ramp(seg_time, seg_jerk, n, change, -a, dec, jerk, -sign * jerk)


def highest_velocity(distance: float, lowest: float, limit: float, jerk: float) -> float:
    """Highest velocity that a ramp from `lowest` reaches within `distance` >= 0.

    Both ends are without acceleration; as well the highest one to brake from down to `lowest` >= 0.
    """
    limit = bounded(limit)
    jerk = bounded(jerk)
    half = limit / jerk
    if distance >= (2.0 * lowest + limit * half) * half:
        # holding the limit: change²/2 + change (lowest + limit half/2) = limit (way - lowest half)
        linear = lowest + 0.5 * limit * half
        constant = limit * (distance - lowest * half)
        return lowest + 2.0 * constant / (linear + sqrt(linear * linear + 2.0 * constant))
    # Jerk only: with u² = change, u³ + 2 lowest u = distance sqrt(jerk), Newton from above.
    goal = distance * sqrt(jerk)
    if goal <= NEGLIGIBLE:
        return lowest
    u = cube_root(goal) if lowest >= 0.0 else cube_root(2.0 * goal) + 2.0 * sqrt(-lowest)
    if goal < 2.0 * lowest * u:
        u = goal / (2.0 * lowest)
    for _ in range(MAX_ITERATIONS):
        step = (u * (u * u + 2.0 * lowest) - goal) / (3.0 * u * u + 2.0 * lowest)
        if step <= 0.0:
            break
        u -= step
        if step <= CONVERGED * u:
            break
    return lowest + u * u


def reachable_velocity(distance: float, v: float, a: float, limit: float, jerk: float) -> float:
    """Highest velocity that can be had, without acceleration, after `distance`; -1 if none.

    Travel frame: v >= 0, and a negative `a` can be released before v = 0.
    """
    jerk = bounded(jerk)
    braked = -a / jerk
    swing = a * a / (2.0 * jerk)
    start = v - swing
    distance -= braked * (start + jerk * braked * braked / 6.0)
    if distance < 0.0:
        return -1.0
    highest = highest_velocity(distance, start, limit, jerk)
    if highest < (v + swing if a > 0.0 else start):
        return -1.0
    return highest
