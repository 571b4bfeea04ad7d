"""Ramps along the path: from a velocity and an acceleration to another velocity, jerk-limited.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from math import sqrt

_HALVINGS = 60


def _phases(
    v: float, a: float, w: float, acceleration: float, deceleration: float, jerk: float
) -> tuple[float, float, float, float, float, float]:
    """Three phases that lead from (v, a) to (w, 0) in the shortest time.

    Jerk and duration of the first, acceleration and duration of the second, jerk and duration of
    the third.
    """
    sign = 1.0
    limit = acceleration
    if v + 0.5 * a * abs(a) / jerk > w:
        sign = -1.0
        limit = deceleration
    rise = sign * (w - v)
    b = sign * a
    square = max(jerk * rise + 0.5 * b * b, 0.0)
    top = sqrt(square)
    if top < b:
        top = b  # rounding
    if top <= limit:
        return sign * jerk, (top - b) / jerk, sign * top, 0.0, -sign * jerk, top / jerk
    top = limit
    first = sign * jerk
    way = top * top - b * b
    duration = (top - b) / jerk
    if b > top:
        first = -first
        way = -way
        duration = -duration
    constant = max((rise - 0.5 * (way + top * top) / jerk) / top, 0.0)
    return first, duration, sign * top, constant, -sign * jerk, top / jerk


def ramp_duration(
    v: float, a: float, w: float, acceleration: float, deceleration: float, jerk: float
) -> float:
    """Time of the ramp from (v, a) to (w, 0)."""
    _, t1, _, t2, _, t3 = _phases(v, a, w, acceleration, deceleration, jerk)
    return t1 + t2 + t3


def ramp_after(
    v: float, a: float, w: float, acceleration: float, deceleration: float, jerk: float, time: float
) -> tuple[float, float, float]:
    """Way, velocity and acceleration after some time on the ramp to w; behind its end it is w."""
    j1, t1, top, t2, j3, t3 = _phases(v, a, w, acceleration, deceleration, jerk)
    t = min(time, t1)
    way = t * (v + t * (0.5 * a + t * j1 / 6.0))
    v += t * (a + 0.5 * t * j1)
    a += t * j1
    if time <= t1:
        return way, v, a
    a = top
    t = min(time - t1, t2)
    way += t * (v + t * 0.5 * a)
    v += t * a
    if time <= t1 + t2:
        return way, v, a
    t = min(time - t1 - t2, t3)
    way += t * (v + t * (0.5 * a + t * j3 / 6.0))
    v += t * (a + 0.5 * t * j3)
    a += t * j3
    if time < t1 + t2 + t3:
        return way, v, a
    return way + (time - t1 - t2 - t3) * w, w, 0.0


def stretch(v: float, a: float, w: float, deceleration: float, jerk: float) -> float:
    """Shortest way on which the velocity comes to w and stays there; 0 if it never exceeds it."""
    released = v + 0.5 * a * abs(a) / jerk
    if released <= w:
        if v <= w:
            return 0.0
        # it brakes more than needed: to where it gets below w while the brake is released
        t = (-a - sqrt(max(a * a - 2.0 * jerk * (v - w), 0.0))) / jerk
        return t * (v + t * (0.5 * a + t * jerk / 6.0))
    top = sqrt(max(jerk * (v - w) + 0.5 * a * a, 0.0))
    constant = 0.0
    j = -jerk
    t = (a + top) / jerk
    if top > deceleration:
        top = deceleration
        t = (a + top) / jerk
        if t < 0.0:
            t = -t
            j = jerk
        constant = (released - w) / top
        if a > -top:
            constant = (v - w + (0.5 * a * a - top * top) / jerk) / top
    way = t * (v + t * (0.5 * a + t * j / 6.0))
    v += t * (a + 0.5 * t * j)
    way += constant * (v - 0.5 * constant * top)
    v -= constant * top
    t = top / jerk
    return way + t * (v + t * (-0.5 * top + t * jerk / 6.0))


def reachable(w: float, length: float, deceleration: float, jerk: float) -> float:
    """Return the highest velocity from which, with no acceleration, w is reached within a
    length."""
    if length <= 0.0:
        return w
    # with a phase of constant deceleration: (2 w + d) (d / deceleration + lag) = 2 length
    lag = deceleration / jerk
    half = 0.5 * (2.0 * w + deceleration * lag)
    rest = 2.0 * deceleration * (length - w * lag)
    if rest > 0.0:
        d = rest / (half + sqrt(half * half + rest))
        if d >= deceleration * lag:
            return w + d
    # without: (2 w + y²) y = length sqrt(jerk), y² = d
    target = length * sqrt(jerk)
    y: float = target ** (1.0 / 3.0)
    if 2.0 * w * y > target:
        y = min(y, target / (2.0 * w))
    for _ in range(_HALVINGS):
        step = ((2.0 * w + y * y) * y - target) / (2.0 * w + 3.0 * y * y)
        y -= step
        if abs(step) <= 1e-15 * y:
            break
    return w + y * y


def rest_is_nearer(w: float, deceleration: float, jerk: float) -> bool:
    """Return True if a ramp to rest may be shorter than one to w, which releases the brake earlier.

    From v, with deceleration, it is for w below deceleration² / jerk; without, below 0.618 v.
    """
    return 0.0 < w * jerk < 2.0 * deceleration * deceleration
