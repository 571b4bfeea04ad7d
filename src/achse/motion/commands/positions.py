"""The origin of positions: the present one gets another value; scaling; the homed flag.

These commands are for one encoder of an axis. Where it is not the one that controls, the set
position is not concerned.
"""

from math import isfinite

from achse.codes import NcError
from achse.codes.axis import ActualPositionType, ControlBit
from achse.codes.nc.choices import ControllerType, DriveType, EncoderReferenceSystem
from achse.motion.axis import Axis
from achse.motion.checks import FARTHEST, OK
from achse.motion.commands.homing import end_application_request
from achse.motion.commands.queue import busy
from achse.motion.machine.hardware import count_from
from achse.motion.parts import AxisEncoder
from achse.motion.port import wrapped
from achse.motion.setpoints.setpoint import shift_encoder, shift_origin, shift_setpoint
from achse.motion.setpoints.targets import modulo_part

_CANOPEN = {DriveType.CANOPEN_SPECIAL, DriveType.MDP_742, DriveType.AX2XX_B900}
_POSITION_INTERFACE = {ControllerType.SERCOS_POSITION, ControllerType.TCOM_POSITION}

_ABSOLUTE = 1
_RELATIVE = 2
"""Kinds of a change of scaling, or of a position on the fly."""

_CLEAR_FOLLOWING_ERROR = 1


def _controls(encoder: AxisEncoder) -> bool:
    return encoder.owner.encoder is encoder


def _shift(encoder: AxisEncoder, position_type: int, position: float) -> tuple[int, float]:
    """By how much the position grows, after the error that forbids it."""
    if encoder.is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED, 0.0
    if not abs(position) <= FARTHEST:
        return NcError.ENCODER_SET_POSITION_RANGE, 0.0
    if position_type == ActualPositionType.ABSOLUTE:
        shift = position - encoder.actual_position
    elif position_type == ActualPositionType.RELATIVE:
        shift = position
    elif position_type == ActualPositionType.MODULO:
        shift = position - modulo_part(encoder.actual_position, encoder.modulo_factor)
    else:
        return NcError.JOB_START_TYPE, 0.0
    if abs(encoder.actual_position + shift) > FARTHEST:
        return NcError.ENCODER_SET_POSITION_RANGE, 0.0
    return OK, shift


def _rename(encoder: AxisEncoder, shift: float) -> None:
    if _controls(encoder):
        shift_origin(encoder.owner, shift)
    else:
        shift_encoder(encoder.owner, encoder, shift)


def set_actual_position(at: Axis | AxisEncoder, position_type: int, position: float) -> int:
    """Give the present position another value, set and actual alike (0x1A); at rest only."""
    encoder = at.encoder
    if encoder.is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED
    if _controls(encoder) and busy(encoder.owner):
        return NcError.GROUP_BUSY
    code, shift = _shift(encoder, position_type, position)
    if code == OK:
        _rename(encoder, shift)
    return code


def set_actual_position_only(at: Axis | AxisEncoder, position_type: int, position: float) -> int:
    """Give the actual position another value, not the set position (0x1C), also in motion.

    A closed loop takes what comes of it for a following error, and moves.
    """
    encoder = at.encoder
    code, shift = _shift(encoder, position_type, position)
    if code == OK:
        shift_encoder(encoder.owner, encoder, shift)
    return code


def set_actual_position_on_the_fly(
    at: Axis | AxisEncoder, position_type: int, control_dword: int, position: float
) -> int:
    """Give the present position another value while the axis moves (0x1F).

    What is planned moves along, so the motion goes on undisturbed to where it was to end. Bit 0 of
    `control_dword` clears the following error.
    """
    encoder = at.encoder
    if position_type not in (_ABSOLUTE, _RELATIVE):
        return NcError.JOB_START_TYPE
    code, shift = _shift(encoder, position_type, position)
    if code:
        return code
    _rename(encoder, shift)
    if control_dword & _CLEAR_FOLLOWING_ERROR and _controls(encoder):
        shift_setpoint(encoder.owner, encoder.actual_position - encoder.owner.set.position)
    return OK


def set_actual_position_in_drive(
    at: Axis | AxisEncoder, position_type: int, position: float
) -> int:
    """Have the drive count from another number (0x1D): CANopen drives with position interface.

    The position becomes that of the nearest increment.
    """
    encoder = at.encoder
    owner = encoder.owner
    if owner.drive.type not in _CANOPEN or owner.controller.type not in _POSITION_INTERFACE:
        return NcError.FUNCTION_NOT_AVAILABLE
    if encoder.position_offset != 0.0:
        return NcError.ENCODER_POSITION_OFFSET
    if _controls(encoder) and busy(encoder.owner):
        return NcError.GROUP_BUSY
    code, shift = _shift(encoder, position_type, position)
    if code:
        return code
    steps = round(shift / encoder.scale)
    _rename(encoder, steps * encoder.scale)
    encoder.set_position_offset -= steps * encoder.scale
    encoder.software_increments += steps
    encoder.data = wrapped(encoder.data + steps)
    count_from(encoder.sensor, encoder.owner.amplifier, steps)
    encoder.adapt = 1
    encoder.owner.wake(adapts=True)
    return OK


def set_encoder_scaling_factor(
    at: Axis | AxisEncoder, scaling_type: int, control_word: int, factor: float
) -> int:
    """Change the scaling of an encoder on the fly (0x1E).

    Absolute (1): from now on the counts mean other positions, at rest only. Relative (2): the
    position stays, only what comes counts differently. No bit of the control word is documented.
    """
    encoder = at.encoder
    if scaling_type not in (_ABSOLUTE, _RELATIVE):
        return NcError.JOB_START_TYPE
    if not (isfinite(factor) and 1e-8 <= factor <= 100.0):
        return NcError.ENCODER_SCALING_FACTOR
    if scaling_type == _ABSOLUTE and _controls(encoder) and busy(encoder.owner):
        return NcError.GROUP_BUSY
    growth = factor / encoder.scaling_factor
    difference = encoder.software_increments * encoder.scale * (growth - 1.0)
    if scaling_type == _ABSOLUTE:
        _rename(encoder, difference)
    encoder.set_position_offset -= difference
    encoder.scaling_factor = factor
    encoder.scaling_numerator = factor
    encoder.scaling_denominator = 1.0
    return OK


def reinitialize_encoder(at: Axis | AxisEncoder) -> int:
    """Take the position from the hardware again, as at the start of the NC (0x3B).

    What was set is lost, and an incremental encoder is no longer homed. Not while enabled.
    """
    encoder = at.encoder
    owner = encoder.owner
    if owner.control_dword & ControlBit.ENABLE or owner.loop_closed:
        return NcError.FUNCTION_NOT_ALLOWED
    encoder.reinitialization_state = 1
    encoder.adapt = 1
    encoder.owner.wake(adapts=True)
    owner.initialize_command_counter += 1
    owner.resting = 0
    return OK


def reinitialize_actual_position(at: Axis | AxisEncoder) -> int:
    """Take an absolute position from the hardware again (0x5200:0x1B); incremental ones stay."""
    encoder = at.encoder
    if encoder.reference_system == EncoderReferenceSystem.INC:
        return OK
    return reinitialize_encoder(encoder)


def set_homed_flag(at: Axis | AxisEncoder, homed: int) -> int:
    """Set or clear the homed flag (0x1B); it ends a request to the application to home."""
    encoder = at.encoder
    if homed not in (0, 1):
        return NcError.ENCODER_HOMED_FLAG
    encoder.homed = homed
    if homed and _controls(encoder):
        end_application_request(encoder.owner)
    return OK
