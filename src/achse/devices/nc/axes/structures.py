"""The cyclic axis interface: each member of both structures once, with what it shows of the axis.

From one table come the structures as IEC types, for symbols and for programs that look into them,
and the layouts that services send. Names of the members as in the PLC library (004 §5.1) and its
successor; the structure of TwinCAT 2 is packed, has fewer members and two of them elsewhere.
"""

import types
from collections.abc import Sequence
from typing import Any

from achse.codes.nc.structures import FROM_PLC, TO_PLC, TO_PLC_TC2, StructureMember
from achse.devices.nc.layouts import AxisStructure, fields_of
from achse.iec import (
    ARRAY,
    BOOL,
    BYTE,
    DINT,
    DWORD,
    LREAL,
    UDINT,
    UINT,
    USINT,
    Struct,
    var,
)

_TYPES: dict[str, Any] = {
    "BOOL": BOOL, "BYTE": BYTE, "USINT": USINT, "UINT": UINT, "DWORD": DWORD, "UDINT": UDINT,
    "DINT": DINT, "LREAL": LREAL,
}  # fmt: skip


def _type(member: StructureMember) -> Any:
    type = _TYPES[member.type]
    return ARRAY(type, (0, member.elements - 1)) if member.elements > 1 else type


def _declared(name: str, members: Sequence[StructureMember], doc: str) -> type[Struct]:
    body = {member.name: var(_type(member)) for member in members}
    return types.new_class(
        name, (Struct,), exec_body=lambda space: space.update({"__doc__": doc} | body)
    )


NCTOPLC_AXIS_REF = _declared("NCTOPLC_AXIS_REF", TO_PLC, "What the NC shows the PLC, 256 bytes.")
PLCTONC_AXIS_REF = _declared("PLCTONC_AXIS_REF", FROM_PLC, "What the PLC gives the NC, 128 bytes.")

NC_TO_PLC_TC2 = AxisStructure("NCTOPLC_AXIS_REF", fields_of(TO_PLC_TC2), aligned=False, size=128)
NC_TO_PLC_TC3 = AxisStructure("NCTOPLC_AXIS_REF", fields_of(TO_PLC), aligned=True, size=256)
PLC_TO_NC = AxisStructure("PLCTONC_AXIS_REF", fields_of(FROM_PLC), aligned=True, size=128)
