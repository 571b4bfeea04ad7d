"""Encoder: from the count of the hardware to actual position, velocity and acceleration.

What goes beyond scaling and filters (masks, directions, corrections, dead time) is computed only on
axes that use it.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.codes import NcError
from achse.motion.fields.encoder import POSITION_HISTORY
from achse.motion.port import wrapped
from achse.motion.record import AxisFields, EncoderFields
from achse.motion.setpoints.setpoint import fail

_STILL = 1e-9
"""A filtered velocity or acceleration below this is zero."""

_FULL_COUNTER = 4_000_000_000_000_000_000
"""Increments that the software counter holds, either way."""

_FULL_MASK = 0xFFFF_FFFF
_HALF = 0x8000_0000

_SIGNED = 2
_POSITIVE_ONLY = 1
_NEGATIVE_ONLY = 2
_BLOCKED = 3
_ABSOLUTE = 1

_POSITION_ONLY = 1
_WITH_VELOCITY = 2

_BY_VELOCITY = 1
_BY_ACCELERATION = 2


def _raw_count(encoder: EncoderFields, count: int) -> int:
    """Return the evaluated bits of a count: within the mask, without the bits filtered out."""
    period = encoder.mask + 1
    raw = count % period & (_FULL_MASK ^ encoder.raw_value_filter_mask)
    if encoder.sign_interpretation == _SIGNED and 2 * raw >= period:
        raw -= period
    return raw


def _begin_again(encoder: EncoderFields) -> None:
    """Take the position from the hardware as at the start: what was set or counted is lost."""
    encoder.data = encoder.io.data_in1
    raw = _raw_count(encoder, encoder.data)
    if raw > 0x7FFF_FFFF and encoder.reference_system != _ABSOLUTE:
        raw -= 0x1_0000_0000
    encoder.software_increments = raw
    encoder.watched_count = raw
    encoder.set_position_offset = 0.0
    encoder.actual_position_filtered = raw * encoder.scale + encoder.position_offset
    if encoder.is_absolute == 0:
        encoder.homed = 0
    encoder.reinitialization_state = 0


def adapt_encoder(ax: AxisFields, encoder: EncoderFields, dt: float) -> None:
    """Derive what follows from the parameters; the actual position does not jump."""
    scale = encoder.scaling_factor
    encoder.scale = -scale if encoder.count_direction else scale
    if encoder.reinitialization_state:
        _begin_again(encoder)
    special = 0
    if (
        encoder.mask != _FULL_MASK
        or encoder.raw_value_filter_mask != 0
        or encoder.evaluation_direction != 0
        or encoder.reference_system == _ABSOLUTE
        or encoder.sign_interpretation == _SIGNED
        or encoder.mode <= _WITH_VELOCITY
        or encoder.actual_position_correction_enable != 0
        or encoder.position_correction != 0.0
        or (encoder.in_use and ax.backlash_compensation_enable != 0 and ax.backlash != 0.0)
        or encoder.dead_time_compensation_mode != 0
        or encoder.dead_time_position_correction != 0.0
    ):
        special = 1
    encoder.special = special
    encoder.velocity_weight = dt / (encoder.velocity_filter_time + dt)
    encoder.acceleration_weight = dt / (encoder.acceleration_filter_time + dt)
    encoder.adapt = 0


def read_counter(encoder: EncoderFields) -> int:
    """Return the software count by way of the hardware's: overflow, masks, directions."""
    raw = _raw_count(encoder, encoder.io.data_in1)
    moved = raw - _raw_count(encoder, encoder.data)
    encoder.raw = raw
    encoder.data = encoder.io.data_in1
    if encoder.reference_system == _ABSOLUTE:
        return raw
    period = encoder.mask + 1
    if 2 * moved > period:
        moved -= period
    elif 2 * moved < -period:
        moved += period
    direction = encoder.evaluation_direction
    if (
        direction == _BLOCKED
        or (direction == _POSITIVE_ONLY and moved < 0)
        or (direction == _NEGATIVE_ONLY and moved > 0)
    ):
        moved = 0
    return encoder.software_increments + moved


def _correct(ax: AxisFields, encoder: EncoderFields, dt: float) -> float:
    """Return the correction of the actual position now: of the measuring system and of backlash."""
    goal = 0.0
    if encoder.actual_position_correction_enable:
        goal = ax.actual_position_correction
    if ax.backlash_compensation_enable and encoder.in_use:
        if ax.set.velocity > 0.0:
            encoder.backlash_side = 1.0
        elif ax.set.velocity < 0.0:
            encoder.backlash_side = -1.0
        if encoder.backlash_side < 0.0:
            goal += ax.backlash
    before = encoder.position_correction
    if goal != before:
        filter_time = encoder.actual_position_correction_filter_time
        goal = before + (goal - before) * (dt / (filter_time + dt)) if filter_time > 0.0 else goal
        if abs(goal - before) < _STILL:
            goal = before
    encoder.position_correction = goal
    return goal - before


def measure(ax: AxisFields, encoder: EncoderFields, dt: float, fast: bool = False) -> None:
    """Read position, velocity and acceleration of the encoder; on the fast path as they are."""
    special = 0 if fast else encoder.special
    before_count = encoder.software_increments
    if special:
        count = read_counter(encoder)
        moved = count - before_count
    else:
        data = encoder.io.data_in1
        moved = data - encoder.data
        if abs(moved) >= _HALF:
            moved = wrapped(moved)
        count = before_count + moved
        encoder.data = data
        encoder.hardware_increments = data
    if moved:
        if abs(count) > _FULL_COUNTER:
            if encoder.in_use:
                fail(ax, NcError.ENCODER_OVERFLOW if count > 0 else NcError.ENCODER_UNDERFLOW, 1)
            count = before_count
            moved = 0
        encoder.software_increments = count
    scale = encoder.scale
    position = count * scale + encoder.position_offset + encoder.set_position_offset
    velocity = moved * scale / dt
    if special:
        raw = encoder.raw
        encoder.hardware_increments = raw - 0x1_0000_0000 if raw > 0x7FFF_FFFF else raw
        if encoder.mode == _POSITION_ONLY:
            velocity = 0.0
        before = encoder.actual_velocity_uncorrected
        change = (velocity - before) * encoder.velocity_weight
        encoder.actual_velocity_uncorrected = before + change
        velocity += _correct(ax, encoder, dt) / dt
        position += encoder.position_correction
    encoder.actual_position_unfiltered = position
    filter_time = 0.0 if fast else encoder.position_filter_time
    if filter_time > 0.0:
        before = encoder.actual_position_filtered
        if abs(position - before) > _STILL:
            position = before + (position - before) * (dt / (filter_time + dt))
    encoder.actual_position_filtered = position
    encoder.actual_velocity_unfiltered = velocity
    before = encoder.actual_velocity
    if velocity != before:
        velocity = before + (velocity - before) * encoder.velocity_weight
        if abs(velocity) < _STILL:
            velocity = 0.0
        encoder.actual_velocity = velocity
    acceleration = (velocity - before) / dt
    before = encoder.actual_acceleration
    if special and encoder.mode <= _WITH_VELOCITY:
        acceleration = 0.0
    if acceleration != before:
        acceleration = before + (acceleration - before) * encoder.acceleration_weight
        if abs(acceleration) < _STILL:
            acceleration = 0.0
        encoder.actual_acceleration = acceleration
    if special:
        way = 0.0
        mode = encoder.dead_time_compensation_mode
        if mode >= _BY_VELOCITY:
            late = encoder.dead_time_compensation_shift * 1e-9
            way = velocity * late
            if mode == _BY_ACCELERATION:
                way += 0.5 * acceleration * late * late
        encoder.dead_time_position_correction = way
        position += way
    encoder.actual_position = position
    encoder.history[ax.set_cycle_counter % POSITION_HISTORY] = position
