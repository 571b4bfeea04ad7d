"""Run up to a target that moves: its velocity, or its velocity and position, with limited jerk.

What is between slave and target is taken away by a profile of its own, as fast as the limits allow,
and the motion of the target is added. While the target keeps its velocity that is the fastest way.
A target that changes its velocity takes its part of the limits; one that changes it more than the
slave may is followed as far as the limits allow.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.motion.profiles.profile import plan_to_position, plan_to_velocity
from achse.motion.profiles.segments import segment_acceleration, segment_position, segment_velocity
from achse.motion.record import AxisFields

_LEFT = 0.05
"""Share of a limit that is for coming nearer, whatever the target takes."""

_ROUNDED = 1e-9

_DIGITS = 1e-12


def limits_beside(
    ax: AxisFields, velocity: float, rising: float, jerk: float
) -> tuple[float, float]:
    """Acceleration and jerk that a target of this velocity and acceleration leaves to the slave."""
    v = ax.set.velocity
    limit = ax.sync.acceleration
    if v * velocity < 0.0:  # it passes rest: both limits
        if ax.sync.deceleration < limit:
            limit = ax.sync.deceleration
    elif abs(v) > abs(velocity):
        limit = ax.sync.deceleration
    left = limit - abs(rising)
    if left < _LEFT * limit:
        left = _LEFT * limit
    jerk_left = ax.sync.jerk - abs(jerk)
    if jerk_left < _LEFT * ax.sync.jerk:
        jerk_left = _LEFT * ax.sync.jerk
    return left, jerk_left


def _walk(
    ax: AxisFields, count: int, dt: float, v: float, a: float
) -> tuple[bool, float, float, float]:
    """Return a cycle along the planned segments: whether they end in it; way, velocity,
    acceleration."""
    left = dt
    p = 0.0
    for i in range(count):
        if left <= 0.0:
            break
        t = ax.profile.time[i]
        if t > left:
            t = left
        j = ax.profile.jerk[i]
        p = segment_position(t, j, p, v, a)
        v = segment_velocity(t, j, v, a)
        a = segment_acceleration(t, j, a)
        left -= ax.profile.time[i]
    return left > 0.0, p, v, a


def _most(ax: AxisFields, velocity: float, change: float, dt: float) -> float:
    """Largest acceleration in a cycle whose velocity changes to this way, or goes on changing."""
    limit = ax.sync.acceleration if change * velocity >= 0.0 else ax.sync.deceleration
    if ax.set.velocity * velocity < 0.0:
        if ax.sync.acceleration < limit:
            limit = ax.sync.acceleration
        if ax.sync.deceleration < limit:
            limit = ax.sync.deceleration
    before = abs(ax.set.acceleration) - ax.sync.jerk * dt
    return before if before > limit else limit


def _permitted(ax: AxisFields, velocity: float, acceleration: float, dt: float) -> float:
    """Return the acceleration nearest to this one that the limits allow in this cycle."""
    before = ax.set.acceleration
    change = ax.sync.jerk * dt
    limit = _most(ax, velocity, acceleration, dt)
    permitted = acceleration
    if permitted > before + change:
        permitted = before + change
    elif permitted < before - change:
        permitted = before - change
    if permitted > limit:
        permitted = limit
    elif permitted < -limit:
        permitted = -limit
    return permitted


def _changes_too_fast(ax: AxisFields, velocity: float, dt: float) -> bool:
    """Return True if no acceleration within the limits leads to this velocity in a cycle.

    Those at its ends may be within them even so: they are samples, and a target that jumps has
    others between.
    """
    change = velocity - ax.set.velocity
    most = _most(ax, velocity, change, dt)
    if abs(ax.set.acceleration) > most:
        most = abs(ax.set.acceleration)
    return abs(change) > most * dt + _DIGITS * (abs(velocity) + abs(ax.set.velocity))


def _apply(
    ax: AxisFields,
    velocity: float,
    rising: float,
    way: float,
    p: float,
    w: float,
    b: float,
    dt: float,
) -> bool:
    """Go where the target goes and `p` besides; less if that is beyond the limits (False)."""
    before = ax.set.velocity
    was = ax.set.acceleration
    a = rising + b
    v = velocity + w
    permitted = _permitted(ax, v, a, dt)
    exact = abs(permitted - a) <= _ROUNDED * (abs(a) + abs(was)) and not _changes_too_fast(
        ax, v, dt
    )
    moved = way + p
    a = permitted  # of rounding only, if exact
    if not exact:
        v = before + 0.5 * (was + a) * dt
        moved = dt * (before + dt * (2.0 * was + a) / 6.0)
    ax.set.position += moved
    ax.set.velocity = v
    ax.set.acceleration = a
    ax.set.jerk = (a - was) / dt
    ax.sync.offset += moved - way
    ax.sync.pursued_velocity = velocity
    ax.sync.pursued_acceleration = rising
    return exact


def approach_velocity(
    ax: AxisFields, velocity: float, rising: float, jerk: float, way: float, noisy: bool, dt: float
) -> bool:
    """One cycle nearer to the velocity of a target; whether the slave has it.

    `rising` is the acceleration of the target, `way` what it moved in this cycle. A `noisy` one is
    met with what one cycle of acceleration changes.
    """
    w = ax.set.velocity - ax.sync.pursued_velocity
    b = ax.set.acceleration - ax.sync.pursued_acceleration
    limit, jerk_limit = limits_beside(ax, velocity, rising, jerk)
    count = plan_to_velocity(ax.profile.time, ax.profile.jerk, w, b, 0.0, limit, limit, jerk_limit)
    done, p, w, b = _walk(ax, count, dt, w, b)
    if done:
        w = 0.0
        b = 0.0
    exact = _apply(ax, velocity, rising, way, p, w, b, dt)
    if noisy:
        return abs(ax.set.velocity - velocity) <= limit * dt
    return done and exact


def approach_place(
    ax: AxisFields, velocity: float, rising: float, jerk: float, way: float, top: float, dt: float
) -> bool:
    """One cycle nearer to the place of a target, which is `-sync_offset` away; whether it is there.

    `top` is the largest velocity beside it.
    """
    w = ax.set.velocity - ax.sync.pursued_velocity
    b = ax.set.acceleration - ax.sync.pursued_acceleration
    limit, jerk_limit = limits_beside(ax, velocity, rising, jerk)
    offset = ax.sync.offset
    count = plan_to_position(
        ax.profile.time, ax.profile.jerk, offset, w, b, 0.0, 0.0, top, limit, limit, jerk_limit
    )
    done, p, w, b = _walk(ax, count, dt, w, b)
    if done:
        w = 0.0
        b = 0.0
        p = -offset
    return _apply(ax, velocity, rising, way, p, w, b, dt) and done


def settle(ax: AxisFields, velocity: float, way: float, dt: float) -> bool:
    """One cycle with a noisy target that the slave follows; whether nothing is left between them.

    All that the target does is taken over, as it is from then on. What is left of velocity and
    acceleration beside it goes within the limits.
    """
    ax.quiet_cycles = 0  # it is not done even if all are at standstill
    w = ax.set.velocity - ax.sync.pursued_velocity
    was = ax.set.acceleration
    count = plan_to_velocity(
        ax.profile.time,
        ax.profile.jerk,
        w,
        was,
        0.0,
        ax.sync.acceleration,
        ax.sync.deceleration,
        ax.sync.jerk,
    )
    done, p, w, b = _walk(ax, count, dt, w, was)
    if done:
        w = 0.0
        b = 0.0
    ax.set.position += way + p
    ax.set.velocity = velocity + w
    ax.set.acceleration = b
    ax.set.jerk = (b - was) / dt
    ax.sync.pursued_velocity = velocity
    return done


def settle_place(ax: AxisFields, velocity: float, way: float, top: float, dt: float) -> bool:
    """One cycle with a noisy target that the slave follows, nearer to its place beside it, which is
    `-sync_offset` away; whether it is there.

    All that the target does is taken over. Within the limits is what the slave does besides, at
    most with the velocity `top`.
    """
    ax.quiet_cycles = 0  # it is not done even if all are at standstill
    w = ax.set.velocity - ax.sync.pursued_velocity
    was = ax.set.acceleration
    offset = ax.sync.offset
    limit = ax.sync.acceleration
    if ax.sync.deceleration < limit:
        limit = ax.sync.deceleration
    count = plan_to_position(
        ax.profile.time, ax.profile.jerk, offset, w, was, 0.0, 0.0, top, limit, limit, ax.sync.jerk
    )
    done, p, w, b = _walk(ax, count, dt, w, was)
    if done:
        p = -offset
        w = 0.0
        b = 0.0
    ax.set.position += way + p
    ax.set.velocity = velocity + w
    ax.set.acceleration = b
    ax.set.jerk = (b - was) / dt
    ax.sync.offset = offset + p
    ax.sync.pursued_velocity = velocity
    return done
