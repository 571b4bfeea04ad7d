"""The symbols of an NC: `Axes.<axis>.SetPos` and others, found by walking the service rows.

A row with a `symbol` makes one symbol per axis; `ToPlc` and `FromPlc` are the cyclic interface as
structures, whose members are symbols too. Clients know `Axes.Axis 1.ToPlc` of port 501.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.nc.axes.structures import (
    NC_TO_PLC_TC3,
    NCTOPLC_AXIS_REF,
    PLC_TO_NC,
    PLCTONC_AXIS_REF,
)
from achse.devices.value_symbols import ValueSymbol, ValueSymbols
from achse.iec import DINT, LREAL, UDINT, IecPathError, IecType, iec_type
from achse.iec.describe import types_shown
from achse.iec.names import ELEMENTARY
from achse.iec.paths import follow, format_path, parse_path, split_symbol
from achse.motion import Axis, Nc
from achse.motion.groups.group import AxisGroup
from achse.server import READ, WRITE, AreaGroup, Service

CYCLIC = 0x4300
TO_PLC = 0x80
GROUP_STATE = 0x3100
FROM_PLC = 0x00

_MEMBERS = 0x0100_4300
"""Index group + axis id where single members of the cyclic structures have an address: those to the
PLC from offset 0 on, those from the PLC from 0x1000 on. The manuals give them none."""

_FROM_PLC_MEMBERS = 0x1000

_TYPES: dict[str, IecType[Any]] = {"REAL64": LREAL, "UINT32": UDINT, "INT32": DINT}
_TASK = 1


def _to_plc(axis: Axis) -> Callable[[], bytes]:
    return lambda: NC_TO_PLC_TC3.encode(axis)


def _from_plc(axis: Axis) -> Callable[[], bytes]:
    return lambda: PLC_TO_NC.encode(axis)


def _write_from_plc(row: Service, axis: Axis, start: int = 0) -> Callable[[bytes], None]:
    """Set bytes of the structure from the PLC; the row checks the whole of it."""

    def write(data: bytes) -> None:
        whole = bytearray(PLC_TO_NC.encode(axis))
        if start + len(data) > len(whole):
            raise DeviceError(ReturnCode.INVALID_SIZE, f"{len(data)} bytes from {start}")
        whole[start : start + len(data)] = data
        row.set(axis, row.decode(bytes(whole)))

    return write


def _reader(row: Service, group: AxisGroup) -> Callable[[], bytes]:
    encode, get = row.encoder(0), row.get
    return lambda: encode(get(group))


def _row_access(
    row: Service, axis: Axis
) -> tuple[Callable[[], bytes], Callable[[bytes], None] | None]:
    encode, get, element = row.encoder(0), row.get, row.element

    def read() -> bytes:
        return encode(get(axis if element is None else element(axis, 0)))

    def write(data: bytes) -> None:
        row.set(axis, row.decode(data))

    return read, write if WRITE in row.access else None


def interface_groups(nc: Nc, from_plc: Service) -> Iterator[AreaGroup]:
    """Yield the addresses of the members of the cyclic structures, one group per axis."""
    for axis in nc:
        yield _interface_group(axis, from_plc)


def _interface_group(axis: Axis, from_plc: Service) -> AreaGroup:
    def part(offset: int, length: int) -> tuple[bytes, int]:
        if offset < _FROM_PLC_MEMBERS:
            return NC_TO_PLC_TC3.encode(axis), offset
        return PLC_TO_NC.encode(axis), offset - _FROM_PLC_MEMBERS

    def read(offset: int, length: int) -> bytes:
        whole, start = part(offset, length)
        if start >= len(whole):
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{offset:X}")
        return whole[start : start + length]

    def write(offset: int, data: bytes) -> None:
        if offset < _FROM_PLC_MEMBERS:
            raise DeviceError(ReturnCode.INVALID_ACCESS, "what the NC shows cannot be written")
        _write_from_plc(from_plc, axis, offset - _FROM_PLC_MEMBERS)(data)

    return AreaGroup(
        _MEMBERS + axis.axis_id,
        read,
        write,
        name=f"cyclic interface of axis {axis.axis_id}",
        description="bytes of the structures to the PLC, from 0x1000 on those from the PLC",
    )


class NcSymbols(ValueSymbols):
    """All symbols of one NC: those of its rows, per axis, and the cyclic structures.

    `groups` are (first index group, rows) of the axis; `from_plc` is the row of the structure from
    the PLC; `of_groups` are the states of groups of several axes, which
    have names like `Groups.<group>.SetPathVelo`. The names are made when they are first needed.
    """

    def __init__(
        self,
        nc: Nc,
        groups: tuple[tuple[int, tuple[Service, ...]], ...],
        from_plc: Service,
        of_groups: tuple[Service, ...] = (),
    ) -> None:
        self._nc = nc
        self._rows = [(base, row) for base, rows in groups for row in rows if row.symbol]
        self._from_plc = from_plc
        self._group_rows = [row for row in of_groups if row.symbol]

    def resolve(self, name: str) -> ValueSymbol | None:
        """`Axes.X.SetPos`, `Axes.X.ToPlc`, `Axes.X.ToPlc.ActPos`, … in any case."""
        try:
            root, rest = split_symbol(name, self._symbols)
            symbol = self._symbols[root]
            return self._member(symbol, rest) if rest else symbol
        except IecPathError:
            return None

    def _member(self, symbol: ValueSymbol, rest: str) -> ValueSymbol:
        steps = parse_path(rest)
        location = follow(symbol.type, steps)
        if location.bit is not None:
            raise IecPathError(f"single bits have no symbol: {rest}")
        axis = self._nc.axis(symbol.index_group - CYCLIC)
        first, size = location.offset, location.type.size
        whole = symbol.read
        incoming = symbol.index_offset == FROM_PLC
        return ValueSymbol(
            symbol.name + format_path(steps),
            location.type,
            (_MEMBERS + axis.axis_id, first + (_FROM_PLC_MEMBERS if incoming else 0)),
            lambda: whole()[first : first + size],
            _write_from_plc(self._from_plc, axis, first) if incoming else None,
        )

    def all_symbols(self) -> Iterator[ValueSymbol]:
        """Return the symbols of the axes, then the symbols of the groups."""
        for axis in self._nc:
            yield from self._of(axis)
        for group in self._nc.groups:
            yield from self._of_group(group)

    def used_types(self) -> Iterable[IecType[Any]]:
        """Return the cyclic structures with what is in them, and all elementary types."""
        structures: list[IecType[Any]] = [iec_type(NCTOPLC_AXIS_REF), iec_type(PLCTONC_AXIS_REF)]
        return types_shown([*structures, *ELEMENTARY.values()])

    def _of_group(self, group: AxisGroup) -> Iterator[ValueSymbol]:
        """Return the symbols of a group of several axes, as far as its kind has them."""
        for row in self._group_rows:
            read = _reader(row, group)
            try:
                read()
            except DeviceError:
                continue
            yield ValueSymbol(
                f"Groups.{group.name}.{row.symbol}",
                _TYPES[getattr(row.codec, "name", "")],
                (GROUP_STATE + group.group_id, row.offset),
                read,
                comment=row.description,
            )

    def _of(self, axis: Axis) -> Iterator[ValueSymbol]:
        for base, row in self._rows:
            if READ not in row.access or isinstance(row.codec, tuple):
                raise ValueError(f"row {row.name!r} has a symbol, but no single value to read")
            type = _TYPES[getattr(row.codec, "name", "")]
            read, write = _row_access(row, axis)
            group, name = base + axis.axis_id, f"Axes.{axis.name}.{row.symbol}"
            yield ValueSymbol(name, type, (group, row.offset), read, write, row.description)
        group = CYCLIC + axis.axis_id
        yield ValueSymbol(
            f"Axes.{axis.name}.ToPlc",
            iec_type(NCTOPLC_AXIS_REF),
            (group, TO_PLC),
            _to_plc(axis),
            comment="cyclic interface to the PLC",
        )
        yield ValueSymbol(
            f"Axes.{axis.name}.FromPlc",
            iec_type(PLCTONC_AXIS_REF),
            (group, FROM_PLC),
            _from_plc(axis),
            _write_from_plc(self._from_plc, axis),
            comment="cyclic interface from the PLC",
        )
