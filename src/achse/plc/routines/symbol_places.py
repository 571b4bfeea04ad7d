"""Symbols of a PLC as built-in routines find them: by name, or by address and size."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from achse.iec.arrays import ArrayType
from achse.iec.derived import AliasType, PointerType, resolved
from achse.iec.errors import IecIndexError, IecPathError
from achse.iec.paths import follow, parse_path, split_symbol
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.plc.memory import Memory
from achse.plc.program import PlacedVariable


class SymbolPlace(NamedTuple):
    """A symbol in memory: its name, the value of a pointer to it, and its type."""

    name: str
    address: int
    type: IecType[Any]


class SymbolPlaces:
    """The variables of one PLC and their parts."""

    def __init__(self, memory: Memory, variables: Sequence[PlacedVariable]) -> None:
        self._memory = memory
        self._placed = variables

    @cached_property
    def _variables(self) -> Mapping[str, PlacedVariable]:
        return {
            placed.name.lower(): placed
            for placed in self._placed
            if placed.bit is None and not placed.variable.hidden
        }

    def named(self, name: str) -> SymbolPlace | None:
        """Return a variable or a part of one by its name, without case; None if there is none."""
        try:
            root, rest = split_symbol(name.removeprefix("."), self._variables)
            placed = self._variables[root]
            target = follow(placed.variable.type, parse_path(rest) if rest else ())
        except (IecPathError, IecIndexError, KeyError):
            return None
        if target.hops or any(
            part is not None for part in (target.bit, target.method, target.property)
        ):
            return None
        return SymbolPlace(placed.name + rest, self._address(placed) + target.offset, target.type)

    def at(self, address: int, size: int) -> SymbolPlace | None:
        """Return the outermost variable or part of one with that address and size."""
        for placed in self._variables.values():
            offset = address - self._address(placed)
            type = placed.variable.type
            if offset >= 0 and offset + size <= type.size:
                part = _part(type, offset, size)
                if part is not None:
                    return SymbolPlace(placed.name + part[0], address, part[1])
        return None

    def type_named(self, name: str) -> IecType[Any] | None:
        """Return the type of that name, without case, that a variable or a part of one has."""
        return self._types.get(name.lower())

    @cached_property
    def _types(self) -> Mapping[str, IecType[Any]]:
        types: dict[str, IecType[Any]] = {}
        waiting = [placed.variable.type for placed in self._placed]
        while waiting:
            type = waiting.pop()
            if type.name.lower() in types:
                continue
            types[type.name.lower()] = type
            if isinstance(type, AliasType):
                waiting.append(type.base)
            elif isinstance(type, ArrayType):
                waiting.append(type.element)
            elif isinstance(type, PointerType):
                waiting.append(type.target)
            elif isinstance(type, StructType):
                waiting += (member.type for member in type.members)
                waiting += [] if type.base is None else [type.base]
        return types

    def _address(self, placed: PlacedVariable) -> int:
        return self._memory.address(placed.area, placed.offset)


def _part(type: IecType[Any], offset: int, size: int) -> tuple[str, IecType[Any]] | None:
    """Return path and type of the part of a type with that offset and size."""
    plain = resolved(type)
    if offset == 0 and plain.size == size:
        return "", type
    if isinstance(plain, ArrayType):
        number, rest = divmod(offset, plain.element.size)
        part = _part(plain.element, rest, size) if rest + size <= plain.element.size else None
        return None if part is None else (_index(plain, number) + part[0], part[1])
    if not isinstance(plain, StructType):
        return None
    if plain.base is not None and (part := _part(plain.base, offset, size)) is not None:
        return part if part[0] else None
    for member in plain.fields:
        inside = offset - member.offset
        if member.bit is None and inside >= 0 and inside + size <= member.type.size:
            part = _part(member.type, inside, size)
            if part is not None:
                return f".{member.name}{part[0]}", part[1]
    return None


def _index(type: ArrayType[Any], number: int) -> str:
    indices = []
    for bounds in reversed(type.dimensions):
        number, rest = divmod(number, bounds.length)
        indices.append(str(bounds.first + rest))
    return f"[{','.join(reversed(indices))}]"
