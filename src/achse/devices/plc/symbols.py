"""The symbols of a PLC for clients: names, addresses, values, type tables."""

import struct
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.plc.areas import AREA_GROUPS
from achse.iec import IecDecodeError, IecPathError, IecType, Method, Record
from achse.iec.datatypes import encode_types
from achse.iec.describe import describe_type, types_within
from achse.iec.names import ELEMENTARY
from achse.iec.paths import Index, Location, Member, Step, follow, parse_path, split_symbol
from achse.iec.symbols import SymbolEntry, SymbolFlag, encode_symbols, fold
from achse.plc import Area, PlacedVariable, PlcRuntime
from achse.server import UploadInfo

__all__ = ["PlcSymbol", "PlcSymbols"]

_ADDRESS_TYPES = {Area.INPUT: "Input", Area.OUTPUT: "Output"}


class PlcSymbol:
    """A variable, or a part of one, at a fixed place in memory; or a method of a part."""

    __slots__ = (
        "attributes",
        "call",
        "comment",
        "context",
        "flags",
        "index_group",
        "index_offset",
        "name",
        "read",
        "read_only",
        "size",
        "type",
        "write",
    )

    def __init__(
        self,
        name: str,
        type: IecType[Any],
        area: Area,
        data: bytearray,
        offset: int,
        bit: int | None,
        context: int,
        *,
        read_only: bool = False,
        flags: int = 0,
        comment: str = "",
        attributes: Mapping[str, str],
        call: Callable[[bytes], bytes] | None = None,
    ) -> None:
        self.name = name
        self.type = type
        self.size = type.size
        self.read_only = read_only
        self.context = context
        self.flags = flags
        self.comment = comment
        self.attributes = attributes
        self.call = call
        self.read: Callable[[], bytes]
        self.write: Callable[[bytes], None]
        groups = AREA_GROUPS[area]
        if bit is None:
            self.index_group = groups.bytes
            self.index_offset = offset
            self.read, self.write = _whole_bytes(data, offset, type.size)
        else:
            self.index_group = groups.bits
            self.index_offset = 8 * offset + bit
            self.flags |= SymbolFlag.BIT_VALUE
            self.read, self.write = _one_bit(data, offset, 1 << bit)

    def entry(self) -> bytes:
        return self.table_entry().encode()

    def table_entry(self) -> SymbolEntry:
        """The symbol as the tables show it."""
        return SymbolEntry.of(
            self.name,
            self.type,
            self.index_group,
            self.index_offset,
            flags=self.flags | (SymbolFlag.READ_ONLY if self.read_only else 0),
            context=self.context,
            comment=self.comment,
            attributes=self.attributes,
        )


def _whole_bytes(
    data: bytearray, offset: int, size: int
) -> tuple[Callable[[], bytes], Callable[[bytes], None]]:
    take = struct.Struct(f"{size}s").unpack_from

    def read() -> bytes:
        content: bytes = take(data, offset)[0]
        return content

    def write(content: bytes) -> None:
        data[offset : offset + len(content)] = content

    return read, write


def _one_bit(
    data: bytearray, offset: int, mask: int
) -> tuple[Callable[[], bytes], Callable[[bytes], None]]:
    def read() -> bytes:
        return b"\1" if data[offset] & mask else b"\0"

    def write(content: bytes) -> None:
        if any(content):
            data[offset] |= mask
        else:
            data[offset] &= ~mask & 0xFF

    return read, write


class PlcSymbols:
    """All symbols of one PLC: its declared variables and whatever a path reaches in them."""

    def __init__(self, plc: PlcRuntime) -> None:
        self.plc = plc
        numbers = {task: number for number, task in enumerate(plc.tasks, 1)}
        self._roots: dict[str, tuple[PlacedVariable, int, Record]] = {
            fold(placed.name): (placed, numbers[plc.task_of(unit)], unit.instance)
            for unit in plc.units
            for placed in unit.variables
        }

    @property
    def version(self) -> int:
        """1, and one more with each online change."""
        return self.plc.online_changes + 1 & 0xFF

    def resolve(self, name: str) -> PlcSymbol | None:
        """`MAIN.stAxis.fPos`, `GVL.aValues[3]`, `MAIN.nFlags.3`, `MAIN.fbMotor#Start`."""
        try:
            root, rest = split_symbol(name, self._roots)
            if not rest:
                return self._variable(root)
            steps = parse_path(rest)
            location = follow(self._roots[root][0].variable.type, steps)
        except IecPathError:
            return None
        if location.hops:
            return None  # what a pointer points at has no place in these areas
        return self._part(root, rest, steps, location)

    def _variable(self, root: str) -> PlcSymbol:
        placed, context, _ = self._roots[root]
        variable = placed.variable
        attributes = dict(variable.attributes)
        if placed.area in _ADDRESS_TYPES:
            attributes["TcAddressType"] = _ADDRESS_TYPES[placed.area]
        return PlcSymbol(
            placed.name,
            variable.type,
            placed.area,
            self.plc.memory[placed.area].data,
            placed.offset,
            placed.bit,
            context,
            read_only=variable.constant,
            flags=SymbolFlag.PERSISTENT if variable.persistent else 0,
            comment=variable.comment,
            attributes=attributes,
        )

    def _part(self, root: str, rest: str, steps: tuple[Step, ...], location: Location) -> PlcSymbol:
        placed, context, unit = self._roots[root]
        call = None
        if location.method is not None:
            call = _caller(unit, (Member(placed.variable.name), *steps[:-1]), location.method)
        return PlcSymbol(
            placed.name + rest,
            location.type,
            placed.area,
            self.plc.memory[placed.area].data,
            placed.offset + location.offset,
            location.bit,
            context,
            read_only=placed.variable.constant,
            attributes={},
            call=call,
        )

    # tables ----------------------------------------------------------------------------------

    def upload_info(self) -> UploadInfo:
        return UploadInfo(symbol_count=len(self._roots), type_count=len(self._types))

    def symbol_table(self) -> bytes:
        return self._symbol_table

    def type_table(self) -> bytes:
        return self._type_table

    def type_entry(self, name: str) -> bytes | None:
        found = self._types.get(fold(name.strip()))
        return None if found is None else describe_type(found).encode()

    @cached_property
    def _symbol_table(self) -> bytes:
        return encode_symbols(self._variable(root).table_entry() for root in self._roots)

    @cached_property
    def _types(self) -> dict[str, IecType[Any]]:
        used = [placed.variable.type for placed, _, _ in self._roots.values()]
        return {fold(type.name): type for type in types_within([*used, *ELEMENTARY.values()])}

    @cached_property
    def _type_table(self) -> bytes:
        return encode_types(map(describe_type, self._types.values()))


def _caller(unit: Record, steps: tuple[Step, ...], method: Method) -> Callable[[bytes], bytes]:
    """A function that calls the Python method behind a declared one, on the living object."""

    def call(data: bytes) -> bytes:
        try:
            arguments = method.decode_inputs(data)
        except IecDecodeError as failure:
            raise DeviceError(ReturnCode.INVALID_SIZE, str(failure)) from None
        target: Any = unit
        for step in steps:
            if isinstance(step, Member):
                target = target[step.name]
            elif isinstance(step, Index):
                target = target[step.indices if len(step.indices) > 1 else step.indices[0]]
        result = _python_method(target, method)(*arguments)
        answers = len(method.outputs) + (method.returns is not None)
        if answers == 0:
            return b""
        return method.encode_answer((result,) if answers == 1 else result)

    return call


def _python_method(target: object, method: Method) -> Callable[..., Any]:
    for cls in type(target).__mro__:
        for name, value in vars(cls).items():
            if getattr(value, "__iec_method__", None) is method:
                bound: Callable[..., Any] = getattr(target, name)
                return bound
    raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"{method.name} has no body")
