"""Monitoring: enables, limits, windows and times become errors and the status double word.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.codes import NcError
from achse.codes.axis import ControlBit, HomingState, MotionState, OperationModeBit, StateBit
from achse.codes.nc.choices import EncoderType, MotionPhase, SignalType
from achse.motion.features import Feature
from achse.motion.generators.table import (
    CONTINUOUS,
    TRAVELLING,
    UNPLANNED,
    along_the_set_point,
    heading,
)
from achse.motion.port import (
    STATUS_ABSENT,
    STATUS_ERROR,
    STATUS_FAST_STOP,
    STATUS_READY,
)
from achse.motion.record import AxisFields
from achse.motion.setpoints.limits import TOLERANCE, goes_alone, running_into
from achse.motion.setpoints.setpoint import arrived, drop_job, fail, stop_fast
from achse.motion.states import CAM_COUPLINGS

_UNITS_MODULO = 4

_SIGNALS = Feature.FAST_STOP.value | Feature.IO_INVALID.value

_IO_CYCLES = 8.5
"""Cycles without valid I/O data, and a half, that a closed loop bears, and an enabled axis whose
drive the bus has not found. One whose bus starts waits."""


_ENABLES = (
    ControlBit.ENABLE.value | ControlBit.FEED_ENABLE_PLUS.value | ControlBit.FEED_ENABLE_MINUS.value
)
_FEED = ControlBit.FEED_ENABLE_PLUS.value | ControlBit.FEED_ENABLE_MINUS.value

_CLOSED = StateBit.PTP_MODE.value | StateBit.CONTROL_LOOP_CLOSED.value | StateBit.OPERATIONAL.value
_NOT_OPERATIONAL = ~StateBit.OPERATIONAL.value
"""Bits of StateDWord without and with an error, before any other."""

_MOVING = ~StateBit.NOT_MOVING.value

_FOLLOWING = StateBit.PROTECTED.value - StateBit.PTP_MODE.value
"""Bits of StateDWord that a slave adds and removes."""

_QUIET = 32
"""Cycles without a change, beyond those on their way to the drive, until the axis rests."""


def report(ax: AxisFields, code: int, cut: int) -> None:
    """React to a supervision's `code` now, or after the configured delay."""
    if ax.error_reaction_mode == 1 and ax.error_reaction_delay > 0.0 and ax.error_code == 0:
        if ax.delayed_error.code == 0:
            ax.delayed_error.code = code
            ax.features |= Feature.DELAYED_ERROR
            ax.delayed_error.cut = cut
            ax.delayed_error.time = 0.0
        return
    fail(ax, code, cut)


def _watch_signals(ax: AxisFields, dt: float) -> None:
    """Supervise the fast-stop signal of the drive and the validity of the I/O data."""
    drive = ax.drive
    kind = ax.fast_axis_stop_signal_type
    if kind != 0:
        signal = 1 if drive.io.state4 & STATUS_FAST_STOP else 0
        rising = signal == 1 and drive.signal_before == 0
        falling = signal == 0 and drive.signal_before == 1
        drive.signal_before = signal
        if (
            (kind in (SignalType.RISING_EDGE, SignalType.BOTH_EDGES) and rising)
            or (kind in (SignalType.FALLING_EDGE, SignalType.BOTH_EDGES) and falling)
            or (kind == SignalType.HIGH and signal == 1)
            or (kind == SignalType.LOW and signal == 0)
        ) and ax.set_motion_phase != MotionPhase.NONE:
            stop_fast(ax)
    if ax.io_invalid:
        drive.io_time += dt
        in_vain = (
            ax.control_dword & ControlBit.ENABLE
            and drive.io.state4 & STATUS_ABSENT
            and ax.error_code == 0
        )
        if (ax.loop_closed or in_vain) and drive.io_time > _IO_CYCLES * dt:
            fail(ax, NcError.DRIVE_IO_INVALID, 1)
    else:
        drive.io_time = 0.0
        ax.features &= ~Feature.IO_INVALID


def stays_closed(ax: AxisFields) -> bool:
    """Return True if enables and drive are as they are in a move, so that the closed loop stays
    closed.

    A limit switch is a feature: `read_drive` sets its bit.
    """
    return (
        ax.features == 0
        and ax.control_dword & _ENABLES == _ENABLES
        and ax.drive_status & STATUS_READY != 0
        and ax.loop_closed == 1
    )


def _supervise_rare(ax: AxisFields, dt: float) -> None:
    """Watch signals and errors from outside; clear the bits of errors and switches that are off."""
    if ax.features & _SIGNALS:
        _watch_signals(ax, dt)
    if ax.features & Feature.EXTERNAL_ERROR:
        if ax.external_error != 0:
            fail(ax, ax.external_error, 0)
            ax.external_error = 0
        ax.features &= ~Feature.EXTERNAL_ERROR
    if ax.features & Feature.ERROR and ax.error_code == 0 and ax.output_cut == 0:
        ax.features &= ~Feature.ERROR
    if ax.features & Feature.DISABLED and not ax.axis_disabled and not ax.drive_output_disabled:
        ax.features &= ~Feature.DISABLED


def supervise_enable(ax: AxisFields, dt: float) -> None:
    """Close and open the control loop; while it is open the set point follows the axis.

    Without its enable a moving axis brakes under control and only then opens the loop.
    """
    if ax.features:
        _supervise_rare(ax, dt)
    enables = ax.control_dword
    phase = ax.set_motion_phase
    status = ax.drive_status
    ready = status & STATUS_READY != 0
    if ax.limit_switch and enables & ControlBit.ACCEPT_BLOCKED_DRIVE:
        ready = status & STATUS_ERROR == 0
    closed = ax.loop_closed
    if (
        enables & ControlBit.ENABLE
        and ready
        and not ax.axis_disabled
        and not ax.drive_output_disabled
    ):
        if not ax.error_code:
            closed = 1
            if phase and enables & _FEED != _FEED:
                direction = heading(ax)
                if direction > 0.0 and enables & ControlBit.FEED_ENABLE_PLUS == 0:
                    fail(ax, NcError.FEED_ENABLE_PLUS_WITHDRAWN, 0)
                elif direction < 0.0 and enables & ControlBit.FEED_ENABLE_MINUS == 0:
                    fail(ax, NcError.FEED_ENABLE_MINUS_WITHDRAWN, 0)
    else:
        if (
            phase != MotionPhase.NONE
            and ax.error_code == 0
            and (phase != MotionPhase.COUPLED or ax.set.velocity != 0.0)
        ):
            if ready:
                fail(ax, NcError.CONTROLLER_ENABLE_MISSING, 0)
            else:
                fail(ax, NcError.DRIVE_NOT_READY, 1)
        if ax.set_motion_phase != MotionPhase.STOPPING or not ready:
            closed = 0
    if ax.output_cut:
        closed = 0
    if closed and ax.loop_closed:
        return
    encoder = ax.encoder
    ax.set.position = encoder.actual_position
    if closed == 0:
        drop_job(ax)
    else:
        if phase == MotionPhase.NONE:
            ax.target_position = encoder.actual_position
        ax.monitoring.motion_position = encoder.actual_position
        ax.monitoring.following_error_time = 0.0
        ax.monitoring.following_error_velocity_time = 0.0
    ax.loop_closed = closed


def _supervise_following_error(ax: AxisFields, dt: float) -> None:
    """Cut the output at following errors above their window for longer than the filter time."""
    controller = ax.controller
    if controller.following_error_position_monitoring_enable:
        if abs(controller.following_error) > controller.following_error_position_max:
            ax.monitoring.following_error_time += dt
            if ax.monitoring.following_error_time > controller.following_error_position_filter_time:
                report(ax, NcError.FOLLOWING_ERROR_POSITION, 1)
        else:
            ax.monitoring.following_error_time = 0.0
    if controller.following_error_velocity_monitoring_enable:
        if abs(controller.following_error_velocity) > controller.following_error_velocity_max:
            ax.monitoring.following_error_velocity_time += dt
            if (
                ax.monitoring.following_error_velocity_time
                > controller.following_error_velocity_filter_time
            ):
                report(ax, NcError.FOLLOWING_ERROR_VELOCITY, 1)
        else:
            ax.monitoring.following_error_velocity_time = 0.0


def _limit_error(ax: AxisFields, code: int) -> int:
    """Return the error of a homing that comes to a soft limit, else `code`."""
    if ax.set_motion_phase != MotionPhase.HOMING:
        return code
    if ax.homing.state == HomingState.AWAIT_CAM:
        return NcError.HOMING_CAM_NOT_FOUND
    if ax.homing.state == HomingState.AWAIT_CAM_OFF:
        return NcError.HOMING_CAM_STAYS
    return (
        NcError.HOMING_SYNC_PULSE_NOT_FOUND if ax.homing.state == HomingState.AWAIT_LATCH else code
    )


def _at_limit(ax: AxisFields) -> int:
    """Return the soft limit that the axis has come to: 1 upper, -1 lower, 0 none.

    A table knows beforehand that it ends at one or has to pass it.
    """
    where = ax.limits.reached
    ax.limits.reached = 0
    if where != 0:
        return where
    direction = along_the_set_point(ax)
    if direction > 0.0 and ax.set.position > ax.limits.high + TOLERANCE:
        return 1
    if direction < 0.0 and ax.set.position < ax.limits.low - TOLERANCE:
        return -1
    return 0


def _supervise_limits(ax: AxisFields, dt: float) -> None:
    """End every motion at a soft limit. A delayed reaction waits only if the axis rests by then."""
    where = _at_limit(ax)
    if ax.compensating or not goes_alone(ax) or UNPLANNED[ax.set_motion_phase]:
        ahead = running_into(ax, ax.set.velocity, dt)
        if ahead != 0:
            where = ahead
    if where == 0:
        return
    code = _limit_error(
        ax, NcError.SOFT_LIMIT_MAX_PASSED if where > 0 else NcError.SOFT_LIMIT_MIN_PASSED
    )
    if ax.set.velocity == 0.0:
        report(ax, code, 0)
    else:
        fail(ax, code, 0)


def _count_delay(ax: AxisFields, dt: float) -> None:
    """React to a delayed error once its time is over."""
    if ax.delayed_error.code == 0:
        ax.features &= ~Feature.DELAYED_ERROR
        return
    ax.delayed_error.time += dt
    if ax.delayed_error.time >= ax.error_reaction_delay:
        fail(ax, ax.delayed_error.code, ax.delayed_error.cut)


def supervise_motion(ax: AxisFields, dt: float, fast: bool = False) -> None:
    """Supervise a closed loop: following error, soft limits, missing movement.

    The fast path skips soft limits and errors with a delayed reaction: both are off there.
    """
    if not fast and ax.features & Feature.DELAYED_ERROR:
        _count_delay(ax, dt)
    if not ax.loop_closed:
        return
    encoder = ax.encoder
    _supervise_following_error(ax, dt)
    if not fast and ax.limits.active and ax.set_motion_phase != MotionPhase.NONE:
        _supervise_limits(ax, dt)
    if ax.set.velocity == 0.0:
        ax.monitoring.motion_time = 0.0
        ax.monitoring.motion_position = encoder.actual_position
    elif ax.motion_monitoring_enable:
        if (
            abs(encoder.actual_position - ax.monitoring.motion_position)
            > ax.motion_monitoring_window
        ):
            ax.monitoring.motion_position = encoder.actual_position
            ax.monitoring.motion_time = 0.0
        else:
            ax.monitoring.motion_time += dt
            if ax.monitoring.motion_time > ax.motion_monitoring_time:
                report(ax, NcError.NO_MOVEMENT_SEEN, 1)


def _travelling(ax: AxisFields, fast: bool) -> bool:
    """Return True if no target is awaited: the axis only passes through a window."""
    phase = ax.set_motion_phase
    return (
        TRAVELLING[phase] == 1
        or (phase == MotionPhase.COUPLED and ax.set.velocity != 0.0)
        or (not fast and phase == MotionPhase.HOMING and ax.set.velocity != 0.0)
        or ax.loop.outward == 1
    )


def watch_standstill(ax: AxisFields, dt: float) -> None:
    """Detect the standstill of an encoder axis; rest counts after its time."""
    if abs(ax.encoder.actual_velocity) > ax.no_motion_window:
        ax.monitoring.encoder_moves = 1
        ax.monitoring.standstill_time = 0.0
    elif ax.monitoring.encoder_moves:
        ax.monitoring.standstill_time += dt
        if ax.monitoring.standstill_time > ax.no_motion_time:
            ax.monitoring.encoder_moves = 0


def supervise_arrival(ax: AxisFields, dt: float, fast: bool = False) -> None:
    """Position and target window, positioning time, PEH time."""
    job = ax.job
    way = abs(ax.target_position - ax.encoder.actual_position)
    ax.in_position_range = 0
    if (
        ax.position_range_monitoring_enable
        and way <= ax.position_range_window
        and not _travelling(ax, fast)
    ):
        ax.in_position_range = 1
    if (
        ax.target_position_monitoring_enable
        and way <= ax.target_position_window
        and not _travelling(ax, fast)
    ):
        if ax.in_target_position == 0:
            if ax.monitoring.target_window_time >= ax.target_position_monitoring_time:
                ax.in_target_position = 1
            ax.monitoring.target_window_time += dt
    else:
        ax.in_target_position = 0
        ax.monitoring.target_window_time = 0.0
    if job.timing:
        job.time += dt
        if ax.set_motion_phase == MotionPhase.NONE:
            if arrived(ax):
                ax.last_positioning_time = job.time
                job.timing = 0
            elif ax.peh_monitoring_enable and ax.target_position_monitoring_enable:
                ax.monitoring.peh_time += dt
                if ax.monitoring.peh_time > ax.peh_monitoring_time:
                    job.timing = 0
                    report(ax, NcError.PEH_TIME_OVER, 0)
        else:
            ax.monitoring.peh_time = 0.0


def operation_mode(ax: AxisFields) -> int:
    """OpModeDWord: the monitoring that is switched on."""
    encoder = ax.encoder
    mode = 0
    if encoder.type == EncoderType.SIMULATION:
        mode |= OperationModeBit.SIMULATION
    if ax.drive.output_filter_type:
        mode |= OperationModeBit.OUTPUT_FILTER
    if ax.loop_enable:
        mode |= OperationModeBit.LOOP
    if ax.backlash_compensation_enable:
        mode |= OperationModeBit.BACKLASH_COMPENSATION
    if encoder.actual_position_correction_enable:
        mode |= OperationModeBit.POSITION_CORRECTION
    if ax.application.request:
        mode |= OperationModeBit.APPLICATION_REQUEST
    if ax.allow_slave_motion_commands:
        mode |= OperationModeBit.ALLOW_SLAVE_COMMANDS
    if ax.allow_motion_commands_with_external_setpoint:
        mode |= OperationModeBit.ALLOW_COMMANDS_WITH_EXTERNAL_SETPOINT
    if ax.position_range_monitoring_enable:
        mode |= OperationModeBit.POSITION_AREA_MONITORING
    if ax.target_position_monitoring_enable:
        mode |= OperationModeBit.TARGET_POSITION_MONITORING
    if ax.motion_monitoring_enable:
        mode |= OperationModeBit.MOTION_MONITORING
    if ax.peh_monitoring_enable:
        mode |= OperationModeBit.PEH_TIME_MONITORING
    if ax.error_reaction_mode == 1:
        mode |= OperationModeBit.DELAYED_ERROR_REACTION
    if ax.unit_interpretation & _UNITS_MODULO:
        mode |= OperationModeBit.MODULO
    if ax.controller.following_error_position_monitoring_enable:
        mode |= OperationModeBit.POSITION_LAG_MONITORING
    if ax.controller.following_error_velocity_monitoring_enable:
        mode |= OperationModeBit.VELOCITY_LAG_MONITORING
    if encoder.soft_limit_min_enable:
        mode |= OperationModeBit.SOFT_LIMIT_MIN_MONITORING
    if encoder.soft_limit_max_enable:
        mode |= OperationModeBit.SOFT_LIMIT_MAX_MONITORING
    return mode


def _rare_state(ax: AxisFields) -> int:
    """Bits of the status double word that most axes do not have most of the time."""
    encoder = ax.encoder
    state = 0
    if ax.delayed_error.code != 0:
        state |= StateBit.ERROR_PROPAGATION_DELAYED
    if ax.has_been_stopped:
        state |= StateBit.HAS_BEEN_STOPPED
    if ax.got_new_target:
        state |= StateBit.NEW_TARGET_POSITION
    if encoder.soft_limit_min_enable and encoder.actual_position < encoder.soft_limit_min:
        state |= StateBit.SOFT_LIMIT_MIN_EXCEEDED
    if encoder.soft_limit_max_enable and encoder.actual_position > encoder.soft_limit_max:
        state |= StateBit.SOFT_LIMIT_MAX_EXCEEDED
    if ax.homing.state != 0:
        state |= StateBit.HOMING_BUSY
    if ax.compensating:
        state |= StateBit.COMPENSATING
    if ax.external_setpoint_active:
        state |= StateBit.EXTERNAL_SETPOINT_ENABLED
    if ax.phasing.active:
        state |= StateBit.PHASING_ACTIVE
    if encoder.latch_valid:
        state |= StateBit.EXTERNAL_LATCH_VALID
    if ax.io_invalid:
        state |= StateBit.IO_DATA_INVALID
    if ax.drive.limit_active:
        state |= StateBit.DRIVE_LIMIT_ACTIVE
    if ax.motion_locked:
        state |= StateBit.MOTION_COMMANDS_LOCKED
    if not ax.has_been_stopped and not ax.got_new_target and not ax.motion_locked:
        ax.features &= ~Feature.STATUS
    return state


def show_state(ax: AxisFields, fast: bool = False) -> None:
    """Show the status double word and the motion state; on the fast path without rare bits."""
    encoder = ax.encoder
    phase = ax.set_motion_phase
    v = ax.set.velocity
    if phase == MotionPhase.COUPLED and v == 0.0:
        phase = MotionPhase.NONE  # shows as an axis at rest
    motion: int = MotionState.INACTIVE
    state: int = _CLOSED if ax.loop_closed else StateBit.PTP_MODE
    waiting = ax.buffer.count
    if not fast and ax.error_code:
        state = state & _NOT_OPERATIONAL | StateBit.ERROR
    elif phase or waiting:
        state |= StateBit.HAS_JOB
    if waiting:
        state |= StateBit.COMMAND_BUFFERED
    if not phase:
        state |= StateBit.NOT_MOVING
    else:
        motion = MotionState.RUNNING
        a = ax.set.acceleration
        facing = v if v != 0.0 else along_the_set_point(ax)
        if facing == 0.0 and not ax.profile.override and phase != MotionPhase.STOPPING:
            # At override 0 an axis moves logically (004 §4.1.1).
            facing = ax.job.direction
            if phase == MotionPhase.POSITIONING:
                facing = ax.border.position - ax.set.position
        if facing > 0.0:
            state |= StateBit.POSITIVE_DIRECTION
        elif facing < 0.0:
            state |= StateBit.NEGATIVE_DIRECTION
            a = -a
        if CONTINUOUS[phase]:
            state |= StateBit.CONTINUOUS_MOTION
        if v != 0.0:
            if ax.set.jerk == 0.0 and abs(a) <= 1e-9 * ax.job.acceleration:
                motion = MotionState.CONSTANT_VELOCITY
                state |= StateBit.CONSTANT_VELOCITY
            elif a > 0.0:
                motion = MotionState.ACCELERATING
            else:
                motion = MotionState.DECELERATING
        elif not ax.profile.override and phase != MotionPhase.STOPPING:
            motion = MotionState.OVERRIDE_ZERO
    state |= encoder.homed * StateBit.HOMED
    state |= ax.in_position_range * StateBit.IN_POSITION_AREA
    state |= ax.in_target_position * StateBit.IN_TARGET_POSITION
    if ax.drive_status & STATUS_ERROR:
        state |= StateBit.DRIVE_DEVICE_ERROR
    if ax.coupling.law:
        state += _FOLLOWING
        if ax.coupling.law in CAM_COUPLINGS:
            state |= ax.camming.status
        if ax.sync.state:
            motion = ax.sync.state
    if not fast:
        if ax.grouped:
            state -= StateBit.PTP_MODE
        else:
            ax.features &= ~Feature.GROUPED
        if ax.external_setpoint_active and phase:
            motion = (
                MotionState.EXTERNAL
                if phase == MotionPhase.EXTERNAL
                else MotionState.INTERNAL_AND_EXTERNAL
            )
        if ax.monitoring.encoder_moves:
            state &= _MOVING
        state |= _rare_state(ax)
    ax.state_dword = state
    ax.operation_mode_feedback = ax.operation_mode
    ax.motion_state = motion


def settle(ax: AxisFields) -> None:
    """Let an axis without a job rest when a whole row of cycles changed nothing."""
    encoder = ax.encoder
    drive = ax.drive
    if (
        drive.output == 0.0
        and encoder.actual_acceleration == 0.0
        and encoder.actual_velocity == 0.0
        and encoder.actual_position == encoder.actual_position_unfiltered
        and ax.buffer.count == 0
        and ax.phasing.active == 0
        and ax.monitoring.encoder_moves == 0
        and ax.job.timing == 0
        and ax.delayed_error.code == 0
        and ax.monitoring.following_error_time == 0.0
        and ax.monitoring.following_error_velocity_time == 0.0
        and (ax.in_target_position == 1 or ax.monitoring.target_window_time == 0.0)
        and drive.actual_torque_derivative == 0.0
        and drive.io_time == 0.0
        and ax.controller.special == 0
    ):
        ax.quiet_cycles += 1
        if ax.quiet_cycles >= _QUIET + drive.delay + drive.filter_count:
            ax.resting = 1
    else:
        ax.quiet_cycles = 0
