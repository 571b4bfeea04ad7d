"""Sensors: what an encoder counts, and the counts that its latches take.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from math import floor

from achse.motion.machine.record import Sensor
from achse.motion.machine.signals import NOWHERE, cam_closed, drive_inputs, edge
from achse.motion.port import CAM_CLOSED, LATCH_FALLING, STATUS_INVALID, wrapped

_FARTHEST = 4.0e18
"""A count does not go beyond."""

FULL_MASK = 0xFFFF_FFFF
"""The mask of a counter of 32 bits."""
_HALF = 0x8000_0000

_WAITS = 1 << 0
_LATCHED = 1 << 1
_RISEN = 1 << 1
_FALLEN = 1 << 2


def count_at(s: Sensor, place: float) -> int:
    """Return the count when the machine is at `place`, without overflow."""
    way = place / s.encoder_resolution
    if s.encoder_inverted:
        way = -way
    way += s.zero + 0.5
    if way > _FARTHEST:
        way = _FARTHEST
    elif way < -_FARTHEST:
        way = -_FARTHEST
    return floor(way)


def _shown(s: Sensor, count: int) -> int:
    """Return the count as the hardware reports it."""
    if s.encoder_mask == FULL_MASK:
        return wrapped(count)
    return count % (s.encoder_mask + 1)


def sense(s: Sensor, fast: bool = False) -> None:
    """Put the inputs of the encoder into its structure; on the `fast` path the data are valid."""
    m = s.machine
    io = s.io
    if not fast and m.io_invalid:
        if io.state4 == 0:
            io.state4 = STATUS_INVALID
            io.has_changed = 1
        return
    if not fast and io.state4:
        io.state4 = 0
        io.has_changed = 1
    position = m.position
    way = position / s.encoder_resolution
    if s.encoder_inverted:
        way = -way
    way += s.zero + 0.5
    count = floor(way) if abs(way) < _FARTHEST else count_at(s, position)
    if not fast and s.noise > 0.0:
        s.noise_state = (s.noise_state * 1_103_515_245 + 12_345) % 0x8000_0000
        count += floor(s.noise * (s.noise_state / 1_073_741_824.0 - 1.0) + 0.5)
    if count != s.count:
        s.count = count
        if (fast or s.encoder_mask == FULL_MASK) and abs(count) < _HALF:
            io.data_in1 = count
        else:
            io.data_in1 = _shown(s, count)
        io.has_changed = 1
    if fast or not m.cam_input:
        cam = 0
        if not fast and m.period > 0.0:
            cam = CAM_CLOSED if cam_closed(m) else 0
        elif m.cam_begin <= position <= m.cam_end:
            cam = CAM_CLOSED
        if cam != io.state2:
            io.state2 = cam
            io.has_changed = 1
    elif io.state2:
        io.state2 = 0
    if s.watching:
        _latch(s)


def arm_latches(s: Sensor) -> None:
    """Watch the signals as long as the NC has a latch wait; from here on edges count."""
    io = s.io
    io.fresh = 0
    if io.ctrl1 | io.ctrl5 | io.ctrl6 | io.ctrl7 | io.ctrl8:
        if s.watching == 0:
            s.watching = 1
            s.before = s.machine.position
            s.inputs_before = drive_inputs(s.machine)
    elif s.watching:
        s.watching = 0
        io.state1 &= _LATCHED


def _latch(s: Sensor) -> None:
    """Take the counts of what happened on the way since the cycle before."""
    io = s.io
    waits = io.ctrl1
    if waits:
        place = edge(s, waits & 15, 1 if waits & LATCH_FALLING else 0)
        io.state1 |= _WAITS
        if place != NOWHERE:
            io.data_in2 = _shown(s, count_at(s, place))
            io.state1 ^= _LATCHED
            io.has_changed = 1
    else:
        io.state1 &= _LATCHED
    if io.ctrl5:
        states, io.data_in3 = _probe(s, io.ctrl5, io.state5, io.data_in3)
        io.state5 = states
    if io.ctrl6:
        states, io.data_in4 = _probe(s, io.ctrl6, io.state6, io.data_in4)
        io.state6 = states
    if io.ctrl7:
        states, io.data_in5 = _probe(s, io.ctrl7, io.state7, io.data_in5)
        io.state7 = states
    if io.ctrl8:
        states, io.data_in6 = _probe(s, io.ctrl8, io.state8, io.data_in6)
        io.state8 = states
    s.before = s.machine.position
    s.inputs_before = drive_inputs(s.machine)


def _probe(s: Sensor, control: int, states: int, counts: int) -> tuple[int, int]:
    """State and counts of a touch probe after this cycle."""
    upper = counts >> 32
    lower = counts & FULL_MASK
    if control & 15:
        place = edge(s, control & 15, 0)
        if place != NOWHERE:
            lower = _shown(s, count_at(s, place)) & FULL_MASK
            states ^= _RISEN
            s.io.has_changed = 1
    if control >> 4:
        place = edge(s, control >> 4, 1)
        if place != NOWHERE:
            upper = wrapped(_shown(s, count_at(s, place)))
            states ^= _FALLEN
            s.io.has_changed = 1
    return states, upper << 32 | lower
