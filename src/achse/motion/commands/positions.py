"""The origin of positions: the present one gets another value; scaling; the homed flag.

These commands are for one encoder of an axis. Where it is not the one that controls, the set
position is not concerned.
"""

from math import isfinite

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import FARTHEST, OK
from achse.motion.commands.homing import end_application_request
from achse.motion.commands.queue import busy
from achse.motion.machine.hardware import count_from
from achse.motion.port import wrapped
from achse.motion.setpoint import shift_encoder, shift_origin, shift_setpoint
from achse.motion.states import (
    ActualPositionType,
    ControlBit,
    ControllerType,
    DriveType,
    EncoderReferenceSystem,
)
from achse.motion.targets import modulo_part

__all__ = [
    "reinitialize_actual_position",
    "reinitialize_encoder",
    "set_actual_position",
    "set_actual_position_in_drive",
    "set_actual_position_on_the_fly",
    "set_actual_position_only",
    "set_encoder_scaling_factor",
    "set_homed_flag",
]

_CANOPEN = {DriveType.CANOPEN_SPECIAL, DriveType.MDP_742, DriveType.AX2XX_B900}
_POSITION_INTERFACE = {ControllerType.SERCOS_POSITION, ControllerType.TCOM_POSITION}

_ABSOLUTE = 1
_RELATIVE = 2
"""Kinds of a change of scaling, or of a position on the fly."""

_CLEAR_FOLLOWING_ERROR = 1


def _controls(encoder: Axis) -> bool:
    return encoder.owner is encoder


def _shift(encoder: Axis, position_type: int, position: float) -> tuple[int, float]:
    """By how much the position grows, after the error that forbids it."""
    if encoder.encoder_is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED.number, 0.0
    if not abs(position) <= FARTHEST:
        return NcError.ENCODER_SET_POSITION_RANGE.number, 0.0
    if position_type == ActualPositionType.ABSOLUTE:
        shift = position - encoder.actual_position
    elif position_type == ActualPositionType.RELATIVE:
        shift = position
    elif position_type == ActualPositionType.MODULO:
        shift = position - modulo_part(encoder.actual_position, encoder.encoder_modulo_factor)
    else:
        return NcError.JOB_START_TYPE.number, 0.0
    if abs(encoder.actual_position + shift) > FARTHEST:
        return NcError.ENCODER_SET_POSITION_RANGE.number, 0.0
    return OK, shift


def _rename(encoder: Axis, shift: float) -> None:
    if _controls(encoder):
        shift_origin(encoder, shift)
    else:
        shift_encoder(encoder, shift)


def set_actual_position(encoder: Axis, position_type: int, position: float) -> int:
    """Give the present position another value, set and actual alike (0x1A); at rest only."""
    if encoder.encoder_is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED.number
    if _controls(encoder) and busy(encoder):
        return NcError.GROUP_BUSY.number
    code, shift = _shift(encoder, position_type, position)
    if code == OK:
        _rename(encoder, shift)
    return code


def set_actual_position_only(encoder: Axis, position_type: int, position: float) -> int:
    """Give the actual position another value, not the set position (0x1C), also in motion.

    A closed loop takes what comes of it for a following error, and moves.
    """
    code, shift = _shift(encoder, position_type, position)
    if code == OK:
        shift_encoder(encoder, shift)
    return code


def set_actual_position_on_the_fly(
    encoder: Axis, position_type: int, control_dword: int, position: float
) -> int:
    """Give the present position another value while the axis moves (0x1F).

    What is planned moves along, so the motion goes on undisturbed to where it was to end. Bit 0 of
    `control_dword` clears the following error.
    """
    if position_type not in (_ABSOLUTE, _RELATIVE):
        return NcError.JOB_START_TYPE.number
    code, shift = _shift(encoder, position_type, position)
    if code:
        return code
    _rename(encoder, shift)
    if control_dword & _CLEAR_FOLLOWING_ERROR and _controls(encoder):
        shift_setpoint(encoder, encoder.actual_position - encoder.set_position)
    return OK


def set_actual_position_in_drive(encoder: Axis, position_type: int, position: float) -> int:
    """Have the drive count from another number (0x1D): CANopen drives with position interface.

    The position becomes that of the nearest increment.
    """
    owner = encoder.owner
    if owner.drive_type not in _CANOPEN or owner.controller_type not in _POSITION_INTERFACE:
        return NcError.FUNCTION_NOT_AVAILABLE.number
    if encoder.encoder_position_offset != 0.0:
        return NcError.ENCODER_POSITION_OFFSET.number
    if _controls(encoder) and busy(encoder):
        return NcError.GROUP_BUSY.number
    code, shift = _shift(encoder, position_type, position)
    if code:
        return code
    steps = round(shift / encoder.encoder_scale)
    _rename(encoder, steps * encoder.encoder_scale)
    encoder.encoder_set_position_offset -= steps * encoder.encoder_scale
    encoder.encoder_software_increments += steps
    encoder.encoder_data = wrapped(encoder.encoder_data + steps)
    count_from(encoder.sensor, encoder.amplifier, steps)
    encoder.adapt = 1
    return OK


def set_encoder_scaling_factor(
    encoder: Axis, scaling_type: int, control_word: int, factor: float
) -> int:
    """Change the scaling of an encoder on the fly (0x1E).

    Absolute (1): from now on the counts mean other positions, at rest only. Relative (2): the
    position stays, only what comes counts differently. No bit of the control word is documented.
    """
    if scaling_type not in (_ABSOLUTE, _RELATIVE):
        return NcError.JOB_START_TYPE.number
    if not (isfinite(factor) and 1e-8 <= factor <= 100.0):
        return NcError.ENCODER_SCALING_FACTOR.number
    if scaling_type == _ABSOLUTE and _controls(encoder) and busy(encoder):
        return NcError.GROUP_BUSY.number
    growth = factor / encoder.encoder_scaling_factor
    difference = encoder.encoder_software_increments * encoder.encoder_scale * (growth - 1.0)
    if scaling_type == _ABSOLUTE:
        _rename(encoder, difference)
    encoder.encoder_set_position_offset -= difference
    encoder.encoder_scaling_factor = factor
    encoder.encoder_scaling_numerator = factor
    encoder.encoder_scaling_denominator = 1.0
    return OK


def reinitialize_encoder(encoder: Axis) -> int:
    """Take the position from the hardware anew, as at the start of the NC (0x3B).

    What was set is lost, and an incremental encoder is no longer homed. Not while enabled.
    """
    owner = encoder.owner
    if owner.control_dword & ControlBit.ENABLE or owner.loop_closed:
        return NcError.FUNCTION_NOT_ALLOWED.number
    encoder.encoder_reinitialization_state = 1
    encoder.adapt = 1
    owner.initialize_command_counter += 1
    owner.resting = 0
    return OK


def reinitialize_actual_position(encoder: Axis) -> int:
    """Take an absolute position from the hardware anew (0x5200:0x1B); incremental ones stay."""
    if encoder.encoder_reference_system == EncoderReferenceSystem.INC:
        return OK
    return reinitialize_encoder(encoder)


def set_homed_flag(encoder: Axis, homed: int) -> int:
    """Set or clear the homed flag (0x1B); it ends a request to the application to home."""
    if homed not in (0, 1):
        return NcError.ENCODER_HOMED_FLAG.number
    encoder.homed = homed
    if homed and _controls(encoder):
        end_application_request(encoder)
    return OK
