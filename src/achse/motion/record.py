"""The axis record: every value of one NC axis, declared once.

`AxisFields` is the table, put together from the parts in `achse.motion.fields`. From it come a
layout in memory (`LAYOUT`), a class with `__slots__` (`SlotsRecord`) and the static type of both.
All values are 64 bits wide, so that the kernel means the same on either form. A field
carries the name of the axis service row that shows it wherever such a row exists (002 §6.4.4;
encoder, controller and drive values with that prefix), so that a device binds rows to fields by
name.

Positions are in the axis unit (mm, degree), times in seconds, flags 0 or 1.
"""

import struct
from collections.abc import Iterable
from typing import TYPE_CHECKING

from achse.kernel.kinds import Layout
from achse.motion.fields.axis import AxisParameters, AxisState
from achse.motion.fields.controller import (
    ControllerMemory,
    ControllerParameters,
    ControllerState,
)
from achse.motion.fields.cyclic import CyclicInput
from achse.motion.fields.declare import Field, Inputs, Memory, Parameters, Role, States
from achse.motion.fields.drive import (
    DRIVE_DELAY,
    FILTER_ORDER,
    DriveInput,
    DriveInternal,
    DriveParameters,
    DriveState,
    SimulationParameters,
)
from achse.motion.fields.encoder import (
    POSITION_HISTORY,
    TOUCH_PROBES,
    EncoderMemory,
    EncoderParameters,
    EncoderState,
    TouchProbeState,
)
from achse.motion.fields.functions import FunctionInput
from achse.motion.fields.monitoring import MonitoringInternal
from achse.motion.fields.setpoint import (
    COMMAND_BUFFER,
    SEGMENTS,
    SetpointInternal,
    SetpointState,
)

__all__ = [
    "COMMAND_BUFFER",
    "DRIVE_DELAY",
    "FIELDS",
    "FILTER_ORDER",
    "LAYOUT",
    "POSITION_HISTORY",
    "RECORD_SIZE",
    "SEGMENTS",
    "TOUCH_PROBES",
    "AxisFields",
    "Field",
    "Role",
    "SlotsRecord",
    "pack_record",
]


class AxisFields(
    AxisParameters,
    EncoderParameters,
    ControllerParameters,
    DriveParameters,
    SimulationParameters,
    CyclicInput,
    FunctionInput,
    DriveInput,
    AxisState,
    SetpointState,
    EncoderState,
    ControllerState,
    DriveState,
    TouchProbeState,
    MonitoringInternal,
    SetpointInternal,
    EncoderMemory,
    ControllerMemory,
    DriveInternal,
):
    """All fields of an axis, in the order of the record."""


_ROLES: dict[type, Role] = {
    Parameters: Role.PARAMETER,
    Inputs: Role.INPUT,
    States: Role.STATE,
    Memory: Role.INTERNAL,
}


def _declared() -> dict[str, Field]:
    fields: dict[str, Field] = {}
    offset = 0
    for section in AxisFields.__bases__:
        (kind,) = section.__bases__
        for name in section.__annotations__:
            if name in fields:
                raise TypeError(f"field {name!r} is declared twice")
            row: Field = getattr(section, name)
            row.name, row.role, row.offset = name, _ROLES[kind], offset
            fields[name] = row
            offset += row.words
    return fields


FIELDS = _declared()
"""Every field by name, in record order."""

LAYOUT = Layout("axis record", FIELDS, sum(row.words for row in FIELDS.values()))
"""One record in memory."""

RECORD_SIZE = 8 * LAYOUT.words
"""Bytes of one record."""

_STRUCT = struct.Struct(
    "=" + "".join(f"{row.words}{'d' if row.is_real else 'q'}" for row in FIELDS.values())
)

if TYPE_CHECKING:

    class SlotsRecord(AxisFields):
        pass

else:

    class SlotsRecord:
        """One axis as a plain object: the record's form without NumPy."""

        __slots__ = tuple(FIELDS)

        def __init__(self) -> None:
            for name, row in FIELDS.items():
                setattr(self, name, [row.default] * row.length if row.length else row.default)


def pack_record(record: AxisFields) -> bytes:
    """The record's bytes, equal for both forms when every value is equal."""
    values: list[float] = []
    extend: Iterable[float]
    for name, row in FIELDS.items():
        value = getattr(record, name)
        extend = value if row.length else (value,)
        values.extend(extend)
    return _STRUCT.pack(*values)
