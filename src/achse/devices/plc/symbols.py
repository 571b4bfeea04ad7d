"""The symbols of a PLC for clients: names, addresses, values, type tables."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, NamedTuple

from achse.ams import DeviceError
from achse.codes import ReservedGroup, ReturnCode
from achse.devices.plc.areas import AREA_GROUPS
from achse.devices.plc.calls import PropertyAccess, caller, property_access
from achse.iec import GlobalVariables, IecIndexError, IecPathError, IecType, Record, Variable
from achse.iec.datatypes import DataTypeEntry, TypeFlag, encode_types
from achse.iec.describe import describe_type, types_shown
from achse.iec.names import elementary
from achse.iec.paths import (
    PathMember,
    ResolvedPath,
    Step,
    dereferenced,
    follow,
    format_path,
    parse_path,
    split_symbol,
)
from achse.iec.structs import StructType
from achse.iec.symbols import SymbolEncoder, SymbolEntry, SymbolFlag, UploadFlag, fold
from achse.iec.text import plain_name
from achse.native.memory import MemoryCell
from achse.plc import Area, Memory, PlacedUnit, PlacedVariable, PlcRuntime, Region
from achse.plc.system_info import SYSTEM_LIST
from achse.server import TableSizes

_ADDRESS_TYPES = {Area.INPUT: "Input", Area.OUTPUT: "Output"}
"""The index group in the entries of properties: they are reached by handle only."""


_LONGEST_PART = 256
"""Characters behind a root up to which a symbol has the spelling of the client as its name."""


class MemoryRange(NamedTuple):
    """A place in PLC memory."""

    region: Region
    offset: int
    bit: int | None


class PlcSymbol:
    """A variable, or a part of one, at a fixed place in memory; a method or property of a part."""

    __slots__ = (
        "__weakref__",
        "_spot",
        "attributes",
        "call",
        "comment",
        "context",
        "flags",
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
        spot: "MemoryRange | PropertyAccess | Callable[[], MemoryRange]",
        context: int,
        *,
        read_only: bool = False,
        flags: int = 0,
        comment: str = "",
        attributes: Mapping[str, str],
        call: Callable[[bytes], bytes] | None = None,
    ) -> None:
        """`spot` is a function where pointers lead to the value, and may raise `DeviceError`."""
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
        self._spot = spot
        if isinstance(spot, MemoryRange):
            self.read, self.write = _access(spot, type.size)
        elif isinstance(spot, PropertyAccess):
            self.read, self.write = spot
        else:
            self.read = lambda: _access(spot(), type.size)[0]()
            self.write = lambda content: _access(spot(), type.size)[1](content)

    @property
    def _place(self) -> tuple[int, int]:
        if isinstance(self._spot, PropertyAccess):
            return ReservedGroup.PROPERTY, 0
        spot = self._spot if isinstance(self._spot, MemoryRange) else self._spot()
        groups = AREA_GROUPS[spot.region.area]
        if spot.bit is None:
            return groups.bytes, spot.offset
        return groups.bits, 8 * spot.offset + spot.bit

    @property
    def index_group(self) -> int:
        return self._place[0]

    @property
    def index_offset(self) -> int:
        return self._place[1]

    def entry(self) -> bytes:
        return self.table_entry().encode()

    def table_entry(self) -> SymbolEntry:
        """Return the symbol as the tables show it."""
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


def _access(spot: MemoryRange, size: int) -> tuple[Callable[[], bytes], Callable[[bytes], None]]:
    if spot.bit is None:
        return _whole_bytes(spot.region.data, spot.offset, size)
    return _one_bit(spot.region.data, spot.offset, 1 << spot.bit)


def _whole_bytes(
    data: bytearray, offset: int, size: int
) -> tuple[Callable[[], bytes], Callable[[bytes], None]]:
    def write(content: bytes) -> None:
        data[offset : offset + len(content)] = content

    return MemoryCell(data, offset, size), write


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


class _Root(NamedTuple):
    """First step of a path: a variable, or a program as a whole."""

    placed: PlacedVariable
    context: int
    unit: Record | None
    is_whole: bool = False

    @property
    def instance(self) -> Record:
        """Its unit. Raises `DeviceError` 0x701 for a static variable, which is in none."""
        if self.unit is None:
            raise DeviceError(
                ReturnCode.SERVICE_NOT_SUPPORTED,
                f"{self.placed.name} is static: it has no methods and properties",
            )
        return self.unit

    @property
    def steps(self) -> tuple[Step, ...]:
        """The way to it in the unit."""
        return () if self.is_whole else (PathMember(self.placed.variable.name),)


def _whole(unit: PlacedUnit) -> PlacedVariable:
    """Return a program with its own memory as one variable, which clients may look at."""
    variable: Variable[Any, Any] = Variable(
        type(unit.instance).__iec__, name=unit.name, constant=True
    )
    return PlacedVariable(unit.name, variable, Area.DATA, unit.base, None)


class PlcSymbols:
    """All symbols of one PLC: its declared variables and whatever a path reaches in them."""

    def __init__(self, plc: PlcRuntime) -> None:
        self.plc = plc
        self._roots: dict[str, _Root] = {}
        self._units: dict[str, _Root] = {}
        self.refresh()

    def refresh(self) -> None:
        """Take the variables that the PLC has now; call it after an online change."""
        plc = self.plc
        numbers = {task: number for number, task in enumerate(plc.tasks, 1)}
        self._roots = {
            fold(placed.name): _Root(placed, context, unit.instance)
            for unit in plc.units
            for context in (0 if _is_global(unit) else numbers[plc.task_of(unit)],)
            for placed in unit.variables
            if not placed.variable.hidden
        }
        for placed in plc.statics:
            self._roots.setdefault(fold(placed.name), _Root(placed, 1, None))
        self._units = {
            fold(unit.name): _Root(_whole(unit), numbers[plc.task_of(unit)], unit.instance, True)
            for unit in plc.units
            if (iec := type(unit.instance).__iec__).methods or iec.properties
        }
        for cached in ("_symbol_table", "_types", "_type_table", "_persistent_types"):
            self.__dict__.pop(cached, None)

    @property
    def version(self) -> int:
        """Differs for other declarations, and after each online change."""
        return self._edition + self.plc.online_changes & 0xFF

    @cached_property
    def _edition(self) -> int:
        """A byte of a hash over names, types and places, computed at its first use."""
        state = hashlib.blake2b(digest_size=1)
        for root, (placed, *_) in self._roots.items():
            state.update(
                b"%b %b %d %a;"
                % (root.encode(), placed.variable.type.guid, placed.offset, placed.bit)
            )
        return state.digest()[0]

    def resolve(self, name: str) -> PlcSymbol | None:
        """`MAIN.stAxis.fPos`, `GVL.aValues[3]`, `MAIN.nFlags.3`, `GVL.pPart^`, `MAIN.fb#Start`.

        A reference is what it refers to. A program with methods or properties is found as well, and
        these in it: `MAIN#Start`. Raises `DeviceError` 0x721 for an index out of bounds.
        """
        name = plain_name(name)
        for roots in (self._roots, self._units):
            try:
                key, rest = split_symbol(name, roots)
                root = roots[key]
                variable = root.placed.variable
                steps = parse_path(rest) if rest else ()
                location = follow(variable.type, steps, variable.attributes)
                if location.property is None:
                    location = dereferenced(location)
                if not rest and not location.hops:
                    return self._variable(root)
            except IecIndexError as failure:
                raise DeviceError(ReturnCode.INVALID_ARRAY_INDEX, str(failure)) from None
            except IecPathError:
                continue
            if len(rest) > _LONGEST_PART:
                rest = format_path(steps)
            return self._part(root, rest, steps, location)
        return None

    def _variable(self, root: "_Root") -> PlcSymbol:
        placed, context, *_ = root
        variable = placed.variable
        return PlcSymbol(
            placed.name,
            variable.type,
            MemoryRange(self.plc.memory[placed.area], placed.offset, placed.bit),
            context,
            read_only=variable.constant,
            flags=_flags(placed),
            comment=variable.comment,
            attributes=_attributes(placed),
        )

    def _part(
        self, root: "_Root", rest: str, steps: tuple[Step, ...], location: ResolvedPath
    ) -> PlcSymbol:
        placed, context, *_ = root
        first = root.steps
        call = None
        if location.method is not None:
            path = (*first, *steps[:-1])
            call = caller(root.instance, path, location.method, self.plc.bodies)
        if location.property is not None:
            return PlcSymbol(
                placed.name + rest,
                location.type,
                property_access(
                    root.instance, (*first, *steps[:-1]), location.property, self.plc.bodies
                ),
                context,
                read_only=not location.property.writable,
                comment=location.property.comment,
                attributes=location.property.attributes,
            )
        memory = self.plc.memory
        region, offset = memory[placed.area], placed.offset
        if location.static is not None:
            region, offset = memory[Area.DATA], memory.statics[location.static].offset
        spot: MemoryRange | Callable[[], MemoryRange]
        if location.hops:
            spot = partial(
                _pointee, memory, self.plc.pointer_size, MemoryRange(region, offset, None), location
            )
        else:
            spot = MemoryRange(region, offset + location.offset, location.bit)
        return PlcSymbol(
            placed.name + rest,
            location.type,
            spot,
            context,
            read_only=placed.variable.constant and not location.hops,
            comment=location.comment,
            attributes=location.attributes,
            call=call,
        )

    # tables ----------------------------------------------------------------------------------

    def upload_info(self) -> TableSizes:
        flags = UploadFlag.BASE_TYPES
        if self.plc.pointer_size == 8:
            flags |= UploadFlag.PLATFORM_64_BIT
        return TableSizes(
            symbol_count=len(self._roots), type_count=len(self._types), flags=int(flags)
        )

    def symbol_table(self) -> bytes:
        return self._symbol_table

    def type_table(self) -> bytes:
        return self._type_table

    def type_entry(self, name: str) -> bytes | None:
        type = self._types.get(fold(plain_name(name).strip()))
        return None if type is None else self._described(type).encode()

    @cached_property
    def _symbol_table(self) -> bytes:
        encode = SymbolEncoder()
        parts = []
        for root in sorted(self._roots):
            placed, context, *_ = self._roots[root]
            variable = placed.variable
            groups = AREA_GROUPS[placed.area]
            group, offset = groups.bytes, placed.offset
            if placed.bit is not None:
                group, offset = groups.bits, 8 * offset + placed.bit
            parts.append(
                encode(
                    placed.name,
                    variable.type,
                    group,
                    offset,
                    _flags(placed) | (context & 0xF) << 8,
                    variable.comment,
                    _attributes(placed),
                )
            )
        return b"".join(parts)

    @cached_property
    def _types(self) -> dict[str, IecType[Any]]:
        roots = (*self._units.values(), *self._roots.values())
        used = {id(each): each for each in (root.placed.variable.type for root in roots)}
        known = elementary(self.plc.pointer_size).values()
        return {fold(type.name): type for type in types_shown([*used.values(), *known])}

    @cached_property
    def _type_table(self) -> bytes:
        return encode_types(map(self._described, self._types.values()))

    @cached_property
    def _persistent_types(self) -> set[str]:
        """Names of the types of persistent variables, and of all that is in them."""
        variables = [root.placed.variable for root in self._roots.values()]
        members = [
            member
            for type in self._types.values()
            if isinstance(type, StructType)
            for member in type.shown
        ]
        types = [each.type for each in (*variables, *members) if each.persistent]
        return {fold(type.name) for type in types_shown(types)}

    def _described(self, type: IecType[Any]) -> DataTypeEntry:
        entry = describe_type(type)
        if fold(type.name) not in self._persistent_types:
            return entry
        return replace(entry, flags=entry.flags | TypeFlag.PERSISTENT_TYPE)


def _is_global(unit: PlacedUnit) -> bool:
    """Return True if the list belongs to the application and to no task: its task mask is 0.

    Lists of the runtime have the mask of the first task, as recorded.
    """
    return isinstance(unit.instance, GlobalVariables) and unit.name != SYSTEM_LIST


def _flags(placed: PlacedVariable) -> int:
    variable = placed.variable
    flags = SymbolFlag.PERSISTENT if variable.persistent else 0
    if variable.constant:
        flags |= SymbolFlag.READ_ONLY
    if placed.bit is not None:
        flags |= SymbolFlag.BIT_VALUE
    if not variable.in_memory:
        flags |= SymbolFlag.STATIC
    return int(flags)


def _attributes(placed: PlacedVariable) -> Mapping[str, str]:
    kind = _ADDRESS_TYPES.get(placed.area)
    attributes = placed.variable.attributes
    return attributes if kind is None else {**attributes, "TcAddressType": kind}


def _pointee(
    memory: Memory, pointer_size: int, start: MemoryRange, location: ResolvedPath
) -> MemoryRange:
    """Return the memory that a path reaches through the present values of its pointers.

    Raises `DeviceError` 0x722 if a pointer is NULL or points outside the memory.
    """
    region, offset = start.region, start.offset
    for hop in location.hops:
        place = offset + hop
        address = int.from_bytes(region.data[place : place + pointer_size], "little")
        target = memory.at(address)
        if target is None:
            raise DeviceError(
                ReturnCode.SYMBOL_NOT_ACTIVE, f"a pointer holds 0x{address:X}, no address of data"
            )
        region, offset = target
    end = offset + location.offset + location.type.size
    if end > len(region):
        raise DeviceError(ReturnCode.SYMBOL_NOT_ACTIVE, "a pointer leads to the end of its area")
    return MemoryRange(region, offset + location.offset, location.bit)
