"""Phasing: change the shift by which a slave sees its master."""

from math import isfinite

from achse.codes import NcError
from achse.codes.axis import BufferMode
from achse.motion.axis import Axis
from achse.motion.checks import OK, check_dynamics, check_velocity
from achse.motion.commands.queue import dynamics
from achse.motion.profiles.profile import plan_to_position, plan_to_velocity, stopping_distance
from achse.motion.states import PhasingType

_CONTINUOUS_UPDATE = 1


def start_phasing(
    axis: Axis,
    phasing_type: int,
    control_mask: int,
    master_axis_id: int,
    phase_shift: float,
    velocity: float,
    acceleration: float = 0.0,
    deceleration: float = 0.0,
    jerk: float = 0.0,
    buffer_mode: int = BufferMode.ABORTING,
    blending_position: float = 0.0,
) -> int:
    """Start, change or stop phasing (0x34); dynamics of 0 mean the axis default.

    A relative shift counts from the present one; with bit 0 of the mask (continuous update) and a
    phasing at work, from where that one began. A stop lets the shift stay where the ramp ends.
    Buffer modes do not exist here (002), another than aborting answers 0x4251.
    """
    if axis.axis_disabled:
        return NcError.AXIS_NOT_READY
    if phasing_type not in PhasingType.__members__.values():
        return NcError.JOB_START_TYPE
    if buffer_mode != BufferMode.ABORTING or blending_position:
        return NcError.FUNCTION_NOT_AVAILABLE
    if master_axis_id and master_axis_id not in axis.fellows:
        return NcError.AXIS_ID
    acceleration, deceleration, jerk = dynamics(axis, acceleration, deceleration, jerk)
    code = check_dynamics(axis, acceleration, deceleration, jerk)
    p, v, a = axis.phasing.position, axis.phasing.velocity, axis.phasing.acceleration
    if phasing_type == PhasingType.STOP:
        if code or not axis.phasing.active:
            return code
        target = p + stopping_distance(v, a, deceleration, jerk)
        count = plan_to_velocity(
            axis.phasing.time, axis.phasing.jerk, v, a, 0.0, acceleration, deceleration, jerk
        )
    else:
        code = code or check_velocity(axis, velocity)
        if not code and not isfinite(phase_shift):
            code = NcError.START_AXIS_DATA
        if code:
            return code
        begin = p
        if axis.phasing.active and control_mask & _CONTINUOUS_UPDATE:
            begin = axis.phasing.begin
        target = phase_shift if phasing_type == PhasingType.ABSOLUTE else begin + phase_shift
        count = plan_to_position(
            axis.phasing.time, axis.phasing.jerk, p, v, a, target,
            0.0, velocity, acceleration, deceleration, jerk,
        )  # fmt: skip
        if count >= 0:
            axis.phasing.begin = begin
    if count < 0:
        return NcError.DYNAMICS_NOT_ALLOWED
    axis.phasing.target = target
    axis.phasing.count = count
    axis.phasing.index = 0
    axis.phasing.elapsed = 0.0
    axis.phasing.active = 1
    return OK
