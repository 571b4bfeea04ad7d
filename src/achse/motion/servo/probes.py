"""Touch probes of the drive (60B8h ff) for those of the axis and for the sync pulse of a homing.

An edge is taken once and the probe armed again for the next, for which the drive wants to see it
switched off in between: edges that follow each other within some four cycles are missed.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.motion.port import LATCH_FALLING, LATCH_INDEX
from achse.motion.servo.record import PROBES, Servo

_ENABLE = 0x01
_INDEX = 0x04
_RISING = 0x10
_FALLING = 0x20
_EDGES = 0x30
_STORED = 0x06
"""Bits of the byte that a probe has in 60B8h, and in 60B9h."""

_SIGNAL = 15
_TURNS = 1 << 1
_FALL_TURNS = 1 << 2
_WAITS = 1 << 0
_FULL_MASK = 0xFFFF_FFFF


def _wanted(control: int) -> int:
    """Return the byte of 60B8h for what the axis waits for: rising edge in bits 0..3, falling in
    4..7."""
    if control == 0:
        return 0
    function = _ENABLE
    signal = control & _SIGNAL
    if signal:
        function |= _RISING
    if control >> 4:
        function |= _FALLING
        if signal == 0:
            signal = control >> 4
    if signal == LATCH_INDEX:
        function |= _INDEX
    return function


def _homing(control: int) -> int:
    """Return the same for the latch of a homing, which waits for one edge."""
    signal = control & _SIGNAL
    return signal << 4 if control & LATCH_FALLING else signal


def _control(s: Servo, probe: int) -> int:
    """Return the control word of a probe of the drive for the edges that the axis awaits."""
    if probe:
        return s.encoder.ctrl6
    if s.encoder.ctrl5 == 0 and s.encoder.ctrl1:
        return _homing(s.encoder.ctrl1)
    return s.encoder.ctrl5


def arm_probes(s: Servo) -> None:
    """Write 60B8h: what the probes wait for."""
    function = 0
    for probe in range(PROBES):
        wanted = _wanted(_control(s, probe))
        armed = s.probe_armed[probe]
        if probe == 0:
            homing = 1 if s.encoder.ctrl5 == 0 and s.encoder.ctrl1 else 0
            if homing != s.probe_homing:
                s.probe_homing = homing
                if armed & _EDGES:
                    wanted = 0
        waiting = armed & _EDGES & ~s.probe_taken[probe]
        keeps = armed & _ENABLE and wanted & _INDEX == armed & _INDEX
        if wanted and keeps and wanted & _EDGES & ~waiting == 0:
            function |= armed << 8 * probe
            continue
        shown = s.probe_status >> 8 * probe & 0xFF
        if armed or shown & _ENABLE:
            wanted = 0  # off for as long as the drive shows it armed
        s.probe_armed[probe] = wanted
        s.probe_taken[probe] = 0
        function |= wanted << 8 * probe
    s.probe_function = function


def take_probes(s: Servo) -> None:
    """Pass on the edges that the drive has stored since the cycle before."""
    e = s.encoder
    if s.probe_homing and s.probe_armed[0]:
        e.state1 |= _WAITS
    elif e.state1 & _WAITS:
        e.state1 &= ~_WAITS
    for probe in range(PROBES):
        armed = s.probe_armed[probe]
        shown = s.probe_status >> 8 * probe & 0xFF
        if armed == 0 or shown & _ENABLE == 0:
            continue
        stored = (shown & _STORED) << 3 & armed & ~s.probe_taken[probe]
        if stored == 0:
            continue
        s.probe_taken[probe] |= stored
        e.has_changed = 1
        rising = s.probe2_rising if probe else s.probe1_rising
        falling = s.probe2_falling if probe else s.probe1_falling
        if probe == 0 and s.probe_homing:
            e.data_in2 = rising if stored & _RISING else falling
            e.state1 ^= _TURNS
        else:
            counts = e.data_in4 if probe else e.data_in3
            states = e.state6 if probe else e.state5
            upper = counts >> 32
            lower = counts & _FULL_MASK
            if stored & _RISING:
                lower = rising & _FULL_MASK
                states ^= _TURNS
            if stored & _FALLING:
                upper = falling
                states ^= _FALL_TURNS
            if probe:
                e.state6 = states
                e.data_in4 = upper << 32 | lower
            else:
                e.state5 = states
                e.data_in3 = upper << 32 | lower
