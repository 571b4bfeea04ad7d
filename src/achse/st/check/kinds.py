"""Kinds of flat types, and the type that operands of an operator meet at."""

from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import InterfaceType, PointerType, resolved
from achse.iec.elementary import (
    BYTE,
    DINT,
    DWORD,
    INT,
    LINT,
    LREAL,
    LWORD,
    REAL,
    SINT,
    UDINT,
    UINT,
    ULINT,
    USINT,
    WORD,
    BoolType,
    IntegerType,
    RealType,
)
from achse.iec.enums import EnumType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.times import LTIME, TIME, TimeType
from achse.iec.types import IecType
from achse.st.typed.expressions import Known

SIGNED: dict[int, IntegerType] = {1: SINT, 2: INT, 4: DINT, 8: LINT}
UNSIGNED: dict[int, IntegerType] = {1: USINT, 2: UINT, 4: UDINT, 8: ULINT}
BITS: dict[int, IntegerType] = {1: BYTE, 2: WORD, 4: DWORD, 8: LWORD}
"""Integer types by their size in bytes."""

_DURATIONS = ("TIME", "LTIME")


def is_signed(type: IntegerType) -> bool:
    """Return True if a type of integers has numbers below 0."""
    return type.low < 0


def is_whole(type: IecType[Any]) -> bool:
    """Return True if values are counts in a number of bits: integers, times, pointers."""
    return isinstance(type, IntegerType | TimeType | PointerType)


def is_number(type: IecType[Any]) -> bool:
    """Return True if values are numbers for arithmetic: integers or reals."""
    return isinstance(type, IntegerType | RealType)


def is_text(type: IecType[Any]) -> bool:
    """Return True for a STRING or WSTRING."""
    return isinstance(type, StringType)


def is_pointer(type: IecType[Any]) -> bool:
    """Return True for a pointer, reference or interface."""
    return isinstance(type, PointerType)


def is_interface(type: IecType[Any]) -> bool:
    """Return True for a variable of an interface."""
    return isinstance(type, InterfaceType)


def is_duration(type: IecType[Any]) -> bool:
    """Return True for TIME or LTIME."""
    return isinstance(type, TimeType) and type.name in _DURATIONS


def is_date(type: IecType[Any]) -> bool:
    """Return True for a date, a time of day, or both."""
    return isinstance(type, TimeType) and type.name not in _DURATIONS


def counted(type: IecType[Any]) -> IntegerType:
    """Return the integer type that the bits of a value are: of a pointer or time the unsigned
    one."""
    return type if isinstance(type, IntegerType) else UNSIGNED[type.size]


def promoted(type: IecType[Any]) -> IntegerType:
    """Return the type a single operand computes in: DINT at least."""
    whole = counted(type)
    return DINT if whole.size < DINT.size else whole


def common_integer(left: IecType[Any], right: IecType[Any]) -> IntegerType:
    """Return the type that two integers compute in.

    As recorded of a real controller: below 32 bits everything is DINT; else the wider width,
    signed if either is.
    """
    first, second = counted(left), counted(right)
    size = max(first.size, second.size)
    if size < DINT.size:
        return DINT
    if first is second:
        return first
    return (SIGNED if is_signed(first) or is_signed(second) else UNSIGNED)[size]


def common_real(left: IecType[Any], right: IecType[Any]) -> RealType:
    """Return the type that numbers compute in of which at least one is real."""
    return LREAL if LREAL in (left, right) else REAL


def natural(value: int) -> IntegerType:
    """Return the smallest type that holds a whole number: unsigned for what is not below 0."""
    for size in (1, 2, 4, 8):
        type = (SIGNED if value < 0 else UNSIGNED)[size]
        if type.low <= value <= type.high:
            return type
    return LINT if value < 0 else ULINT


def same_shape(left: IecType[Any], right: IecType[Any]) -> bool:
    """Return True if all bytes of a value have the same meaning in both types."""
    if left is right:
        return True
    if isinstance(left, ArrayType) and isinstance(right, ArrayType):
        return left.count == right.count and same_shape(left.element, right.element)
    if isinstance(left, StructType) and isinstance(right, StructType):
        return left.guid == right.guid or extends(left, right) or _declared_twice(left, right)
    if isinstance(left, PointerType) and isinstance(right, PointerType):
        return left.size == right.size
    if isinstance(left, IntegerType) and isinstance(right, IntegerType):
        return left.name == right.name
    return left.guid == right.guid or _declared_twice(left, right)


def _declared_twice(left: IecType[Any], right: IecType[Any]) -> bool:
    """Return True if both are one type of a library, by its source and by a symbol file: there
    its name has a name space."""
    names = [type.name.lower().rpartition(".")[2] for type in (left, right)]
    if names[0] != names[1] or left.size != right.size:
        return False
    if isinstance(left, EnumType) and isinstance(right, EnumType):
        return left.numbers == right.numbers
    if isinstance(left, StructType) and isinstance(right, StructType):
        if left.kind is not right.kind or len(left.members) != len(right.members):
            return False
        return all(
            (one.name.lower(), one.offset) == (other.name.lower(), other.offset)
            and same_shape(one.type, other.type)
            for one, other in zip(left.members, right.members, strict=True)
        )
    return False


def extends(derived: StructType[Any], base: StructType[Any]) -> bool:
    """Return True if a record begins with all of another record, because it extends it."""
    here: StructType[Any] | None = derived
    while here is not None:
        if here is base or here.guid == base.guid:
            return True
        here = here.base
    return False


def duration_of(date: IecType[Any]) -> TimeType[Any]:
    """Return the type of a difference of dates: TIME; LTIME of the 64-bit ones."""
    return TIME if date.size == TIME.size else LTIME


def known_from(image: bytes, type: IecType[Any]) -> Known:
    """Return the constant that some bytes are, of a flat type."""
    if isinstance(type, BoolType):
        return Known(image[0] != 0, type)
    if isinstance(type, RealType):
        return Known(type.decode(image), type)
    if isinstance(type, StringType):
        text = image[: type.length * type.unit]
        if type.unit == 1:
            return Known(text.partition(b"\0")[0], type)
        end = next((at for at in range(0, len(text), 2) if text[at : at + 2] == b"\0\0"), len(text))
        return Known(text[:end], type)
    if is_whole(type):
        whole = counted(type)
        return Known(int.from_bytes(image, "little", signed=whole.low < 0), type)
    return Known(image, type)


def is_one_type_twice(have: IecType[Any], want: IecType[Any]) -> bool:
    """Return True if a library of ours and a symbol file both have this type: `AXIS_REF` and
    `Tc2_MC2.AXIS_REF`. The variable must be at least as long as the type that the block expects."""
    have, want = resolved(have), resolved(want)
    if isinstance(have, ArrayType) and isinstance(want, ArrayType):
        is_of_file = "." in have.element.name or "." in want.element.name
        return (
            is_of_file and have.size >= want.size and is_one_type_twice(have.element, want.element)
        )
    return (
        isinstance(have, StructType)
        and isinstance(want, StructType)
        and have.name.rpartition(".")[2].casefold() == want.name.rpartition(".")[2].casefold()
        and have.size >= want.size
    )
