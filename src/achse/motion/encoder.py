"""Encoder: from the count of the hardware to actual position, velocity and acceleration.

What goes beyond scaling and filters (masks, directions, corrections, dead time) is computed only on
axes that use it.

Kernel source: compiled as it stands, see `compiled`.
"""

from math import floor

from achse.codes import NcError
from achse.motion.port import wrapped
from achse.motion.record import POSITION_HISTORY, AxisFields
from achse.motion.setpoint import fail
from achse.motion.targets import modulo_part

__all__ = ["adapt_encoder", "measure", "read_counter"]

_STILL = 1e-9
"""A filtered velocity or acceleration below this is zero."""

_FULL_COUNTER = 4_000_000_000_000_000_000
"""Increments that the software counter holds, either way."""

_FULL_MASK = 0xFFFF_FFFF

_SIGNED = 2
_POSITIVE_ONLY = 1
_NEGATIVE_ONLY = 2
_BLOCKED = 3
_ABSOLUTE = 1

_POSITION_ONLY = 1
_WITH_VELOCITY = 2

_BY_VELOCITY = 1
_BY_ACCELERATION = 2


def _raw_count(ax: AxisFields, count: int) -> int:
    """What is evaluated of a count: within the mask, without the bits filtered out."""
    period = ax.encoder_mask + 1
    raw = count % period & (_FULL_MASK ^ ax.encoder_raw_value_filter_mask)
    if ax.encoder_sign_interpretation == _SIGNED and 2 * raw >= period:
        raw -= period
    return raw


def _begin_again(ax: AxisFields) -> None:
    """Take the position from the hardware as at the start: what was set or counted is lost."""
    ax.encoder_data = ax.encoder_io.data_in1
    raw = _raw_count(ax, ax.encoder_data)
    if raw > 0x7FFF_FFFF and ax.encoder_reference_system != _ABSOLUTE:
        raw -= 0x1_0000_0000
    ax.encoder_software_increments = raw
    ax.encoder_watched_count = raw
    ax.encoder_set_position_offset = 0.0
    ax.encoder_actual_position_filtered = raw * ax.encoder_scale + ax.encoder_position_offset
    if ax.encoder_is_absolute == 0:
        ax.homed = 0
    ax.encoder_reinitialization_state = 0


def adapt_encoder(ax: AxisFields) -> None:
    """Derive what follows from the parameters; the actual position does not jump."""
    scale = ax.encoder_scaling_factor
    ax.encoder_scale = -scale if ax.encoder_count_direction else scale
    if ax.encoder_reinitialization_state:
        _begin_again(ax)
    special = 0
    if (
        ax.encoder_mask != _FULL_MASK
        or ax.encoder_raw_value_filter_mask != 0
        or ax.encoder_evaluation_direction != 0
        or ax.encoder_reference_system == _ABSOLUTE
        or ax.encoder_sign_interpretation == _SIGNED
        or ax.encoder_mode <= _WITH_VELOCITY
        or ax.encoder_actual_position_correction_enable != 0
        or ax.encoder_position_correction != 0.0
        or (ax.backlash_compensation_enable != 0 and ax.backlash != 0.0)
        or ax.encoder_dead_time_compensation_mode != 0
        or ax.encoder_dead_time_position_correction != 0.0
    ):
        special = 1
    ax.encoder_special = special


def read_counter(ax: AxisFields) -> int:
    """The software count by way of the hardware's: overflow, masks, directions."""
    raw = _raw_count(ax, ax.encoder_io.data_in1)
    moved = raw - _raw_count(ax, ax.encoder_data)
    ax.encoder_raw = raw
    ax.encoder_data = ax.encoder_io.data_in1
    if ax.encoder_reference_system == _ABSOLUTE:
        return raw
    period = ax.encoder_mask + 1
    if 2 * moved > period:
        moved -= period
    elif 2 * moved < -period:
        moved += period
    direction = ax.encoder_evaluation_direction
    if (
        direction == _BLOCKED
        or (direction == _POSITIVE_ONLY and moved < 0)
        or (direction == _NEGATIVE_ONLY and moved > 0)
    ):
        moved = 0
    return ax.encoder_software_increments + moved


def _correct(ax: AxisFields, dt: float) -> float:
    """The correction of the actual position now: of the measuring system and of backlash."""
    goal = 0.0
    if ax.encoder_actual_position_correction_enable:
        goal = ax.actual_position_correction
    if ax.backlash_compensation_enable:
        if ax.set_velocity > 0.0:
            ax.encoder_backlash_side = 1.0
        elif ax.set_velocity < 0.0:
            ax.encoder_backlash_side = -1.0
        if ax.encoder_backlash_side < 0.0:
            goal += ax.backlash
    before = ax.encoder_position_correction
    if goal != before:
        filter_time = ax.encoder_actual_position_correction_filter_time
        goal = before + (goal - before) * (dt / (filter_time + dt)) if filter_time > 0.0 else goal
        if abs(goal - before) < _STILL:
            goal = before
    ax.encoder_position_correction = goal
    return goal - before


def measure(ax: AxisFields, dt: float) -> None:
    """Read the encoder: actual position, velocity and acceleration."""
    special = ax.encoder_special
    if special:
        count = read_counter(ax)
    else:
        data = ax.encoder_io.data_in1
        count = ax.encoder_software_increments
        if data != ax.encoder_data:
            count += wrapped(data - ax.encoder_data)
            ax.encoder_data = data
    if abs(count) > _FULL_COUNTER:
        fail(ax, NcError.ENCODER_OVERFLOW if count > 0 else NcError.ENCODER_UNDERFLOW, 1)
        count = ax.encoder_software_increments
    moved = count - ax.encoder_software_increments
    ax.encoder_software_increments = count
    scale = ax.encoder_scale
    position = count * scale + ax.encoder_position_offset + ax.encoder_set_position_offset
    velocity = moved * scale / dt
    if special:
        raw = ax.encoder_raw
        ax.encoder_hardware_increments = raw - 0x1_0000_0000 if raw > 0x7FFF_FFFF else raw
        if ax.encoder_mode == _POSITION_ONLY:
            velocity = 0.0
        before = ax.encoder_actual_velocity_uncorrected
        weight = dt / (ax.encoder_velocity_filter_time + dt)
        ax.encoder_actual_velocity_uncorrected = before + (velocity - before) * weight
        velocity += _correct(ax, dt) / dt
        position += ax.encoder_position_correction
    else:
        ax.encoder_hardware_increments = ax.encoder_data
    ax.encoder_actual_position_unfiltered = position
    filter_time = ax.encoder_position_filter_time
    if filter_time > 0.0:
        before = ax.encoder_actual_position_filtered
        if abs(position - before) > _STILL:
            position = before + (position - before) * (dt / (filter_time + dt))
    ax.encoder_actual_position_filtered = position
    ax.actual_velocity_unfiltered = velocity
    before = ax.actual_velocity
    if velocity != before:
        velocity = before + (velocity - before) * (dt / (ax.encoder_velocity_filter_time + dt))
        if abs(velocity) < _STILL:
            velocity = 0.0
        ax.actual_velocity = velocity
    acceleration = (velocity - before) / dt
    before = ax.actual_acceleration
    if special and ax.encoder_mode <= _WITH_VELOCITY:
        acceleration = 0.0
    if acceleration != before:
        weight = dt / (ax.encoder_acceleration_filter_time + dt)
        acceleration = before + (acceleration - before) * weight
        if abs(acceleration) < _STILL:
            acceleration = 0.0
        ax.actual_acceleration = acceleration
    if special:
        way = 0.0
        mode = ax.encoder_dead_time_compensation_mode
        if mode >= _BY_VELOCITY:
            late = ax.encoder_dead_time_compensation_shift * 1e-9
            way = velocity * late
            if mode == _BY_ACCELERATION:
                way += 0.5 * acceleration * late * late
        ax.encoder_dead_time_position_correction = way
        position += way
    ax.actual_position = position
    ax.encoder_history[ax.set_cycle_counter % POSITION_HISTORY] = position
    period = ax.encoder_modulo_factor
    ax.actual_position_modulo = modulo_part(position, period)
    ax.actual_modulo_turns = floor((position - ax.actual_position_modulo) / period + 0.5)
