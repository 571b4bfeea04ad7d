"""Set-point generation: jobs become tables of constant-jerk segments, cycles walk along them.

A job is one command at work (`job`), further ones wait in the ring `waiting`. A function that
changes the job sets `replan`; the next cycle plans the table again. A job whose border is passed at
speed hands over to the next command, or goes on at its segment end velocity.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.codes import NcError
from achse.codes.axis import CommandState, StartType
from achse.codes.nc.choices import MotionPhase
from achse.motion.features import Feature
from achse.motion.fields.drive import FILTER_ORDER
from achse.motion.fields.encoder import POSITION_HISTORY
from achse.motion.fields.setpoint import COMMAND_BUFFER
from achse.motion.profiles.segments import segment_acceleration
from achse.motion.record import AxisFields, EncoderFields
from achse.motion.setpoints.dynamics import (
    fastest,
    fault_deceleration,
    fault_jerk,
    shed_excess,
    shed_foreign,
)
from achse.motion.setpoints.jobs import copy_request
from achse.motion.setpoints.limits import goes_alone, table_passes
from achse.motion.setpoints.planning import (
    TO_CONSTANT_VELOCITY,
    TO_LIMIT,
    TO_PAUSE,
    TO_TARGET,
    follow_override,
    plan,
)
from achse.motion.setpoints.targets import resolve_target

_SWITCH_TARGET = 2


def end_homing(ax: AxisFields) -> None:
    """End homing, whatever its result."""
    if ax.set_motion_phase == MotionPhase.HOMING:
        ax.homing.state = 0
        ax.homing.latch = 0


def begin_job(ax: AxisFields) -> None:
    """Begin the motion of the job; the present motion blends into it."""
    job = ax.job
    start_type = job.start_type
    if ax.set_motion_phase != MotionPhase.NONE:
        ax.set_command_state = CommandState.ABORTED
    end_homing(ax)
    if start_type in (StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE):
        ax.set_motion_phase = MotionPhase.ENDLESS
        job.direction = 1.0 if start_type == StartType.ENDLESS_POSITIVE else -1.0
    elif start_type == StartType.HALT:
        ax.set_motion_phase = MotionPhase.STOPPING
    else:
        ax.set_motion_phase = MotionPhase.POSITIONING
        ax.target_position = resolve_target(ax, start_type, job.position, ax.set.position)
        job.direction = 1.0 if ax.target_position >= ax.set.position else -1.0
    ax.border.time = -1.0
    ax.loop.undecided = 1
    ax.loop.outward = 0
    job.peak_velocity = 0.0
    job.timing = 0 if start_type == StartType.HALT else 1
    job.time = 0.0
    ax.profile.replan = 1
    ax.switch.armed = 0
    ax.got_new_target = 0
    ax.has_been_stopped = 0
    if start_type == StartType.HALT:
        ax.has_been_stopped = 1
        ax.features |= Feature.STATUS
    ax.in_target_position = 0
    ax.monitoring.target_window_time = 0.0
    ax.monitoring.peh_time = 0.0
    ax.set_command_number = job.number
    ax.set_command_state = CommandState.ACTIVE


def absorb(ax: AxisFields) -> None:
    """Make the motion on top of the main motion part of the set point.

    Its velocity stays; its acceleration, which no jerk limits, does not.
    """
    if ax.compensating:
        ax.profile.abrupt = 1
    ax.compensating = 0
    if ax.superposed.set_velocity != 0.0 or ax.superposed.set_acceleration != 0.0:
        shed_foreign(ax, ax.superposed.set_acceleration)
    ax.superposed.set_velocity = 0.0
    ax.superposed.set_acceleration = 0.0


def begin_stop(ax: AxisFields, deceleration: float, jerk: float) -> None:
    """Drop the job and everything that waits; brake to rest."""
    ax.buffer.count = 0
    ax.switch.armed = 0
    ax.loop.outward = 0
    ax.border.time = -1.0
    ax.has_been_stopped = 1
    ax.features |= Feature.STATUS
    ax.job.timing = 0
    if ax.set_motion_phase == MotionPhase.NONE:
        return
    if ax.set_command_state == CommandState.ACTIVE:
        ax.set_command_state = CommandState.ABORTED
    absorb(ax)
    if ax.set_motion_phase == MotionPhase.GROUPED and shed_excess(ax, jerk):
        ax.profile.abrupt = 1
    end_homing(ax)
    ax.set_motion_phase = MotionPhase.STOPPING
    ax.job.deceleration = deceleration
    ax.job.jerk = jerk
    ax.profile.replan = 1


def drop_job(ax: AxisFields) -> None:
    """Be at rest here and now: no job, no velocity, nothing waiting."""
    absorb(ax)
    if ax.set_command_state == CommandState.ACTIVE:
        ax.set_command_state = CommandState.ABORTED
    end_homing(ax)
    ax.set_motion_phase = MotionPhase.NONE
    ax.buffer.count = 0
    ax.switch.armed = 0
    ax.loop.outward = 0
    ax.profile.replan = 0
    ax.border.time = -1.0
    ax.job.timing = 0
    ax.profile.count = 0
    ax.profile.index = 0
    ax.set.velocity = 0.0
    ax.set.acceleration = 0.0
    ax.set.jerk = 0.0
    ax.external.velocity = 0.0
    ax.external.acceleration = 0.0
    ax.limits.reached = 0
    ax.set_torque = 0.0
    ax.set_torque_derivative = 0.0
    ax.remaining_time = 0.0
    ax.remaining_distance = 0.0
    ax.target_position = ax.set.position


def fail(ax: AxisFields, code: int, cut: int) -> None:
    """Drop all commands at an axis error; open the control loop if `cut`, else brake.

    The first error stays. The ramp is the strongest one of the axis.
    """
    if ax.error_code == 0:
        ax.error_code = code
    ax.features |= Feature.ERROR
    ax.delayed_error.code = 0
    if cut:
        ax.output_cut = 1
        drop_job(ax)
    elif ax.set_motion_phase == MotionPhase.NONE:
        ax.buffer.count = 0
    else:
        stop_fast(ax)


def stop_fast(ax: AxisFields) -> None:
    """Brake with the strongest ramp of the axis, whatever it is doing; a stop that runs as well."""
    deceleration = fault_deceleration(ax)
    jerk = fault_jerk(ax)
    if (
        ax.set_motion_phase != MotionPhase.STOPPING
        or deceleration > ax.job.deceleration
        or jerk > ax.job.jerk
    ):
        begin_stop(ax, deceleration, jerk)


def arrived(ax: AxisFields) -> int:
    """Return 1 if the last positioning is done in the sense of the enabled monitoring, else 0."""
    if ax.target_position_monitoring_enable:
        return ax.in_target_position
    if ax.position_range_monitoring_enable:
        return ax.in_position_range
    return 1


def begin_next_job(ax: AxisFields) -> None:
    """Make the oldest waiting command the active one; it counts from the target before it."""
    start = (
        ax.target_position if ax.set_motion_phase == MotionPhase.POSITIONING else ax.set.position
    )
    i = ax.buffer.first
    ax.buffer.first = (i + 1) % COMMAND_BUFFER
    ax.buffer.count -= 1
    copy_request(ax.job, ax.waiting[i])
    begin_job(ax)
    if ax.set_motion_phase == MotionPhase.POSITIONING:
        ax.target_position = resolve_target(ax, ax.job.start_type, ax.job.position, start)
        ax.job.direction = 1.0 if ax.target_position >= start else -1.0


def pass_switch_position(ax: AxisFields) -> None:
    """Carry out the change that waits for the switch position, once the set point is past it."""
    if ax.switch.from_below:
        if ax.set.position < ax.switch.position:
            return
    elif ax.set.position > ax.switch.position:
        return
    if ax.switch.armed == _SWITCH_TARGET:
        ax.set_motion_phase = MotionPhase.POSITIONING
        ax.target_position = ax.switch.target
        ax.job.direction = 1.0 if ax.target_position >= ax.set.position else -1.0
        ax.job.end_velocity = 0.0
    ax.switch.armed = 0
    ax.job.velocity = ax.switch.velocity
    if ax.job.end_velocity > ax.job.velocity:
        ax.job.end_velocity = ax.job.velocity
    ax.job.peak_velocity = 0.0
    ax.got_new_target = 1
    ax.features |= Feature.STATUS
    ax.profile.replan = 1


def _pass_border(ax: AxisFields) -> None:
    """Go over to the next command, or on at the segment end velocity."""
    if ax.buffer.count > 0:
        begin_next_job(ax)
        return
    ax.set_motion_phase = MotionPhase.ENDLESS
    ax.job.velocity = ax.job.end_velocity
    ax.profile.replan = 1


def follow_segment(ax: AxisFields, dt: float) -> bool:
    """Go on along the active segment for a cycle; return False if the move needs more than that."""
    profile = ax.profile
    phase = ax.set_motion_phase
    t = profile.elapsed + dt
    if not (
        (phase == MotionPhase.POSITIONING or (phase != MotionPhase.NONE and ax.buffer.count == 0))
        and ax.velocity_override == profile.override
        and ax.limits.recheck | profile.replan | ax.switch.armed == 0
        and ax.border.time < 0.0
        and profile.index < profile.count
        and t < profile.time[profile.index]
    ):
        return False
    profile.elapsed = t
    v = profile.velocity
    a = profile.acceleration
    j = profile.jerk[profile.index]
    set_point = ax.set
    set_point.position = profile.position + t * (v + t * (0.5 * a + t * (j / 6.0)))
    set_point.velocity = v + t * (a + t * (0.5 * j))
    set_point.acceleration = a + t * j
    set_point.jerk = j
    return True


def advance(ax: AxisFields, dt: float) -> float:
    """Walk `dt` seconds along the table; returns the time left when a blended job begins."""
    profile = ax.profile
    t = profile.elapsed + dt
    i = profile.index
    count = profile.count
    p = profile.position
    v = profile.velocity
    a = profile.acceleration
    if i < count:
        step = profile.time[i]
        j = profile.jerk[i]
        if t >= step:
            while t >= step:
                p += step * (v + step * (0.5 * a + step * (j / 6.0)))
                v += step * (a + step * (0.5 * j))
                a = segment_acceleration(step, j, a)
                t -= step
                i += 1
                if i == count:
                    break
                step = profile.time[i]
                j = profile.jerk[i]
            profile.index = i
            profile.position = p
            profile.velocity = v
            profile.acceleration = a
        profile.elapsed = t
        if i < count:
            ax.set.position = p + t * (v + t * (0.5 * a + t * (j / 6.0)))
            ax.set.velocity = v + t * (a + t * (0.5 * j))
            ax.set.acceleration = a + t * j
            ax.set.jerk = j
            return 0.0
    profile.elapsed = t
    ax.set.acceleration = 0.0
    ax.set.jerk = 0.0
    arrival = v
    v = profile.end_velocity
    if profile.replan:  # to be planned again from here
        ax.set.position = p
        ax.set.velocity = -v if v * arrival < 0.0 else v
        return t
    if profile.end == TO_CONSTANT_VELOCITY:
        profile.velocity = v
        profile.acceleration = 0.0
        ax.set.velocity = v
        ax.set.position = p + t * v
        return 0.0
    if profile.end == TO_TARGET:
        ax.set.position = ax.border.position
        if v != 0.0:
            ax.set.velocity = v if arrival > 0.0 else -v
            _pass_border(ax)
            return t
        if ax.loop.outward:
            ax.loop.outward = 0
            ax.set.velocity = 0.0
            profile.replan = 1
            return t
        ax.set_command_state = CommandState.DONE
        ax.set_motion_phase = MotionPhase.NONE
        ax.remaining_time = 0.0
    elif profile.end == TO_PAUSE:
        ax.set.position = p
        ax.set.velocity = 0.0
        profile.replan = 1
        return t
    elif profile.end == TO_LIMIT:
        ax.set.position = ax.border.position
        ax.limits.reached = 1 if ax.job.direction > 0.0 else -1
    else:
        ax.set.position = p
        if ax.set_motion_phase == MotionPhase.STOPPING:
            ax.set_motion_phase = MotionPhase.NONE
            ax.target_position = p
            if ax.set_command_state == CommandState.ACTIVE:  # a halt
                ax.set_command_state = CommandState.DONE
    ax.set.velocity = 0.0
    return 0.0


def _in_velocity(ax: AxisFields) -> bool:
    """Return True if an endless move has its velocity, which is all that it wants."""
    if ax.profile.replan:
        return False
    if ax.profile.end == TO_LIMIT:
        return ax.set.velocity != 0.0 and ax.set.acceleration == 0.0 and ax.set.jerk == 0.0
    return ax.profile.end == TO_CONSTANT_VELOCITY and ax.profile.index == ax.profile.count


def _look_at_limits(ax: AxisFields) -> None:
    """Ask for a new table where limits or positions changed, and the present one does not fit."""
    ax.limits.recheck = 0
    phase = ax.set_motion_phase
    if (
        phase in (MotionPhase.ENDLESS, MotionPhase.HOMING)
        or ax.profile.end == TO_LIMIT
        or fastest(ax) != ax.profile.fastest
        or table_passes(ax)
    ):
        ax.profile.replan = 1


def generate(ax: AxisFields, dt: float) -> None:
    """Run one cycle of the set-point generator."""
    if ax.set_motion_phase == MotionPhase.NONE:
        if ax.buffer.count == 0 or not arrived(ax):
            return
        begin_next_job(ax)
    elif ax.set_motion_phase == MotionPhase.ENDLESS and ax.buffer.count > 0 and _in_velocity(ax):
        begin_next_job(ax)
    if ax.velocity_override != ax.profile.override:
        if ax.velocity_override <= 0 and ax.set_motion_phase == MotionPhase.STOPPING:
            stop_fast(ax)
        follow_override(ax)
    if ax.limits.recheck and goes_alone(ax):
        _look_at_limits(ax)
    left = dt
    while left > 0.0:
        if ax.profile.replan and plan(ax) < 0:
            fail(ax, NcError.DYNAMICS_NOT_ALLOWED, 1)
            return
        t = ax.border.time
        if 0.0 <= t <= left:
            ax.border.time = -1.0
            left -= t
            if t > 0.0:
                advance(ax, t)
            _pass_border(ax)
        else:
            if t > 0.0:
                ax.border.time -= left
            left = advance(ax, left)
    if ax.switch.armed:
        pass_switch_position(ax)
    show_remaining(ax, dt)


def show_remaining(ax: AxisFields, dt: float) -> None:
    """Compute distance and time to the target."""
    if ax.set_motion_phase == MotionPhase.POSITIONING:
        ax.remaining_distance = abs(ax.target_position - ax.set.position)
        if ax.loop.outward:
            ax.remaining_distance = abs(ax.border.position - ax.set.position)
            ax.remaining_distance += abs(ax.loop_distance)
        ax.remaining_time -= dt
        if ax.remaining_time < 0.0:
            ax.remaining_time = 0.0
    else:
        ax.remaining_distance = 0.0
        ax.remaining_time = 0.0
        if ax.set.velocity != 0.0:
            ax.target_position = ax.set.position


def shift_encoder(ax: AxisFields, encoder: EncoderFields, shift: float) -> None:
    """Rename the actual positions of an encoder alone: they become `shift` larger."""
    encoder.set_position_offset += shift
    encoder.actual_position_unfiltered += shift
    encoder.actual_position_filtered += shift
    encoder.actual_position += shift
    for i in range(POSITION_HISTORY):
        encoder.history[i] += shift
    if encoder.in_use:
        ax.controller.observer_position += shift
        ax.monitoring.motion_position += shift
        if ax.homing.state != 0:
            ax.homing.latch_begin += shift
            ax.homing.latch_position += shift


def displace(ax: AxisFields, way: float) -> None:
    """Let what is planned go on as it is, `way` farther on, and what waits behind it too."""
    for n in range(ax.buffer.count):
        i = (ax.buffer.first + n) % COMMAND_BUFFER
        job = ax.waiting[i]
        if job.start_type == StartType.ABSOLUTE:
            job.position += way
        job.blending_position += way
    ax.set.position += way
    ax.target_position += way
    ax.profile.position += way
    ax.switch.position += way
    ax.switch.target += way
    ax.border.position += way
    ax.loop.target += way
    ax.reversing.target += way


def shift_setpoint(ax: AxisFields, shift: float) -> None:
    """Rename the set positions alone: what is planned goes on as it is, `shift` further."""
    drive = ax.drive
    displace(ax, shift)
    ax.limits.recheck = 1
    ax.external.origin += shift
    ax.coupling.slave_base += shift
    ax.leading_value.offset += shift
    drive.switch_start += shift
    drive.sent_position += shift
    drive.filtered_set_position += shift
    for i in range(drive.filter_count):
        drive.filter_ring[i] += shift
    for i in range(FILTER_ORDER):
        drive.filter_stage[i] += shift


def shift_origin(ax: AxisFields, shift: float) -> None:
    """Rename positions: the axis stays where it is, its position becomes `shift` larger."""
    shift_encoder(ax, ax.encoder, shift)
    shift_setpoint(ax, shift)
