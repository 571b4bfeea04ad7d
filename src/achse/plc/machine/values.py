"""Representation of values of the typed form in machine code."""

from dataclasses import dataclass
from typing import Any, TypeAlias

from achse.iec.arrays import ArrayType
from achse.iec.elementary import BoolType, RealType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.native.backend import (
    BOOL,
    F32,
    F64,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    MachineType,
    Operand,
)
from achse.st.check.kinds import counted


class NotTranslatedError(Exception):
    """A routine stays plain; the text says why."""


@dataclass(slots=True)
class MachineText:
    """A text: where its bytes are and how many, without NUL."""

    address: Operand
    length: Operand
    """I64, in bytes."""
    steady: bool = False
    """True if nothing can change the bytes before the statement ends."""


@dataclass(slots=True)
class PackedBytes:
    """A record or array: where its bytes are."""

    address: Operand
    size: int
    steady: bool = False


MachineValue: TypeAlias = Operand | MachineText | PackedBytes

_WHOLES = {
    (1, True): I8,
    (2, True): I16,
    (4, True): I32,
    (8, True): I64,
    (1, False): U8,
    (2, False): U16,
    (4, False): U32,
    (8, False): U64,
}


def machine_type(type: IecType[Any]) -> MachineType:
    """Return the type in a register of a flat elementary type."""
    if isinstance(type, BoolType):
        return BOOL
    if isinstance(type, RealType):
        return F32 if type.size == F32.size else F64
    whole = counted(type)
    return _WHOLES[whole.size, whole.low < 0]


def is_packed(type: IecType[Any]) -> bool:
    """Return True if values are all the bytes of a record or array."""
    return isinstance(type, StructType | ArrayType)


def words_of(value: MachineValue) -> list[Operand]:
    """Return the registers that a value is in."""
    if isinstance(value, MachineText):
        return [value.address, value.length]
    return [value.address] if isinstance(value, PackedBytes) else [value]
