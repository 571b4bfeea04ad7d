"""Touch probe 1 and pulses of the machine: positions latched where an edge really was.

Source: 001 §3.2.9, 60B8h to 60BBh.
"""

import math

from achse.drive.modes import HM
from achse.drive.record import DriveFields

_ENABLE = 0x01
_CONTINUOUS = 0x02
_SOURCE = 0x0C
_INDEX = 0x04
_RISING = 0x10
_FALLING = 0x20
_UPDATED = 0x80
_NOTHING = -1e300


def to_inc(d: DriveFields, position: float) -> int:
    """A machine position in counts as 6064h shows it, not wrapped."""
    count = math.floor(position + 0.5) - d.encoder_zero
    return math.floor(count * d.inc_per_count + 0.5) + d.active_home_offset


def index_crossed(d: DriveFields) -> float:
    """Return the position of the first index edge passed in this cycle; -1e300 without one."""
    before = math.floor((d.previous_position - d.index_offset) / d.index_pitch)
    after = math.floor((d.motor_position - d.index_offset) / d.index_pitch)
    if after > before:
        return d.index_offset + (before + 1) * d.index_pitch
    if after < before:
        return d.index_offset + before * d.index_pitch
    return _NOTHING


def latch(d: DriveFields) -> None:
    """Run one cycle of touch probe 1: levels, edges, status 60B9h and values."""
    function = d.probe_function
    status = d.probe_status
    if not function & _ENABLE or d.mode_display == HM:
        d.probe_status = 0
        d.probe_level = d.probe_input
        return
    status |= _ENABLE
    if not function & _RISING:
        status &= ~0x02
    if not function & _FALLING:
        status &= ~0x04
    if not function & (_RISING | _FALLING):
        status &= ~_UPDATED
    rising, falling = _edges(d, function & _SOURCE)
    if function & _RISING and rising != _NOTHING and (function & _CONTINUOUS or not status & 0x02):
        d.probe_positive = to_inc(d, rising)
        status |= 0x02
        status = _stored(d, function, status)
    if (
        function & _FALLING
        and falling != _NOTHING
        and (function & _CONTINUOUS or not status & 0x04)
    ):
        d.probe_negative = to_inc(d, falling)
        status |= 0x04
        status = _stored(d, function, status)
    d.probe_status = status


def _stored(d: DriveFields, function: int, status: int) -> int:
    if d.probe_error_map:
        d.error_map_updates += 1
    return status ^ _UPDATED if function & _CONTINUOUS else status


def _edges(d: DriveFields, source: int) -> tuple[float, float]:
    """Positions of a rising and a falling edge in this cycle."""
    before = d.previous_position
    after = d.motor_position
    if source == _INDEX:
        pulse = math.floor((max(before, after) - d.index_offset) / d.index_pitch)
        start = d.index_offset + pulse * d.index_pitch
        return _pulse(before, after, start, start + d.index_width)
    if source != 0:
        return (_NOTHING, _NOTHING)
    rising, falling = _NOTHING, _NOTHING
    if d.probe_input != d.probe_level:
        if d.probe_input:
            rising = after
        else:
            falling = after
        d.probe_level = d.probe_input
    elif d.probe_assigned:
        rising, falling = _pulse(before, after, d.probe_from, d.probe_to)
    return (rising, falling)


def _pulse(before: float, after: float, start: float, end: float) -> tuple[float, float]:
    """Edges of a signal that is on from `start` to `end`."""
    rising, falling = _NOTHING, _NOTHING
    if before < start <= after:
        rising = start
    elif after <= end < before:
        rising = end
    if before <= end < after:
        falling = end
    elif after < start <= before:
        falling = start
    return (rising, falling)
