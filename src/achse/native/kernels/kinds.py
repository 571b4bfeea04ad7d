"""Kinds of values in a translated kernel: a number, a record, a row of them, a tuple, tables."""

from dataclasses import dataclass
from typing import Any, TypeAlias

from achse.native.backend import types
from achse.native.backend.types import MachineType, Operand
from achse.native.declare import RecordLayout


@dataclass(frozen=True)
class Scalar:
    """A number: its type in the machine, and its place in the order bool, int, float."""

    machine: MachineType
    order: int


@dataclass(frozen=True)
class RecordReference:
    """A reference to one record."""

    layout: RecordLayout[Any]


@dataclass(frozen=True)
class Row:
    """A reference to numbers or records, one behind the other, and how many they are."""

    of: "Scalar | RecordReference"


@dataclass(frozen=True)
class Several:
    """A tuple."""

    kinds: "tuple[ValueKind, ...]"


@dataclass(frozen=True)
class RowTables:
    """Rows by name: all that an entry works on, of several record types."""

    name: str
    rows: "tuple[tuple[str, ValueKind], ...]"


ValueKind: TypeAlias = Scalar | RecordReference | Row | Several | RowTables

BOOL = Scalar(types.BOOL, 0)
INT = Scalar(types.I64, 1)
REAL = Scalar(types.F64, 2)
BYTE = Scalar(types.U8, 1)
"""An element of a `bytearray`, loaded as INT and stored from one."""

NOTHING = Several(())


@dataclass(frozen=True, slots=True)
class KernelValue:
    """A value and the operands that hold it, one for each of `machine_types(kind)`."""

    kind: ValueKind
    operands: tuple[Operand, ...]


def machine_types(kind: ValueKind) -> tuple[MachineType, ...]:
    """Return the machine's types of a kind, flat."""
    if isinstance(kind, Scalar):
        return (kind.machine,)
    if isinstance(kind, RecordReference):
        return (types.ADDRESS,)
    if isinstance(kind, Row):
        return types.ADDRESS, types.I64
    parts = kind.kinds if isinstance(kind, Several) else (row for _, row in kind.rows)
    return tuple(machine for part in parts for machine in machine_types(part))


def joined(a: ValueKind, b: ValueKind) -> ValueKind | None:
    """Return the kind that holds values of both: the wider number; None if there is none."""
    if a == b:
        return a
    if isinstance(a, Scalar) and isinstance(b, Scalar):
        return a if a.order > b.order else b
    if isinstance(a, Several) and isinstance(b, Several) and len(a.kinds) == len(b.kinds):
        parts = [joined(x, y) for x, y in zip(a.kinds, b.kinds, strict=True)]
        kinds = tuple(part for part in parts if part is not None)
        return Several(kinds) if len(kinds) == len(parts) else None
    return None


def described(kind: ValueKind) -> str:
    """Return a kind in words."""
    if isinstance(kind, Scalar):
        return ("a bool", "a whole number", "a float")[kind.order]
    if isinstance(kind, RecordReference | RowTables):
        return f"a {kind.layout.name if isinstance(kind, RecordReference) else kind.name}"
    return "a sequence" if isinstance(kind, Row) else "a tuple"
