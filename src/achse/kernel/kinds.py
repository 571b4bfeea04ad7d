"""What a value is in a translated kernel: a number, a record, a row of them, or a tuple."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, TypeAlias

__all__ = ["BOOL", "INT", "NOTHING", "REAL", "Kind", "Layout", "Place", "Record", "Row", "Scalar"]
__all__ += ["Several", "Value", "joined", "machine_types"]


class Place(Protocol):
    """Where a field lies in its record: `offset` in words of 8 bytes, `length` 0 for a scalar."""

    @property
    def offset(self) -> int: ...
    @property
    def length(self) -> int: ...
    @property
    def is_real(self) -> bool: ...


@dataclass(frozen=True)
class Scalar:
    """A number: how the machine calls it, and its place in the order bool, int, float."""

    machine: str
    order: int


@dataclass(frozen=True, eq=False)
class Layout:
    """A record of fields, each some words of 8 bytes; `words` in all."""

    name: str
    fields: Mapping[str, Place]
    words: int


@dataclass(frozen=True)
class Record:
    """A reference to one record."""

    layout: Layout


@dataclass(frozen=True)
class Row:
    """A reference to numbers or records that lie one behind the other, and how many they are."""

    of: "Scalar | Record"


@dataclass(frozen=True)
class Several:
    """A tuple."""

    kinds: "tuple[Kind, ...]"


Kind: TypeAlias = Scalar | Record | Row | Several

BOOL = Scalar("i1", 0)
INT = Scalar("i64", 1)
REAL = Scalar("double", 2)
NOTHING = Several(())


@dataclass(frozen=True, slots=True)
class Value:
    """A value and the operands that hold it, one for each of `machine_types(kind)`."""

    kind: Kind
    operands: tuple[str, ...]


def machine_types(kind: Kind) -> tuple[str, ...]:
    """The machine's types of a kind, flat."""
    if isinstance(kind, Scalar):
        return (kind.machine,)
    if isinstance(kind, Record):
        return ("ptr",)
    if isinstance(kind, Row):
        return ("ptr", "i64")
    return tuple(machine for part in kind.kinds for machine in machine_types(part))


def joined(a: Kind, b: Kind) -> Kind | None:
    """The kind that holds values of both: the wider number; None if there is none."""
    if a == b:
        return a
    if isinstance(a, Scalar) and isinstance(b, Scalar):
        return a if a.order > b.order else b
    if isinstance(a, Several) and isinstance(b, Several) and len(a.kinds) == len(b.kinds):
        parts = [joined(x, y) for x, y in zip(a.kinds, b.kinds, strict=True)]
        found = tuple(part for part in parts if part is not None)
        return Several(found) if len(found) == len(parts) else None
    return None
