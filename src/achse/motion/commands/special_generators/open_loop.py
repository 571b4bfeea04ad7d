"""Motion in open loop: direct drive output, torque mode; operation mode of the drive, brake."""

from math import isfinite

from achse.codes import NcError
from achse.codes.axis import BufferMode
from achse.codes.nc.choices import AxisType, DriveType, MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK, check_away, check_command, check_permitted
from achse.motion.commands.queue import busy
from achse.motion.commands.special_generators.generators import begin_generator, check_generator
from achse.motion.commands.stops import stop
from achse.motion.port import STATUS_READY
from achse.motion.setpoints.setpoint import absorb, begin_stop
from achse.motion.states import (
    POSITION_MODES,
    TORQUE_MODES,
    VELOCITY_MODES,
    DriveOperationMode,
    DriveOutputType,
    TorqueStartType,
)

_MODES = (DriveOperationMode.DEFAULT, *TORQUE_MODES, *VELOCITY_MODES, *POSITION_MODES)
"""Operation modes that the simulated drive knows.

It has no commutation angle (6), which a master sends as process data, no homing of its own (38) and
none of the modes that a SERCOS (100 …) or CoE drive (below 0) is given by its own parameters.
"""

_TORQUE_TAKES_OVER = (
    MotionPhase.NONE,
    MotionPhase.POSITIONING,
    MotionPhase.ENDLESS,
    MotionPhase.STOPPING,
    MotionPhase.TORQUE,
)

_FROM_MANUAL_TORQUE = 1 << 0
_UPDATE_ONLY = 1 << 31
"""Bits of the control mask of function 0x2D."""

_LARGEST = 1e10


def _output(axis: Axis, output_type: int, value: float) -> float:
    """Output in axis units per second."""
    if output_type == DriveOutputType.PERCENT:
        return value / 100.0 * axis.drive.reference_velocity / axis.drive.reference_output
    return value


def _check_output(output_type: int, value: float) -> int:
    if output_type not in DriveOutputType.__members__.values():
        return NcError.START_TYPE
    return OK if isfinite(value) else NcError.START_AXIS_DATA


def start_drive_output(axis: Axis, output_type: int, value: float) -> int:
    """Give the drive an output past the position controller, in % or as velocity (0x26).

    The set point follows the axis meanwhile. The output limits of the drive hold; a two-speed axis
    runs at rapid speed above 50 %.
    """
    code = _check_output(output_type, value)
    code = code or check_generator(axis, value, at_any_axis=True) or check_away(axis, value)
    if code:
        return code
    begin_generator(axis, MotionPhase.DRIVE_OUTPUT)
    axis.direct_output = _output(axis, output_type, value)
    return OK


def change_drive_output(axis: Axis, output_type: int, value: float) -> int:
    """Change the direct output of the drive (0x28)."""
    if axis.set_motion_phase != MotionPhase.DRIVE_OUTPUT:
        return NcError.GENERATOR_INACTIVE
    code = _check_output(output_type, value) or check_permitted(axis, value)
    if code:
        return code
    axis.direct_output = _output(axis, output_type, value)
    return OK


def stop_drive_output(axis: Axis) -> int:
    """End the direct output (0x27): the position controller takes over and brakes the axis."""
    if axis.set_motion_phase != MotionPhase.DRIVE_OUTPUT:
        return NcError.GENERATOR_INACTIVE
    begin_stop(axis, axis.job.deceleration, axis.job.jerk)
    return OK


def start_torque_control(
    axis: Axis,
    torque_start_type: int,
    control_mask: int,
    mode: int,
    buffer_mode: int,
    torque: float,
    torque_ramp: float,
    velocity_limit_high: float,
    velocity_limit_low: float,
    acceleration: float,
    deceleration: float,
    manual_torque: float,
) -> int:
    """Switch the drive to torque mode (CST) and command a signed torque, 1000 = 100 % (0x2D).

    The set torque runs to its target with `torque_ramp` per second, 0 at once. It begins with the
    manual torque if bit 0 of the mask says so, else with the actual torque. The drive keeps the
    velocity between the limits, and its change below acceleration and deceleration, 0 without
    limit. A stop, type 0x3000 and any motion command lead back to position control; after an error
    that opens the loop the drive stays in torque mode, without torque.
    """
    if torque_start_type not in TorqueStartType.__members__.values():
        return NcError.START_TYPE
    if torque_start_type == TorqueStartType.ABORT:
        if axis.set_motion_phase != MotionPhase.TORQUE:
            return NcError.GENERATOR_INACTIVE
        return stop(axis)
    if buffer_mode != BufferMode.ABORTING:
        return NcError.FUNCTION_NOT_AVAILABLE
    positive = (torque_ramp, acceleration, deceleration)
    signed = (torque, velocity_limit_high, velocity_limit_low, manual_torque)
    if (
        mode not in (0, 1)
        or not all(0.0 <= value <= _LARGEST for value in positive)
        or not all(abs(value) <= _LARGEST for value in signed)
        or velocity_limit_low > velocity_limit_high
    ):
        return NcError.START_AXIS_DATA
    runs = axis.set_motion_phase == MotionPhase.TORQUE
    if control_mask & _UPDATE_ONLY:
        if not (runs and axis.torque.continuous):
            return NcError.GENERATOR_INACTIVE
    else:
        code = _begin_torque(axis, torque_start_type, control_mask, torque, manual_torque)
        if code:
            return code
        axis.torque.continuous = mode
        axis.torque.acceleration = acceleration
        axis.torque.deceleration = deceleration
    axis.torque.ramp = torque_ramp
    axis.torque.velocity_high = velocity_limit_high
    axis.torque.velocity_low = velocity_limit_low
    return OK


def _begin_torque(
    axis: Axis, start_type: int, control_mask: int, torque: float, manual_torque: float
) -> int:
    """Make the torque the active job, if nothing forbids it."""
    if axis.axis_type == AxisType.DISCRETE_RAPID_CREEP or axis.drive.type == DriveType.STEPPER:
        return NcError.GENERATOR_FUNCTION_MISSING
    if axis.external_setpoint_active:
        return NcError.EXTERNAL_GENERATOR_ACTIVE
    code = check_command(axis)
    if not code and axis.set_motion_phase not in _TORQUE_TAKES_OVER:
        code = NcError.GROUP_BUSY
    present = axis.drive.actual_torque
    if axis.set_motion_phase == MotionPhase.TORQUE:
        present = axis.set_torque
    if start_type == TorqueStartType.RELATIVE:
        torque += present
    code = code or check_permitted(axis, torque)
    if code:
        return code
    axis.buffer.count = 0
    axis.switch.armed = 0
    absorb(axis)
    begin_generator(axis, MotionPhase.TORQUE)
    axis.torque.target = torque
    axis.set_torque = manual_torque if control_mask & _FROM_MANUAL_TORQUE else present
    if axis.drive_operation_mode not in TORQUE_MODES:
        axis.torque.mode_before = axis.drive_operation_mode
        axis.drive_operation_mode = DriveOperationMode.TORQUE
    return OK


def set_drive_operation_mode(axis: Axis, mode: int) -> int:
    """Choose the operation mode of the drive (0x63), not while the axis has a job.

    Velocity and position modes choose the interface whatever the drive is configured for; 0 goes
    back to that. In torque mode without a torque command the motor has no torque. Modes with a
    dynamic container (17 … 21) follow the same value; a velocity goes on within the cycle. A mode
    that the simulated drive has not is refused with 0x4602. While a drive that is ready still
    changes to the mode before, another is refused with 0x4627.
    """
    if axis.axis_type == AxisType.DISCRETE_RAPID_CREEP or axis.drive.type == DriveType.STEPPER:
        return NcError.AXIS_INCOMPATIBLE
    if mode not in _MODES:
        return NcError.DRIVE_MODE
    if busy(axis):
        return NcError.GROUP_BUSY
    io = axis.drive.io
    if io.state1 & STATUS_READY and io.state3 != io.ctrl3:
        return NcError.DRIVE_MODE_CHANGE_BUSY
    axis.drive_operation_mode = mode
    axis.torque.mode_before = DriveOperationMode.DEFAULT
    axis.set_torque = 0.0
    axis.wake(adapts=True)
    return OK


def release_brake(axis: Axis, released: int) -> int:
    """Keep the parking brake released (1) or leave it to the axis (0), which a reset does too."""
    if axis.axis_type != AxisType.DISCRETE_RAPID_CREEP:
        return NcError.AXIS_INCOMPATIBLE
    if released not in (0, 1):
        return NcError.REQUEST_PARAMETER
    axis.brake_released = released
    return OK
