"""A set-point table: segments of constant jerk, written and walked.

Times in seconds and jerks are in two sequences of at least `MAX_SEGMENTS` floats, owned by the
caller. Plain functions in the language of `achse.native`.
"""

from collections.abc import MutableSequence, Sequence

MAX_SEGMENTS = 12  # unavoidable crossing 1, bring-in 1, brake to rest 3, return 7

_CANCELLED = 1e-11


def segment_position(t: float, j: float, p: float, v: float, a: float) -> float:
    """Position after `t` seconds of jerk `j` from the state (p, v, a)."""
    return p + t * (v + t * (0.5 * a + t * (j / 6.0)))


def segment_velocity(t: float, j: float, v: float, a: float) -> float:
    """Velocity after `t` seconds of jerk `j` from the state (v, a)."""
    return v + t * (a + t * (0.5 * j))


def segment_acceleration(t: float, j: float, a: float) -> float:
    """Acceleration after `t` seconds of jerk `j`; zero where only rounding is left of it.

    Left standing, 1e-15 unit/s² would bend an hour of constant velocity.
    """
    result = a + t * j
    if abs(result) <= _CANCELLED * abs(a):
        return 0.0
    return result


def duration(seg_time: Sequence[float], count: int) -> float:
    """Sum of the first `count` segment times, in seconds."""
    total = 0.0
    for i in range(count):
        total += seg_time[i]
    return total


def end_state(
    seg_time: Sequence[float],
    seg_jerk: Sequence[float],
    count: int,
    position: float,
    velocity: float,
    acceleration: float,
) -> tuple[float, float, float]:
    """State (position, velocity, acceleration) after the first `count` segments."""
    p = position
    v = velocity
    a = acceleration
    for i in range(count):
        t = seg_time[i]
        j = seg_jerk[i]
        p = segment_position(t, j, p, v, a)
        v = segment_velocity(t, j, v, a)
        a = segment_acceleration(t, j, a)
    return p, v, a


def append_segment(
    seg_time: MutableSequence[float], seg_jerk: MutableSequence[float], n: int, t: float, j: float
) -> int:
    """Write segment `n` unless it is empty; return the next free index."""
    if t <= 0.0:
        return n
    seg_time[n] = t
    seg_jerk[n] = j
    return n + 1
