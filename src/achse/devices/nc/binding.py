"""How NC rows refer to the axis record: by the name of the service.

A row's value lives in the record field of the same name; rows of an encoder, controller or drive
look for the name with that prefix first. A row whose field does not exist is an error when the
table is built.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from enum import IntEnum

from achse.ams import DeviceError
from achse.codes import NcError
from achse.motion import Axis
from achse.motion.record import FIELDS
from achse.motion.states import ControlBit
from achse.server import READ, WRITE, Codec, Service

__all__ = ["in_sub_range", "not_while_enabled", "parameter", "per_element", "shown"]

Element = Callable[[Axis, int], Axis]


def _field(name: str, prefix: str) -> str:
    for field in (prefix + name, name):
        if field in FIELDS:
            return field
    raise ValueError(f"service {name!r} refers to nothing: the axis record has no such field")


def shown(
    offset: int,
    name: str,
    codec: Codec,
    unit: str,
    description: str,
    *,
    prefix: str = "",
    field: str = "",
    symbol: str = "",
) -> Service:
    """A row that shows a record field."""
    return Service(
        offset,
        name,
        READ,
        codec,
        description,
        unit,
        field=field or _field(name, prefix),
        symbol=symbol,
    )


def parameter(
    offset: int,
    name: str,
    codec: Codec,
    unit: str,
    description: str,
    error: NcError,
    minimum: float | None = None,
    maximum: float | None = None,
    *,
    prefix: str = "",
    choices: type[IntEnum] | None = None,
    guard: Callable[[Axis], None] | None = None,
) -> Service:
    """A row that shows and sets a record field; a value out of range is answered `error`."""
    return Service(
        offset,
        name,
        READ | WRITE,
        codec,
        description,
        unit,
        field=_field(name, prefix),
        minimum=minimum,
        maximum=maximum,
        choices=choices,
        code=error.number,
        guard=guard,
    )


def not_while_enabled(axis: Axis) -> None:
    """Guard of parameters that scale position or direction (002: not while enabled).

    The manuals do not print the code; 0x4B42 says it.
    """
    if axis.control_dword & ControlBit.ENABLE:
        raise DeviceError(NcError.PLC_AXIS_ENABLED.number, f"axis {axis.axis_id}")


def _only_standard(error: NcError) -> Element:
    def element(axis: Axis, n: int) -> Axis:
        if n:
            raise DeviceError(error.number, f"axis {axis.axis_id} has no sub-element {n}")
        return axis

    return element


_SUB_RANGES = {
    "": (0, _only_standard(NcError.AXIS_ID)),
    "encoder_": (0x1_0000, _only_standard(NcError.ENCODER_ID)),
    "controller_": (0x2_0000, _only_standard(NcError.CONTROLLER_ID)),
    "drive_": (0x3_0000, _only_standard(NcError.DRIVE_ID)),
}


def per_element(rows: Iterable[Service]) -> Iterator[Service]:
    """`rows` at 0x00n0_0000 + offset; the standard element n = 0 is the axis itself."""
    for row in rows:
        yield replace(row, element=_SUB_RANGES[""][1])


def in_sub_range(prefix: str, rows: Iterable[Service]) -> Iterator[Service]:
    """Rows of an encoder, controller or drive as the axis shows them: 0x00nK_0000 + offset."""
    base, element = _SUB_RANGES[prefix]
    for row in rows:
        name = row.name if row.name.startswith(prefix) else prefix + row.name
        yield replace(row, offset=base + row.offset, name=name, element=element)
