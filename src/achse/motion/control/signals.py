"""Signals: the homing cam, and the latches of edges that the hardware takes for the NC.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.codes.axis import ControlBit
from achse.codes.nc.choices import HomingSensorSource, MotionPhase, ReferenceMode
from achse.motion.features import Feature
from achse.motion.fields.encoder import PROBE_EDGES, TOUCH_PROBES
from achse.motion.port import (
    CAM_CLOSED,
    LATCH_DRIVE_DEFINED,
    LATCH_FALLING,
    LATCH_INDEX,
    wrapped,
)
from achse.motion.record import AxisFields, EncoderFields
from achse.motion.states import SignalSource

WAITS = 1
LATCHED = 2
"""States of the latch of a homing sequence."""


_TURNED = 1 << 1
"""Bit of a latch's state that turns over with its edge; of a probe's falling edge the next one."""

_FULL_MASK = 0xFFFF_FFFF


def homing_cam(ax: AxisFields) -> int:
    """Return 1 if the reference cam is closed, as the configured source says, else 0."""
    source = ax.encoder.homing_sensor_source
    if source == 0:
        return (
            1
            if ax.control_dword & ControlBit.HOMING_SENSOR or ax.encoder.io.state2 & CAM_CLOSED
            else 0
        )
    inputs = ax.drive.io.state8
    if source < HomingSensorSource.DIGITAL_INPUT_1_LOW:
        return inputs >> (source - 1) & 1
    return 1 - (inputs >> (source - HomingSensorSource.DIGITAL_INPUT_1_LOW) & 1)


def _increments(encoder: EncoderFields, count: int) -> int:
    """Software increments when the hardware showed `count`, not long ago."""
    way = count - encoder.io.data_in1
    if encoder.mask == _FULL_MASK:
        return encoder.software_increments + wrapped(way)
    period = encoder.mask + 1
    way %= period
    if 2 * way >= period:
        way -= period
    return encoder.software_increments + way


def _position(encoder: EncoderFields, increments: int) -> float:
    offset = encoder.position_offset + encoder.set_position_offset
    return increments * encoder.scale + offset + encoder.position_correction


def latched_position(encoder: EncoderFields) -> float:
    """Return the position at the homing latch of the hardware, in present coordinates."""
    return _position(encoder, _increments(encoder, encoder.io.data_in2))


def latch_probe(encoder: EncoderFields, edge: int, increments: int, position: float) -> None:
    """Latch a touch probe: `edge` is its unit, 0 based, or TOUCH_PROBES more for a falling one."""
    encoder.probe_valid[edge] = 1
    encoder.probe_position[edge] = position
    encoder.probe_counter[edge] += 1
    encoder.probe_active[edge] = encoder.probe_continuous[edge]
    encoder.latch_valid = 1
    hardware = ((increments + 0x8000_0000) & 0xFFFF_FFFF) - 0x8000_0000
    encoder.latch_hardware_increment_difference = hardware - encoder.latch_hardware_increments
    encoder.latch_software_increment_difference = increments - encoder.latch_software_increments
    encoder.latch_position_difference = position - encoder.latch_position
    encoder.latch_hardware_increments = hardware
    encoder.latch_software_increments = increments
    encoder.latch_position = position


def probe_inputs(ax: AxisFields) -> int:
    """Return the inputs of touch probes 1 and 2 in bits 0 and 1; bit 2, the set torque has
    reached the target of a torque command."""
    inputs = ax.drive.io.state8 & 0b11
    if ax.set_motion_phase == MotionPhase.TORQUE and ax.set_torque == ax.torque.target:
        inputs |= 0b100
    return inputs


def probe_status(encoder: EncoderFields) -> int:
    """States of the touch probes, a byte each as in object 60B9h of a drive.

    Bit 0 waits, bits 1 and 2 a rising and a falling edge are latched, bit 7 turns over with each
    edge of a probe that goes on.
    """
    status = 0
    if encoder.latch_active == 0 and encoder.latch_valid == 0:
        return status
    for rising in range(TOUCH_PROBES):
        falling = rising + TOUCH_PROBES
        state = encoder.probe_active[rising] | encoder.probe_active[falling]
        state |= encoder.probe_valid[rising] << 1 | encoder.probe_valid[falling] << 2
        if encoder.probe_continuous[rising] | encoder.probe_continuous[falling]:
            edges = encoder.probe_counter[rising] + encoder.probe_counter[falling]
            state |= (edges & 1) << 7
        status |= state << 8 * rising
    return status


def probe_counts(encoder: EncoderFields) -> int:
    """Edges of both kinds that the touch probes latched, a byte each."""
    counts = 0
    for rising in range(TOUCH_PROBES):
        edges = encoder.probe_counter[rising] + encoder.probe_counter[rising + TOUCH_PROBES]
        counts |= (edges & 0xFF) << 8 * rising
    return counts


def probe_state(encoder: EncoderFields, probe: int) -> int:
    """State of touch probe 0..3 as the hardware shows it."""
    io = encoder.io
    if probe == 0:
        return io.state5
    if probe == 1:
        return io.state6
    return io.state7 if probe == 2 else io.state8


def _probe_data(encoder: EncoderFields, probe: int) -> int:
    io = encoder.io
    if probe == 0:
        return io.data_in3
    if probe == 1:
        return io.data_in4
    return io.data_in5 if probe == 2 else io.data_in6


def _signal(source: int) -> int:
    """Return a signal as commanded to the hardware."""
    if source == SignalSource.ZERO_PULSE:
        return LATCH_INDEX
    return source if source < LATCH_INDEX else LATCH_DRIVE_DEFINED


def _sync_signal(encoder: EncoderFields) -> int:
    """Return the signal of the sync pulse in the hardware, 0 if the NC counts itself."""
    mode = encoder.reference_mode
    if mode == ReferenceMode.SOFTWARE_SYNC:
        return 0
    if mode == ReferenceMode.HARDWARE_SYNC:
        return 1 if encoder.external_sync_pulse else LATCH_INDEX
    if mode == ReferenceMode.HARDWARE_LATCH_1_RISING:
        return 1
    if mode == ReferenceMode.HARDWARE_LATCH_1_FALLING:
        return 1 | LATCH_FALLING
    if mode == ReferenceMode.HARDWARE_LATCH_1_FALLING_DRIVE:
        return LATCH_DRIVE_DEFINED | LATCH_FALLING
    return LATCH_DRIVE_DEFINED


def _probe_signals(encoder: EncoderFields, probe: int) -> int:
    control = 0
    if encoder.probe_active[probe]:
        control = _signal(encoder.probe_source[probe])
    if encoder.probe_active[probe + TOUCH_PROBES]:
        control |= _signal(encoder.probe_source[probe + TOUCH_PROBES]) << 4
    return control


def arm(ax: AxisFields, encoder: EncoderFields) -> None:
    """Tell the hardware what the latches wait for."""
    waits = encoder.in_use and ax.homing.latch == WAITS
    if encoder.latch_active == 0 and not waits and encoder.armed == 0:
        return
    io = encoder.io
    io.ctrl1 = _sync_signal(encoder) if waits else 0
    io.ctrl5 = _probe_signals(encoder, 0)
    io.ctrl6 = _probe_signals(encoder, 1)
    io.ctrl7 = _probe_signals(encoder, 2)
    io.ctrl8 = _probe_signals(encoder, 3)
    io.fresh = 1
    encoder.armed = 1 if io.ctrl1 | io.ctrl5 | io.ctrl6 | io.ctrl7 | io.ctrl8 else 0


def arm_in_force(ax: AxisFields) -> None:
    """Arm the latches of the encoder that the axis works with, and clear the bits of idle ones."""
    encoder = ax.encoder
    arm(ax, encoder)
    if encoder.latch_active or encoder.latch_valid or encoder.armed:
        ax.features |= Feature.LATCH
    else:
        ax.features &= ~Feature.LATCH
    if ax.homing.state == 0 and ax.homing.latch == 0:
        ax.features &= ~Feature.HOMING


def begin_watch(ax: AxisFields, encoder: EncoderFields) -> None:
    """Wait for a sync pulse: from here on pulses count."""
    ax.homing.latch = WAITS
    encoder.homing_seen = encoder.io.state1
    encoder.watched_count = encoder.software_increments


def _software_pulse(encoder: EncoderFields) -> int:
    """Return the first multiple of the sub mask plus 1 on the way of this cycle, else where it
    began."""
    turn = encoder.sub_mask + 1
    before = encoder.watched_count
    now = encoder.software_increments
    if now > before:
        count = (before // turn + 1) * turn
        return count if count <= now else before
    count = (-(-before // turn) - 1) * turn
    return count if count >= now else before


def _watch_homing(ax: AxisFields, encoder: EncoderFields) -> None:
    increments = encoder.watched_count
    if encoder.reference_mode == ReferenceMode.SOFTWARE_SYNC:
        increments = _software_pulse(encoder)
        if increments == encoder.watched_count:
            encoder.watched_count = encoder.software_increments
            return
    else:
        state = encoder.io.state1
        if (state ^ encoder.homing_seen) & _TURNED == 0:
            return
        encoder.homing_seen = state
        increments = _increments(encoder, encoder.io.data_in2)
    ax.homing.latch = LATCHED
    ax.homing.latch_position = _position(encoder, increments)
    encoder.latch_activation_difference = ax.homing.latch_position - ax.homing.latch_begin


def watch(ax: AxisFields, encoder: EncoderFields) -> None:
    """Take what the hardware latched since the cycle before."""
    if encoder.latch_active:
        active = 0
        for edge in range(PROBE_EDGES):
            if encoder.probe_active[edge]:
                falling = edge >= TOUCH_PROBES
                probe = edge - TOUCH_PROBES if falling else edge
                turned = probe_state(encoder, probe) ^ encoder.probe_seen[probe]
                if turned & (_TURNED << 1 if falling else _TURNED):
                    counts = _probe_data(encoder, probe)
                    increments = _increments(
                        encoder, counts >> 32 if falling else counts & _FULL_MASK
                    )
                    latch_probe(encoder, edge, increments, _position(encoder, increments))
                active |= encoder.probe_active[edge]
        for probe in range(TOUCH_PROBES):
            encoder.probe_seen[probe] = probe_state(encoder, probe)
        encoder.latch_active = active
    if encoder.in_use and ax.homing.latch == WAITS:
        _watch_homing(ax, encoder)
