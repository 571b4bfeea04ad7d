"""Junctions ahead: places where the bounds change, with what they allow.

A span of a bend allows less acceleration and jerk the faster it is followed. From a junction's
*safe* velocity, with no acceleration, all junctions behind it can be kept span by span; the last
one is at rest. Each span is braked with what it allows at the velocity with which it is entered.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from collections.abc import Sequence

from achse.motion.path.bounds import ENDLESS, span_feed
from achse.motion.path.ramp import reachable
from achse.motion.path.record import ElementKind, PathElement, PathJunction, PathState

_ROUNDS = 8
"""Halvings of the velocities of a bend, to find the one from which it can be braked."""


def element_velocity(element: PathElement, k: int, state: PathState) -> float:
    """Velocity that a part of the element shall have: programmed, reduced, with the override."""
    factor = min(state.override, state.most_override)
    if state.override_type == 1:  # original: the programmed velocity is meant
        return min(factor * span_feed(element, k), element.caps[k])
    return min(factor * min(span_feed(element, k), element.caps[k]), element.caps[k])


def junction_acceleration(junction: PathJunction, v: float) -> float:
    """Return the acceleration that the span before the junction permits up to velocity v, mm/s²."""
    share = min(v / junction.cap, 1.0)
    least = junction.start - (junction.start - junction.acceleration) * share * share
    return min(least, junction.most_acceleration)


def junction_deceleration(junction: PathJunction, v: float) -> float:
    """Deceleration there at velocities up to v, mm/s²."""
    share = min(v / junction.cap, 1.0)
    least = junction.rest - (junction.rest - junction.deceleration) * share * share
    if least * v > junction.power:
        least = junction.power / v
    return min(least, junction.most_deceleration)


def junction_jerk(junction: PathJunction, v: float) -> float:
    """Jerk there at velocities up to v, mm/s³."""
    share = min(v / junction.cap, 1.0)
    least = junction.first_jerk - (junction.first_jerk - junction.jerk) * share * share * share
    return min(least, junction.most_jerk)


def build_junctions(
    elements: Sequence[PathElement], junctions: Sequence[PathJunction], state: PathState
) -> None:
    """Build the junctions ahead, in the direction of travel."""
    rows = len(elements)
    x = -state.way if state.backwards else state.way
    count = 0
    n = state.current
    step = -1 if state.backwards else 1
    end = state.oldest - 1 if state.backwards else state.following
    last = False
    while n != end and not last:
        element = elements[n % rows]
        if state.backwards:
            last = n + step == end
            allowed = 0.0 if last else elements[(n - 1) % rows].junction
        else:
            last = n + step == end or n == state.barrier
            allowed = 0.0 if element.stops or last else element.junction
        for m in range(element.spans):
            k = element.spans - 1 - m if state.backwards else m
            begin = element.ends[k - 1] if k else 0.0
            if begin >= element.length and k:
                continue  # lost to a curve
            junction = junctions[count]
            final = m == element.spans - 1
            if state.backwards:
                junction.at = -element.first - begin
            else:
                final = final or element.ends[k] >= element.length
                junction.at = element.first + (element.length if final else element.ends[k])
            if not final and junction.at <= x:
                continue  # behind already
            junction.ends = 1 if final else 0
            _fill(junction, element, k, state)
            junction.limit = allowed if final else ENDLESS
            count += 1
            if final:
                break
        n += step
    state.junctions = count
    state.junction = 0
    state.fresh = 1
    state.slower = 0
    if count:
        _make_safe(junctions, state)


def _fill(junction: PathJunction, element: PathElement, k: int, state: PathState) -> None:
    """Fill the junction with the limits of the span before it."""
    junction.waits = 1 if element.kind == ElementKind.WAIT else 0
    junction.velocity = element_velocity(element, k, state)
    junction.cap = element.caps[k]
    if junction.waits:
        junction.cap = junction.velocity = ENDLESS
    junction.start = element.starts[k]
    junction.acceleration = element.accelerations[k]
    junction.rest = element.rests[k]
    junction.deceleration = element.decelerations[k]
    junction.power = element.powers[k]
    junction.first_jerk = element.first_jerks[k]
    junction.jerk = element.jerks[k]
    junction.most_acceleration = element.path_acceleration
    junction.most_deceleration = element.path_deceleration
    junction.most_jerk = element.path_jerk
    if state.stop_deceleration > 0.0:
        junction.most_deceleration = max(junction.most_deceleration, state.stop_deceleration)
        junction.most_jerk = max(junction.most_jerk, state.stop_jerk)


def _make_safe(junctions: Sequence[PathJunction], state: PathState) -> None:
    """Set limits and safe velocities, from the last junction back."""
    factor = min(state.override, 1.0)
    if state.override_type == 1:
        factor = 1.0
    end = junctions[state.junctions - 1]
    end.limit = end.safe = end.wanted_limit = end.wanted_safe = 0.0
    if end.velocity < end.cap:
        state.slower = 1
    for k in range(state.junctions - 2, -1, -1):
        junction = junctions[k]
        after = junctions[k + 1]
        junction.wanted_limit = min(factor * junction.limit, after.velocity)
        junction.limit = min(junction.limit, after.cap)
        if junction.waits or after.waits:
            junction.limit = junction.wanted_limit = 0.0
        junction.safe = _entry(after, after.at - junction.at, after.safe, junction.limit)
        junction.wanted_safe = junction.safe
        if junction.wanted_limit < junction.limit or after.wanted_safe < after.safe:
            state.slower = 1
            most = min(junction.wanted_limit, junction.safe)
            junction.wanted_safe = _entry(after, after.at - junction.at, after.wanted_safe, most)


def _entry(junction: PathJunction, length: float, speed: float, limit: float) -> float:
    """Return the highest velocity, up to a limit, from which the span before a junction leads to a
    speed.

    The places that are tried are always the same: where more is known, it falls only if a ramp to
    rest is shorter than one to the speed.
    """
    if limit <= speed:
        return limit
    down, jerk = (
        junction_deceleration(junction, junction.cap),
        junction_jerk(junction, junction.cap),
    )
    highest = reachable(speed, length, down, jerk)
    even = (
        junction.deceleration >= junction.rest
        and junction.jerk >= junction.first_jerk
        and junction.power >= ENDLESS
    )
    if even or highest >= limit:
        return min(highest, limit)
    # the slower it is entered, the more it can brake
    low, high = 0.0, junction.cap
    for _ in range(_ROUNDS):
        v = 0.5 * (low + high)
        if v <= highest:
            low = v
            continue
        entry = reachable(
            speed, length, junction_deceleration(junction, v), junction_jerk(junction, v)
        )
        if entry >= v:
            low = v
            if low >= limit:
                return limit
        else:
            high = v
            highest = entry
    return min(max(low, highest), limit)
