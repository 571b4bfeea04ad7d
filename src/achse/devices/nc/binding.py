"""How NC rows refer to the axis record: by the name of the service.

A row's value lives in the record field of the same name (encoder, controller and drive rows: with
that prefix first), and the field tells unit, range and meaning. So a row is one line: offset, type,
for parameters the NC error of a value out of range, name. A row that names no field is an error
when the module is imported.
"""

from collections.abc import Callable, Container, Iterable, Iterator
from dataclasses import replace
from math import isfinite
from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.layouts import INT32, REAL64, Integer
from achse.motion import Axis
from achse.motion.parts import AxisPart
from achse.motion.record import FIELDS, PART_OF, Field
from achse.motion.states import ControlBit, choices_of
from achse.native.memory import ComputedCell, MemoryCell
from achse.server import READ, WRITE, Codec, Service

__all__ = [
    "error_state",
    "in_sub_range",
    "not_while_enabled",
    "parameter",
    "per_element",
    "per_encoder",
    "sample_of_reals",
    "shown",
]


Place = Callable[[Axis | AxisPart, int], MemoryCell | ComputedCell | None]
"""Finds where so many bytes of a value lie; None where only a function reads it."""


def _field(name: str, prefix: str) -> str:
    for field in (prefix + name, name):
        if field in FIELDS:
            return field
    raise ValueError(f"service {name!r} refers to nothing: the axis record has no such field")


def _unit(row: Field) -> str:
    """The physical unit; flags, bits and enumerations have none."""
    return "1" if row.unit in ("0/1", "bits", "NcError") or choices_of(row.unit) else row.unit


def shown(
    offset: int, codec: Codec, name: str, field: str = "", *, prefix: str = "", symbol: str = ""
) -> Service:
    """A row that shows a record field."""
    field = _field(field or name, prefix)
    row = FIELDS[field]
    return Service(
        *(offset, name, READ, codec, row.doc, _unit(row)),
        field=field,
        choices=choices_of(row.unit),
        symbol=symbol,
        sample=_sample(field, codec),
    )


def _sample(name: str, codec: Codec) -> Place | None:
    """Finds the place of a value in its record, if it is there as it is shown."""
    row = FIELDS[name]
    if row.length or not (codec is REAL64 if row.is_real else isinstance(codec, Integer)):
        return None
    return lambda axis, length: axis.place_of(name, min(length, codec.size or 0))


def sample_of_reals(
    *names: str,
) -> Place | None:
    """The same of fields that are shown one behind the other as REAL64."""
    found = [PART_OF[name] for name in names]
    part, first = found[0]
    for n, (other, row) in enumerate(found):
        if other != part or not row.is_real or row.offset != first.offset + n:
            return None
    return lambda axis, length: axis.place_of(names[0], min(length, 8 * len(found)))


def parameter(
    offset: int,
    codec: Codec,
    error: int,
    name: str,
    field: str = "",
    *,
    prefix: str = "",
    guard: Callable[[Any], None] | None = None,
    write: Callable[[Any, Any], None] | None = None,
    **facts: Any,
) -> Service:
    """A row that shows and sets a record field; a value out of range is answered `error`.

    The record's range counts unless `minimum` or `maximum` say otherwise. `write` sets the value
    where more than the field depends on it, or refuses it with a DeviceError.
    """
    field = _field(field or name, prefix)
    row = FIELDS[field]
    limits: dict[str, Any] = {
        "minimum": row.least if isfinite(row.least) else None,
        "maximum": row.most if isfinite(row.most) else None,
    }
    if write is not None:
        limits |= {"field": "", "read": attrgetter(field), "write": write}
    return replace(
        shown(offset, codec, name, field),
        access=READ | WRITE,
        code=error,
        guard=guard,
        **limits | facts,
    )


def error_state(first: int, description: str) -> Service:
    """The row of the error of an encoder, controller or drive: the axis error if it is theirs."""

    def read(element: Axis | AxisPart) -> int:
        code = element.owner.error_code
        return code if first <= code <= first + 0xFF else 0

    return Service(0x01, "error_state", READ, INT32, description, "1", read=read)


def not_while_enabled(axis: Axis | AxisPart) -> None:
    """Guard of parameters that scale position or direction (002: not while enabled): 0x4257.

    The manuals do not print the code; 0x4B42, which says it, is one of the PLC library alone.
    """
    owner = axis.owner
    if owner.control_dword & ControlBit.ENABLE or owner.loop_closed:
        raise DeviceError(NcError.FUNCTION_NOT_ALLOWED.number, f"axis {axis.axis_id} is enabled")


def _only_standard(axis: Axis, n: int) -> Axis:
    if n:
        raise DeviceError(NcError.AXIS_ID.number, f"axis {axis.axis_id} has no sub-element {n}")
    return axis


def _element_of(parts: Callable[[Axis], list[AxisPart]], error: NcError) -> Callable[..., AxisPart]:
    def element(axis: Axis, n: int) -> AxisPart:
        own = parts(axis)
        if n >= len(own):
            raise DeviceError(error.number, f"axis {axis.axis_id} has no sub-element {n}")
        return own[n]

    return element


_SUB_RANGES: dict[str, tuple[int, Callable[[Axis, int], Axis | AxisPart]]] = {
    "": (0, _only_standard),
    "encoder_": (0x1_0000, _element_of(attrgetter("encoders"), NcError.ENCODER_ID)),
    "controller_": (0x2_0000, _element_of(attrgetter("controllers"), NcError.CONTROLLER_ID)),
    "drive_": (0x3_0000, _element_of(attrgetter("drives"), NcError.DRIVE_ID)),
}
"""Prefix of names, first offset, and what answers for sub-element n."""


def per_element(*rows: Service) -> Iterator[Service]:
    """`rows` at 0x00n0_0000 + offset; the standard element n = 0 is the axis itself."""
    for row in rows:
        yield replace(row, element=_SUB_RANGES[""][1])


def per_encoder(*rows: Service) -> Iterator[Service]:
    """`rows` at 0x00n0_0000 + offset, about encoder n of the axis."""
    for row in rows:
        yield replace(row, element=_SUB_RANGES["encoder_"][1])


def in_sub_range(
    prefix: str,
    rows: Iterable[Service],
    *,
    without: Container[int] = (),
    read_only: Container[int] = (),
) -> Iterator[Service]:
    """Rows of an encoder, controller or drive as the axis shows them: 0x00nK_0000 + offset.

    The axis does not show all of them, and some for reading only.
    """
    base, element = _SUB_RANGES[prefix]
    for row in rows:
        if row.offset in without:
            continue
        name = row.name if row.name.startswith(prefix) else prefix + row.name
        access = READ if row.offset in read_only else row.access
        write = None if row.offset in read_only else row.write
        yield replace(
            row, offset=base + row.offset, name=name, element=element, access=access, write=write
        )
