"""Monitoring: enables, limits, windows and times become errors and the status double word.

Kernel source: compiled as it stands, see `compiled`.
"""

from math import floor

from achse.motion.generators.table import (
    CONTINUOUS,
    TRAVELLING,
    UNPLANNED,
    along_the_set_point,
    heading,
)
from achse.motion.limits import TOLERANCE, running_into
from achse.motion.port import (
    STATUS_ERROR,
    STATUS_FAST_STOP,
    STATUS_READY,
)
from achse.motion.record import AxisFields
from achse.motion.setpoint import arrived, drop_job, fail, stop_fast
from achse.motion.states import (
    ControlBit,
    EncoderType,
    HomingState,
    MotionPhase,
    MotionState,
    OperationModeBit,
    SignalType,
    StateBit,
)
from achse.motion.targets import modulo_part

__all__ = [
    "operation_mode",
    "report",
    "settle",
    "show_state",
    "supervise_arrival",
    "supervise_enable",
    "supervise_motion",
]

_ENABLE = ControlBit.ENABLE.value
_FEED_ENABLE_PLUS = ControlBit.FEED_ENABLE_PLUS.value
_FEED_ENABLE_MINUS = ControlBit.FEED_ENABLE_MINUS.value
_ACCEPT_BLOCKED = ControlBit.ACCEPT_BLOCKED_DRIVE.value

_NO_JOB = MotionPhase.NONE.value
_POSITIONING = MotionPhase.POSITIONING.value
_ENDLESS = MotionPhase.ENDLESS.value
_STOPPING = MotionPhase.STOPPING.value
_HOMING = MotionPhase.HOMING.value
_EXTERNAL = MotionPhase.EXTERNAL.value
_REVERSING = MotionPhase.REVERSING.value
_DRIVE_OUTPUT = MotionPhase.DRIVE_OUTPUT.value
_TORQUE = MotionPhase.TORQUE.value

_INACTIVE = MotionState.INACTIVE.value
_RUNNING = MotionState.RUNNING.value
_OVERRIDE_ZERO = MotionState.OVERRIDE_ZERO.value
_CONSTANT = MotionState.CONSTANT_VELOCITY.value
_ACCELERATING = MotionState.ACCELERATING.value
_DECELERATING = MotionState.DECELERATING.value
_LED_EXTERNALLY = MotionState.EXTERNAL.value
_LED_BY_BOTH = MotionState.INTERNAL_AND_EXTERNAL.value

_OPERATIONAL = StateBit.OPERATIONAL.value
_HOMED = StateBit.HOMED.value
_NOT_MOVING = StateBit.NOT_MOVING.value
_IN_POSITION = StateBit.IN_POSITION_AREA.value
_IN_TARGET = StateBit.IN_TARGET_POSITION.value
_ERROR_DELAYED = StateBit.ERROR_PROPAGATION_DELAYED.value
_STOPPED = StateBit.HAS_BEEN_STOPPED.value
_HAS_JOB = StateBit.HAS_JOB.value
_POSITIVE = StateBit.POSITIVE_DIRECTION.value
_NEGATIVE = StateBit.NEGATIVE_DIRECTION.value
_HOMING_BUSY = StateBit.HOMING_BUSY.value
_COMPENSATING = StateBit.COMPENSATING.value
_EXTERNAL_ENABLED = StateBit.EXTERNAL_SETPOINT_ENABLED.value
_PHASING = StateBit.PHASING_ACTIVE.value
_LATCH_VALID = StateBit.EXTERNAL_LATCH_VALID.value
_IO_INVALID = StateBit.IO_DATA_INVALID.value
_CONSTANT_VELOCITY = StateBit.CONSTANT_VELOCITY.value
_NEW_TARGET = StateBit.NEW_TARGET_POSITION.value
_CONTINUOUS = StateBit.CONTINUOUS_MOTION.value
_LOOP_CLOSED = StateBit.CONTROL_LOOP_CLOSED.value
_BUFFERED = StateBit.COMMAND_BUFFERED.value
_PTP = StateBit.PTP_MODE.value
_BELOW_MIN = StateBit.SOFT_LIMIT_MIN_EXCEEDED.value
_ABOVE_MAX = StateBit.SOFT_LIMIT_MAX_EXCEEDED.value
_DRIVE_ERROR = StateBit.DRIVE_DEVICE_ERROR.value
_LIMIT_ACTIVE = StateBit.DRIVE_LIMIT_ACTIVE.value
_LOCKED = StateBit.MOTION_COMMANDS_LOCKED.value
_ERROR = StateBit.ERROR.value

_MODE_LOOP = OperationModeBit.LOOP.value
_MODE_BACKLASH = OperationModeBit.BACKLASH_COMPENSATION.value
_MODE_CORRECTION = OperationModeBit.POSITION_CORRECTION.value
_MODE_SLAVE_COMMANDS = OperationModeBit.ALLOW_SLAVE_COMMANDS.value
_MODE_APPLICATION = OperationModeBit.APPLICATION_REQUEST.value
_MODE_EXTERNAL_COMMANDS = OperationModeBit.ALLOW_COMMANDS_WITH_EXTERNAL_SETPOINT.value
_MODE_POSITION = OperationModeBit.POSITION_AREA_MONITORING.value
_MODE_TARGET = OperationModeBit.TARGET_POSITION_MONITORING.value
_MODE_MOTION = OperationModeBit.MOTION_MONITORING.value
_MODE_PEH = OperationModeBit.PEH_TIME_MONITORING.value
_MODE_DELAYED = OperationModeBit.DELAYED_ERROR_REACTION.value
_MODE_MODULO = OperationModeBit.MODULO.value
_MODE_SIMULATION = OperationModeBit.SIMULATION.value
_MODE_OUTPUT_FILTER = OperationModeBit.OUTPUT_FILTER.value
_MODE_LAG_POSITION = OperationModeBit.POSITION_LAG_MONITORING.value
_MODE_LAG_VELOCITY = OperationModeBit.VELOCITY_LAG_MONITORING.value
_MODE_SOFT_MIN = OperationModeBit.SOFT_LIMIT_MIN_MONITORING.value
_MODE_SOFT_MAX = OperationModeBit.SOFT_LIMIT_MAX_MONITORING.value

_RISING = SignalType.RISING_EDGE.value
_FALLING = SignalType.FALLING_EDGE.value
_BOTH = SignalType.BOTH_EDGES.value
_HIGH = SignalType.HIGH.value
_LOW = SignalType.LOW.value

_AWAIT_CAM = HomingState.AWAIT_CAM.value
_AWAIT_CAM_OFF = HomingState.AWAIT_CAM_OFF.value
_AWAIT_LATCH = HomingState.AWAIT_LATCH.value

_SIMULATED = EncoderType.SIMULATION.value

_UNITS_MODULO = 4

_IO_CYCLES = 8.5
"""Cycles without valid I/O data, and a half, that a closed loop bears."""

_ENABLE_WITHDRAWN = 0x4260
_CAM_NOT_FOUND = 0x429C
_CAM_STAYS = 0x429D
_SYNC_PULSE_NOT_FOUND = 0x429E
_FEED_MINUS_WITHDRAWN = 0x4357
_FEED_PLUS_WITHDRAWN = 0x4358
_PEH_TIME_OVER = 0x435C
_NO_MOVEMENT = 0x435D
_SOFT_LIMIT_MIN_PASSED = 0x4462
_SOFT_LIMIT_MAX_PASSED = 0x4463
_FOLLOWING_ERROR_POSITION = 0x4550
_FOLLOWING_ERROR_VELOCITY = 0x4551
_DRIVE_NOT_READY = 0x4650
_IO_DATA_INVALID = 0x4655

_QUIET = 32
"""Cycles without a change, beyond those on their way to the drive, until the axis rests."""


def report(ax: AxisFields, code: int, cut: int) -> None:
    """A supervision found `code`: react now, or after the configured delay."""
    if ax.error_reaction_mode == 1 and ax.error_reaction_delay > 0.0 and ax.error_code == 0:
        if ax.delayed_error_code == 0:
            ax.delayed_error_code = code
            ax.delayed_error_cut = cut
            ax.delayed_error_time = 0.0
        return
    fail(ax, code, cut)


def _watch_signals(ax: AxisFields, dt: float) -> None:
    """The fast-stop signal of the drive and the validity of the I/O data."""
    kind = ax.fast_axis_stop_signal_type
    if kind != 0:
        signal = 1 if ax.drive_io.state4 & STATUS_FAST_STOP else 0
        rising = signal == 1 and ax.drive_signal_before == 0
        falling = signal == 0 and ax.drive_signal_before == 1
        ax.drive_signal_before = signal
        if (
            (kind in (_RISING, _BOTH) and rising)
            or (kind in (_FALLING, _BOTH) and falling)
            or (kind == _HIGH and signal == 1)
            or (kind == _LOW and signal == 0)
        ) and ax.set_motion_phase != _NO_JOB:
            stop_fast(ax)
    if ax.io_invalid:
        ax.drive_io_time += dt
        if ax.loop_closed and ax.drive_io_time > _IO_CYCLES * dt:
            fail(ax, _IO_DATA_INVALID, 1)
    else:
        ax.drive_io_time = 0.0


def supervise_enable(ax: AxisFields, dt: float) -> None:
    """Close and open the control loop; while it is open the set point follows the axis.

    Without its enable a moving axis brakes under control and only then opens the loop.
    """
    if ax.fast_axis_stop_signal_type != 0 or ax.io_invalid or ax.drive_io_time > 0.0:
        _watch_signals(ax, dt)
    if ax.external_error != 0:
        fail(ax, ax.external_error, 0)
        ax.external_error = 0
    enables = ax.control_dword
    phase = ax.set_motion_phase
    status = ax.drive_status
    ready = status & STATUS_READY != 0
    if ax.limit_switch != 0 and enables & _ACCEPT_BLOCKED:
        ready = status & STATUS_ERROR == 0
    closed = ax.loop_closed
    if enables & _ENABLE and ready and ax.axis_disabled == 0 and ax.drive_output_disabled == 0:
        if ax.error_code == 0:
            closed = 1
            if phase != _NO_JOB:
                direction = heading(ax)
                if direction > 0.0 and enables & _FEED_ENABLE_PLUS == 0:
                    fail(ax, _FEED_PLUS_WITHDRAWN, 0)
                elif direction < 0.0 and enables & _FEED_ENABLE_MINUS == 0:
                    fail(ax, _FEED_MINUS_WITHDRAWN, 0)
    else:
        if phase != _NO_JOB and ax.error_code == 0:
            if ready:
                fail(ax, _ENABLE_WITHDRAWN, 0)
            else:
                fail(ax, _DRIVE_NOT_READY, 1)
        if ax.set_motion_phase != _STOPPING or not ready:
            closed = 0
    if ax.output_cut:
        closed = 0
    if closed and ax.loop_closed:
        return
    ax.set_position = ax.actual_position
    if closed == 0:
        drop_job(ax)
    else:
        if phase == _NO_JOB:
            ax.target_position = ax.actual_position
        ax.motion_position = ax.actual_position
        ax.following_error_time = 0.0
        ax.following_error_velocity_time = 0.0
    ax.loop_closed = closed


def _supervise_following_error(ax: AxisFields, dt: float) -> None:
    """Following errors above their window for longer than the filter time cut the output."""
    if ax.controller_following_error_position_monitoring_enable:
        if abs(ax.following_error) > ax.controller_following_error_position_max:
            ax.following_error_time += dt
            if ax.following_error_time > ax.controller_following_error_position_filter_time:
                report(ax, _FOLLOWING_ERROR_POSITION, 1)
        else:
            ax.following_error_time = 0.0
    if ax.controller_following_error_velocity_monitoring_enable:
        if abs(ax.following_error_velocity) > ax.controller_following_error_velocity_max:
            ax.following_error_velocity_time += dt
            if (
                ax.following_error_velocity_time
                > ax.controller_following_error_velocity_filter_time
            ):
                report(ax, _FOLLOWING_ERROR_VELOCITY, 1)
        else:
            ax.following_error_velocity_time = 0.0


def _not_found(ax: AxisFields, code: int) -> int:
    """What homing has not found when it comes to a soft limit, else `code`."""
    if ax.set_motion_phase != _HOMING:
        return code
    if ax.homing_state == _AWAIT_CAM:
        return _CAM_NOT_FOUND
    if ax.homing_state == _AWAIT_CAM_OFF:
        return _CAM_STAYS
    return _SYNC_PULSE_NOT_FOUND if ax.homing_state == _AWAIT_LATCH else code


def _at_limit(ax: AxisFields) -> int:
    """The soft limit that the axis has come to: 1 upper, -1 lower, 0 none.

    A table knows beforehand that it ends at one or has to pass it.
    """
    where = ax.limit_reached
    ax.limit_reached = 0
    if where != 0:
        return where
    direction = along_the_set_point(ax)
    if direction > 0.0 and ax.set_position > ax.limit_high + TOLERANCE:
        return 1
    if direction < 0.0 and ax.set_position < ax.limit_low - TOLERANCE:
        return -1
    return 0


def _supervise_limits(ax: AxisFields, dt: float) -> None:
    """Soft limits end every motion. A delayed reaction waits only where the axis stands by then."""
    where = _at_limit(ax)
    if ax.compensating or ax.external_setpoint_active or UNPLANNED[ax.set_motion_phase]:
        ahead = running_into(ax, ax.set_velocity, dt)
        if ahead != 0:
            where = ahead
    if where == 0:
        return
    code = _not_found(ax, _SOFT_LIMIT_MAX_PASSED if where > 0 else _SOFT_LIMIT_MIN_PASSED)
    if ax.set_velocity == 0.0:
        report(ax, code, 0)
    else:
        fail(ax, code, 0)


def supervise_motion(ax: AxisFields, dt: float) -> None:
    """What can go wrong in a closed loop: following error, soft limits, no movement."""
    if ax.delayed_error_code != 0:
        ax.delayed_error_time += dt
        if ax.delayed_error_time >= ax.error_reaction_delay:
            fail(ax, ax.delayed_error_code, ax.delayed_error_cut)
    if ax.loop_closed == 0:
        return
    _supervise_following_error(ax, dt)
    if ax.limited and ax.set_motion_phase != _NO_JOB:
        _supervise_limits(ax, dt)
    if ax.set_velocity == 0.0:
        ax.motion_time = 0.0
        ax.motion_position = ax.actual_position
    elif ax.motion_monitoring_enable:
        if abs(ax.actual_position - ax.motion_position) > ax.motion_monitoring_window:
            ax.motion_position = ax.actual_position
            ax.motion_time = 0.0
        else:
            ax.motion_time += dt
            if ax.motion_time > ax.motion_monitoring_time:
                report(ax, _NO_MOVEMENT, 1)


def supervise_arrival(ax: AxisFields, dt: float) -> None:
    """Position and target window, positioning time, PEH time."""
    phase = ax.set_motion_phase
    way = abs(ax.target_position - ax.actual_position)
    travelling = (
        TRAVELLING[phase] == 1
        or (phase == _HOMING and ax.set_velocity != 0.0)
        or ax.loop_outward == 1
    )
    ax.in_position_range = 0
    if ax.position_range_monitoring_enable and way <= ax.position_range_window and not travelling:
        ax.in_position_range = 1
    if ax.target_position_monitoring_enable and way <= ax.target_position_window and not travelling:
        if ax.in_target_position == 0:
            if ax.target_window_time >= ax.target_position_monitoring_time:
                ax.in_target_position = 1
            ax.target_window_time += dt
    else:
        ax.in_target_position = 0
        ax.target_window_time = 0.0
    if ax.job_timing:
        ax.job_time += dt
        if phase == _NO_JOB:
            if arrived(ax):
                ax.last_positioning_time = ax.job_time
                ax.job_timing = 0
            elif ax.peh_monitoring_enable and ax.target_position_monitoring_enable:
                ax.peh_time += dt
                if ax.peh_time > ax.peh_monitoring_time:
                    ax.job_timing = 0
                    report(ax, _PEH_TIME_OVER, 0)
        else:
            ax.peh_time = 0.0


def operation_mode(ax: AxisFields) -> int:
    """OpModeDWord: the monitoring that is switched on."""
    mode = 0
    if ax.encoder_type == _SIMULATED:
        mode |= _MODE_SIMULATION
    if ax.drive_output_filter_type:
        mode |= _MODE_OUTPUT_FILTER
    if ax.loop_enable:
        mode |= _MODE_LOOP
    if ax.backlash_compensation_enable:
        mode |= _MODE_BACKLASH
    if ax.encoder_actual_position_correction_enable:
        mode |= _MODE_CORRECTION
    if ax.application_request:
        mode |= _MODE_APPLICATION
    if ax.allow_slave_motion_commands:
        mode |= _MODE_SLAVE_COMMANDS
    if ax.allow_motion_commands_with_external_setpoint:
        mode |= _MODE_EXTERNAL_COMMANDS
    if ax.position_range_monitoring_enable:
        mode |= _MODE_POSITION
    if ax.target_position_monitoring_enable:
        mode |= _MODE_TARGET
    if ax.motion_monitoring_enable:
        mode |= _MODE_MOTION
    if ax.peh_monitoring_enable:
        mode |= _MODE_PEH
    if ax.error_reaction_mode == 1:
        mode |= _MODE_DELAYED
    if ax.unit_interpretation & _UNITS_MODULO:
        mode |= _MODE_MODULO
    if ax.controller_following_error_position_monitoring_enable:
        mode |= _MODE_LAG_POSITION
    if ax.controller_following_error_velocity_monitoring_enable:
        mode |= _MODE_LAG_VELOCITY
    if ax.encoder_soft_limit_min_enable:
        mode |= _MODE_SOFT_MIN
    if ax.encoder_soft_limit_max_enable:
        mode |= _MODE_SOFT_MAX
    return mode


def show_state(ax: AxisFields) -> None:
    """Status double word, motion state, override in force, modulo set position."""
    ax.set_velocity_override = ax.velocity_override / 1e6
    phase = ax.set_motion_phase
    v = ax.set_velocity
    state = _PTP
    motion = _INACTIVE
    direction = 0.0
    if ax.error_code != 0:
        state |= _ERROR
    elif ax.loop_closed:
        state |= _OPERATIONAL
    if ax.loop_closed:
        state |= _LOOP_CLOSED
    if phase == _NO_JOB:
        state |= _NOT_MOVING
    else:
        motion = _RUNNING
        a = ax.set_acceleration
        facing = along_the_set_point(ax)
        if facing > 0.0:
            state |= _POSITIVE
            direction = 1.0
        elif facing < 0.0:
            state |= _NEGATIVE
            direction = -1.0
            a = -a
        if phase != _STOPPING:
            if ax.planned_override == 0 and v == 0.0:
                motion = _OVERRIDE_ZERO
            if CONTINUOUS[phase]:
                state |= _CONTINUOUS
        if v != 0.0:
            if ax.set_jerk == 0.0 and abs(a) <= 1e-9 * ax.job_acceleration:
                motion = _CONSTANT
                state |= _CONSTANT_VELOCITY
            elif a > 0.0:
                motion = _ACCELERATING
            else:
                motion = _DECELERATING
        if ax.external_setpoint_active:
            motion = _LED_EXTERNALLY if phase == _EXTERNAL else _LED_BY_BOTH
    if ax.error_code == 0 and (phase != _NO_JOB or ax.buffer_count > 0):
        state |= _HAS_JOB
    if ax.buffer_count > 0:
        state |= _BUFFERED
    if ax.homed:
        state |= _HOMED
    if ax.in_position_range:
        state |= _IN_POSITION
    if ax.in_target_position:
        state |= _IN_TARGET
    if ax.delayed_error_code != 0:
        state |= _ERROR_DELAYED
    if ax.has_been_stopped:
        state |= _STOPPED
    if ax.got_new_target:
        state |= _NEW_TARGET
    if ax.encoder_soft_limit_min_enable and ax.actual_position < ax.encoder_soft_limit_min:
        state |= _BELOW_MIN
    if ax.encoder_soft_limit_max_enable and ax.actual_position > ax.encoder_soft_limit_max:
        state |= _ABOVE_MAX
    if ax.homing_state != 0:
        state |= _HOMING_BUSY
    if ax.compensating:
        state |= _COMPENSATING
    if ax.external_setpoint_active:
        state |= _EXTERNAL_ENABLED
    if ax.phasing_active:
        state |= _PHASING
    if ax.encoder_latch_valid:
        state |= _LATCH_VALID
    if ax.io_invalid:
        state |= _IO_INVALID
    if ax.drive_status & STATUS_ERROR:
        state |= _DRIVE_ERROR
    if ax.drive_limit_active:
        state |= _LIMIT_ACTIVE
    if ax.motion_locked:
        state |= _LOCKED
    ax.state_dword = state
    ax.operation_mode_feedback = ax.operation_mode
    ax.motion_state = motion
    ax.set_direction = direction
    period = ax.encoder_modulo_factor
    ax.set_position_modulo = modulo_part(ax.set_position, period)
    ax.set_modulo_turns = floor((ax.set_position - ax.set_position_modulo) / period + 0.5)


def settle(ax: AxisFields) -> None:
    """Let the axis rest when a whole row of cycles changed nothing."""
    if (
        ax.set_motion_phase == _NO_JOB
        and ax.drive_output == 0.0
        and ax.actual_acceleration == 0.0
        and ax.actual_velocity == 0.0
        and ax.actual_position == ax.encoder_actual_position_unfiltered
        and ax.buffer_count == 0
        and ax.phasing_active == 0
        and ax.job_timing == 0
        and ax.delayed_error_code == 0
        and ax.following_error_time == 0.0
        and ax.following_error_velocity_time == 0.0
        and (ax.in_target_position == 1 or ax.target_window_time == 0.0)
        and ax.drive_actual_torque_derivative == 0.0
        and ax.drive_io_time == 0.0
        and ax.controller_special == 0
    ):
        ax.quiet_cycles += 1
        if ax.quiet_cycles >= _QUIET + ax.drive_delay + ax.filter_count:
            ax.resting = 1
    else:
        ax.quiet_cycles = 0
