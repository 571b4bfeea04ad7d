"""Simulated drive: from the output of the axis to the position of the motor.

The drive follows its output with a dead time and a first-order lag.

Kernel source: compiled by Numba as it stands, see `compiled`.
"""

from math import floor

from achse.motion.record import DRIVE_DELAY, AxisFields

__all__ = ["drive", "place_motor"]

_STILL = 1e-9
"""A velocity below this without output is zero."""


def place_motor(ax: AxisFields, position: float) -> None:
    """Put the motor where the encoder will read `position` (the ideal drive)."""
    way = position - ax.encoder_position_offset - ax.encoder_set_position_offset
    if ax.encoder_count_direction:
        way = -way
    ax.plant_position = way / ax.encoder_scaling_factor
    ax.plant_velocity = ax.set_velocity


def drive(ax: AxisFields, dt: float) -> None:
    """Move the motor until the next cycle: dead time, first-order lag of the velocity."""
    command = ax.drive_output
    delay = floor(ax.simulation_dead_time / dt + 0.5)
    if delay > 0:
        if delay > DRIVE_DELAY:
            delay = DRIVE_DELAY
        slot = ax.delay_index % delay
        delayed = ax.delay_output[slot]
        ax.delay_output[slot] = command
        ax.delay_index = (slot + 1) % delay
        command = delayed
    velocity = ax.plant_velocity
    velocity += (command - velocity) * (dt / (ax.simulation_time_constant + dt))
    if abs(velocity) < _STILL and command == 0.0:
        velocity = 0.0
    if ax.simulation_blocked:
        velocity = 0.0
    ax.plant_velocity = velocity
    if velocity != 0.0:
        if ax.drive_motor_polarity:
            velocity = -velocity
        ax.plant_position += velocity * dt / ax.encoder_scaling_factor
