"""Types of a target, built from its uploaded type entries at their first use.

Source: recorded traffic of TwinCAT 3.1 targets and the code of public clients; no manual prints it.
"""

from collections.abc import Iterable, Iterator, Mapping
from enum import IntEnum
from math import prod
from typing import Any

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.datatypes import STATIC_OFFSET, DataTypeEntry, MethodEntry, ParameterFlag, TypeFlag
from achse.iec.derived import AliasType, InterfaceType, OpaqueType
from achse.iec.elementary import (
    BOOL,
    DINT,
    INT,
    LINT,
    LREAL,
    REAL,
    SINT,
    UDINT,
    UINT,
    ULINT,
    USINT,
    IntegerType,
)
from achse.iec.enums import EnumType
from achse.iec.errors import DeclarationError, IecDecodeError
from achse.iec.layout import MemberOffset, TypeLayout
from achse.iec.methods import Method, Parameter
from achse.iec.names import ELEMENTARY, parse_type, with_coding
from achse.iec.strings import STRING, WSTRING
from achse.iec.structs import RecordKind, StructType
from achse.iec.symbols import SymbolEntry
from achse.iec.types import Adst, IecType
from achse.iec.variables import Section, Variable

_DEEPEST = 64
_BY_ADST: Mapping[int, IecType[Any]] = {
    type.adst: type
    for type in (BOOL, SINT, USINT, INT, UINT, DINT, UDINT, LINT, ULINT, REAL, LREAL)
}


class TypeTable:
    """The types of a target by name, without case.

    Offsets and sizes are those of the table, whatever the layout rules here would say. Entries
    that contradict themselves raise `IecDecodeError` at the first use of their type.
    """

    def __init__(self, entries: Iterable[DataTypeEntry] = (), *, pointer_size: int = 8) -> None:
        self._entries = {entry.name.lower(): entry for entry in entries}
        self.pointer_size = pointer_size
        self._types: dict[str, IecType[Any]] = {}
        self._building: list[str] = []

    def __len__(self) -> int:
        return len(self._entries)

    def __iter__(self) -> Iterator[DataTypeEntry]:
        return iter(self._entries.values())

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name.lower() in self._entries

    def add(self, entry: DataTypeEntry) -> None:
        """Take in an entry that came later (0xF011)."""
        self._entries[entry.name.lower()] = entry
        self._types.clear()

    def entry(self, name: str) -> DataTypeEntry | None:
        return self._entries.get(name.lower())

    def type(self, name: str) -> IecType[Any]:
        """Return the type of that name, from the table or by its text (`ARRAY [0..3] OF INT`).

        Raises `DeclarationError` for an unknown name, `IecDecodeError` for a bad entry.
        """
        return parse_type(name, self._find, pointer_size=self.pointer_size)

    def symbol_type(self, symbol: SymbolEntry) -> IecType[Any]:
        """Return the type of a symbol: by name, else by its ADST id, else its bytes."""
        return self._sized(
            symbol.type_name, symbol.size, symbol.adst, symbol.flags & 0x2 != 0, symbol.attributes
        )

    def _sized(
        self,
        name: str,
        size: int,
        adst: int,
        is_bit: bool,
        attributes: Iterable[tuple[str, str]],
    ) -> IecType[Any]:
        try:
            type = self.type(name)
        except DeclarationError:
            type = None
        if type is None or type.size != size:
            type = _by_adst(name, size, adst)
        if is_bit and size == 1:
            type = ELEMENTARY["bit"]
        if ("tcencoding", "utf-8") in {(key.lower(), value.lower()) for key, value in attributes}:
            type = with_coding(type, "utf-8")
        return type

    def _find(self, name: str) -> IecType[Any] | None:
        key = name.lower()
        type = self._types.get(key)
        if type is not None:
            return type
        entry = self._entries.get(key)
        if entry is None or key == entry.type_name.lower():
            return None
        if key in self._building or len(self._building) > _DEEPEST:
            raise IecDecodeError(f"type {name[:80]!r} contains itself or nests too deep")
        self._building.append(key)
        try:
            type = self._build(entry)
        except DeclarationError as error:
            raise IecDecodeError(f"type entry {name[:80]!r}: {error}") from None
        finally:
            self._building.pop()
        if type is not None:
            self._types[key] = type
        return type

    def _build(self, entry: DataTypeEntry) -> IecType[Any] | None:
        if entry.members:
            return self._struct(entry)
        if entry.enum_values:
            return self._enum(entry)
        if entry.dimensions:
            return self._array(entry)
        try:
            # STRING(n), POINTER TO, INT (0..5) and the like say it all in their name.
            named = parse_type(entry.name, self._find_other(entry), pointer_size=entry.size)
        except DeclarationError:
            named = None
        if named is not None and named.size == entry.size:
            return named
        if entry.type_name:
            bit = entry.flags & TypeFlag.BIT_VALUES != 0
            base = self._sized(entry.type_name, entry.size, entry.adst, bit, entry.attributes)
            return AliasType(
                entry.name,
                base,
                guid=entry.guid,
                comment=entry.comment,
                attributes=dict(entry.attributes),
            )
        if entry.adst == Adst.BIGTYPE and entry.size == self.pointer_size:
            return InterfaceType(entry.name, self.pointer_size)
        return _by_adst(entry.name, entry.size, entry.adst)

    def _find_other(self, entry: DataTypeEntry) -> Any:
        return lambda name: None if name.lower() == entry.name.lower() else self._find(name)

    def _array(self, entry: DataTypeEntry) -> IecType[Any]:
        count = prod(length for _, length in entry.dimensions)
        if count and entry.size % count:
            raise DeclarationError(f"{entry.size} bytes are not {count} elements")
        if count:
            element = self._sized(entry.type_name, entry.size // count, entry.adst, False, ())
        else:
            element = self._unsized(entry)
        bounds = [Bounds(first, first + length - 1) for first, length in entry.dimensions]
        array = ArrayType(element, bounds)
        array.guid = entry.guid
        if entry.name.upper().startswith("ARRAY"):
            return array
        return AliasType(entry.name, array, guid=entry.guid, comment=entry.comment)

    def _unsized(self, entry: DataTypeEntry) -> IecType[Any]:
        """Return the element type of an array without elements, which does not contain its size."""
        try:
            type = self.type(entry.type_name)
        except DeclarationError:
            type = None
        return type if type is not None and type.size else _by_adst(entry.type_name, 1, 0)

    def _enum(self, entry: DataTypeEntry) -> IecType[Any]:
        base = self._sized(entry.type_name, entry.size, entry.adst, False, ())
        while isinstance(base, AliasType):
            base = base.base
        if not isinstance(base, IntegerType):
            raise DeclarationError(f"the base {entry.type_name!r} is not an integer type")
        # Python keeps `_x_` and `mro` for itself; such values stay plain numbers.
        numbers = {
            name: base.decode(raw)
            for name, raw in entry.enum_values
            if name and name != "mro" and not (name.startswith("_") and name.endswith("_"))
        }
        members = IntEnum(entry.name.replace("\0", ""), numbers)  # type: ignore[misc]
        notes = zip(entry.enum_values, entry.enum_notes, strict=False)
        type: EnumType[Any] = EnumType(
            members,
            base,
            name=entry.name,
            comment=entry.comment,
            attributes=dict(entry.attributes),
            comments={name: note.comment for (name, _), note in notes if note.comment},
        )
        type.guid = entry.guid
        return type

    def _struct(self, entry: DataTypeEntry) -> IecType[Any]:
        members = [self._member(item, entry) for item in entry.members]
        inside = [item for item in members if item.in_memory]
        alignment = max((item.type.alignment for item in inside), default=1)
        while entry.size % alignment:
            alignment //= 2
        spots = tuple(MemberOffset(item.offset, item.bit) for item in inside)
        sized = [item for item in inside if item.type.size]
        starts = {item.offset for item in sized}
        union = len(sized) > 1 and starts == {0} and all(item.bit is None for item in sized)
        type: StructType[Any] = StructType(
            entry.name,
            members,
            kind=RecordKind.UNION if union else RecordKind.STRUCT,
            layout=TypeLayout(entry.size, alignment, spots),
            methods=[self._method(item) for item in entry.methods],
            comment=entry.comment,
            attributes=dict(entry.attributes),
            guid=entry.guid,
        )
        return type

    def _member(self, item: DataTypeEntry, parent: DataTypeEntry) -> Variable[Any, Any]:
        is_bit = item.flags & TypeFlag.BIT_VALUES != 0
        outside = TypeFlag.STATIC | TypeFlag.PROPERTY_ITEM
        static = item.flags & outside != 0 or item.offset == STATIC_OFFSET
        type = self._sized(item.type_name, item.size, item.adst, is_bit, item.attributes)
        offset, bit = (item.offset // 8, item.offset % 8) if type.is_bit else (item.offset, None)
        if not static and offset + type.size > parent.size:
            raise DeclarationError(
                f"member {item.name[:80]!r} ends at {offset + type.size} of {parent.size} bytes"
            )
        return Variable(
            type,
            name=item.name,
            section=Section.STATIC if static else Section.LOCAL,
            persistent=item.flags & TypeFlag.PERSISTENT != 0,
            comment=item.comment,
            attributes=dict(item.attributes),
            offset=offset,
            bit=bit,
        )

    def _method(self, entry: MethodEntry) -> Method:
        parameters = tuple(
            Parameter(
                item.name,
                self._sized(item.type_name, item.size, item.adst, False, item.attributes),
                is_output=item.flags & ParameterFlag.OUT != 0,
                by_reference=item.flags & ParameterFlag.BY_REFERENCE != 0,
                comment=item.comment,
                attributes=dict(item.attributes),
            )
            for item in entry.parameters
        )
        returns = None
        if entry.return_size:
            returns = self._sized(
                entry.return_type, entry.return_size, entry.return_adst, False, ()
            )
        return Method(entry.name, parameters, returns, entry.comment, dict(entry.attributes))


def _by_adst(name: str, size: int, adst: int) -> IecType[Any]:
    type = _BY_ADST.get(adst)
    if type is not None and type.size == size:
        return type
    if adst == Adst.STRING and size > 1:
        return STRING(size - 1)
    if adst == Adst.WSTRING and size > 2 and size % 2 == 0:
        return WSTRING(size // 2 - 1)
    return OpaqueType(name, size, 1, adst)
