"""Stops: halts, ramps and the lock; what a stop would take."""

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import OK, STEEPEST_JERK, why_not_dynamics
from achse.motion.commands.queue import next_number
from achse.motion.profile import stopping_distance, stopping_time
from achse.motion.setpoint import begin_stop
from achse.motion.states import BufferMode, CommandState, MotionPhase, StartType, StateBit

__all__ = [
    "emergency_stop",
    "halt",
    "parameterized_stop",
    "release_lock",
    "stop",
    "stop_information",
]


def _brake(axis: Axis, deceleration: float, jerk: float) -> None:
    """Begin a stop; one that already runs is never weakened."""
    if axis.set_motion_phase == MotionPhase.STOPPING:
        deceleration = max(deceleration, axis.job_deceleration)
        jerk = max(jerk, axis.job_jerk)
    begin_stop(axis, deceleration, jerk)
    axis.state_dword |= StateBit.HAS_BEEN_STOPPED


def halt(axis: Axis, start_type: int, deceleration: float, jerk: float, buffer_mode: int) -> int:
    if axis.axis_disabled:
        return NcError.AXIS_NOT_READY.number
    if axis.error_code:
        return axis.error_code
    if axis.motion_locked and start_type == StartType.HALT:
        return NcError.AXIS_LOCKED_BY_STOP.number
    code = why_not_dynamics(axis, axis.default_acceleration, deceleration, jerk)
    if code:
        return code
    if buffer_mode != BufferMode.ABORTING:
        return NcError.FUNCTION_NOT_AVAILABLE.number
    next_number(axis)
    _brake(axis, deceleration, jerk)
    axis.set_command_number = axis.command_counter
    moving = axis.set_motion_phase != MotionPhase.NONE
    axis.set_command_state = CommandState.ACTIVE if moving else CommandState.DONE
    if start_type == StartType.STOP_AND_LOCK:
        axis.motion_locked = 1
        axis.state_dword |= StateBit.MOTION_COMMANDS_LOCKED
    return OK


def stop(axis: Axis) -> int:
    """Stop with the deceleration and jerk of the running command (0x02)."""
    _brake(axis, axis.job_deceleration, axis.job_jerk)
    return OK


def parameterized_stop(axis: Axis, deceleration: float, jerk: float) -> int:
    """Stop with the given deceleration and jerk (0x05)."""
    code = why_not_dynamics(axis, axis.default_acceleration, deceleration, jerk)
    if code:
        return code
    _brake(axis, deceleration, jerk)
    return OK


def emergency_stop(axis: Axis, deceleration: float, jerk: float) -> int:
    """Stop with values at least as strong as those of the running command (0x04)."""
    if not (0.0 < deceleration <= axis.max_deceleration and 0.0 < jerk <= STEEPEST_JERK):
        return NcError.EMERGENCY_STOP_DATA.number
    if axis.set_motion_phase != MotionPhase.NONE and (
        deceleration < axis.job_deceleration or jerk < axis.job_jerk
    ):
        return NcError.EMERGENCY_STOP_DATA.number
    _brake(axis, deceleration, jerk)
    return OK


def release_lock(axis: Axis) -> int:
    """Release the lock of 'stop and lock' (0x18); the stop itself runs to its end."""
    axis.motion_locked = 0
    axis.state_dword &= ~StateBit.MOTION_COMMANDS_LOCKED
    return OK


def stop_information(axis: Axis, deceleration: float, jerk: float) -> tuple[float, float]:
    """Signed distance and time of a stop begun now (state 0x18).

    0 takes the values of the running command, or the axis defaults at rest.
    """
    moving = axis.set_motion_phase != MotionPhase.NONE
    if not deceleration > 0.0:
        deceleration = axis.job_deceleration if moving else axis.default_deceleration
    if not jerk > 0.0:
        jerk = axis.job_jerk if moving else axis.default_jerk
    state = axis.set_velocity, axis.set_acceleration, deceleration, jerk
    return stopping_distance(*state), stopping_time(*state)
