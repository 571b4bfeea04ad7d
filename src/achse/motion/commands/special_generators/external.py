"""External set points: the cyclic interface takes the lead, and gives it back."""

from math import isfinite

from achse.codes import NcError
from achse.codes.axis import BufferMode, CommandState, StartType
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import ENDLESS, OK
from achse.motion.commands.special_generators.generators import begin_generator, check_generator
from achse.motion.commands.starts import universal_start
from achse.motion.generators.external import leave_external
from achse.motion.setpoints.setpoint import begin_stop


def start_external_setpoint(axis: Axis, start_type: int, end_position: float) -> int:
    """Let the cyclic interface give the set point (0x23).

    The end position is where target monitoring expects the axis, absolute or counted from here; it
    moves nothing. A set position farther away than the axis can go in one cycle is error 0x4359.
    """
    code = check_generator(axis)
    if code:
        return code
    if start_type not in (StartType.ABSOLUTE, StartType.RELATIVE):
        return NcError.START_TYPE
    if not isfinite(end_position):
        return NcError.START_AXIS_DATA
    begin_generator(axis, MotionPhase.EXTERNAL)
    axis.external_setpoint_active = 1
    axis.external.position = axis.set.position
    axis.external.origin = 0.0
    start = axis.set.position if start_type == StartType.RELATIVE else 0.0
    axis.target_position = start + end_position
    return OK


def stop_external_setpoint(axis: Axis) -> int:
    """Take no more external set points (0x24); a moving axis brakes with its own dynamics.

    A motion command on top of them goes on.
    """
    if not axis.external_setpoint_active:
        return NcError.EXTERNAL_GENERATOR_NOT_ACTIVE
    leave_external(axis)
    if axis.set_motion_phase != MotionPhase.EXTERNAL:
        axis.job.peak_velocity = 0.0
        axis.profile.replan = 1
    elif axis.set.velocity == 0.0:
        axis.set.acceleration = 0.0
        axis.set.jerk = 0.0
        axis.set_torque = 0.0
        axis.set_torque_derivative = 0.0
        axis.set_motion_phase = MotionPhase.NONE
        axis.set_command_state = CommandState.DONE
    else:
        begin_stop(axis, axis.job.deceleration, axis.job.jerk)
    return OK


def stop_external_setpoint_endless(
    axis: Axis,
    start_type: int,
    position: float,
    velocity: float,
    acceleration: float = 0.0,
    deceleration: float = 0.0,
    jerk: float = 0.0,
    buffer_mode: int = BufferMode.ABORTING,
    blending_position: float | None = None,
    segment_start_velocity: float = 0.0,
    segment_end_velocity: float = 0.0,
) -> int:
    """Go over from external set points into an endless move, without a stop (0x2B)."""
    if not axis.external_setpoint_active:
        return NcError.EXTERNAL_GENERATOR_NOT_ACTIVE
    if start_type not in ENDLESS:
        return NcError.START_TYPE
    if buffer_mode != BufferMode.ABORTING:
        return NcError.FUNCTION_NOT_AVAILABLE
    axis.external_setpoint_active = 0
    code = universal_start(
        axis,
        start_type,
        position,
        velocity,
        acceleration,
        deceleration,
        jerk,
        buffer_mode,
        blending_position,
        segment_start_velocity,
        segment_end_velocity,
    )
    if code:
        axis.external_setpoint_active = 1
    else:
        leave_external(axis)
    return code
