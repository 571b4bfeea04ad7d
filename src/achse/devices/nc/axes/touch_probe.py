"""Touch probe services of an encoder, 0x5100 + ID, 0x101 and 0x200 … 0x213. Source: 002 §6.4.5.2.

A row about one probe is answered for probe 1, or as four values when so many bytes are requested
(CANopen drives have up to four).
"""

from collections.abc import Callable, Sequence
from functools import partial
from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows
from achse.devices.nc import rows
from achse.devices.nc.layouts import REAL64, OfAxis, codec_of
from achse.devices.nc.rows import bound
from achse.motion.fields.encoder import TOUCH_PROBES
from achse.motion.parts import AxisEncoder
from achse.server import Layout, Service

_ROWS = named_rows(0x5100)

shown = partial(rows.shown, prefix="encoder_")


def _state(encoder: AxisEncoder, unit: int) -> tuple[float, ...]:
    if not 1 <= unit <= TOUCH_PROBES:
        raise DeviceError(
            NcError.REQUEST_PARAMETER.number, f"touch probe {unit}, expected 1..{TOUCH_PROBES}"
        )
    return tuple(
        values[edge]
        for edge in (unit - 1, unit - 1 + TOUCH_PROBES)
        for values in (
            encoder.probe_active,
            encoder.probe_valid,
            encoder.probe_position,
            encoder.probe_counter,
        )
    )


def _either(flags: Sequence[int]) -> list[int]:
    return [flags[unit] | flags[unit + TOUCH_PROBES] for unit in range(TOUCH_PROBES)]


def _positions(encoder: AxisEncoder) -> list[float]:
    """Of the falling edge where that alone is valid, else of the rising one."""
    valid, position = encoder.probe_valid, encoder.probe_position
    return [
        position[unit + TOUCH_PROBES if valid[unit + TOUCH_PROBES] and not valid[unit] else unit]
        for unit in range(TOUCH_PROBES)
    ]


def _input(number: int) -> Callable[[AxisEncoder], int]:
    return lambda encoder: encoder.owner.drive.io.state8 >> (number - 1) & 1


def _flags(row: NcRow, read: Callable[[AxisEncoder], Any]) -> Service:
    of_first, of_four = row.layouts
    return bound(
        row,
        codec=(
            OfAxis(codec_of(of_first), lambda encoder: int(any(read(encoder)))),
            OfAxis(codec_of(of_four), read),
        ),
        read=lambda encoder: encoder,
    )


TOUCH_PROBE = (
    shown(_ROWS["latch_activation_difference"]),
    bound(_ROWS["touch_probe_state"], exchange=_state),
    _flags(_ROWS["latch_active"], lambda encoder: _either(encoder.probe_active)),
    _flags(_ROWS["latch_valid"], lambda encoder: _either(encoder.probe_valid)),
    shown(_ROWS["latch_hardware_increments"]),
    shown(_ROWS["latch_software_increments"]),
    bound(
        _ROWS["latch_position"],
        codec=(
            OfAxis(REAL64, attrgetter("latch_position")),
            OfAxis(Layout("<4d"), _positions),
        ),
        read=lambda encoder: encoder,
    ),
    shown(_ROWS["latch_hardware_increment_difference"]),
    shown(_ROWS["latch_software_increment_difference"]),
    shown(_ROWS["latch_position_difference"]),
    _flags(_ROWS["latch_rising_edge_active"], lambda encoder: encoder.probe_active[:TOUCH_PROBES]),
    _flags(_ROWS["latch_falling_edge_active"], lambda encoder: encoder.probe_active[TOUCH_PROBES:]),
    bound(_ROWS["touch_probe1_input_state"], read=_input(1)),
    bound(_ROWS["touch_probe2_input_state"], read=_input(2)),
)
"""Digital inputs 1 and 2 of the drive are the inputs of touch probe 1 and 2."""
