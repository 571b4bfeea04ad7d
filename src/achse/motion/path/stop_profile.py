"""Stopping trajectories: ramps to the safe velocity of a junction ahead, without acceleration.

A stopping trajectory brakes with the least deceleration and jerk of all spans up to its junction,
each at the highest velocity it has on the way. It passes the junctions before it with what they
allow. It stays valid, and can be followed to its end whatever comes: only what is appended
changes the junctions, and that allows more.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from collections.abc import Sequence
from math import fabs

from achse.motion.path.bounds import ENDLESS
from achse.motion.path.junctions import junction_acceleration, junction_deceleration, junction_jerk
from achse.motion.path.ramp import ramp_after, ramp_duration, rest_is_nearer, stretch
from achse.motion.path.record import PathJunction, PathState
from achse.motion.rounding import JUST_ABOVE, RAMP_MARGIN

NEAR = 1e-9
"""Ways are equal up to this, mm; velocities, mm/s."""
_SNAP = 1e-8
"""A ramp that ends so near a junction ends there."""
_MOMENT = 1e-12
"""Times are equal up to this, s."""


def find_stop_profile(
    junctions: Sequence[PathJunction],
    state: PathState,
    x: float,
    v: float,
    a: float,
    top: float,
    wanted: bool,
    rest: bool,
) -> tuple[int, float, float, float]:
    """Return junction, speed, deceleration and jerk of a stopping trajectory from (x, v, a).

    Junction -1 if there is none. `top` is the highest velocity since the junctions before x were
    ahead; `wanted`: keep what is wanted at the junctions too. `rest`: also a ramp to rest, which
    can be shorter than one to a lower velocity; there is one where less was known of the path
    before.
    """
    down = jerk = ENDLESS
    least = ENDLESS
    cap = ENDLESS  # of the first span
    checked = False  # whether a junction before was passed with a stronger ramp
    for k in range(state.junction, state.junctions):
        junction = junctions[k]
        limit = junction.wanted_limit if wanted else junction.limit
        room = junction.at - x
        if room < -NEAR:
            if top > limit * JUST_ABOVE:
                break
            continue
        if not junction.waits:
            fastest = v
            if a > 0.0:
                fastest = min(v + 0.5 * a * a / junction_jerk(junction, junction.cap), junction.cap)
            jerk = min(jerk, junction_jerk(junction, fastest))
            highest = v + 0.5 * a * a / jerk if a > 0.0 else v
            if cap >= ENDLESS:
                cap = junction.cap
            if highest > cap * JUST_ABOVE:
                break
            down = min(down, junction_deceleration(junction, highest))
        if a < -down * JUST_ABOVE or (a < 0.0 and 2.0 * v * jerk < RAMP_MARGIN * a * a):
            break  # the brake is on too strongly for what comes
        room = max(room, 0.0)
        released = v + 0.5 * a * fabs(a) / jerk
        speed = min(released, min(junction.wanted_safe if wanted else junction.safe, least))
        if v * v - speed * speed <= 2.0 * down * (room + NEAR):
            way = _way_to(v, a, speed, down, jerk)
            if rest and way > room + NEAR and rest_is_nearer(speed, down, jerk):
                speed = 0.0
                way = stretch(v, a, speed, down, jerk)
            if way <= room + NEAR and (
                not checked or _passes(junctions, state, x, v, a, k, down, jerk, wanted)
            ):
                return k, speed if speed > NEAR else 0.0, down, jerk
        highest = v + 0.5 * a * a / jerk if a > 0.0 else v
        if highest > limit:
            if stretch(v, a, limit, down, jerk) > room + NEAR:
                break
            checked = True
        if a > 0.0 and k < state.junctions - 1:
            if _release_way(junctions[k + 1], v, a, jerk) > room + NEAR:
                break
            checked = True
        least = min(least, limit)
    return -1, 0.0, down, jerk


def _way_to(v: float, a: float, speed: float, down: float, jerk: float) -> float:
    """Way to a speed with no acceleration; the speed is what the acceleration leads to, or less."""
    if v + 0.5 * a * fabs(a) / jerk > speed:
        return stretch(v, a, speed, down, jerk)
    t = fabs(a) / jerk
    return t * (v + t * a / 3.0)


def _release_way(after: PathJunction, v: float, a: float, jerk: float) -> float:
    """Way until an acceleration is so low that the span behind a junction can go on with it."""
    if after.waits:
        return 0.0
    most = junction_acceleration(after, v + 0.5 * a * a / jerk)
    if a <= most:
        return 0.0
    t = (a - most) / jerk
    return t * (v + t * (0.5 * a - t * jerk / 6.0))


def _passes(
    junctions: Sequence[PathJunction],
    state: PathState,
    x: float,
    v: float,
    a: float,
    last: int,
    down: float,
    jerk: float,
    wanted: bool,
) -> bool:
    """Return True if such a ramp keeps the limits of the junctions before the last."""
    highest = v + 0.5 * a * a / jerk if a > 0.0 else v
    for k in range(state.junction, last):
        junction = junctions[k]
        limit = junction.wanted_limit if wanted else junction.limit
        room = junction.at - x
        if room < -NEAR:
            continue
        if highest > limit and stretch(v, a, limit, down, jerk) > room + NEAR:
            return False
        if a > 0.0:
            if not junction.waits and down > junction_deceleration(junction, highest) * JUST_ABOVE:
                return False
            if _release_way(junctions[k + 1], v, a, jerk) > room + NEAR:
                return False
    return True


def find_rest(junctions: Sequence[PathJunction], state: PathState) -> float:
    """Return the way from here on which the path comes to rest with one ramp; ENDLESS if there is
    none."""
    x = -state.way if state.backwards else state.way
    v, a = state.velocity, state.acceleration
    down = jerk = ENDLESS
    for k in range(state.junction, state.junctions):
        junction = junctions[k]
        if junction.waits:
            continue
        jerk = min(jerk, junction_jerk(junction, junction.cap if a > 0.0 else v))
        highest = v + 0.5 * a * a / jerk if a > 0.0 else v
        down = min(down, junction_deceleration(junction, highest))
        if a < -down * JUST_ABOVE or (a < 0.0 and 2.0 * v * jerk < RAMP_MARGIN * a * a):
            break
        way = stretch(v, a, 0.0, down, jerk)
        if way <= junction.at - x:
            return way if _passes(junctions, state, x, v, a, k, down, jerk, False) else ENDLESS
    return ENDLESS


def keep_stop_profile(
    state: PathState,
    at: float,
    x: float,
    v: float,
    a: float,
    speed: float,
    down: float,
    jerk: float,
    wanted: bool,
) -> None:
    """Keep a stopping trajectory to the junction at a way."""
    state.out = 2 if wanted else 1
    state.out_begin = x
    state.out_velocity = v
    state.out_acceleration = a
    state.out_speed = speed
    state.out_deceleration = down
    state.out_jerk = jerk
    state.out_at = at
    state.out_time = 0.0
    state.out_duration = ramp_duration(v, a, speed, ENDLESS, down, jerk)
    if speed > 0.0:
        left = at - x - _way_to(v, a, speed, down, jerk)
        state.out_duration += max(left, 0.0) / speed


def follow_stop_profile(state: PathState, time: float) -> tuple[float, float]:
    """Follow the stopping trajectory for some time; return the way and the time that is left."""
    spent = min(time, state.out_duration - state.out_time)
    ends = spent >= state.out_duration - state.out_time - _MOMENT
    state.out_time += spent
    way, v, a = ramp_after(
        state.out_velocity,
        state.out_acceleration,
        state.out_speed,
        ENDLESS,
        state.out_deceleration,
        state.out_jerk,
        state.out_time,
    )
    x = state.out_begin + way
    if ends:
        v, a = state.out_speed, 0.0
        state.out = 0
        if fabs(state.out_at - x) <= _SNAP:
            x = state.out_at
    state.velocity = max(v, 0.0)
    state.acceleration = a
    return x, time - spent
