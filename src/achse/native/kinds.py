"""What a value is in a translated kernel: a number, a record, a row of them, or a tuple."""

from dataclasses import dataclass
from typing import Any, TypeAlias

from achse.native.declare import Layout

__all__ = [
    "BOOL",
    "BYTE",
    "INT",
    "NOTHING",
    "REAL",
    "Kind",
    "Record",
    "Row",
    "Scalar",
    "Several",
    "Value",
    "joined",
    "machine_types",
]


@dataclass(frozen=True)
class Scalar:
    """A number: how the machine calls it, and its place in the order bool, int, float."""

    machine: str
    order: int


@dataclass(frozen=True)
class Record:
    """A reference to one record."""

    layout: Layout[Any]


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
BYTE = Scalar("i8", 1)
"""An element of a `bytearray`, loaded as INT and stored from one."""

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
