"""The type classes of the vendor, and the records that ANY inputs are."""

from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import (
    AliasType,
    InterfaceType,
    PointerType,
    ReferenceType,
    SubrangeType,
)
from achse.iec.elementary import BOOL, IntegerType
from achse.iec.enums import EnumType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.check.operands import TypedOperand
from achse.st.typed.expressions import Composed
from achse.st.typed.places import flat

if TYPE_CHECKING:
    from achse.st.check.body import RoutineBody

_BY_NAME = {
    "BOOL": 0, "BIT": 1, "BYTE": 2, "WORD": 3, "DWORD": 4, "LWORD": 5, "SINT": 6, "INT": 7,
    "DINT": 8, "LINT": 9, "USINT": 10, "UINT": 11, "UDINT": 12, "ULINT": 13, "REAL": 14,
    "LREAL": 15, "TIME": 18, "DATE": 19, "DT": 20, "DATE_AND_TIME": 20, "TOD": 21,
    "TIME_OF_DAY": 21, "LTIME": 37, "HRESULT": 8, "PVOID": 5, "UXINT": 13, "XINT": 9, "XWORD": 5,
}  # fmt: skip
"""TYPE_CLASS of elementary types."""
_STRING, _WSTRING = 16, 17
_POINTER, _REFERENCE, _SUBRANGE, _ENUM, _ARRAY, _USER = 22, 23, 24, 25, 26, 28


def type_class(type: IecType[Any]) -> int:
    """Return the number that `TYPE_CLASS` has for a type."""
    while isinstance(type, AliasType) and not isinstance(type, SubrangeType):
        type = type.base
    if isinstance(type, SubrangeType):
        return _SUBRANGE
    if isinstance(type, EnumType):
        return _ENUM
    if isinstance(type, StringType):
        return _STRING if type.unit == 1 else _WSTRING
    if isinstance(type, ReferenceType):
        return _REFERENCE
    if isinstance(type, PointerType):
        return _USER if isinstance(type, InterfaceType) else _POINTER
    if isinstance(type, ArrayType):
        return _ARRAY
    if isinstance(type, StructType):
        return _USER
    return _BY_NAME.get(type.name, _USER)


def any_record(
    body: "RoutineBody", operand: TypedOperand, record: IecType[Any], at: int
) -> Composed:
    """Return the record that an ANY input gets for an argument: {TypeClass, pValue, diSize}."""
    assert isinstance(record, StructType)
    type = operand.type
    if operand.loose and operand.storage is None:
        real = operand.flat
        if isinstance(real, IntegerType) and real.size < 2:
            # As the vendor's compiler takes plain numbers: INT at least.
            operand = body.widened(operand, at)
            type = operand.type
    if operand.storage is not None and operand.storage.bit is not None:
        operand = TypedOperand(operand.value, BOOL)  # a copy: a bit has no address
    image = bytearray(record.size)
    members = record.members
    for member, value in ((members[0], type_class(type)), (members[2], flat(type).size)):
        data = value.to_bytes(member.type.size, "little")
        image[member.offset : member.offset + len(data)] = data
    pointer = members[1]
    address = body.paths.address(operand, pointer.type, at)
    return Composed(bytes(image), ((pointer.offset, address),), record, at)
