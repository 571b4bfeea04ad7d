"""Look-ahead: how fast the path may be now, so that it keeps all that the junctions ahead allow.

A state (way, velocity, acceleration) is *safe* if a stopping trajectory begins there
(`stop_profile`). The last known junction has velocity 0, so whatever is appended only makes more
states safe.

The cycle goes as fast as it may: it follows the ramp up for as long as the state after it is safe,
and from there the stopping trajectory. Ramps are exact, and the stopping trajectory stays until
there is another: so the path never is where it cannot keep a limit.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from collections.abc import Sequence

from achse.motion.path.bounds import ENDLESS
from achse.motion.path.junctions import (
    build_junctions,
    junction_acceleration,
    junction_deceleration,
    junction_jerk,
)
from achse.motion.path.ramp import ramp_after, stretch
from achse.motion.path.record import ElementKind, PathElement, PathJunction, PathState
from achse.motion.path.stop_profile import (
    NEAR,
    find_rest,
    find_stop_profile,
    follow_stop_profile,
    keep_stop_profile,
)
from achse.motion.rounding import JUST_ABOVE, RAMP_MARGIN

_SNAP = 1e-8
"""At rest so near a junction, the path is there, mm."""
_HALVINGS = 34
_CROSSINGS = 44
_INSTANT = 1.0 / 1024.0
"""Part of a cycle: a way up that is shorter is not looked for, but from rest."""
_SIMILAR = 0.5
"""Elements are taken together within a cycle if the next allows at least this part."""
_MOMENT = 1e-9
"""An acceleration that the jerk ends in this time, s, is none."""
_TURNS = 256
"""Changes of the ramp within one cycle; many short segments that each stop need some."""


def _local(
    junctions: Sequence[PathJunction],
    state: PathState,
    v: float,
    a: float,
    end: float,
    similar: bool,
) -> tuple[float, float, float, float, float]:
    """Velocity wanted; acceleration, deceleration and jerk at velocities up to v, up to `end`.

    Where they hold: with `similar` up to the first span that allows much less, or stops.
    """
    wanted = up = down = jerk = ENDLESS
    for k in range(state.junction, state.junctions):
        junction = junctions[k]
        if junction.waits:
            if similar and k > state.junction:
                return wanted, up, down, jerk, junctions[k - 1].at
            continue
        most_up, most_down = junction_acceleration(junction, v), junction_deceleration(junction, v)
        most_jerk = junction_jerk(junction, v)
        if k > state.junction:
            begin = junctions[k - 1].at
            if begin > end:
                break
            if similar and (
                most_jerk < _SIMILAR * jerk or most_up < _SIMILAR * up or a < -most_down
            ):
                return wanted, up, down, jerk, begin
        wanted = min(wanted, junction.velocity)
        up = min(up, most_up)
        down = min(down, most_down)
        jerk = min(jerk, most_jerk)
    return wanted, up, down, jerk, ENDLESS


def _time_to(
    v: float, a: float, w: float, up: float, down: float, jerk: float, way: float, time: float
) -> float:
    """Return the time, within `time`, when the ramp to w has covered a distance."""
    low = 0.0
    high = time
    for _ in range(_CROSSINGS):
        middle = 0.5 * (low + high)
        step, _, _ = ramp_after(v, a, w, up, down, jerk, middle)
        if step < way:
            low = middle
        else:
            high = middle
    return high


def _cross(
    elements: Sequence[PathElement], junctions: Sequence[PathJunction], state: PathState, x: float
) -> float:
    """Go on to the element at x; x itself, which is that of a junction where the path ends."""
    rows = len(elements)
    while x >= junctions[state.junction].at - NEAR:
        junction = junctions[state.junction]
        if junction.limit <= 0.0 and (state.velocity > 0.0 or state.acceleration != 0.0):
            break  # its ramp ends in a moment
        element = elements[state.current % rows]
        if element.kind == ElementKind.WAIT and state.waiting > 0.0:
            break
        if state.junction == state.junctions - 1:
            state.arrived = 1
            return junction.at
        state.junction += 1
        if not junction.ends:
            continue
        if state.backwards:
            state.current -= 1
            if elements[state.current % rows].last:
                state.passed_segments -= 1
        else:
            if element.last:
                state.passed_segments += 1
            state.current += 1
            state.waiting = elements[state.current % rows].wait
    return x


def move(
    elements: Sequence[PathElement],
    junctions: Sequence[PathJunction],
    state: PathState,
    time: float,
) -> None:
    """Move along the path for some time."""
    rows = len(elements)
    sign = -1.0 if state.backwards else 1.0
    x = sign * state.way
    left = time
    state.arrived = 0
    for _ in range(_TURNS):
        x = _cross(elements, junctions, state, x)
        if state.arrived or left <= 0.0:
            break
        if elements[state.current % rows].kind == ElementKind.WAIT:
            if state.hold:
                break
            waits = min(left, state.waiting)
            left -= waits
            state.waiting -= waits
            if state.waiting > 0.0:
                break
            continue
        wanted = _prepare(junctions, state, x)
        before = left
        x, left = _go_up(junctions, state, x, left, wanted)
        if left > 0.0:
            if state.out:
                x, left = follow_stop_profile(state, left)
            elif left >= before:
                at = junctions[state.junction].at
                if state.hold or at - x > _SNAP:
                    break
                x = at
    state.way = sign * x


def rest_ahead(
    elements: Sequence[PathElement],
    junctions: Sequence[PathJunction],
    state: PathState,
    room: float,
) -> float:
    """Way from here on which the path surely can come to rest: at most `room`, or ENDLESS."""
    if state.velocity == 0.0 and state.acceleration == 0.0:
        return 0.0
    if state.out and not state.backwards:
        # behind the stopping trajectory, with what the known path allows at its weakest
        down = jerk = ENDLESS
        for n in range(state.current, state.following):
            down = min(down, elements[n % len(elements)].deceleration)
            jerk = min(jerk, elements[n % len(elements)].jerk)
        way = state.out_at - state.way + stretch(state.out_speed, 0.0, 0.0, down, jerk)
        if way <= room:
            return way
    if not state.fresh:
        build_junctions(elements, junctions, state)
    return find_rest(junctions, state)


def stop_at_end(
    elements: Sequence[PathElement], junctions: Sequence[PathJunction], state: PathState, first: int
) -> bool:
    """Single block: stop at the end of a segment, the first one, from element `first` on, where the
    path still can; False if there is none yet."""
    for n in range(first, state.following):
        if not elements[n % len(elements)].last:
            continue
        state.barrier = n
        build_junctions(elements, junctions, state)
        v, a = state.velocity, state.acceleration
        if v == 0.0 and a == 0.0:
            return True
        x = -state.way if state.backwards else state.way
        k, speed, down, jerk = find_stop_profile(junctions, state, x, v, a, v, False, True)
        if k >= 0:
            keep_stop_profile(state, junctions[k].at, x, v, a, speed, down, jerk, False)
            return True
    state.barrier = -1
    state.fresh = 0
    return False


def _prepare(junctions: Sequence[PathJunction], state: PathState, x: float) -> bool:
    """Return True if the velocities wanted at the junctions can be kept.

    A stopping trajectory from here is there in any case.
    """
    v, a = state.velocity, state.acceleration
    if v == 0.0 and a == 0.0:
        state.out = 0
        return state.slower == 1
    if state.slower and state.out < 2:
        k, speed, down, jerk = find_stop_profile(junctions, state, x, v, a, v, True, True)
        if k >= 0:
            keep_stop_profile(state, junctions[k].at, x, v, a, speed, down, jerk, True)
    if not state.out:
        k, speed, down, jerk = find_stop_profile(junctions, state, x, v, a, v, False, True)
        if k < 0:
            # none: what is left is to brake with what this span allows
            k, speed = state.junction, 0.0
            down, jerk = junction_deceleration(junctions[k], v), junction_jerk(junctions[k], v)
            state.lost_cycles += 1
        keep_stop_profile(state, junctions[k].at, x, v, a, speed, down, jerk, False)
    return state.slower == 1 and state.out == 2


def _go_up(
    junctions: Sequence[PathJunction], state: PathState, x: float, left: float, wanted: bool
) -> tuple[float, float]:
    """Follow the ramp to the velocity that is wanted for as long as there is a stopping trajectory,
    and keep that: where it leads, and time that is left.
    """
    v, a = state.velocity, state.acceleration
    junction = junctions[state.junction]
    rise = max(a, 0.0) + left * junction_jerk(junction, v)
    faster = left * min(rise, max(a, junction_acceleration(junction, v)))
    reach = x + left * (v + faster)
    aim, up, down, jerk, until = _local(junctions, state, v + faster, a, reach, True)
    if state.hold:
        aim = 0.0
    if v == 0.0 and a == 0.0 and aim <= 0.0:
        return x, left
    if v + 0.5 * a * abs(a) / jerk > aim:
        # it brakes beyond this cycle: with what the elements on the way allow
        weak_down, weak_jerk = down, jerk
        for _ in range(3):
            reach = max(reach, x + stretch(v, a, aim, weak_down, weak_jerk))
            _, _, weak_down, weak_jerk, _ = _local(junctions, state, v, a, reach, False)
        if v + 0.5 * a * abs(a) / weak_jerk >= aim:
            down, jerk, until = weak_down, weak_jerk, ENDLESS
    if a < 0.0 and (2.0 * v * jerk < RAMP_MARGIN * a * a or a < -down * JUST_ABOVE):
        return x, left  # the brake is let go as the stopping trajectory says
    peak = v
    if a > 0.0 and v + 0.5 * a * a / jerk > aim:
        peak = v + 0.5 * a * a / jerk
        if peak > junction.cap * JUST_ABOVE:
            return x, left
    longest = left
    step, v1, a1 = ramp_after(v, a, aim, up, down, jerk, longest)
    if x + step > until:
        longest = _time_to(v, a, aim, up, down, jerk, until - x, left)
        step, v1, a1 = ramp_after(v, a, aim, up, down, jerk, longest)
    k, speed, out_down, out_jerk = find_stop_profile(
        junctions, state, x + step, v1, a1, max(peak, v1), wanted, False
    )
    good = longest
    if k < 0:
        # the longest time that the way up is safe
        good = 0.0
        bad = min(left * _INSTANT, longest)
        middle = bad
        for n in range(_HALVINGS):
            step, v1, a1 = ramp_after(v, a, aim, up, down, jerk, middle)
            last, last_speed, last_down, last_jerk = find_stop_profile(
                junctions, state, x + step, v1, a1, max(peak, v1), wanted, False
            )
            if last >= 0:
                good = middle
                k, speed, out_down, out_jerk = last, last_speed, last_down, last_jerk
                if n == 0:
                    bad = longest
            else:
                bad = middle
                if n == 0 and v > 0.0:
                    break
            if (bad - good) * (v + faster) < 0.1 * NEAR:
                break
            middle = 0.5 * (good + bad)
        if k < 0:
            return x, left
        step, v1, a1 = ramp_after(v, a, aim, up, down, jerk, good)
    x += step
    if v1 <= NEAR and abs(a1) <= _MOMENT * jerk:
        v1 = a1 = 0.0
    keep_stop_profile(state, junctions[k].at, x, v1, a1, speed, out_down, out_jerk, wanted)
    state.velocity, state.acceleration = v1, a1
    return x, left - good
