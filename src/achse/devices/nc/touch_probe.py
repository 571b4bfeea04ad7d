"""Touch probe services of an encoder, 0x5100 + ID, 0x101 and 0x200 … 0x213. Source: 002 §6.4.5.2.

A row about one probe is answered for probe 1, or as four values when so many bytes are asked for
(CANopen drives have up to four).
"""

from collections.abc import Callable, Sequence
from functools import partial
from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc import binding
from achse.devices.nc.layouts import REAL64, UINT16, UINT32, UINT64, OfAxis
from achse.motion.parts import AxisEncoder
from achse.motion.record import TOUCH_PROBES
from achse.server import READ, READ_WRITE, Layout, Service

__all__ = ["TOUCH_PROBE"]

shown = partial(binding.shown, prefix="encoder_")


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


def _flags(
    offset: int, name: str, four: str, read: Callable[[AxisEncoder], Any], doc: str
) -> Service:
    return Service(
        offset,
        name,
        READ,
        (OfAxis(UINT16, lambda encoder: int(any(read(encoder)))), OfAxis(Layout(four), read)),
        doc,
        "1",
        read=lambda encoder: encoder,
    )


TOUCH_PROBE = (
    shown(0x101, REAL64, "latch_activation_difference"),
    Service(
        0x200,
        "touch_probe_state",
        READ_WRITE,
        Layout("<I20x"),
        "state of touch probe 1..4: both edges",
        exchange=_state,
        response=Layout("<IIdI4xIIdI20x"),
    ),
    _flags(
        0x201,
        "latch_active",
        "<4I",
        lambda encoder: _either(encoder.probe_active),
        "an external latch is active",
    ),
    _flags(
        0x202,
        "latch_valid",
        "<4I",
        lambda encoder: _either(encoder.probe_valid),
        "an external latch value has become valid",
    ),
    shown(0x203, UINT32, "latch_hardware_increments"),
    shown(0x204, UINT64, "latch_software_increments"),
    Service(
        0x205,
        "latch_position",
        READ,
        (
            OfAxis(REAL64, attrgetter("latch_position")),
            OfAxis(Layout("<4d"), _positions),
        ),
        "latched position, or those of four probes",
        "mm",
        read=lambda encoder: encoder,
    ),
    shown(0x206, UINT32, "latch_hardware_increment_difference"),
    shown(0x207, UINT64, "latch_software_increment_difference"),
    shown(0x208, REAL64, "latch_position_difference"),
    _flags(
        0x210,
        "latch_rising_edge_active",
        "<4H",
        lambda encoder: encoder.probe_active[:TOUCH_PROBES],
        "an external latch waits for a rising edge",
    ),
    _flags(
        0x211,
        "latch_falling_edge_active",
        "<4H",
        lambda encoder: encoder.probe_active[TOUCH_PROBES:],
        "an external latch waits for a falling edge",
    ),
    Service(
        0x212, "touch_probe1_input_state", READ, UINT16, "input of touch probe 1", "1",
        read=_input(1),
    ),
    Service(
        0x213, "touch_probe2_input_state", READ, UINT16, "input of touch probe 2", "1",
        read=_input(2),
    ),
)  # fmt: skip
"""Digital inputs 1 and 2 of the drive are the inputs of touch probe 1 and 2."""
