"""Switches of an axis: reset, errors from outside, enables."""

from achse.codes import NcError
from achse.codes.axis import StateBit
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.commands.homing import end_application_request
from achse.motion.commands.queue import busy
from achse.motion.setpoints.setpoint import drop_job, stop_fast


def reset(axis: Axis) -> int:
    """Reset errors (0x01), those of a drive on a bus too. During a move it stops the axis abruptly.

    A stop runs to its end, with the strongest ramp of the axis, and an axis that a group leads
    brakes with that; what MC_Stop locked is free again.
    """
    if axis.set_motion_phase in (MotionPhase.STOPPING, MotionPhase.GROUPED):
        stop_fast(axis)
    elif axis.set_motion_phase not in (MotionPhase.NONE, MotionPhase.COUPLED):
        drop_job(axis)
    axis.buffer.count = 0
    axis.error_code = 0
    axis.delayed_error.code = 0
    axis.output_cut = 0
    axis.monitoring.following_error_time = 0.0
    axis.monitoring.following_error_velocity_time = 0.0
    axis.monitoring.motion_time = 0.0
    axis.got_new_target = 0
    axis.brake_released = 0
    axis.reset_command_counter += 1
    for drive in axis.drives:
        drive.reset_cycles = drive.reset_counter if drive.on_bus else 0
    end_application_request(axis)
    axis.motion_locked = 0
    axis.state_dword &= ~(
        StateBit.ERROR | StateBit.ERROR_PROPAGATION_DELAYED | StateBit.MOTION_COMMANDS_LOCKED
    )
    return OK


def set_external_error(axis: Axis, code: int) -> int:
    """Put the axis into error `code` (0x19); it brakes as after any run-time error."""
    if not 0 < code <= 0xFFFF_FFFF:
        return NcError.REQUEST_PARAMETER
    axis.external_error = code
    return OK


def enable(axis: Axis) -> int:
    """Enable the complete axis (0x51)."""
    axis.axis_disabled = 0
    return OK


def disable(axis: Axis) -> int:
    """Disable the complete axis (0x50), not while it has a job."""
    if busy(axis):
        return NcError.GROUP_BUSY
    axis.axis_disabled = 1
    return OK


def set_drive_output(axis: Axis, enabled: bool) -> int:
    """Enable (0x61) or disable (0x60) the drive output."""
    axis.drive_output_disabled = 0 if enabled else 1
    return OK
