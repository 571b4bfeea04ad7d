"""Section compensation: let a moving axis gain or lose a distance over a given way."""

from math import sqrt
from typing import NamedTuple

from achse.codes import NcError
from achse.codes.nc.choices import AxisType, MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK, check_command, check_dynamics, check_target
from achse.motion.commands.queue import dynamics, heading, sign
from achse.motion.setpoints.superposition import superposed_speed, superposed_way
from achse.motion.states import CompensationType

_ROUNDING = 1e-12
"""Relative rounding by which a distance may be too short."""

_LEAST, _MOST = 1e-9, 1e10
"""Bounds of the numbers of a compensation, whatever their unit."""

_OWN_WAY = {
    CompensationType.VELOCITY_REDUCTION_LIMITED,
    CompensationType.LENGTH_REDUCTION_LIMITED,
    CompensationType.ACCELERATION_REDUCTION_LIMITED,
}
"""Types whose length is the way of the compensated axis itself."""

_SHORTEST = {
    CompensationType.LENGTH_REDUCTION_ADDITIVE,
    CompensationType.LENGTH_REDUCTION_LIMITED,
}
"""Types that use the full velocity difference and as little of the way as that takes."""

_GENTLEST = {
    CompensationType.ACCELERATION_REDUCTION_ADDITIVE,
    CompensationType.ACCELERATION_REDUCTION_LIMITED,
}
"""Types that use the whole way and as little acceleration as that takes."""


class Compensation(NamedTuple):
    """A section compensation as requested, or as carried out (axis units and seconds).

    Over `length` an axis that runs at `process_velocity` gains `distance` (loses it, if negative),
    at most `velocity_increase` faster. `warning` is 0, or 0x4243 when only a part is possible.
    """

    type: int
    acceleration_increase: float
    deceleration_increase: float
    velocity_increase: float
    process_velocity: float
    distance: float
    length: float
    warning: int = 0


def start_superposition(axis: Axis, compensation: Compensation) -> tuple[int, Compensation]:
    """Start a section compensation (0x30): the refusing error or 0, and what is carried out.

    The axis must be travelling to a position, endlessly or as a slave. Accelerations of 0 are the
    axis defaults. No set velocity exceeds the axis maximum, and one that falls back does not turn.
    """
    code = _check(axis, compensation)
    if code:
        return code, compensation
    acceleration, deceleration, jerk = dynamics(
        axis, compensation.acceleration_increase, compensation.deceleration_increase, 0.0
    )
    compensation = compensation._replace(
        acceleration_increase=acceleration, deceleration_increase=deceleration
    )
    code = check_dynamics(axis, acceleration, deceleration, jerk)
    limit = _fastest(axis, compensation)
    if not code and limit <= 0.0:
        code = NcError.SET_VELOCITY_NOT_ALLOWED
    if code:
        return code, compensation
    done = _as_possible(compensation, limit)
    direction = heading(axis)
    if axis.set_motion_phase == MotionPhase.POSITIONING:
        shift = direction * done.distance
        code = check_target(axis, axis.target_position + shift)
        if not code and axis.reversing.number:
            code = check_target(axis, axis.reversing.target + shift)
        if code:
            return code, compensation
    _begin(axis, direction, done)
    return OK, done


def _begin(axis: Axis, direction: float, done: Compensation) -> None:
    """Put the trapezoid beside the main motion, which travels in `direction`."""
    rise = done.velocity_increase / done.acceleration_increase
    fall = done.velocity_increase / done.deceleration_increase
    distance = abs(done.distance)
    axis.superposed.direction = direction
    axis.superposed.sign = direction * sign(done.distance)
    axis.superposed.process_velocity = done.process_velocity
    axis.superposed.acceleration = done.acceleration_increase
    axis.superposed.deceleration = done.deceleration_increase
    axis.superposed.fastest = done.process_velocity * sqrt(
        min(
            axis.max_acceleration / done.acceleration_increase,
            axis.max_deceleration / done.deceleration_increase,
        )
    )
    axis.superposed.limit = min(axis.max_velocity, axis.drive.reference_velocity)
    axis.superposed.velocity = done.velocity_increase
    axis.superposed.distance = distance
    axis.superposed.rise_end = rise
    axis.superposed.end = distance / done.velocity_increase + 0.5 * (rise + fall)
    axis.superposed.fall_begin = axis.superposed.end - fall
    axis.superposed.stopping = 0
    axis.superposed.main_way = 0.0
    axis.superposed.position = 0.0
    axis.superposed.set_velocity = 0.0
    axis.superposed.set_acceleration = 0.0
    axis.compensating = 1
    axis.limits.recheck = 1


def stop_superposition(axis: Axis) -> int:
    """End a section compensation with its own deceleration (0x31); the main motion goes on."""
    if not axis.compensating:
        return NcError.COMPENSATION_NOT_ACTIVE
    if axis.superposed.stopping:
        return NcError.COMPENSATION_STOPPING
    now = axis.superposed.main_way / axis.superposed.process_velocity
    speed = superposed_speed(axis, now)
    fall = speed / axis.superposed.deceleration
    axis.superposed.distance = superposed_way(axis, now) + 0.5 * speed * fall
    axis.superposed.velocity = speed
    axis.superposed.rise_end = min(axis.superposed.rise_end, now)
    axis.superposed.fall_begin = now
    axis.superposed.end = now + fall
    axis.superposed.stopping = 1
    return OK


def _check(axis: Axis, compensation: Compensation) -> int:
    if axis.axis_type == AxisType.DISCRETE_RAPID_CREEP:
        return NcError.AXIS_INCOMPATIBLE
    if compensation.type not in CompensationType.__members__.values():
        return NcError.COMPENSATION_TYPE
    accelerations = (compensation.acceleration_increase, compensation.deceleration_increase)
    if not (
        all(value == 0.0 or value >= _LEAST for value in accelerations)
        and _LEAST <= compensation.process_velocity <= _MOST
    ):
        return NcError.COMPENSATION_DYNAMICS
    if not compensation.velocity_increase >= _LEAST:
        return NcError.COMPENSATION_CAMBER
    if not _LEAST <= abs(compensation.distance) <= _MOST:
        return NcError.SUPERIMPOSED_MOVE_DATA
    if not _LEAST <= compensation.length <= _MOST or _base_way(compensation) <= 0.0:
        return NcError.COMPENSATION_DISTANCE
    code = check_command(axis)
    if code:
        return code
    if axis.external_setpoint_active:
        return NcError.EXTERNAL_GENERATOR_ACTIVE
    if axis.coupling.law:
        moving = axis.set_motion_phase == MotionPhase.COUPLED and axis.set.velocity != 0.0
    else:
        moving = axis.set_motion_phase in (MotionPhase.POSITIONING, MotionPhase.ENDLESS)
        moving = moving and axis.job.velocity > 0.0  # else it is let go and comes to rest
    if axis.compensating or not moving:
        return NcError.COMPENSATION_ACTIVE
    return OK


def _base_way(compensation: Compensation) -> float:
    """Way of the main motion over which the compensation may act."""
    return (
        compensation.length - compensation.distance
        if compensation.type in _OWN_WAY
        else compensation.length
    )


def _fastest(axis: Axis, compensation: Compensation) -> float:
    """Return the requested additional velocity, as far as the limits of the axis go.

    The additional velocity scales with that of the main motion, so the ratio is what counts.
    """
    if compensation.distance < 0.0:
        return min(compensation.velocity_increase, compensation.process_velocity)
    most = min(axis.max_velocity, axis.drive.reference_velocity)
    main = abs(axis.set.velocity) if axis.coupling.law else axis.job.velocity
    ratio = most / main - 1.0
    return min(compensation.velocity_increase, compensation.process_velocity * ratio)


def _as_possible(compensation: Compensation, limit: float) -> Compensation:
    """Return the trapezoid that covers the distance, or as much of it as way and limits allow.

    A trapezoid with top v over a time T covers v T - v² c / 2, c = 1 / a + 1 / d.
    """
    c = 1.0 / compensation.acceleration_increase + 1.0 / compensation.deceleration_increase
    distance = abs(compensation.distance)
    time = _base_way(compensation) / compensation.process_velocity
    warning = 0
    if compensation.type in _SHORTEST:
        top = min(limit, sqrt(2.0 * distance / c))
        needed = distance / top + 0.5 * top * c
    elif compensation.type in _GENTLEST:
        top = min(limit, 2.0 * distance / time)  # the latter of a triangle
        gentlest = 2.0 * (top * time - distance) / (top * top)
        needed = time if gentlest >= c * (1.0 - _ROUNDING) else 2.0 * time
        if needed == time:
            compensation = compensation._replace(
                acceleration_increase=compensation.acceleration_increase * c / gentlest,
                deceleration_increase=compensation.deceleration_increase * c / gentlest,
            )
    else:
        room = time * time - 2.0 * c * distance
        # the smaller root, in the form that loses no digits
        top = 2.0 * distance / (time + sqrt(room)) if room >= 0.0 else limit
        needed = time if top <= limit * (1.0 + _ROUNDING) and room >= 0.0 else 2.0 * time
    if needed > time * (1.0 + _ROUNDING):
        warning = NcError.COMPENSATION_IN_PART
        top = min(limit, time / c)
        distance = top * time - 0.5 * c * top * top
        needed = time
    done = distance if compensation.distance > 0.0 else -distance
    length = compensation.process_velocity * needed
    return compensation._replace(
        velocity_increase=top,
        distance=done,
        length=length + done if compensation.type in _OWN_WAY else length,
        warning=warning,
    )
