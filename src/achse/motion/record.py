"""The axis record: every value of one NC axis, declared once.

`AxisFields` is the table, put together from the parts in `achse.motion.fields`. From it come a
layout in memory (`LAYOUT`), a class with `__slots__` (`SlotsRecord`) and the static type of both.
All values are 64 bits wide, so that the kernel means the same on either form. A field
carries the name of the axis service row that shows it wherever such a row exists (002 §6.4.4;
encoder, controller and drive values with that prefix), so that a device binds rows to fields by
name.

Positions are in the axis unit (mm, degree), times in seconds, flags 0 or 1.
"""

from typing import TYPE_CHECKING

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
    DriveInterface,
    DriveInternal,
    DriveParameters,
    DriveState,
)
from achse.motion.fields.encoder import (
    POSITION_HISTORY,
    PROBE_EDGES,
    TOUCH_PROBES,
    EncoderMemory,
    EncoderParameters,
    EncoderState,
    TouchProbeMemory,
    TouchProbeState,
)
from achse.motion.fields.functions import FunctionInput
from achse.motion.fields.generators import GeneratorMemory, GeneratorSwitch
from achse.motion.fields.hardware import HardwareLinks
from achse.motion.fields.homing import HomingMemory
from achse.motion.fields.monitoring import MonitoringInternal
from achse.motion.fields.setpoint import (
    COMMAND_BUFFER,
    SEGMENTS,
    SetpointInternal,
    SetpointState,
)
from achse.motion.fields.superposition import (
    PhasingMemory,
    PhasingState,
    SuperpositionMemory,
)
from achse.native.declare import lay_out, pack, plain_record

__all__ = [
    "COMMAND_BUFFER",
    "DRIVE_DELAY",
    "FIELDS",
    "FILTER_ORDER",
    "LAYOUT",
    "POSITION_HISTORY",
    "PROBE_EDGES",
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
    DriveInterface,
    CyclicInput,
    FunctionInput,
    DriveInput,
    GeneratorSwitch,
    AxisState,
    SetpointState,
    EncoderState,
    ControllerState,
    DriveState,
    TouchProbeState,
    PhasingState,
    MonitoringInternal,
    SetpointInternal,
    GeneratorMemory,
    SuperpositionMemory,
    PhasingMemory,
    EncoderMemory,
    TouchProbeMemory,
    HomingMemory,
    ControllerMemory,
    DriveInternal,
    HardwareLinks,
):
    """All fields of an axis, in the order of the record."""


_ROLES: dict[type, Role] = {
    Parameters: Role.PARAMETER,
    Inputs: Role.INPUT,
    States: Role.STATE,
    Memory: Role.INTERNAL,
}


LAYOUT = lay_out("axis record", AxisFields.__bases__, Field)
"""One record in memory."""

FIELDS = {name: row for name, row in LAYOUT.fields.items() if row.refers is None}
"""Every value by name, in record order."""

for _section in AxisFields.__bases__:
    for _name in _section.__annotations__:
        LAYOUT.fields[_name].role = _ROLES[_section.__bases__[0]]

if TYPE_CHECKING:

    class SlotsRecord(AxisFields):
        pass

else:
    SlotsRecord = plain_record(LAYOUT)


def pack_record(record: AxisFields) -> bytes:
    """The record's bytes, equal for both forms when every value is equal."""
    return pack(LAYOUT, record)
