"""Superposition: a trapezoid of additional velocity on top of the main motion (section
compensation).

Its clock is the way of the main motion, divided by the process velocity it was planned for: a
slower main motion slows the compensation too, and at override zero both wait. It ends when the main
motion comes to rest or turns. The additional way moves the target of the main motion along, so that
the main motion itself is not disturbed.

Kernel source, in the language of `achse.native`.
"""

from math import inf

from achse.codes.nc.choices import MotionPhase
from achse.motion.record import AxisFields
from achse.motion.rounding import JUST_ABOVE
from achse.motion.setpoints.dynamics import run_out
from achse.motion.setpoints.setpoint import absorb, displace, generate

_APPROACHES = 8
"""Steps by which a way is made shorter until what it adds fits into the room."""


def superposed_way(ax: AxisFields, t: float) -> float:
    """Additional way, without sign, at process time `t`."""
    if t < ax.superposed.rise_end:
        return 0.5 * ax.superposed.acceleration * t * t
    left = ax.superposed.end - t
    if left <= 0.0:
        return ax.superposed.distance
    fall = ax.superposed.end - ax.superposed.fall_begin
    if left > fall:
        return ax.superposed.distance - ax.superposed.velocity * (left - 0.5 * fall)
    return ax.superposed.distance - 0.5 * ax.superposed.deceleration * left * left


def superposed_speed(ax: AxisFields, t: float) -> float:
    """Additional velocity, without sign, at process time `t`."""
    if t < ax.superposed.rise_end:
        return ax.superposed.acceleration * t
    left = ax.superposed.end - t
    if left <= 0.0:
        return 0.0
    if t < ax.superposed.fall_begin:
        return ax.superposed.velocity
    return ax.superposed.deceleration * left


def _bend(ax: AxisFields, t: float) -> float:
    """Additional acceleration in the direction of the compensation at process time `t`."""
    if t < ax.superposed.rise_end:
        return ax.superposed.acceleration
    if t < ax.superposed.fall_begin or t >= ax.superposed.end:
        return 0.0
    return -ax.superposed.deceleration


def _room(ax: AxisFields) -> float:
    """Return the velocity that the axis may still have beyond the main motion, in its direction.

    The main motion counts with what its acceleration still adds, should it be stopped now.
    """
    if ax.superposed.sign != ax.superposed.direction:
        return inf
    room = ax.superposed.limit - run_out(ax) * ax.superposed.direction
    return room if room > 0.0 else 0.0


def _cover(ax: AxisFields, way: float, room: float, dt: float) -> float:
    """Let the main motion's `way` pass and shift the axis by what that adds; process time then.

    Less of the way counts if there is no room for the whole additional velocity, or if the main
    motion is faster than the acceleration limits allow.
    """
    process = ax.superposed.process_velocity
    if way > ax.superposed.fastest * dt:
        way = ax.superposed.fastest * dt
    speed = superposed_speed(ax, ax.superposed.main_way / process)
    if speed * way > room * process * dt:
        way = room * process * dt / speed
    begin = ax.superposed.main_way
    if way > 0.0:
        ax.superposed.main_way += way
    t = ax.superposed.main_way / process
    covered = superposed_way(ax, t)
    if ax.coupling.law:  # the law may jump
        most = room * dt
        for _ in range(_APPROACHES):
            added = covered - ax.superposed.position
            if added <= most * JUST_ABOVE:
                break
            ax.superposed.main_way = begin + (ax.superposed.main_way - begin) * most / added
            t = ax.superposed.main_way / process
            covered = superposed_way(ax, t)
        if covered - ax.superposed.position > most * JUST_ABOVE:
            ax.superposed.main_way = begin
            t = begin / process
            covered = ax.superposed.position
    displace(ax, ax.superposed.sign * (covered - ax.superposed.position))
    ax.superposed.position = covered
    return t


def generate_superposed(ax: AxisFields, dt: float) -> None:
    """Run one cycle of the set-point generator with the compensation on top."""
    ax.set.velocity -= ax.superposed.set_velocity
    ax.set.acceleration -= ax.superposed.set_acceleration
    ax.superposed.set_acceleration = 0.0
    begin = ax.set.position
    generate(ax, dt)
    if ax.compensating:  # it was not dropped with the job
        ax.superposed.set_velocity = 0.0
        superpose(ax, begin, dt)


def superpose(ax: AxisFields, begin: float, dt: float) -> None:
    """Add the compensation to a cycle in which the main motion began at `begin`."""
    room = _room(ax)
    way = (ax.set.position - begin) * ax.superposed.direction
    if ax.coupling.law:  # a law may jump within the position window: less of the room is left then
        left = ax.superposed.limit - way / dt
        if ax.superposed.sign == ax.superposed.direction and left < room:
            room = left if left > 0.0 else 0.0
    t = _cover(ax, way, room, dt)
    pace = ax.set.velocity * ax.superposed.direction
    standing = pace <= 0.0 and (ax.profile.override != 0 or ax.coupling.law != 0)
    if t >= ax.superposed.end or standing or ax.set_motion_phase == MotionPhase.NONE:
        absorb(ax)
        return
    gain = ax.set.acceleration * ax.superposed.direction
    if pace < 0.0:
        pace = 0.0
    elif pace > ax.superposed.fastest:
        pace = ax.superposed.fastest
        gain = 0.0
    share = pace / ax.superposed.process_velocity
    speed = superposed_speed(ax, t)
    if speed * share > room:
        ax.superposed.set_velocity = ax.superposed.sign * room
        ax.superposed.set_acceleration = -ax.set.acceleration if room > 0.0 else 0.0
    else:
        ax.superposed.set_velocity = ax.superposed.sign * speed * share
        ax.superposed.set_acceleration = ax.superposed.sign * (
            _bend(ax, t) * share * share + speed * gain / ax.superposed.process_velocity
        )
    ax.set.velocity += ax.superposed.set_velocity
    ax.set.acceleration += ax.superposed.set_acceleration
