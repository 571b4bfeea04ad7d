"""Oscillations: reversing between two targets, velocity steps, sine and frequency sequence.

Reversing is positioning in turn; while it pauses at a target its phase is REVERSING. Velocity steps
are abrupt, as the answer of the axis to them is what they are made for. The sine is one of the
velocity: a slow base oscillation that keeps the axis moving, and one to measure with, which goes
from frequency to frequency without a jump.

Kernel source: compiled as it stands, see `compiled`.
"""

from math import cos, pi, sin

from achse.motion.dynamics import fastest
from achse.motion.record import AxisFields
from achse.motion.setpoint import absorb, begin_job, generate
from achse.motion.states import CommandState, MotionPhase, StartType

__all__ = ["oscillate", "position_in_turn"]

_STILL = 1e-6
"""A sequence whose velocity is below ends without a ramp."""

_STEP_STAGES = 4
"""First velocity, pause, second velocity, pause."""


def position_in_turn(ax: AxisFields) -> None:
    """After each cycle of a reversing command: at a target the pause begins."""
    if ax.set_command_number != ax.reversing_number or ax.set_command_state not in (
        CommandState.ACTIVE,
        CommandState.DONE,
    ):
        ax.reversing_number = 0
    elif ax.set_motion_phase == MotionPhase.NONE and ax.buffer_count == 0:
        ax.set_motion_phase = MotionPhase.REVERSING
        ax.set_command_state = CommandState.ACTIVE
        ax.generator_time = 0.0
        ax.job_timing = 0


def _pause(ax: AxisFields, dt: float) -> None:
    """Wait at a target, then go to the other one; a command that waits is let in."""
    ax.generator_time += dt
    if ax.buffer_count > 0:
        ax.set_motion_phase = MotionPhase.NONE
        ax.set_command_state = CommandState.DONE
        return
    if ax.generator_time < ax.generator_pause + 0.5 * dt:
        return
    here = ax.set_position
    target = ax.reversing_target
    ax.reversing_target = here
    begin_job(
        ax,
        ax.reversing_number,
        StartType.ABSOLUTE,
        target,
        ax.job_velocity,
        ax.job_acceleration,
        ax.job_deceleration,
        ax.job_jerk,
        0.0,
    )
    generate(ax, dt)
    position_in_turn(ax)


def _override(ax: AxisFields) -> float:
    ax.planned_override = ax.velocity_override
    share = ax.velocity_override / 1e6
    return share if share < 1.0 else 1.0


def _finish(ax: AxisFields) -> None:
    """The sequence is complete: brake where the axis still moves."""
    absorb(ax)
    ax.set_command_state = CommandState.DONE
    if abs(ax.set_velocity) < _STILL:
        ax.set_velocity = 0.0
        ax.set_acceleration = 0.0
        ax.set_jerk = 0.0
        ax.set_motion_phase = MotionPhase.NONE
    else:
        ax.set_motion_phase = MotionPhase.STOPPING
        ax.replan = 1


def _step(ax: AxisFields, dt: float) -> None:
    """Velocity steps: constant velocities and pauses by turns, without ramps."""
    stage = ax.generator_stage
    pausing = stage % 2 == 1
    velocity = 0.0
    if not pausing:
        velocity = ax.step_velocity_1 if stage == 0 else ax.step_velocity_2
        velocity *= _override(ax)
        top = fastest(ax)
        if velocity > top:
            velocity = top
        elif velocity < -top:
            velocity = -top
    if stage == _STEP_STAGES:
        ax.set_velocity = 0.0
        _finish(ax)
        return
    ax.set_velocity = velocity
    ax.set_position += velocity * dt
    ax.target_position = ax.set_position
    ax.generator_time += dt
    duration = ax.generator_pause if pausing else ax.generator_duration
    while ax.generator_time >= duration - 0.5 * dt:
        ax.generator_time = 0.0
        stage += 1
        if stage == _STEP_STAGES:
            ax.generator_round += 1
            if ax.generator_round == ax.generator_rounds:
                break
            stage = 0
        duration = ax.generator_pause if stage % 2 == 1 else ax.generator_duration
    ax.generator_stage = stage


def _wave(
    angle: float, frequency: float, amplitude: float, dt: float
) -> tuple[float, float, float, float, float]:
    """A sine's phase angle a cycle later, and its way, velocity, acceleration and jerk by then."""
    if amplitude == 0.0 or frequency == 0.0:
        return angle, 0.0, 0.0, 0.0, 0.0
    omega = 2.0 * pi * frequency
    later = angle + omega * dt
    while later >= 2.0 * pi:
        later -= 2.0 * pi
    way = amplitude / omega * (cos(angle) - cos(later))
    velocity = amplitude * sin(later)
    acceleration = amplitude * omega * cos(later)
    return later, way, velocity, acceleration, -omega * omega * velocity


def _ease(ax: AxisFields, dt: float) -> float:
    """Let the amplitudes follow the override with the acceleration of the axis at most.

    Returns by how much they grew.
    """
    amplitude = ax.sine_base_velocity + ax.sine_velocity
    most = ax.default_acceleration * dt / amplitude
    share = _override(ax)
    if share * amplitude > fastest(ax):
        share = fastest(ax) / amplitude
    growth = share - ax.sine_share
    if growth > most:
        growth = most
    elif growth < -most:
        growth = -most
    ax.sine_share += growth
    return growth


def _swing(ax: AxisFields, dt: float) -> None:
    """Sine oscillation: base and measuring oscillation, each integrated over the cycle."""
    if ax.generator_time >= ax.generator_duration - 0.5 * dt:
        ax.generator_time = 0.0
        ax.generator_round += 1
        ax.sine_frequency *= ax.sine_frequency_ratio
    if ax.generator_round == ax.generator_rounds:
        _finish(ax)
        if ax.set_motion_phase == MotionPhase.STOPPING:
            generate(ax, dt)
        return
    ax.generator_time += dt
    growth = _ease(ax, dt)
    angle, way, velocity, acceleration, jerk = _wave(
        ax.sine_base_angle, ax.sine_base_frequency, ax.sine_base_velocity, dt
    )
    ax.sine_base_angle = angle
    angle, more_way, more_velocity, more_acceleration, more_jerk = _wave(
        ax.sine_angle, ax.sine_frequency, ax.sine_velocity, dt
    )
    ax.sine_angle = angle
    way += more_way
    velocity += more_velocity
    acceleration += more_acceleration
    jerk += more_jerk
    share = ax.sine_share
    ax.set_position += (share - 0.5 * growth) * way
    ax.set_velocity = share * velocity
    ax.superposed_acceleration = growth / dt * velocity
    ax.set_acceleration = share * acceleration + ax.superposed_acceleration
    ax.set_jerk = share * jerk + 2.0 * growth / dt * acceleration
    ax.target_position = ax.set_position


def oscillate(ax: AxisFields, dt: float) -> None:
    """One cycle of a pause in reversing, of velocity steps or of the sine."""
    if ax.set_motion_phase == MotionPhase.REVERSING:
        _pause(ax, dt)
    elif ax.set_motion_phase == MotionPhase.VELOCITY_STEPS:
        _step(ax, dt)
    else:
        _swing(ax, dt)
