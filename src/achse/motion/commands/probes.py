"""Touch probes of an encoder: its external latches are made to wait, and let go."""

from achse.codes import NcError
from achse.codes.nc.choices import EncoderType, ReferenceMode
from achse.motion.axis import Axis
from achse.motion.checks import FARTHEST, OK
from achse.motion.control.signals import latch_probe, probe_state
from achse.motion.fields.encoder import PROBE_EDGES, TOUCH_PROBES
from achse.motion.parts import AxisEncoder
from achse.motion.states import ProbeMode, SignalSource

_HOMING_BY_INDEX = {ReferenceMode.HARDWARE_SYNC, ReferenceMode.SOFTWARE_SYNC}


def _edge(probe_unit: int, signal_edge: int) -> int | None:
    """Return the index of the latch of this edge, None if there is none."""
    if 1 <= probe_unit <= TOUCH_PROBES and signal_edge in (0, 1):
        return probe_unit - 1 + TOUCH_PROBES * signal_edge
    return None


def _count(encoder: AxisEncoder) -> None:
    """Show whether any latch waits, and whether any has latched."""
    encoder.latch_active = int(any(encoder.probe_active))
    encoder.latch_valid = int(any(encoder.probe_valid))
    encoder.owner.resting = 0


def _homing_holds_latch(encoder: AxisEncoder, edge: int) -> bool:
    """Unit 1 is the latch of a homing sequence, unless that goes by the index pulse."""
    return (
        edge % TOUCH_PROBES == 0
        and encoder.owner.homing.latch != 0
        and encoder.reference_mode not in _HOMING_BY_INDEX
    )


def _activate(encoder: AxisEncoder, edge: int, continuous: bool, source: int) -> None:
    probe = edge % TOUCH_PROBES
    encoder.probe_seen[probe] = probe_state(encoder, probe)
    encoder.probe_active[edge] = 1
    encoder.probe_valid[edge] = 0
    encoder.probe_counter[edge] = 0
    encoder.probe_continuous[edge] = int(continuous)
    encoder.probe_source[edge] = source


def _check_activate(encoder: AxisEncoder, edge: int) -> int:
    if encoder.probe_active[edge]:
        return NcError.ENCODER_FUNCTION_ACTIVE
    if _homing_holds_latch(encoder, edge) or encoder.probe_refused >> edge & 1:
        return NcError.ENCODER_EXTERNAL_LATCH
    return OK


def activate_touch_probe(
    at: Axis | AxisEncoder, probe_unit: int, signal_edge: int, probe_mode: int, signal_source: int
) -> int:
    """Have touch probe 1..4 wait for an edge, once or on and on (0x200).

    Source 1..4 is an input, 128 the index pulse, 129 what the drive is set to; 0 is the input of
    the probe's own number.
    """
    encoder = at.encoder
    edge = _edge(probe_unit, signal_edge)
    if (
        edge is None
        or probe_mode not in ProbeMode.__members__.values()
        or signal_source not in SignalSource.__members__.values()
    ):
        return NcError.REQUEST_PARAMETER
    code = _check_activate(encoder, edge)
    if code:
        return code
    source = signal_source or probe_unit
    _activate(encoder, edge, probe_mode == ProbeMode.CONTINUOUS, source)
    _count(encoder)
    return OK


def deactivate_touch_probe(at: Axis | AxisEncoder, probe_unit: int, signal_edge: int) -> int:
    """Have touch probe 1..4 wait no longer, and forget that it latched (0x205)."""
    encoder = at.encoder
    edge = _edge(probe_unit, signal_edge)
    if edge is None:
        return NcError.REQUEST_PARAMETER
    encoder.probe_active[edge] = 0
    encoder.probe_valid[edge] = 0
    _count(encoder)
    return OK


def activate_latch(at: Axis | AxisEncoder, *chosen: int, falling: bool) -> int:
    """Have the latches that are `chosen` wait for one edge of their inputs (0x201, 0x202).

    There is a flag for each of four latches, or nothing for the first.
    """
    encoder = at.encoder
    edges = [unit + TOUCH_PROBES * falling for unit, flag in enumerate(chosen or (1,)) if flag]
    for edge in edges:
        code = _check_activate(encoder, edge)
        if code:
            return code
    for edge in edges:
        _activate(encoder, edge, False, edge % TOUCH_PROBES + 1)
    _count(encoder)
    return OK


def deactivate_latch(at: Axis | AxisEncoder, *chosen: int) -> int:
    """Have the latches that are `chosen` wait no longer (0x205); nothing means the first."""
    encoder = at.encoder
    for unit, flag in enumerate(chosen or (1,)):
        if flag:
            for edge in range(unit, PROBE_EDGES, TOUCH_PROBES):
                encoder.probe_active[edge] = 0
                encoder.probe_valid[edge] = 0
    _count(encoder)
    return OK


def set_latch_event(at: Axis | AxisEncoder, position: float) -> int:
    """Let the first latch, which waits, latch this position (0x210); simulated encoders only."""
    encoder = at.encoder
    if encoder.type != EncoderType.SIMULATION:
        return NcError.ENCODER_FUNCTION_NOT_SUPPORTED
    if not abs(position) <= FARTHEST:
        return NcError.REQUEST_PARAMETER
    edges = [e for e in range(0, PROBE_EDGES, TOUCH_PROBES) if encoder.probe_active[e]]
    if not edges:
        return NcError.ENCODER_EXTERNAL_LATCH
    offset = encoder.position_offset + encoder.set_position_offset
    offset += encoder.position_correction
    for edge in edges:
        latch_probe(encoder, edge, round((position - offset) / encoder.scale), position)
    _count(encoder)
    return OK
