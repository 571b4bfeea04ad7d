"""Binding of rows to behaviour: `codes.nc` says what a service is, a device what it does.

The value of most rows is the field of the axis record with the row's name (encoder, controller and
drive rows: with that prefix first). A row that names no field is an error when the module is
imported.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from enum import IntEnum
from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.axis import ControlBit
from achse.codes.nc.row import NcRow
from achse.devices.nc.layouts import REAL64, Integer, codec_of, codecs_of
from achse.motion import Axis
from achse.motion.parts import AxisPart
from achse.motion.record import FIELDS, PART_OF
from achse.native.memory import Cell
from achse.server import READ, READ_WRITE, WRITE, Codec, Service


def _field(name: str, prefix: str) -> str:
    for field in (prefix + name, name):
        if field in FIELDS:
            return field
    raise ValueError(f"service {name!r} refers to nothing: the axis record has no such field")


_ACCESS = {"R": READ, "W": WRITE, "R W": READ | WRITE, "R&W": READ_WRITE}


def bound(
    row: NcRow,
    *,
    codec: Codec | tuple[Codec, ...] | None = None,
    response: Codec | tuple[Codec, ...] | None = None,
    choices: type[IntEnum] | None = None,
    **behaviour: Any,
) -> Service:
    """Return a row of the table with its behaviour: `field`, `read`, `write`, `exchange`, `guard`,
    …

    `codec` and `response` are for layouts that the row's text cannot say, `choices` for
    enumerations of other rooms.
    """
    if row.answer:
        behaviour["response"] = response or codecs_of(row.answers)
    return Service(
        row.offset,
        row.name,
        _ACCESS[row.access],
        codec or codecs_of(row.layouts),
        row.meaning,
        row.unit,
        minimum=row.least,
        maximum=row.most,
        choices=choices or row.choices,
        count=row.offsets,
        symbol=row.symbol,
        source=row.source,
        **behaviour,
    )


def shown(row: NcRow, field: str = "", *, prefix: str = "") -> Service:
    """Return the service that shows a record field, that of the row's name if none is given."""
    field = _field(field or row.name, prefix)
    return bound(row, field=field, sample=_sample(field, codec_of(row.layout)))


Place = Callable[[Axis | AxisPart, int], Cell | None]
"""Finder of the place of so many bytes of a value; None where only a function reads it."""


def _sample(name: str, codec: Codec) -> Place | None:
    """Finds the place of a value in its record, if it is there as it is shown."""
    row = FIELDS[name]
    if row.length or not (codec is REAL64 if row.is_real else isinstance(codec, Integer)):
        return None
    return lambda axis, length: axis.place_of(name, min(length, codec.size or 0))


def sample_of_floats(*names: str) -> Place | None:
    """Return the same of fields that are shown one behind the other as REAL64."""
    fields = [PART_OF[name] for name in names]
    part, first = fields[0]
    for n, (other, row) in enumerate(fields):
        if other != part or not row.is_real or row.offset != first.offset + n:
            return None
    return lambda axis, length: axis.place_of(names[0], min(length, 8 * len(fields)))


def parameter(
    row: NcRow,
    error: int,
    field: str = "",
    *,
    prefix: str = "",
    guard: Callable[[Any], None] | None = None,
    write: Callable[[Any, Any], None] | None = None,
) -> Service:
    """Return the service that shows and sets a record field; a value out of range is answered
    `error`.

    `write` sets the value where more than the field depends on it, or refuses it with a
    DeviceError.
    """
    field = _field(field or row.name, prefix)
    where: dict[str, Any] = {"field": field}
    if write is not None:
        where = {"read": attrgetter(field), "write": write}
    sample = _sample(field, codec_of(row.layout))
    return bound(row, code=error, guard=guard, sample=sample, **where)


def error_state(row: NcRow, first: int) -> Service:
    """Return the error of an encoder, controller or drive: the axis error if it is from `first`
    on."""

    def read(element: Axis | AxisPart) -> int:
        code = element.owner.error_code
        return code if first <= code <= first + 0xFF else 0

    return bound(row, read=read)


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


def at_axis(prefix: str, rows: Iterable[NcRow], services: Iterable[Service]) -> Iterator[Service]:
    """Services of an encoder, controller or drive as the rows of the axis show them."""
    base, element = _SUB_RANGES[prefix]
    served = {(service.offset, READ_WRITE in service.access): service for service in services}
    for row in rows:
        if row.offset & ~0xFFFF == base:
            service = served.get((row.offset - base, row.access == "R&W"))
            if service is not None:
                access = _ACCESS[row.access]
                yield replace(
                    service,
                    offset=row.offset,
                    name=row.name,
                    element=element,
                    access=access,
                    write=service.write if WRITE in access else None,
                )
