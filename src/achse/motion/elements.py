"""Control loops: which of its encoders, controllers and drives an axis works with.

The kernel works on the record of the axis alone. So another loop becomes active by exchanging the
fields of its encoder, controller and drive with those of the axis record.
"""

from collections.abc import Iterable

from achse.motion.axis import Axis
from achse.motion.fields.controller import ControllerMemory, ControllerParameters, ControllerState
from achse.motion.fields.drive import DriveInternal, DriveParameters, DriveState
from achse.motion.fields.encoder import (
    EncoderMemory,
    EncoderParameters,
    EncoderState,
    TouchProbeMemory,
    TouchProbeState,
)
from achse.motion.record import FIELDS

__all__ = ["control_loop_count", "exchange_control_loop"]


def _fields(*sections: type) -> tuple[str, ...]:
    return tuple(name for section in sections for name in section.__annotations__)


_PARTS = (
    (
        "encoders",
        (
            *_fields(
                EncoderParameters,
                EncoderState,
                TouchProbeState,
                EncoderMemory,
                TouchProbeMemory,
            ),
            "homed",
        ),
    ),
    ("controllers", _fields(ControllerParameters, ControllerState, ControllerMemory)),
    ("drives", _fields(DriveParameters, DriveState, DriveInternal)),
)
"""Attribute of the axis with the elements of a part, and the fields of the part."""


def control_loop_count(axis: Axis) -> int:
    """Loops of the axis: as many as the part has that it has most of."""
    return len(axis.records)


def exchange_control_loop(axis: Axis, loop: int) -> None:
    """Make encoder, controller and drive number `loop` the active ones; as many as there are.

    Parts of which there are fewer stay. Where the axis stands then is what its new encoder says;
    the set position is left to the caller. IndexError if there is no such loop.
    """
    if not 0 <= loop < control_loop_count(axis):
        raise IndexError(f"control loop {loop}, expected 0..{control_loop_count(axis) - 1}")
    for part, names in _PARTS:
        elements: list[Axis] = getattr(axis, part)
        if loop >= len(elements):
            continue
        other = elements[loop]
        if other is axis:
            continue
        _exchange(axis, other, names)
        if part == "encoders":
            axis.sensor, other.sensor = other.sensor, axis.sensor
        elif part == "drives":
            other.drive_io.ctrl1 = axis.drive_io.ctrl1 = 0
            axis.amplifier, other.amplifier = other.amplifier, axis.amplifier
            axis.machine.driver = axis.amplifier.number
        for each in (axis, other):
            each.link("encoder_io", each.sensor.io)
            each.link("drive_io", each.amplifier.io)
        elements[elements.index(axis)], elements[loop] = other, axis
    axis.active_control_loop = loop


def _exchange(axis: Axis, other: Axis, names: Iterable[str]) -> None:
    for name in names:
        if FIELDS[name].length:
            mine, theirs = getattr(axis, name), getattr(other, name)
            for i, value in enumerate(list(mine)):
                mine[i], theirs[i] = theirs[i], value
        else:
            value = getattr(axis, name)
            setattr(axis, name, getattr(other, name))
            setattr(other, name, value)
    for record in (axis, other):
        record.adapt = 1
        record.resting = 0
