"""The origin of positions: the present one gets another value; the homed flag."""

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import FARTHEST, OK
from achse.motion.commands.queue import busy
from achse.motion.setpoint import shift_origin
from achse.motion.states import ActualPositionType

__all__ = ["set_actual_position", "set_homed_flag"]


def set_actual_position(axis: Axis, position_type: int, position: float) -> int:
    """Give the present position another value, set and actual alike (0x1A); at rest only."""
    if axis.encoder_is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED.number
    if busy(axis):
        return NcError.GROUP_BUSY.number
    if not abs(position) <= FARTHEST:
        return NcError.ENCODER_SET_POSITION_RANGE.number
    if position_type == ActualPositionType.ABSOLUTE:
        shift = position - axis.actual_position
    elif position_type == ActualPositionType.RELATIVE:
        shift = position
    elif position_type == ActualPositionType.MODULO:
        shift = position - axis.actual_position_modulo
    else:
        return NcError.JOB_START_TYPE.number
    if abs(axis.actual_position + shift) > FARTHEST:
        return NcError.ENCODER_SET_POSITION_RANGE.number
    shift_origin(axis, shift)
    return OK


def set_homed_flag(axis: Axis, homed: int) -> int:
    """Set or clear the homed flag (0x1B)."""
    if homed not in (0, 1):
        return NcError.ENCODER_HOMED_FLAG.number
    axis.homed = homed
    return OK
