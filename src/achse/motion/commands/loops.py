"""Control loops: an axis goes over to another encoder, controller and drive of its own."""

from achse.codes import NcError
from achse.codes.nc.choices import ControllerType, MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.control.controller import reset_controller
from achse.motion.elements import choose_control_loop, control_loop_count
from achse.motion.setpoints.setpoint import drop_job, shift_setpoint
from achse.motion.states import ControlLoopSwitch

_POSITION_IN_DRIVE = {ControllerType.SERCOS_POSITION, ControllerType.TCOM_POSITION}


def switch_control_loop(
    axis: Axis, loop: int, switch_type: int, sync_value: float, external_setpoint: int = 0
) -> int:
    """Work with control loop `loop` from now on (0x52).

    Type 1 drops the job and begins again where the new encoder says. Types 2 and 3 go on with the
    job: 2 with the output as it was, 3 with the controller's part of it at `sync_value`, in axis
    units per second. The I-part is set so, or the following error where there is none.
    `external_setpoint`, 0 or 1, is not used.
    """
    if not 0 <= loop < control_loop_count(axis):
        return NcError.REQUEST_PARAMETER
    if switch_type not in ControlLoopSwitch.__members__.values():
        return NcError.FUNCTION_TYPE
    if not abs(sync_value) <= axis.drive.full or external_setpoint not in (0, 1):
        return NcError.REQUEST_PARAMETER
    if axis.set_motion_phase == MotionPhase.HOMING and switch_type != ControlLoopSwitch.STANDARD:
        return NcError.GROUP_BUSY
    error, output = axis.set.position - axis.actual_position, axis.drive.output
    choose_control_loop(axis, loop)
    reset_controller(axis)
    axis.monitoring.following_error_time = axis.monitoring.following_error_velocity_time = 0.0
    axis.monitoring.motion_position = axis.actual_position
    if switch_type == ControlLoopSwitch.STANDARD or not axis.loop_closed:
        drop_job(axis)
        shift_setpoint(axis, axis.actual_position - axis.set.position)
        return OK
    feedforward = axis.controller.velocity_feedforward_weight * axis.set.velocity
    beside = axis.external_controller_component + axis.drive.velocity_offset
    part = sync_value
    if switch_type == ControlLoopSwitch.SYNC_INTERNAL:
        part = output - beside - feedforward
        part -= axis.controller.acceleration_feedforward_ka * axis.set.acceleration
    kind, kv = axis.controller.type, axis.controller.position_kv
    if kind == ControllerType.PID_POSITION and axis.controller.position_tn > 0.0:
        axis.controller.position_i_part = part - kv * error
    elif kind == ControllerType.PI_VELOCITY and axis.controller.velocity_tn > 0.0:
        lag = kv * error + feedforward - axis.actual_velocity
        axis.controller.velocity_i_part = part + feedforward - axis.controller.velocity_kp * lag
    elif kv > 0.0 and kind not in _POSITION_IN_DRIVE:
        error = part / kv
    axis.controller.error_before = error
    shift_setpoint(axis, axis.actual_position + error - axis.set.position)
    return OK
