"""Jerk-limited set-point profiles: constant-jerk segments from any state to a position or velocity.

Units are the axis unit (mm, degree) and seconds. `max_acceleration` limits |v| growing and
`max_deceleration` limits |v| shrinking, in both directions of travel alike; one `max_jerk` limits
both. A reversal always passes rest (v = 0 with a = 0). A start state outside the limits is allowed:
an acceleration beyond its limit is first brought inside with `max_jerk`, a velocity above
`max_velocity` is first reduced with `max_deceleration`. An end velocity above `max_velocity` is
reached by one last ramp just before the target. Limits that no axis has (below 1e-9, above 1e12)
count as these bounds.

Every profile without a reversal is time optimal. With the state mirrored so that travel is
positive, a jerk line through (v, a) crosses a = 0 at v - a²/2j; seen from there each velocity ramp
is point symmetric, so its distance is mean velocity times duration, and a move is two such ramps
meeting at the peak velocity. Distances too short to release a running deceleration to zero are
filled by easing it to some a1 in [a, 0] and braking again. What has no closed form is solved by
Newton steps on a convex function from above its root: monotone, hence safe, and bounded.

Plain functions in the language of `achse.native`, so that machine code gives the same bits: floats,
`sqrt`, comparisons and loops; callees are before their callers. Times and jerks are written into
sequences of at least `MAX_SEGMENTS` floats owned by the caller.
"""

from collections.abc import MutableSequence
from math import sqrt

from achse.motion.profiles.ramps import (
    CONVERGED,
    MAX_ITERATIONS,
    NEGLIGIBLE,
    Limits,
    append_change,
    append_ramp,
    append_velocity_ramp,
    bounded,
    cube_root,
    ramp_peak,
    ramp_time,
)
from achse.motion.profiles.segments import append_segment, end_state, segment_position

LIMITS_INVALID = -1  # a limit not positive or not finite
STATE_INVALID = -2  # position, velocity, acceleration or target not finite or beyond ±1e15
END_VELOCITY_UNREACHABLE = -3  # negative, not finite, or the distance is too short for it
_OVERSHOOT = -4  # the brakes do not hold before the target

_LARGEST_STATE = 1e15
_INFINITE = 1e300
_ROUNDING = 1e-13  # what accumulated rounding of a replanned state may amount to, relative


def _limit_is_valid(limit: float) -> bool:
    return limit > 0.0 and limit < _INFINITE


def _state_is_valid(value: float) -> bool:
    return abs(value) <= _LARGEST_STATE


def _travel_sign(v: float, a: float, otherwise: float) -> float:
    """Direction of travel: sign of v, at v = 0 of a, at rest of `otherwise` (0 counts positive)."""
    if v != 0.0:
        return 1.0 if v > 0.0 else -1.0
    if a != 0.0:
        return 1.0 if a > 0.0 else -1.0
    return 1.0 if otherwise >= 0.0 else -1.0


def _append_bring_in(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    v: float,
    a: float,
    limits: Limits,
) -> tuple[int, float, float]:
    """Start a profile with what no plan can avoid; return segment count, velocity, acceleration.

    A deceleration too strong to be released before v = 0 crosses into the other direction (with the
    least acceleration possible); an acceleration beyond its limit is brought to it.
    """
    acc, dec, jerk = limits
    n = 0
    sign = _travel_sign(v, a, 1.0)
    speed = sign * v
    growth = sign * a
    if growth < 0.0 and speed - growth * growth / (2.0 * jerk) < -_ROUNDING * speed:
        left = sqrt(growth * growth - 2.0 * jerk * speed)
        n = append_segment(seg_time, seg_jerk, n, 2.0 * speed / (left - growth), sign * jerk)
        sign = -sign
        speed = 0.0
        growth = left
    if growth > acc:
        time = (growth - acc) / jerk
        n = append_segment(seg_time, seg_jerk, n, time, -sign * jerk)
        speed += time * (0.5 * (growth + acc))
        growth = acc
    elif growth < -dec:
        time = (-dec - growth) / jerk
        n = append_segment(seg_time, seg_jerk, n, time, sign * jerk)
        speed += time * (0.5 * (growth - dec))
        growth = -dec
    return n, sign * speed, sign * growth


def _peak_rise(
    excess: float,
    base: float,
    start: float,
    start_gap: float,
    end: float,
    end_gap: float,
    rise_limit: float,
    limits: Limits,
) -> float:
    """Return the excess of the peak velocity over `base` if two ramps meeting there are too short.

    The ramps run from `start` (= base - start_gap) up and down to `end` (= base - end_gap); meeting
    at `base` they leave `excess` of the distance uncovered.
    """
    if excess <= NEGLIGIBLE:
        return 0.0
    acc, dec, jerk = limits
    start_time = ramp_time(start_gap, acc, jerk)
    end_time = ramp_time(end_gap, dec, jerk)
    distance = 0.5 * ((start + base) * start_time + (end + base) * end_time) + excess
    slowness = 1.0 / acc + 1.0 / dec
    # Both ramps holding their limit: a quadratic in the peak velocity.
    linear = (acc + dec) / jerk
    constant = 2.0 * distance + start * (start / acc - acc / jerk) + end * (end / dec - dec / jerk)
    if constant > 0.0:
        root = sqrt(linear * linear + 4.0 * slowness * constant)
        rise = 2.0 * constant / (linear + root) - base
        if (
            rise >= 0.0
            and (rise + start_gap) * jerk >= acc * acc
            and (rise + end_gap) * jerk >= dec * dec
        ):
            return rise if rise < rise_limit else rise_limit
    # Else the distance is a convex function of u = sqrt(rise); each part of it bounds u from above.
    root_jerk = sqrt(jerk)
    u = cube_root(0.5 * excess * root_jerk)
    bound = u * u
    other = sqrt(2.0 * excess / slowness)
    if other < bound:
        bound = other
    if rise_limit < bound:
        bound = rise_limit
    slope = (start + base) / acc + (end + base) / dec + start_time + end_time
    if slope > 0.0:
        other = 2.0 * excess / slope
        if other < bound:
            bound = other
    if start + base > 0.0:
        other = excess * root_jerk / (start + base)
        other = other * (other + 2.0 * sqrt(start_gap))
        if other < bound:
            bound = other
    if end + base > 0.0:
        other = excess * root_jerk / (end + base)
        other = other * (other + 2.0 * sqrt(end_gap))
        if other < bound:
            bound = other
    u = sqrt(bound)
    for i in range(MAX_ITERATIONS):
        rise = u * u
        peak = base + rise
        # covered: twice the distance of both ramps; growth: its derivative, divided by 2 u
        change = start_gap + rise
        if change * jerk <= acc * acc:
            root = sqrt(change / jerk)
            time = 2.0 * root
            growth = time + (start + peak) / (jerk * root)
        else:
            time = change / acc + acc / jerk
            growth = time + (start + peak) / acc
        covered = (start + peak) * time
        change = end_gap + rise
        if change * jerk <= dec * dec:
            root = sqrt(change / jerk)
            time = 2.0 * root
            growth += time + (end + peak) / (jerk * root)
        else:
            time = change / dec + dec / jerk
            growth += time + (end + peak) / dec
        covered += (end + peak) * time
        step = (0.5 * covered - distance) / (u * growth)
        if i > 0 and step <= 0.0:
            break
        u -= step
        if abs(step) <= CONVERGED * u:
            break
    rise = u * u
    return rise if rise < rise_limit else rise_limit


def _eased_hold(
    distance: float, braked: float, gap: float, end: float, dec: float, jerk: float, slack: float
) -> float:
    """Time r such that easing the deceleration to jerk r, then braking to `end`, fits `distance`.

    The deceleration now is jerk `braked`; released to zero it would leave the velocity
    end + jerk gap (gap > 0), and `distance` is counted from the position that belongs to this. The
    time falls from `braked` (brake on) to 0 (release) as the distance grows; -1 if even braking on
    is too long.
    """
    full = dec / jerk
    both = 2.0 * end + jerk * gap
    keep = sqrt(full * full - gap) if gap < full * full else 0.0
    if braked > keep:
        # For r > keep the braking holds `dec`: with k = full - r the distance exceeds that of k = 0
        # by jerk k²/full (c/2 - full k + k²/2), convex and rising in k.
        half = end / jerk + gap + 0.5 * full * full
        at_full = gap / full * (end + 0.5 * jerk * (gap - full * full))
        more = (distance - at_full) * full / jerk
        k = full - braked
        least = k * k * (half - full * k + 0.5 * k * k)
        if more < least:
            if more < least - slack * full / jerk:
                return -1.0
            return braked
        k = gap / (full + keep) if keep > 0.0 else full
        if more <= k * k * (half - full * k + 0.5 * k * k):
            steep = 2.0 * end / jerk + full * full
            other = 2.0 * end / jerk + 2.0 * gap - 0.125 * full * full
            if other > steep:
                steep = other
            other = sqrt(2.0 * more / steep)
            if other < k:
                k = other
            for i in range(MAX_ITERATIONS):
                if k <= 0.0:
                    break
                step = k * k * (half - full * k + 0.5 * k * k) - more
                step /= k * (2.0 * half - 3.0 * full * k + 2.0 * k * k)
                if i > 0 and step <= 0.0:
                    break
                k -= step
                if abs(step) <= CONVERGED * k:
                    break
            r = full - k
            return r if r < braked else braked
    else:
        wide = sqrt(gap + braked * braked) + braked
        h = gap / wide
        least = (both + 0.25 * jerk * h * h) * h - 0.25 * jerk * gap * wide
        if distance < least:
            return -1.0 if distance < least - slack else braked
    # The braking peaks below `dec`: with h = sqrt(gap + r²) - r the distance is
    # both h + jerk h³/4 - jerk gap²/(4 h), and times h a convex quartic.
    low = 0.25 * jerk * gap * gap
    if low <= NEGLIGIBLE:
        return braked
    root = sqrt(distance * distance + 4.0 * both * low)
    h = (distance + root) / (2.0 * both) if distance > 0.0 else 2.0 * low / (root - distance)
    for i in range(MAX_ITERATIONS):
        step = ((0.25 * jerk * h * h + both) * h - distance) * h - low
        step /= (jerk * h * h + 2.0 * both) * h - distance
        if i > 0 and step <= 0.0:
            break
        h -= step
        if abs(step) <= CONVERGED * h:
            break
    r = 0.5 * (gap / h - h)
    if r < 0.0:
        return 0.0
    return r if r < braked else braked


def _append_approach(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    n: int,
    sign: float,
    distance: float,
    v: float,
    a: float,
    end: float,
    top: float,
    limits: Limits,
    slack: float,
) -> int:
    """Append the fastest profile over `distance` to (end, 0) that keeps the direction of travel.

    Travel frame: distance >= 0, v >= 0, -dec <= a <= acc, and `a` can be released before v = 0.
    `slack`: rounding of the distance. Returns the count, _OVERSHOOT or END_VELOCITY_UNREACHABLE.
    """
    acc, dec, jerk = limits
    swing = a * a / (2.0 * jerk)
    settled = v - swing if a < 0.0 else v + swing  # velocity if `a` is released to zero now
    if settled < 0.0:
        settled = 0.0
    if settled > top * (1.0 + _ROUNDING):
        # Too fast: brake until releasing the deceleration leaves `top`, then see what remains.
        change = v + swing - top
        peak = ramp_peak(change, dec, jerk)
        time = (a + peak) / jerk
        if time > 0.0:
            n = append_change(seg_time, seg_jerk, n, -a, peak, jerk, -sign * jerk)
            distance -= segment_position(time, -jerk, 0.0, v, a)
        a = -peak
        swing = a * a / (2.0 * jerk)
        if peak == dec:
            time = change / dec - dec / jerk
            if time > 0.0:
                n = append_segment(seg_time, seg_jerk, n, time, 0.0)
                distance -= time * (top + swing + 0.5 * dec * time)
        settled = top
    # The ramp up is on the jerk line through (v, a), which leaves a = 0 at velocity `start`.
    braked = -a / jerk
    start = v - swing if a > 0.0 else settled
    distance -= braked * (start + jerk * braked * braked / 6.0)
    release = 0.5 * ((settled + end) * ramp_time(abs(settled - end), dec, jerk))
    if a < 0.0 and settled > end and distance < release:
        gap = (settled - end) / jerk
        r = _eased_hold(distance, braked, gap, end, dec, jerk, slack)
        if r < 0.0:
            return _OVERSHOOT
        n = append_segment(seg_time, seg_jerk, n, braked - r, sign * jerk)
        change = jerk * (gap + r * r)
        return append_ramp(seg_time, seg_jerk, n, change, jerk * r, dec, jerk, -sign * jerk)
    base = settled
    start_gap = a * a / jerk if a > 0.0 else 0.0
    if end > settled:
        base = end
        start_gap = end - start
    end_gap = base - end
    excess = distance - 0.5 * (
        (start + base) * ramp_time(start_gap, acc, jerk)
        + (end + base) * ramp_time(end_gap, dec, jerk)
    )
    if excess < -slack:
        return END_VELOCITY_UNREACHABLE if end > 0.0 and settled <= end else _OVERSHOOT
    rise = top - base if top > base else 0.0
    peak = base + rise
    covered = (start + peak) * ramp_time(start_gap + rise, acc, jerk)
    covered += (end + peak) * ramp_time(end_gap + rise, dec, jerk)
    cruise = (distance - 0.5 * covered) / peak
    if cruise < 0.0:
        rise = _peak_rise(excess, base, start, start_gap, end, end_gap, rise, limits)
    n = append_ramp(seg_time, seg_jerk, n, start_gap + rise, a, acc, jerk, sign * jerk)
    n = append_segment(seg_time, seg_jerk, n, cruise, 0.0)
    return append_ramp(seg_time, seg_jerk, n, end_gap + rise, 0.0, dec, jerk, -sign * jerk)


def _append_rise(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    n: int,
    sign: float,
    distance: float,
    v: float,
    a: float,
    end: float,
    limits: Limits,
    slack: float,
) -> int:
    """Append one ramp up to `end` that takes just `distance`, as strong as that needs.

    Travel frame as in `_append_approach`; releasing `a` leaves a velocity of at most `end`. Returns
    the count or END_VELOCITY_UNREACHABLE.
    """
    acc, _, jerk = limits
    if a < 0.0:
        braked = -a / jerk
        distance -= segment_position(braked, jerk, 0.0, v, a)
        n = append_segment(seg_time, seg_jerk, n, braked, sign * jerk)
        v -= a * a / (2.0 * jerk)
        a = 0.0
    lead = a / jerk
    start = v - 0.5 * lead * a
    settled = v + 0.5 * lead * a
    # Counted from where the jerk line through (v, a) has no acceleration, it is one whole ramp.
    way = distance + lead * (start + jerk * lead * lead / 6.0)
    mean = 0.5 * (start + end)
    change = end - start
    shortest = ramp_time(change, acc, jerk) if change > 0.0 else 0.0
    if way < mean * shortest - slack or mean <= 0.0:
        return END_VELOCITY_UNREACHABLE
    time = way / mean
    if time < shortest:
        time = shortest
    root = time * time - 4.0 * change / jerk
    limit = 2.0 * change / (time + (sqrt(root) if root > 0.0 else 0.0)) if change > 0.0 else 0.0
    if limit > acc:
        limit = acc
    if limit > a:
        return append_ramp(seg_time, seg_jerk, n, change, a, limit, jerk, sign * jerk)
    # Weaker than `a`, which is eased to `limit` for the time `hold`: a ramp by the change that is
    # left, upon the way of releasing `a` at once.
    change = end - settled if end > settled else 0.0
    mean = 0.5 * (settled + end)
    way = distance - lead * (v + jerk * lead * lead / 3.0)
    root = way * way - 2.0 * mean * change * change / jerk
    hold = 0.5 * (way + (sqrt(root) if root > 0.0 else 0.0)) / mean
    limit = change / hold if change < a * hold else a  # both may be rounding
    n = append_segment(seg_time, seg_jerk, n, (a - limit) / jerk, -sign * jerk)
    n = append_segment(seg_time, seg_jerk, n, hold, 0.0)
    return append_segment(seg_time, seg_jerk, n, limit / jerk, -sign * jerk)


def _append_travel(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    n: int,
    sign: float,
    distance: float,
    v: float,
    a: float,
    end: float,
    top: float,
    limits: Limits,
    slack: float,
) -> int:
    """Append the way to `end`; one above `top` is reached by a last ramp just before the target.

    Arguments and results of `_append_approach`.
    """
    if end > top:
        acc, _, jerk = limits
        rest = distance - 0.5 * (top + end) * ramp_time(end - top, acc, jerk)
        if rest >= 0.0:
            count = _append_approach(
                seg_time, seg_jerk, n, sign, rest, v, a, top, top, limits, slack
            )
            if count >= 0:
                return append_ramp(
                    seg_time, seg_jerk, count, end - top, 0.0, acc, jerk, sign * jerk
                )
        swing = a * a / (2.0 * jerk)
        if (v - swing if a < 0.0 else v + swing) <= end * (1.0 + _ROUNDING):
            return _append_rise(seg_time, seg_jerk, n, sign, distance, v, a, end, limits, slack)
        top = end
    return _append_approach(seg_time, seg_jerk, n, sign, distance, v, a, end, top, limits, slack)


def plan_to_position(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    position: float,
    velocity: float,
    acceleration: float,
    target: float,
    end_velocity: float,
    max_velocity: float,
    max_acceleration: float,
    max_deceleration: float,
    max_jerk: float,
) -> int:
    """Fill `seg_time` (s) and `seg_jerk` (unit/s³) with the way to `target`; return their count.

    0 means: already there. The profile ends with a = 0 and `end_velocity` >= 0 in the direction
    from `position` to `target` (where these are equal: of present travel); if the target is
    behind or the brakes do not hold before it, the axis first comes to rest and starts again. An
    `end_velocity` above `max_velocity` is reached by a ramp that ends at the target.
    Negative: `LIMITS_INVALID`, `STATE_INVALID`, or `END_VELOCITY_UNREACHABLE`, also when the last
    approach would arrive from the other side; the segments then hold nothing of use.
    """
    if not (
        _limit_is_valid(max_velocity)
        and _limit_is_valid(max_acceleration)
        and _limit_is_valid(max_deceleration)
        and _limit_is_valid(max_jerk)
    ):
        return LIMITS_INVALID
    if not (
        _state_is_valid(position)
        and _state_is_valid(velocity)
        and _state_is_valid(acceleration)
        and _state_is_valid(target)
    ):
        return STATE_INVALID
    if not (end_velocity >= 0.0 and end_velocity <= _LARGEST_STATE):
        return END_VELOCITY_UNREACHABLE
    top = bounded(max_velocity)
    limits = (bounded(max_acceleration), bounded(max_deceleration), bounded(max_jerk))
    slack = _ROUNDING * (abs(position) + abs(target))
    arrival = _travel_sign(target - position, velocity, acceleration)
    p = position
    v = velocity
    a = acceleration
    n = 0
    if a != 0.0:
        n, v, a = _append_bring_in(seg_time, seg_jerk, v, a, limits)
        p, _, _ = end_state(seg_time, seg_jerk, n, position, velocity, acceleration)
    remaining = target - p
    sign = _travel_sign(v, a, remaining)
    if sign * remaining >= 0.0 and (end_velocity == 0.0 or sign == arrival):
        count = _append_travel(
            seg_time, seg_jerk, n, sign, sign * remaining, sign * v, sign * a,
            end_velocity, top, limits, slack,
        )  # fmt: skip
        if count != _OVERSHOOT:
            return count
    n = append_velocity_ramp(seg_time, seg_jerk, n, sign, sign * v, sign * a, 0.0, limits)
    p, _, _ = end_state(seg_time, seg_jerk, n, position, velocity, acceleration)
    remaining = target - p
    sign = 1.0 if remaining >= 0.0 else -1.0
    if end_velocity > 0.0 and sign != arrival:
        return END_VELOCITY_UNREACHABLE
    return _append_travel(
        seg_time, seg_jerk, n, sign, sign * remaining, 0.0, 0.0,
        end_velocity, top, limits, slack,
    )  # fmt: skip


def plan_to_velocity(
    seg_time: MutableSequence[float],
    seg_jerk: MutableSequence[float],
    velocity: float,
    acceleration: float,
    target_velocity: float,
    max_acceleration: float,
    max_deceleration: float,
    max_jerk: float,
) -> int:
    """Fill the segments with the fastest ramp to `target_velocity` (signed; 0.0 stops), a = 0.

    A change of direction passes rest. Returns the count (0: already there), `LIMITS_INVALID` or
    `STATE_INVALID`.
    """
    if not (
        _limit_is_valid(max_acceleration)
        and _limit_is_valid(max_deceleration)
        and _limit_is_valid(max_jerk)
    ):
        return LIMITS_INVALID
    if not (
        _state_is_valid(velocity)
        and _state_is_valid(acceleration)
        and _state_is_valid(target_velocity)
    ):
        return STATE_INVALID
    limits = (bounded(max_acceleration), bounded(max_deceleration), bounded(max_jerk))
    v = velocity
    a = acceleration
    n = 0
    if a != 0.0:
        n, v, a = _append_bring_in(seg_time, seg_jerk, v, a, limits)
    sign = _travel_sign(v, a, target_velocity)
    goal = sign * target_velocity
    first = goal if goal > 0.0 else 0.0
    n = append_velocity_ramp(seg_time, seg_jerk, n, sign, sign * v, sign * a, first, limits)
    if goal < 0.0:
        n = append_velocity_ramp(seg_time, seg_jerk, n, -sign, 0.0, 0.0, -goal, limits)
    return n


def _stop(
    velocity: float, acceleration: float, max_deceleration: float, max_jerk: float
) -> tuple[float, float]:
    """Signed distance and time of the fastest way from the state to rest."""
    max_deceleration = bounded(max_deceleration)
    max_jerk = bounded(max_jerk)
    sign = _travel_sign(velocity, acceleration, 1.0)
    v = sign * velocity
    a = sign * acceleration
    way = 0.0
    time = 0.0
    facing = 1.0
    if a < 0.0 and v - a * a / (2.0 * max_jerk) < -_ROUNDING * v:
        left = sqrt(a * a - 2.0 * max_jerk * v)
        time = 2.0 * v / (left - a)
        way = segment_position(time, max_jerk, 0.0, v, a)
        v = 0.0
        a = left
        facing = -1.0
    elif a < -max_deceleration:
        time = (-max_deceleration - a) / max_jerk
        way = segment_position(time, max_jerk, 0.0, v, a)
        v += time * (0.5 * (a - max_deceleration))
        a = -max_deceleration
    top = v + a * a / (2.0 * max_jerk)
    lead = a / max_jerk
    ramp = ramp_time(top, max_deceleration, max_jerk)
    way += facing * (0.5 * top * ramp + lead * (top - max_jerk * lead * lead / 6.0))
    return sign * way, time + ramp + lead


def stopping_distance(
    velocity: float, acceleration: float, max_deceleration: float, max_jerk: float
) -> float:
    """Signed distance from the state to rest when stopped at once."""
    way, _ = _stop(velocity, acceleration, max_deceleration, max_jerk)
    return way


def stopping_time(
    velocity: float, acceleration: float, max_deceleration: float, max_jerk: float
) -> float:
    """Seconds from the state to rest when stopped at once."""
    _, time = _stop(velocity, acceleration, max_deceleration, max_jerk)
    return time
