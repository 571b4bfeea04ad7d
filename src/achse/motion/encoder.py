"""Encoder: from the motor's position to actual position, velocity and acceleration.

The encoder counts whole increments of the motor's position.

Kernel source: compiled by Numba as it stands, see `compiled`.
"""

from math import floor

from achse.motion.record import AxisFields
from achse.motion.setpoint import fail, modulo_part

__all__ = ["measure"]

_STILL = 1e-9
"""A filtered velocity or acceleration below this is zero."""

_FULL_COUNTER = 4.0e18
"""Increments that the software counter holds, either way."""

_COUNTER_UNDERFLOW = 0x4450
_COUNTER_OVERFLOW = 0x4451


def measure(ax: AxisFields, dt: float) -> None:
    """Read the encoder: actual position, velocity and acceleration."""
    if abs(ax.plant_position) > _FULL_COUNTER:
        fail(ax, _COUNTER_OVERFLOW if ax.plant_position > 0.0 else _COUNTER_UNDERFLOW, 1)
        ax.plant_position = _FULL_COUNTER if ax.plant_position > 0.0 else -_FULL_COUNTER
    count = floor(ax.plant_position + 0.5)
    moved = count - ax.encoder_software_increments
    ax.encoder_software_increments = count
    ax.encoder_hardware_increments = ((count + 0x8000_0000) & 0xFFFF_FFFF) - 0x8000_0000
    scale = ax.encoder_scaling_factor
    if ax.encoder_count_direction:
        scale = -scale
    position = count * scale + ax.encoder_position_offset + ax.encoder_set_position_offset
    ax.encoder_actual_position_unfiltered = position
    filter_time = ax.encoder_position_filter_time
    if filter_time > 0.0:
        difference = position - ax.actual_position
        if abs(difference) > _STILL:
            position = ax.actual_position + difference * (dt / (filter_time + dt))
    ax.actual_position = position
    velocity = moved * scale / dt
    ax.actual_velocity_unfiltered = velocity
    before = ax.actual_velocity
    if velocity != before:
        velocity = before + (velocity - before) * (dt / (ax.encoder_velocity_filter_time + dt))
        if abs(velocity) < _STILL:
            velocity = 0.0
        ax.actual_velocity = velocity
    acceleration = (velocity - before) / dt
    before = ax.actual_acceleration
    if acceleration != before:
        weight = dt / (ax.encoder_acceleration_filter_time + dt)
        acceleration = before + (acceleration - before) * weight
        if abs(acceleration) < _STILL:
            acceleration = 0.0
        ax.actual_acceleration = acceleration
    period = ax.encoder_modulo_factor
    ax.actual_position_modulo = modulo_part(position, period)
    ax.actual_modulo_turns = floor((position - ax.actual_position_modulo) / period + 0.5)
