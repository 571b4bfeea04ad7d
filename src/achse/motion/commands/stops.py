"""Stops: halts, ramps and the lock; what a stop would take."""

from math import isfinite

from achse.codes import NcError
from achse.codes.axis import BufferMode, CommandState, StartType, StateBit
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK, STEEPEST_JERK, check_dynamics, check_own, check_target
from achse.motion.commands.queue import heading, next_number, sign
from achse.motion.profiles.profile import stopping_distance, stopping_time
from achse.motion.setpoints.dynamics import fault_deceleration, fault_jerk
from achse.motion.setpoints.setpoint import absorb, begin_stop
from achse.motion.setpoints.targets import modulo_part


def _brake(axis: Axis, deceleration: float, jerk: float) -> None:
    """Begin a stop; one that already runs is never weakened. A slave is uncoupled.

    The cycle lets a slave go for a motion of its own too, unless that is over within one cycle.
    """
    if axis.coupling.law:
        axis.release()
    if axis.set_motion_phase == MotionPhase.STOPPING:
        deceleration = max(deceleration, axis.job.deceleration)
        jerk = max(jerk, axis.job.jerk)
    begin_stop(axis, deceleration, jerk)
    axis.state_dword |= StateBit.HAS_BEEN_STOPPED


def halt(axis: Axis, start_type: int, deceleration: float, jerk: float, buffer_mode: int) -> int:
    if axis.axis_disabled:
        return NcError.AXIS_NOT_READY
    if axis.error_code:
        return axis.error_code
    if axis.motion_locked and start_type == StartType.HALT:
        return NcError.AXIS_LOCKED_BY_STOP
    code = check_dynamics(axis, axis.max_acceleration, deceleration, jerk)
    if code:
        return code
    if buffer_mode != BufferMode.ABORTING and not (
        buffer_mode == BufferMode.BUFFERED and start_type == StartType.HALT
    ):
        return NcError.FUNCTION_NOT_AVAILABLE
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
    code = check_own(axis)
    if code:
        return code
    _brake(axis, axis.job.deceleration, axis.job.jerk)
    return OK


def parameterized_stop(axis: Axis, deceleration: float, jerk: float) -> int:
    """Stop with the given deceleration and jerk (0x05)."""
    code = check_own(axis) or check_dynamics(axis, axis.max_acceleration, deceleration, jerk)
    if code:
        return code
    _brake(axis, deceleration, jerk)
    return OK


def emergency_stop(axis: Axis, deceleration: float, jerk: float) -> int:
    """Stop with values at least as strong as those of the running command (0x04).

    The ramp is the strongest one of the axis where that is stronger still.
    """
    code = check_own(axis)
    if code:
        return code
    if not (0.0 < deceleration <= axis.max_deceleration and 0.0 < jerk <= STEEPEST_JERK):
        return NcError.EMERGENCY_STOP_DATA
    if axis.set_motion_phase != MotionPhase.NONE and (
        deceleration < axis.job.deceleration or jerk < axis.job.jerk
    ):
        return NcError.EMERGENCY_STOP_DATA
    _brake(axis, max(deceleration, fault_deceleration(axis)), max(jerk, fault_jerk(axis)))
    return OK


def oriented_stop(axis: Axis, modulo_position: float, deceleration: float, jerk: float) -> int:
    """Stop at a position within the period (0x09), the first one ahead where the brakes hold.

    The ramp is that of the running command; the given one is checked but without effect (002).
    """
    code = check_own(axis) or check_dynamics(axis, axis.max_acceleration, deceleration, jerk)
    if code:
        return code
    if not (modulo_position >= 0.0 and isfinite(modulo_position)):
        return NcError.MODULO_START_RANGE
    if axis.set_motion_phase not in (MotionPhase.POSITIONING, MotionPhase.ENDLESS):
        return NcError.NO_MOTION
    ramp = stopping_distance(
        axis.set.velocity, axis.set.acceleration, axis.job.deceleration, axis.job.jerk
    )
    rest = axis.set.position + ramp
    direction = sign(ramp) or heading(axis)
    way = modulo_part((modulo_position - rest) * direction, axis.encoder.modulo_factor)
    target = rest + direction * way
    code = check_target(axis, target)
    if code:
        return code
    absorb(axis)
    axis.buffer.count = 0
    axis.switch.armed = 0
    axis.set_motion_phase = MotionPhase.POSITIONING
    axis.target_position = target
    axis.job.end_velocity = 0.0
    axis.job.peak_velocity = 0.0
    axis.reversing.number = 0
    axis.profile.replan = 1
    axis.has_been_stopped = 1
    axis.state_dword |= StateBit.HAS_BEEN_STOPPED
    return OK


def clear(axis: Axis) -> int:
    """Take the job and all waiting commands away (0x03); a moving axis brakes with its own ramp.

    Other than after a stop, bit 7 of the status does not say that the axis was stopped.
    """
    code = check_own(axis)
    if code:
        return code
    stopped = axis.has_been_stopped
    if axis.coupling.law:
        axis.release()
    begin_stop(axis, axis.job.deceleration, axis.job.jerk)
    axis.has_been_stopped = stopped
    axis.got_new_target = 0
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
        deceleration = axis.job.deceleration if moving else axis.default_deceleration
    if not jerk > 0.0:
        jerk = axis.job.jerk if moving else axis.default_jerk
    state = axis.set.velocity, axis.set.acceleration, deceleration, jerk
    return stopping_distance(*state), stopping_time(*state)
