"""Sine: an oscillation of the velocity, or a sequence of frequencies (0x33).

A slow base oscillation keeps the axis moving; one to measure with goes from frequency to frequency
without a jump.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from math import cos, pi, sin

from achse.codes.nc.choices import MotionPhase
from achse.motion.generators.sequence import finish, override_share
from achse.motion.record import AxisFields
from achse.motion.setpoints.dynamics import fastest
from achse.motion.setpoints.setpoint import generate


def _wave(
    angle: float, frequency: float, amplitude: float, dt: float
) -> tuple[float, float, float, float, float]:
    """Return a sine's phase angle a cycle later, and its way, velocity, acceleration and jerk by
    then."""
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
    amplitude = ax.sine.base_velocity + ax.sine.velocity
    most = ax.default_acceleration * dt / amplitude
    share = override_share(ax)
    if share * amplitude > fastest(ax):
        share = fastest(ax) / amplitude
    growth = share - ax.sine.share
    if growth > most:
        growth = most
    elif growth < -most:
        growth = -most
    ax.sine.share += growth
    return growth


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle of base and measuring oscillation, each integrated over it."""
    ax.profile.abrupt = 1
    if ax.sequence.time >= ax.sequence.duration - 0.5 * dt:
        ax.sequence.time = 0.0
        ax.sequence.round += 1
        ax.sine.frequency *= ax.sine.frequency_ratio
    if ax.sequence.round == ax.sequence.rounds:
        finish(ax)
        if ax.set_motion_phase == MotionPhase.STOPPING:
            generate(ax, dt)
        return
    ax.sequence.time += dt
    growth = _ease(ax, dt)
    angle, way, velocity, acceleration, jerk = _wave(
        ax.sine.base_angle, ax.sine.base_frequency, ax.sine.base_velocity, dt
    )
    ax.sine.base_angle = angle
    angle, more_way, more_velocity, more_acceleration, more_jerk = _wave(
        ax.sine.angle, ax.sine.frequency, ax.sine.velocity, dt
    )
    ax.sine.angle = angle
    way += more_way
    velocity += more_velocity
    acceleration += more_acceleration
    jerk += more_jerk
    share = ax.sine.share
    ax.set.position += (share - 0.5 * growth) * way
    ax.set.velocity = share * velocity
    ax.superposed.set_acceleration = growth / dt * velocity
    ax.set.acceleration = share * acceleration + ax.superposed.set_acceleration
    ax.set.jerk = share * jerk + 2.0 * growth / dt * acceleration
    ax.target_position = ax.set.position
