"""Homing of an axis, by the NC or by the application."""

from achse.codes import NcError
from achse.codes.axis import HomingState, StateBit
from achse.codes.nc.choices import MotionPhase, ReferenceMode
from achse.motion.axis import Axis
from achse.motion.checks import OK, check_command, check_velocity
from achse.motion.commands.queue import busy
from achse.motion.commands.special_generators.generators import begin_generator, check_generator
from achse.motion.fields.encoder import TOUCH_PROBES
from achse.motion.generators.homing import cam_direction, pulse_direction
from achse.motion.port import STATUS_HOMED, STATUS_HOMING_FAILED
from achse.motion.states import TORQUE_MODES

_REQUEST_HOMING = 1

_WITH_LATCH_1 = {
    ReferenceMode.HARDWARE_LATCH_1_RISING,
    ReferenceMode.HARDWARE_LATCH_1_FALLING,
    ReferenceMode.HARDWARE_LATCH_1_RISING_DRIVE,
    ReferenceMode.HARDWARE_LATCH_1_FALLING_DRIVE,
}

_LATCHED = {
    ReferenceMode.HARDWARE_SYNC: 0,
    ReferenceMode.HARDWARE_LATCH_1_RISING: 0,
    ReferenceMode.HARDWARE_LATCH_1_RISING_DRIVE: 0,
    ReferenceMode.HARDWARE_LATCH_1_FALLING: TOUCH_PROBES,
    ReferenceMode.HARDWARE_LATCH_1_FALLING_DRIVE: TOUCH_PROBES,
}
"""The edge that the hardware has to latch for a homing."""


def _request_application(axis: Axis, request_type: int) -> None:
    axis.application.request = int(request_type != 0)
    axis.application.request_type = request_type
    axis.wake(adapts=True)


def end_application_request(axis: Axis) -> None:
    """End the request, as the application has served it or it is withdrawn."""
    if axis.application.request:
        _request_application(axis, 0)


def home(axis: Axis) -> int:
    """Home the axis (0x10) as its reference mode says; the axis is not homed meanwhile.

    In mode 20 the application gets the request. A drive on a bus may do it itself.
    """
    if axis.encoder.reference_mode == ReferenceMode.APPLICATION:
        return _start_by_application(axis)
    if axis.homed_by_drive and axis.drive.on_bus:
        return _let_the_drive_home(axis)
    directions = cam_direction(axis), pulse_direction(axis)
    code = check_generator(axis, *directions, at_any_axis=True) or _check_home(axis)
    if code:
        return code
    begin_generator(axis, MotionPhase.HOMING)
    axis.homed = 0
    axis.homing.state = HomingState.TOWARDS_CAM
    axis.homing.begins = 1
    axis.homing.latch = 0
    axis.job.velocity = axis.homing_velocity_towards_cam
    axis.job.direction = 0.0
    axis.profile.replan = 1
    axis.switch.armed = 0
    axis.state_dword = axis.state_dword & ~StateBit.HOMED | StateBit.HOMING_BUSY
    return OK


def _let_the_drive_home(axis: Axis) -> int:
    """The drive looks for its reference with its own methods and velocities."""
    code = check_generator(axis)
    if code:
        return code
    if axis.encoder.is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED
    begin_generator(axis, MotionPhase.HOMING)
    axis.homed = 0
    axis.homing.state = HomingState.AWAIT_LATCH
    axis.homing.latch = 0
    axis.drive.io.state1 &= ~(STATUS_HOMED | STATUS_HOMING_FAILED)
    axis.switch.armed = 0
    axis.state_dword = axis.state_dword & ~StateBit.HOMED | StateBit.HOMING_BUSY
    return OK


def _start_by_application(axis: Axis) -> int:
    code = check_command(axis)
    if code:
        return code
    if busy(axis):
        return NcError.GROUP_BUSY
    if axis.encoder.is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED
    axis.homed = 0
    axis.application.command_number += 1
    _request_application(axis, _REQUEST_HOMING)
    return OK


def _check_home(axis: Axis) -> int:
    """Return the error that forbids a homing sequence of the NC, or 0."""
    mode = axis.encoder.reference_mode
    if axis.encoder.is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED
    if mode not in ReferenceMode.__members__.values() or mode == ReferenceMode.NOT_DEFINED:
        return NcError.ENCODER_REFERENCE_MODE
    if axis.drive_operation_mode in TORQUE_MODES:
        return NcError.FUNCTION_NOT_AVAILABLE
    if mode in _WITH_LATCH_1 and (
        axis.encoder.probe_active[0] or axis.encoder.probe_active[TOUCH_PROBES]
    ):
        return NcError.ENCODER_HARDWARE_LATCH
    edge = _LATCHED.get(ReferenceMode(mode))
    if edge is not None and axis.encoder.probe_refused >> edge & 1:
        return NcError.ENCODER_HARDWARE_LATCH
    if check_velocity(axis, axis.homing_velocity_towards_cam):
        return NcError.AXIS_HOMING_VELOCITY_TOWARDS_CAM
    if check_velocity(axis, axis.homing_velocity_off_cam):
        return NcError.AXIS_HOMING_VELOCITY_OFF_CAM
    return OK


def set_homing_state(axis: Axis, state: int) -> int:
    """Show a step of a homing that the application does (0x2C); 0 ends its request."""
    if axis.set_motion_phase == MotionPhase.HOMING:
        return NcError.GROUP_BUSY
    axis.homing.state = state
    if state == HomingState.READY:
        end_application_request(axis)
    return OK
