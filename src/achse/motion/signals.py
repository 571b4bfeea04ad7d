"""Signals: the homing cam, and the latches of edges that the hardware takes for the NC.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.motion.port import (
    CAM_CLOSED,
    LATCH_DRIVE_DEFINED,
    LATCH_FALLING,
    LATCH_INDEX,
    wrapped,
)
from achse.motion.record import PROBE_EDGES, TOUCH_PROBES, AxisFields
from achse.motion.states import ControlBit, HomingSensorSource, ReferenceMode, SignalSource

__all__ = [
    "LATCHED",
    "WAITS",
    "arm",
    "begin_watch",
    "homing_cam",
    "latch_probe",
    "probe_counts",
    "probe_state",
    "probe_status",
    "watch",
]

WAITS = 1
LATCHED = 2
"""States of the latch of a homing sequence."""

_TURNED = 1 << 1
"""Bit of a latch's state that turns over with its edge; of a probe's falling edge the next one."""

_FULL_MASK = 0xFFFF_FFFF


def homing_cam(ax: AxisFields) -> int:
    """Whether the reference cam is closed, as the configured source says."""
    source = ax.encoder_homing_sensor_source
    if source == 0:
        return (
            1
            if ax.control_dword & ControlBit.HOMING_SENSOR or ax.encoder_io.state2 & CAM_CLOSED
            else 0
        )
    inputs = ax.drive_io.state8
    if source < HomingSensorSource.DIGITAL_INPUT_1_LOW:
        return inputs >> (source - 1) & 1
    return 1 - (inputs >> (source - HomingSensorSource.DIGITAL_INPUT_1_LOW) & 1)


def _increments(ax: AxisFields, count: int) -> int:
    """Software increments when the hardware showed `count`, not long ago."""
    way = count - ax.encoder_io.data_in1
    if ax.encoder_mask == _FULL_MASK:
        return ax.encoder_software_increments + wrapped(way)
    period = ax.encoder_mask + 1
    way %= period
    if 2 * way >= period:
        way -= period
    return ax.encoder_software_increments + way


def _position(ax: AxisFields, increments: int) -> float:
    offset = ax.encoder_position_offset + ax.encoder_set_position_offset
    return increments * ax.encoder_scale + offset + ax.encoder_position_correction


def latch_probe(ax: AxisFields, edge: int, increments: int, position: float) -> None:
    """Latch a touch probe: `edge` is its unit, 0 based, or TOUCH_PROBES more for a falling one."""
    ax.encoder_probe_valid[edge] = 1
    ax.encoder_probe_position[edge] = position
    ax.encoder_probe_counter[edge] += 1
    ax.encoder_probe_active[edge] = ax.encoder_probe_continuous[edge]
    ax.encoder_latch_valid = 1
    hardware = ((increments + 0x8000_0000) & 0xFFFF_FFFF) - 0x8000_0000
    ax.encoder_latch_hardware_increment_difference = hardware - ax.encoder_latch_hardware_increments
    ax.encoder_latch_software_increment_difference = (
        increments - ax.encoder_latch_software_increments
    )
    ax.encoder_latch_position_difference = position - ax.encoder_latch_position
    ax.encoder_latch_hardware_increments = hardware
    ax.encoder_latch_software_increments = increments
    ax.encoder_latch_position = position


def probe_status(ax: AxisFields) -> int:
    """States of the touch probes, a byte each as in object 60B9h of a drive.

    Bit 0 waits, bits 1 and 2 a rising and a falling edge are latched, bit 7 turns over with each
    edge of a probe that goes on.
    """
    status = 0
    if ax.encoder_latch_active == 0 and ax.encoder_latch_valid == 0:
        return status
    for rising in range(TOUCH_PROBES):
        falling = rising + TOUCH_PROBES
        state = ax.encoder_probe_active[rising] | ax.encoder_probe_active[falling]
        state |= ax.encoder_probe_valid[rising] << 1 | ax.encoder_probe_valid[falling] << 2
        if ax.encoder_probe_continuous[rising] | ax.encoder_probe_continuous[falling]:
            edges = ax.encoder_probe_counter[rising] + ax.encoder_probe_counter[falling]
            state |= (edges & 1) << 7
        status |= state << 8 * rising
    return status


def probe_counts(ax: AxisFields) -> int:
    """Edges of both kinds that the touch probes latched, a byte each."""
    counts = 0
    for rising in range(TOUCH_PROBES):
        edges = ax.encoder_probe_counter[rising] + ax.encoder_probe_counter[rising + TOUCH_PROBES]
        counts |= (edges & 0xFF) << 8 * rising
    return counts


def probe_state(ax: AxisFields, probe: int) -> int:
    """State of touch probe 0..3 as the hardware shows it."""
    io = ax.encoder_io
    if probe == 0:
        return io.state5
    if probe == 1:
        return io.state6
    return io.state7 if probe == 2 else io.state8


def _probe_data(ax: AxisFields, probe: int) -> int:
    io = ax.encoder_io
    if probe == 0:
        return io.data_in3
    if probe == 1:
        return io.data_in4
    return io.data_in5 if probe == 2 else io.data_in6


def _signal(source: int) -> int:
    """A signal as the hardware is told."""
    if source == SignalSource.ZERO_PULSE:
        return LATCH_INDEX
    return source if source < LATCH_INDEX else LATCH_DRIVE_DEFINED


def _sync_signal(ax: AxisFields) -> int:
    """What the hardware watches for the sync pulse of homing; 0 if the NC counts itself."""
    mode = ax.encoder_reference_mode
    if mode == ReferenceMode.SOFTWARE_SYNC:
        return 0
    if mode == ReferenceMode.HARDWARE_SYNC:
        return 1 if ax.encoder_external_sync_pulse else LATCH_INDEX
    if mode == ReferenceMode.HARDWARE_LATCH_1_RISING:
        return 1
    if mode == ReferenceMode.HARDWARE_LATCH_1_FALLING:
        return 1 | LATCH_FALLING
    if mode == ReferenceMode.HARDWARE_LATCH_1_FALLING_DRIVE:
        return LATCH_DRIVE_DEFINED | LATCH_FALLING
    return LATCH_DRIVE_DEFINED


def _probe_signals(ax: AxisFields, probe: int) -> int:
    control = 0
    if ax.encoder_probe_active[probe]:
        control = _signal(ax.encoder_probe_source[probe])
    if ax.encoder_probe_active[probe + TOUCH_PROBES]:
        control |= _signal(ax.encoder_probe_source[probe + TOUCH_PROBES]) << 4
    return control


def arm(ax: AxisFields) -> None:
    """Tell the hardware what the latches wait for."""
    if ax.encoder_latch_active == 0 and ax.homing_latch != WAITS and ax.encoder_armed == 0:
        return
    io = ax.encoder_io
    io.ctrl1 = _sync_signal(ax) if ax.homing_latch == WAITS else 0
    io.ctrl5 = _probe_signals(ax, 0)
    io.ctrl6 = _probe_signals(ax, 1)
    io.ctrl7 = _probe_signals(ax, 2)
    io.ctrl8 = _probe_signals(ax, 3)
    io.fresh = 1
    ax.encoder_armed = 1 if io.ctrl1 | io.ctrl5 | io.ctrl6 | io.ctrl7 | io.ctrl8 else 0


def begin_watch(ax: AxisFields) -> None:
    """Wait for a sync pulse: from here on pulses count."""
    ax.homing_latch = WAITS
    ax.encoder_homing_seen = ax.encoder_io.state1
    ax.encoder_watched_count = ax.encoder_software_increments


def _software_pulse(ax: AxisFields) -> int:
    """The first multiple of the sub mask plus 1 on the way of this cycle, else where it began."""
    turn = ax.encoder_sub_mask + 1
    before = ax.encoder_watched_count
    now = ax.encoder_software_increments
    if now > before:
        count = (before // turn + 1) * turn
        return count if count <= now else before
    count = (-(-before // turn) - 1) * turn
    return count if count >= now else before


def _watch_homing(ax: AxisFields) -> None:
    increments = ax.encoder_watched_count
    if ax.encoder_reference_mode == ReferenceMode.SOFTWARE_SYNC:
        increments = _software_pulse(ax)
        if increments == ax.encoder_watched_count:
            ax.encoder_watched_count = ax.encoder_software_increments
            return
    else:
        state = ax.encoder_io.state1
        if (state ^ ax.encoder_homing_seen) & _TURNED == 0:
            return
        ax.encoder_homing_seen = state
        increments = _increments(ax, ax.encoder_io.data_in2)
    ax.homing_latch = LATCHED
    ax.homing_latch_position = _position(ax, increments)
    ax.encoder_latch_activation_difference = ax.homing_latch_position - ax.homing_latch_begin


def watch(ax: AxisFields) -> None:
    """Take what the hardware latched since the cycle before."""
    if ax.encoder_latch_active:
        active = 0
        for edge in range(PROBE_EDGES):
            if ax.encoder_probe_active[edge]:
                falling = edge >= TOUCH_PROBES
                probe = edge - TOUCH_PROBES if falling else edge
                turned = probe_state(ax, probe) ^ ax.encoder_probe_seen[probe]
                if turned & (_TURNED << 1 if falling else _TURNED):
                    counts = _probe_data(ax, probe)
                    increments = _increments(ax, counts >> 32 if falling else counts & _FULL_MASK)
                    latch_probe(ax, edge, increments, _position(ax, increments))
                active |= ax.encoder_probe_active[edge]
        for probe in range(TOUCH_PROBES):
            ax.encoder_probe_seen[probe] = probe_state(ax, probe)
        ax.encoder_latch_active = active
    if ax.homing_latch == WAITS:
        _watch_homing(ax)
