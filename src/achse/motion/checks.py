"""Checks: what forbids a command, as the number of the NC error; 0 is nothing."""

from collections.abc import Iterator
from math import isfinite

from achse.codes import NcError
from achse.codes.axis import ControlBit, StartType
from achse.codes.nc.choices import AxisType
from achse.motion.axis import Axis
from achse.motion.port import STATUS_ERROR

OK = 0

SLOWEST = 1e-3
FASTEST = 1e10
"""Velocities that a start may name (0x4231)."""

STEEPEST_JERK = 1e30
"""Largest jerk that a command may name."""

FARTHEST = 1e10
"""Positions beyond have too coarse a resolution (0x4232)."""

ENDLESS = {StartType.ENDLESS_POSITIVE: 1.0, StartType.ENDLESS_NEGATIVE: -1.0}
"""Start types without a target, and their direction."""

_ONE_PERIOD = {StartType.MODULO_SHORTEST, StartType.MODULO_POSITIVE, StartType.MODULO_NEGATIVE}


def check_command(axis: Axis) -> int:
    """Return the error that forbids any motion command in the present state, or 0."""
    if axis.axis_disabled:
        return NcError.AXIS_NOT_READY
    if axis.error_code:
        return axis.error_code
    if axis.grouped:
        return NcError.FUNCTION_NOT_ALLOWED
    if axis.motion_locked:
        return NcError.AXIS_LOCKED_BY_STOP
    if axis.coupling.law and not axis.allow_slave_motion_commands:
        return NcError.JOB_FOR_SLAVE
    if axis.external_setpoint_active and not axis.allow_motion_commands_with_external_setpoint:
        return NcError.EXTERNAL_GENERATOR_ACTIVE
    return OK


def check_own(axis: Axis) -> int:
    """A slave takes no function about a motion of its own, unless parameter 0x20 lets it."""
    if axis.coupling.law and not axis.allow_slave_motion_commands:
        return NcError.FUNCTION_FOR_SLAVE
    return OK


def check_permitted(axis: Axis, direction: float) -> int:
    """Return the error by which cyclic interface or drive forbid a start in `direction`, or 0."""
    if axis.axis_type == AxisType.ENCODER:
        return NcError.AXIS_INCOMPATIBLE
    control = axis.control_dword
    if not _is_enabled(axis):
        return NcError.CONTROLLER_ENABLE_MISSING
    if direction > 0.0 and not control & ControlBit.FEED_ENABLE_PLUS:
        return NcError.ENABLE_MISSING
    if direction < 0.0 and not control & ControlBit.FEED_ENABLE_MINUS:
        return NcError.ENABLE_MISSING
    blocked = axis.limit_switch != 0 and not (
        control & ControlBit.ACCEPT_BLOCKED_DRIVE and direction * axis.limit_switch < 0.0
    )
    if axis.drive_status & STATUS_ERROR or blocked:
        return NcError.DRIVE_NOT_READY_AT_START
    if axis.followers and not all(map(_is_enabled, _slaves(axis))):
        return NcError.SLAVE_ENABLE_MISSING
    return OK


def _is_enabled(axis: Axis) -> bool:
    """True if the axis has its controller enable and its drive output."""
    return bool(axis.control_dword & ControlBit.ENABLE) and not axis.drive_output_disabled


def _slaves(master: Axis) -> Iterator[Axis]:
    """Yield each axis that is coupled to this master, directly or through another slave."""
    axes = list(master.fellows.values())
    moved = {master.index}
    for row in master.order.rows:  # masters come first, so that one pass is enough
        axis = axes[row]
        if axis.coupling.law and not moved.isdisjoint(axis.followed):
            moved.add(row)
            yield axis


def check_velocity(axis: Axis, velocity: float) -> int:
    limit = min(axis.max_velocity, axis.drive.reference_velocity)
    if not 0.0 < velocity <= limit:
        return NcError.SET_VELOCITY_NOT_ALLOWED
    if not SLOWEST <= velocity <= FASTEST:
        return NcError.SET_VELOCITY_RANGE
    return OK


def check_dynamics(axis: Axis, acceleration: float, deceleration: float, jerk: float) -> int:
    """Return the error in the dynamics of a command, or 0; all are to be positive."""
    if not acceleration > 0.0:
        return NcError.ACCELERATION_NOT_POSITIVE
    if not deceleration > 0.0:
        return NcError.DECELERATION_NOT_POSITIVE
    if not jerk > 0.0:
        return NcError.JERK_NOT_POSITIVE
    if acceleration > axis.max_acceleration or deceleration > axis.max_deceleration:
        return NcError.ACCELERATION_NOT_PERMITTED
    if jerk > STEEPEST_JERK:
        return NcError.JERK_NOT_PERMITTED
    return OK


def check_position(axis: Axis, start_type: int, position: float) -> int:
    """Return the error in a commanded position or distance, whatever the axis does, or 0."""
    if start_type in ENDLESS:
        return OK
    if not isfinite(position):
        return NcError.START_AXIS_DATA
    if start_type in _ONE_PERIOD and not 0.0 <= position < axis.encoder.modulo_factor:
        return NcError.MODULO_START_RANGE
    return OK


def check_target(axis: Axis, target: float, begin: float | None = None) -> int:
    """Return the error in a target, on the way from `begin` or from the present position, or 0."""
    if begin is None:
        begin = axis.set.position
    if abs(target) > FARTHEST:
        return NcError.PRECISION_LOST
    lowest = highest = target
    if axis.loop_enable and (target - begin) * axis.loop_distance > 0.0:
        lowest = min(target, target + axis.loop_distance)
        highest = max(target, target + axis.loop_distance)
    if axis.encoder.soft_limit_min_enable and lowest < axis.encoder.soft_limit_min:
        return NcError.SOFT_LIMIT_MIN_AT_START
    if axis.encoder.soft_limit_max_enable and highest > axis.encoder.soft_limit_max:
        return NcError.SOFT_LIMIT_MAX_AT_START
    if axis.axis_type == AxisType.DISCRETE_RAPID_CREEP:
        way = target - begin
        near = axis.brake_distance_positive if way > 0.0 else axis.brake_distance_negative
        if abs(way) <= near:
            return NcError.DISTANCE_BELOW_BRAKING_DISTANCE
        back = axis.brake_distance_negative if way > 0.0 else axis.brake_distance_positive
        if lowest != highest and abs(axis.loop_distance) <= back:
            return NcError.LOOP_BELOW_BRAKING_DISTANCE
    return OK


def check_away(axis: Axis, direction: float) -> int:
    """An endless start must not lead away from a soft limit that is already passed."""
    p = axis.set.position
    if direction < 0.0 and axis.encoder.soft_limit_min_enable and p <= axis.encoder.soft_limit_min:
        return NcError.SOFT_LIMIT_MIN_AT_START
    if direction > 0.0 and axis.encoder.soft_limit_max_enable and p >= axis.encoder.soft_limit_max:
        return NcError.SOFT_LIMIT_MAX_AT_START
    return OK
