"""Layout: where in a type the bytes are that mean something in one memory only.

These are pointers (references and interfaces, too) and the headers of function blocks.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

from achse.iec import ArrayType, IecType, InterfaceType, PointerType, StructType, resolved
from achse.iec.structs import RecordKind

__all__ = ["KnownPointers", "Pointer", "parts_without_headers", "pointers_within"]


class Pointer(NamedTuple):
    """A pointer in a type."""

    offset: int
    size: int
    type: PointerType

    @property
    def is_to_values(self) -> bool:
        """Whether it leads to numbers of several bytes. Others may lead to records."""
        if isinstance(self.type, InterfaceType):
            return False
        target = resolved(self.type.target)
        return target.size > 1 and not isinstance(target, StructType | ArrayType)


KnownPointers: TypeAlias = dict[int, Sequence[Pointer]]
"""The pointers of types met before."""


def pointers_within(type: IecType[Any], known: KnownPointers | None = None) -> Sequence[Pointer]:
    """Each pointer in a type."""
    known = {} if known is None else known
    type = resolved(type)
    found = known.get(id(type))
    if found is not None:
        return found
    if isinstance(type, PointerType):
        found = [Pointer(0, type.size, type)]
    elif isinstance(type, ArrayType):
        inner = pointers_within(type.element, known)
        step = type.element.size
        found = [
            one._replace(offset=n * step + one.offset)
            for n in range(type.count if inner else 0)
            for one in inner
        ]
    elif isinstance(type, StructType) and type.kind is not RecordKind.UNION:
        found = [
            one._replace(offset=member.offset + one.offset)
            for member in type.fields
            if member.bit is None
            for one in pointers_within(member.type, known)
        ]
    else:
        found = []
    known[id(type)] = found
    return found


def parts_without_headers(type: IecType[Any]) -> tuple[tuple[int, int], ...]:
    """The bytes of a record that a copy takes: all but the headers of function blocks."""
    gaps = sorted(_headers(type, 0))
    parts: list[tuple[int, int]] = []
    at = 0
    for start, end in gaps:
        if start > at:
            parts.append((at, start))
        at = end
    if at < type.size:
        parts.append((at, type.size))
    return tuple(parts)


def _headers(type: IecType[Any], offset: int) -> set[tuple[int, int]]:
    type = resolved(type)
    found: set[tuple[int, int]] = set()
    if isinstance(type, StructType):
        if type.kind is RecordKind.FUNCTION_BLOCK:
            found.add((offset, offset + type.rules.pointer_size))
        for member in type.fields:
            found |= _headers(member.type, offset + member.offset)
    elif isinstance(type, ArrayType) and _headers(type.element, 0):
        for index in range(type.count):
            found |= _headers(type.element, offset + index * type.element.size)
    return found
