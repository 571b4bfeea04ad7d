"""Data types of an object dictionary, by their CiA number.

Source: 001 §2.6; CiA 301, data types of the object dictionary.
"""

import struct
from enum import IntEnum

Number = int | float

_LARGEST_F32 = 3.4028234663852886e38
_LARGEST_F64 = 1.7976931348623157e308


class DataType(IntEnum):
    """A data type of the dictionary (CiA 301 §7.4.7.1): its number.

    `form` is the `struct` code of a number, empty for what is none; `bits` its size there, else 0.
    """

    form: str
    bits: int

    def __new__(cls, number: int, form: str = "") -> "DataType":
        member = int.__new__(cls, number)
        member._value_ = number
        member.form = form
        member.bits = 8 * struct.calcsize(form)
        return member

    BOOL = 0x01
    I8 = (0x02, "<b")
    I16 = (0x03, "<h")
    I32 = (0x04, "<i")
    U8 = (0x05, "<B")
    U16 = (0x06, "<H")
    U32 = (0x07, "<I")
    F32 = (0x08, "<f")
    VISIBLE_STRING = 0x09
    OCTET_STRING = 0x0A
    F64 = (0x11, "<d")
    I64 = (0x15, "<q")
    U64 = (0x1B, "<Q")
    PDO_MAPPING = 0x21
    IDENTITY = 0x23
    SYNC_MANAGER_PARAMETER = 0x29

    @property
    def least(self) -> Number:
        """The smallest number; TypeError if the type has none."""
        most = self.most
        if self.is_real:
            return -most
        return -(1 << self.bits - 1) if self.form[1].islower() else 0

    @property
    def most(self) -> Number:
        """The largest number; TypeError if the type has none."""
        if not self.form:
            raise TypeError(f"{self.name} is not a type of numbers")
        if self.is_real:
            return _LARGEST_F32 if self is DataType.F32 else _LARGEST_F64
        return (1 << (self.bits - 1 if self.form[1].islower() else self.bits)) - 1

    @property
    def is_real(self) -> bool:
        """True if the numbers are floats."""
        return self in (DataType.F32, DataType.F64)

    def pack(self, value: Number) -> bytes:
        """Return a number as it travels; struct.error if it is beyond the type."""
        return struct.pack(self.form, value)

    def unpack(self, data: bytes) -> Number:
        """Return the number that travelled; struct.error if there are not `bits` of it."""
        value: Number = struct.unpack(self.form, data)[0]
        return value
