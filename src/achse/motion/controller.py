"""Encoder, position controller and simulated drive: from set point to actual position.

The encoder counts whole increments of the motor's position, the controller adds a proportional part
to the velocity feed-forward, the drive follows its output with a dead time and a first-order lag.

Kernel source: compiled by Numba as it stands, see `compiled`.
"""

from math import floor

from achse.motion.record import DRIVE_DELAY, AxisFields
from achse.motion.setpoint import fail, modulo_part

__all__ = ["control", "drive", "measure", "place_motor"]

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


def place_motor(ax: AxisFields, position: float) -> None:
    """Put the motor where the encoder will read `position` (the ideal drive)."""
    way = position - ax.encoder_position_offset - ax.encoder_set_position_offset
    if ax.encoder_count_direction:
        way = -way
    ax.plant_position = way / ax.encoder_scaling_factor
    ax.plant_velocity = ax.set_velocity


def control(ax: AxisFields) -> None:
    """Position controller: following error to drive output."""
    error = ax.set_position - ax.actual_position
    ax.following_error = error
    ax.drive_limit_active = 0
    ax.following_error_velocity = ax.set_velocity - ax.actual_velocity
    if error < ax.following_error_peak_negative:
        ax.following_error_peak_negative = error
    if error > ax.following_error_peak_positive:
        ax.following_error_peak_positive = error
    if ax.loop_closed == 0:
        ax.controller_output = 0.0
        ax.drive_output = 0.0
        ax.controller_output_percent = 0.0
        ax.drive_output_percent = 0.0
        return
    dead_band = ax.controller_position_dead_band
    if ax.set_motion_phase == 0 and dead_band < 0.5001 * ax.encoder_scaling_factor:
        dead_band = 0.5001 * ax.encoder_scaling_factor  # at rest the encoder shows no less
    if abs(error) <= dead_band:
        error = 0.0
    full = ax.drive_reference_velocity
    part = ax.controller_position_kv * error
    limit = ax.controller_output_limit * full
    if part > limit:
        part = limit
    elif part < -limit:
        part = -limit
    ax.controller_output = part
    ax.controller_output_percent = 100.0 * part / full
    output = part + ax.controller_velocity_feedforward_weight * ax.set_velocity
    if output > ax.drive_output_limit_max * full:
        output = ax.drive_output_limit_max * full
        ax.drive_limit_active = 1
    elif output < ax.drive_output_limit_min * full:
        output = ax.drive_output_limit_min * full
        ax.drive_limit_active = 1
    ax.drive_output = output
    ax.drive_output_percent = 100.0 * output / full
    if output < ax.drive_output_peak_negative:
        ax.drive_output_peak_negative = output
    if output > ax.drive_output_peak_positive:
        ax.drive_output_peak_positive = output


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
