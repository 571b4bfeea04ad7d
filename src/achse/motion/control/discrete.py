"""Discrete drives: two-speed (rapid/creep) axes with brake, and stepper motors.

A two-speed axis has no set-point profile. It runs at rapid or creep speed until the actual position
is near the target, then switches off and brakes; the set position is where the axis is (004 §6.1,
§6.2). A stepper motor moves by whole steps, whose masks or frequency go out as control bytes.

Kernel source: compiled as it stands, see `compiled`.
"""

from math import ceil

from achse.codes.axis import CommandState
from achse.codes.nc.choices import MotionPhase, StepperMode
from achse.motion.record import AxisFields
from achse.motion.setpoints.setpoint import begin_next_job, pass_switch_position
from achse.motion.setpoints.targets import overrun

_BRAKED = 0
_RELEASING = 1
_RAPID = 2
_SWITCHING = 3
_CREEP = 4
_APPROACH = 5
_RUNNING_OUT = 6
"""Phases of a two-speed movement (`switch_phase`)."""

_RAPID_ABOVE = 50.0
"""Start velocity, and override and output in percent, above which an axis runs at rapid speed."""

_CREEP_SHARE = 0.1
"""Creep velocity that the NC shows, of the rapid one; it does not know that of the motor."""

_SLOWEST_OVERRIDE = 100
"""0.01 %; an override below is standstill."""


_MINUS_HIGH = 1 << 0
_MINUS_LOW = 1 << 1
_PLUS_LOW = 1 << 2
_PLUS_HIGH = 1 << 3
_BRAKE_OPEN = 1 << 6
_BRAKE = 1 << 7

_MINUS = 1 << 0
_PLUS = 1 << 1
_LOW = 1 << 2
_HIGH = 1 << 3

_FREQUENCY = 1 << 0
_FORWARD = 1 << 1

_LONGEST_WAIT = 1_000_000_000
"""Cycles from one step of a stepper motor to the next, at most: at next to no output."""


def _enter(ax: AxisFields, phase: int) -> None:
    ax.drive.switch_phase = phase
    ax.drive.switch_time = 0.0


def _direction(ax: AxisFields) -> float:
    """Return the direction of the job from here."""
    if ax.set_motion_phase in (MotionPhase.ENDLESS, MotionPhase.HOMING) and ax.job.direction != 0.0:
        return ax.job.direction
    if ax.set_motion_phase == MotionPhase.POSITIONING:
        return 1.0 if ax.border.position >= ax.encoder.actual_position else -1.0
    return ax.drive.switch_direction


def _stopping(ax: AxisFields) -> bool:
    """Return True if the axis is to come to rest, for good or as a step of homing."""
    phase = ax.set_motion_phase
    return phase == MotionPhase.STOPPING or (
        phase == MotionPhase.HOMING and ax.job.direction == 0.0
    )


def _main_speed(ax: AxisFields) -> int:
    """Phase of the main travel: rapid, creep, or braked at override zero."""
    if ax.velocity_override < _SLOWEST_OVERRIDE:
        return _BRAKED
    if ax.job.velocity > _RAPID_ABOVE and ax.velocity_override > _RAPID_ABOVE * 1e4:
        return _RAPID
    return _CREEP


def _way(ax: AxisFields) -> float:
    """Way to the target, or past it if negative."""
    return (ax.border.position - ax.encoder.actual_position) * ax.drive.switch_direction


def _braking_way(ax: AxisFields) -> float:
    return (
        ax.brake_distance_positive
        if ax.drive.switch_direction > 0.0
        else ax.brake_distance_negative
    )


def _finish(ax: AxisFields) -> None:
    """End the job, or a part of it, at any position: the brake is on.

    A job that began while the axis ran out from the one before is still to come.
    """
    _enter(ax, _BRAKED)
    phase = ax.set_motion_phase
    if phase == MotionPhase.ENDLESS or (
        phase == MotionPhase.POSITIONING and _way(ax) > _braking_way(ax)
    ):
        return
    if ax.loop.outward:
        ax.loop.outward = 0
        ax.profile.replan = 1
        return
    if phase != MotionPhase.POSITIONING:
        ax.target_position = ax.encoder.actual_position
    if phase == MotionPhase.HOMING:
        return
    if ax.set_command_state == CommandState.ACTIVE:
        ax.set_command_state = CommandState.DONE
    ax.set_motion_phase = MotionPhase.NONE
    ax.switch.armed = 0
    ax.remaining_distance = 0.0


def _choose(ax: AxisFields, dt: float) -> None:
    """Choose the phase of this cycle by position, times, override and job."""
    drive = ax.drive
    phase = drive.switch_phase
    drive.switch_time += dt
    if _stopping(ax):
        if phase in (_BRAKED, _RELEASING):
            _finish(ax)
        elif phase != _RUNNING_OUT:
            if phase != _CREEP:
                _enter(ax, _CREEP)
            if abs(ax.encoder.actual_position - drive.switch_start) >= ax.creep_distance_stop:
                _enter(ax, _RUNNING_OUT)
    elif phase in (_BRAKED, _RELEASING):
        main = _main_speed(ax)
        if main == _BRAKED:
            _enter(ax, _BRAKED)
        elif phase == _BRAKED:
            drive.switch_direction = _direction(ax)
            _enter(ax, _RELEASING)
        if drive.switch_phase == _RELEASING and drive.switch_time >= ax.brake_release_delay:
            _enter(ax, main)
    elif phase != _RUNNING_OUT:
        if ax.set_motion_phase == MotionPhase.POSITIONING:
            way = _way(ax)
            plus = drive.switch_direction > 0.0
            creep = ax.creep_distance_positive if plus else ax.creep_distance_negative
            if way <= _braking_way(ax):
                _enter(ax, _RUNNING_OUT)
                return
            if way <= creep:
                if phase == _RAPID:
                    _enter(ax, _SWITCHING)
                    phase = _SWITCHING
                if phase == _CREEP or (
                    phase == _SWITCHING and drive.switch_time >= ax.rapid_to_creep_switch_time
                ):
                    _enter(ax, _APPROACH)
                return
        main = _main_speed(ax)
        if main != phase:
            _enter(ax, main)
    if drive.switch_phase == _RUNNING_OUT:
        plus = drive.switch_direction > 0.0
        delay = ax.brake_delay_positive if plus else ax.brake_delay_negative
        if drive.switch_time >= delay:
            _finish(ax)


def _obey(ax: AxisFields) -> None:
    """Enter the phase that a direct output commands, without the times of brake and switching."""
    drive = ax.drive
    output = ax.direct_output
    phase = _BRAKED
    if output != 0.0:
        drive.switch_direction = 1.0 if output > 0.0 else -1.0
        phase = _RAPID if abs(output) > 0.01 * _RAPID_ABOVE * drive.full else _CREEP
    if phase != drive.switch_phase:
        _enter(ax, phase)


def _put_out(ax: AxisFields) -> float:
    """Set the control bytes of the phase; return the velocity that they command."""
    drive = ax.drive
    phase = drive.switch_phase
    plus = drive.switch_direction > 0.0
    if drive.motor_polarity:
        plus = not plus
    control = _BRAKE if phase == _BRAKED and ax.brake_released == 0 else _BRAKE_OPEN
    further = control
    velocity = 0.0
    if phase == _RAPID:
        control |= _PLUS_HIGH if plus else _MINUS_HIGH
        further |= _HIGH
        velocity = drive.full
    elif phase in (_CREEP, _APPROACH):
        control |= _PLUS_LOW if plus else _MINUS_LOW
        further |= _LOW
        velocity = drive.full * _CREEP_SHARE
    if velocity > 0.0:
        further |= _PLUS if plus else _MINUS
    drive.control_byte = control
    drive.extended_control_byte = further
    return velocity if drive.switch_direction > 0.0 else -velocity


def run_two_speeds(ax: AxisFields, dt: float) -> None:
    """Set point and output of a two-speed axis."""
    encoder = ax.encoder
    drive = ax.drive
    if ax.loop_closed == 0:
        _enter(ax, _BRAKED)
    else:
        if ax.buffer.count > 0 and (
            ax.set_motion_phase == MotionPhase.NONE
            or (
                ax.set_motion_phase == MotionPhase.ENDLESS
                and drive.switch_phase in (_RAPID, _CREEP)
            )
        ):
            begin_next_job(ax)
        if ax.profile.replan:
            ax.profile.replan = 0
            drive.switch_start = encoder.actual_position
            ax.border.position = ax.target_position
            if ax.set_motion_phase == MotionPhase.POSITIONING:
                overrun(ax)
            if (
                not _stopping(ax)
                and drive.switch_phase != _BRAKED
                and _direction(ax) != drive.switch_direction
            ):
                _enter(ax, _BRAKED)
        if ax.set_motion_phase == MotionPhase.DRIVE_OUTPUT:
            _obey(ax)
        elif ax.set_motion_phase != MotionPhase.NONE:
            _choose(ax, dt)
        else:  # a reset may have taken the job away
            _enter(ax, _BRAKED)
        if ax.switch.armed:
            pass_switch_position(ax)
    ax.profile.override = ax.velocity_override
    velocity = _put_out(ax)
    ax.set.position = encoder.actual_position
    ax.set.velocity = velocity
    ax.controller.following_error = 0.0
    ax.controller.following_error_velocity = 0.0
    drive.output = velocity
    if ax.set_motion_phase == MotionPhase.POSITIONING:
        ax.remaining_distance = abs(ax.border.position - encoder.actual_position)
        if ax.loop.outward:
            ax.remaining_distance += abs(ax.loop_distance)
    elif velocity != 0.0:
        ax.target_position = encoder.actual_position


def show_speed(ax: AxisFields) -> None:
    """Show AxisState of a two-speed axis: 1 moving, 2 switching to creep, 3 creeping near, 4
    braking."""
    phase = ax.drive.switch_phase
    state = 0
    if ax.set_motion_phase != MotionPhase.NONE:
        state = 1
        if phase == _SWITCHING:
            state = 2
        elif phase == _APPROACH:
            state = 3
        elif phase == _RUNNING_OUT:
            state = 4
    ax.motion_state = state


def _mask(ax: AxisFields) -> int:
    """Control byte of the present step."""
    drive = ax.drive
    count = 4 if ax.stepper_operation_mode == StepperMode.TWO_PHASE else 6
    cycle = drive.stepper_step % count
    if cycle == 0:
        return drive.stepper_mask_cycle1
    if cycle == 1:
        return drive.stepper_mask_cycle2
    if cycle == 2:
        return drive.stepper_mask_cycle3
    if cycle == 3:
        return drive.stepper_mask_cycle4
    if cycle == 4:
        return drive.stepper_mask_cycle5
    return drive.stepper_mask_cycle6


def run_stepper(ax: AxisFields, dt: float) -> None:
    """Turn a stepper motor by at most one step, at the frequency of its output.

    The frequency is that of one step in a whole number of cycles, never faster than the output,
    never slower than the minimum velocity; it stays for the configured number of steps. Less than
    half of that is standstill, unless the position controller misses a step.
    """
    drive = ax.drive
    output = drive.output
    speed = abs(output)
    slowest = ax.stepper_min_velocity
    missing = ax.controller.output != 0.0 and (
        abs(ax.controller.following_error) > 0.5 * ax.stepper_step_scaling
    )
    if (speed <= 0.5 * slowest and not missing) or speed == 0.0:
        drive.stepper_wait = 0
        drive.stepper_level = 0
    else:
        if speed < slowest:
            speed = slowest
        way = speed * dt
        level = _LONGEST_WAIT
        if way * _LONGEST_WAIT > ax.stepper_step_scaling:
            level = ceil(ax.stepper_step_scaling / way - 1e-9)
        if level < 1:
            level = 1
        if drive.stepper_level == 0:
            drive.stepper_level = level
            drive.stepper_level_steps = 0
            drive.stepper_wait = level
        elif (
            level != drive.stepper_level
            and drive.stepper_level_steps >= ax.stepper_steps_per_velocity_level
        ):
            drive.stepper_level = level
            drive.stepper_level_steps = 0
            if drive.stepper_wait > level:
                drive.stepper_wait = level
        drive.stepper_wait -= 1
        direction = 1 if output > 0.0 else -1
        if drive.stepper_wait <= 0:
            drive.stepper_wait = drive.stepper_level
            drive.stepper_level_steps += 1
            drive.stepper_step += -direction if drive.motor_polarity else direction
    if ax.stepper_operation_mode in (StepperMode.TWO_PHASE, StepperMode.ONE_TWO_PHASE):
        control = _mask(ax)
        if drive.stepper_level == 0:
            control |= drive.stepper_mask_holding_current
        drive.control_byte = control
        drive.extended_control_byte = 0
    else:
        drive.control_byte = 0
        further = _FREQUENCY if drive.stepper_step % 2 else 0
        if (output > 0.0) != (drive.motor_polarity != 0):
            further |= _FORWARD
        drive.extended_control_byte = further
