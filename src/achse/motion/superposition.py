"""Superposition: a trapezoid of additional velocity on top of the main motion (section
compensation).

Its clock is the way of the main motion, divided by the process velocity it was planned for: a
slower main motion slows the compensation too, and at override zero both wait. It ends when the main
motion comes to rest or turns. The additional way moves the target of the main motion along, so that
the main motion itself is not disturbed.

Kernel source, in the language of `achse.native`.
"""

from math import inf

from achse.motion.dynamics import run_out
from achse.motion.record import AxisFields
from achse.motion.setpoint import absorb, displace, generate
from achse.motion.states import MotionPhase

__all__ = ["generate_superposed", "superpose", "superposed_speed", "superposed_way"]


def superposed_way(ax: AxisFields, t: float) -> float:
    """Additional way, without sign, at process time `t`."""
    if t < ax.superposition_rise_end:
        return 0.5 * ax.superposition_acceleration * t * t
    left = ax.superposition_end - t
    if left <= 0.0:
        return ax.superposition_distance
    fall = ax.superposition_end - ax.superposition_fall_begin
    if left > fall:
        return ax.superposition_distance - ax.superposition_velocity * (left - 0.5 * fall)
    return ax.superposition_distance - 0.5 * ax.superposition_deceleration * left * left


def superposed_speed(ax: AxisFields, t: float) -> float:
    """Additional velocity, without sign, at process time `t`."""
    if t < ax.superposition_rise_end:
        return ax.superposition_acceleration * t
    left = ax.superposition_end - t
    if left <= 0.0:
        return 0.0
    if t < ax.superposition_fall_begin:
        return ax.superposition_velocity
    return ax.superposition_deceleration * left


def _bend(ax: AxisFields, t: float) -> float:
    """Additional acceleration in the direction of the compensation at process time `t`."""
    if t < ax.superposition_rise_end:
        return ax.superposition_acceleration
    if t < ax.superposition_fall_begin or t >= ax.superposition_end:
        return 0.0
    return -ax.superposition_deceleration


def _room(ax: AxisFields) -> float:
    """How much faster than the main motion the axis may still be, in its direction.

    The main motion counts with what its acceleration still adds, should it be stopped now.
    """
    if ax.superposition_sign != ax.superposition_direction:
        return inf
    room = ax.superposition_limit - run_out(ax) * ax.superposition_direction
    return room if room > 0.0 else 0.0


def _cover(ax: AxisFields, way: float, room: float, dt: float) -> float:
    """Let the main motion's `way` pass and shift the axis by what that adds; process time then.

    Where there is no room for the whole additional velocity, less of the way counts; so it does
    where the main motion is faster than the limits of acceleration let the clock follow.
    """
    process = ax.superposition_process_velocity
    if way > ax.superposition_fastest * dt:
        way = ax.superposition_fastest * dt
    speed = superposed_speed(ax, ax.superposed_way / process)
    if speed * way > room * process * dt:
        way = room * process * dt / speed
    begin = ax.superposed_way
    if way > 0.0:
        ax.superposed_way += way
    t = ax.superposed_way / process
    covered = superposed_way(ax, t)
    if ax.coupling and covered - ax.superposed_position > room * dt:  # the law jumps
        ax.superposed_way = begin + way * room * dt / (covered - ax.superposed_position)
        t = ax.superposed_way / process
        covered = superposed_way(ax, t)
        if covered - ax.superposed_position > room * dt:
            ax.superposed_way = begin
            t = begin / process
            covered = ax.superposed_position
    displace(ax, ax.superposition_sign * (covered - ax.superposed_position))
    ax.superposed_position = covered
    return t


def generate_superposed(ax: AxisFields, dt: float) -> None:
    """One cycle of the set-point generator with the compensation on top."""
    ax.set_velocity -= ax.superposed_velocity
    ax.set_acceleration -= ax.superposed_acceleration
    ax.superposed_acceleration = 0.0
    begin = ax.set_position
    generate(ax, dt)
    if ax.compensating:  # it was not dropped with the job
        ax.superposed_velocity = 0.0
        superpose(ax, begin, dt)


def superpose(ax: AxisFields, begin: float, dt: float) -> None:
    """What the compensation adds to a cycle in which the main motion began at `begin`."""
    room = _room(ax)
    way = (ax.set_position - begin) * ax.superposition_direction
    if ax.coupling:  # a law may jump within the position window: less of the room is left then
        left = ax.superposition_limit - way / dt
        if ax.superposition_sign == ax.superposition_direction and left < room:
            room = left if left > 0.0 else 0.0
    t = _cover(ax, way, room, dt)
    pace = ax.set_velocity * ax.superposition_direction
    standing = pace <= 0.0 and (ax.planned_override != 0 or ax.coupling != 0)
    if t >= ax.superposition_end or standing or ax.set_motion_phase == MotionPhase.NONE:
        absorb(ax)
        return
    gain = ax.set_acceleration * ax.superposition_direction
    if pace < 0.0:
        pace = 0.0
    elif pace > ax.superposition_fastest:
        pace = ax.superposition_fastest
        gain = 0.0
    share = pace / ax.superposition_process_velocity
    speed = superposed_speed(ax, t)
    if speed * share > room:
        ax.superposed_velocity = ax.superposition_sign * room
        ax.superposed_acceleration = -ax.set_acceleration if room > 0.0 else 0.0
    else:
        ax.superposed_velocity = ax.superposition_sign * speed * share
        ax.superposed_acceleration = ax.superposition_sign * (
            _bend(ax, t) * share * share + speed * gain / ax.superposition_process_velocity
        )
    ax.set_velocity += ax.superposed_velocity
    ax.set_acceleration += ax.superposed_acceleration
