"""The elementary numeric types of IEC 61131-3, one row each.

Source: IEC 61131-3 (2013) table 10.
"""

import struct
from collections.abc import Mapping
from typing import TypeVar

from achse.iec.errors import IecDecodeError
from achse.iec.types import Adst, Buffer, IecType, derived_guid, no_attributes

V = TypeVar("V", int, float)


def base_guid(number: int) -> bytes:
    """Return the GUID of a base type; `number` fills its last bytes."""
    return bytes.fromhex("95190718") + bytes(8) + number.to_bytes(4, "big")


class ScalarType(IecType[V]):
    """A number that `struct` packs with one format character."""

    def __init__(
        self,
        name: str,
        code: str,
        adst: int,
        guid_number: int | None = None,
        *,
        attributes: Mapping[str, str] = no_attributes,
    ) -> None:
        self.codec = struct.Struct(f"<{code}")
        self.code = code
        size = self.codec.size
        super().__init__(name, size, size, adst, attributes=attributes)
        self.guid = derived_guid(name) if guid_number is None else base_guid(guid_number)

    def encode(self, value: object) -> bytes:
        try:
            return self.codec.pack(value)
        except (struct.error, OverflowError, TypeError, ValueError):
            raise self.reject(value) from None

    def decode(self, data: bytes | Buffer) -> V:
        try:
            value: V = self.codec.unpack_from(data)[0]
        except struct.error:
            raise IecDecodeError(f"{self.name} has {self.size} bytes, got {len(data)}") from None
        return value

    def read(self, buffer: Buffer, offset: int) -> V:
        value: V = self.codec.unpack_from(buffer, offset)[0]
        return value


class IntegerType(ScalarType[int]):
    """An integer; `low` and `high` are its limits."""

    def __init__(self, name: str, code: str, adst: int, guid_number: int | None = None) -> None:
        bits = 8 * struct.calcsize(f"<{code}")
        if code.islower():
            self.low, self.high = -(1 << bits - 1), (1 << bits - 1) - 1
        else:
            self.low, self.high = 0, (1 << bits) - 1
        # As recorded: hexadecimal, two's complement, as many digits as the type has.
        digits = bits // 4
        limits = {
            "DisplayMinValue": f"#x{self.low & (1 << bits) - 1:0{digits}x}",
            "DisplayMaxValue": f"#x{self.high:0{digits}x}",
        }
        super().__init__(name, code, adst, guid_number, attributes=limits)

    @property
    def expected(self) -> str:
        return f"an integer in {self.low}..{self.high}"


class RealType(ScalarType[float]):
    """A floating point number. REAL rounds to the nearest 32-bit value."""

    def __init__(self, name: str, code: str, adst: int, guid_number: int) -> None:
        # As recorded of REAL: what scopes and panels show, no limit of the value.
        limits = {"DisplayMinValue": "-10000", "DisplayMaxValue": "10000"}
        super().__init__(name, code, adst, guid_number, attributes=limits)

    @property
    def expected(self) -> str:
        return f"a number that {8 * self.size} bits of floating point can hold"


class BoolType(IecType[bool]):
    """BOOL in a byte of its own; BIT, the same as a member that shares its byte.

    Any byte but 0 is True. Takes True, False, 1 and 0.
    """

    def __init__(self, name: str, guid_number: int, *, is_bit: bool = False) -> None:
        limits = {"DisplayMinValue": "0", "DisplayMaxValue": "1"}
        super().__init__(name, 1, 1, Adst.BIT, attributes=limits)
        self.guid = base_guid(guid_number)
        self.is_bit = is_bit

    def encode(self, value: object) -> bytes:
        return b"\1" if self.truth(value) else b"\0"

    def decode(self, data: bytes | Buffer) -> bool:
        if not data:
            raise IecDecodeError(f"{self.name} has 1 byte, got none")
        return data[0] != 0

    def read(self, buffer: Buffer, offset: int) -> bool:
        return buffer[offset] != 0

    def write(self, buffer: Buffer, offset: int, value: object) -> None:
        buffer[offset] = self.truth(value)

    def truth(self, value: object) -> bool:
        """Return the value as bool. Raises `IecValueError` unless the value is a bool, 0 or 1."""
        if value is True or value is False:
            return value
        try:
            if value == 0 or value == 1:
                return bool(value)
        except Exception:
            raise self.reject(value) from None
        raise self.reject(value)

    @property
    def expected(self) -> str:
        return "True or False"


BOOL = BoolType("BOOL", 0x30)
BIT = BoolType("BIT", 0x10, is_bit=True)

BYTE = IntegerType("BYTE", "B", Adst.UINT8, 0x01)
USINT = IntegerType("USINT", "B", Adst.UINT8, 0x02)
SINT = IntegerType("SINT", "b", Adst.INT8, 0x03)
WORD = IntegerType("WORD", "H", Adst.UINT16, 0x04)
UINT = IntegerType("UINT", "H", Adst.UINT16, 0x05)
INT = IntegerType("INT", "h", Adst.INT16, 0x06)
DWORD = IntegerType("DWORD", "I", Adst.UINT32, 0x07)
UDINT = IntegerType("UDINT", "I", Adst.UINT32, 0x08)
DINT = IntegerType("DINT", "i", Adst.INT32, 0x09)
LWORD = IntegerType("LWORD", "Q", Adst.UINT64)
ULINT = IntegerType("ULINT", "Q", Adst.UINT64)
LINT = IntegerType("LINT", "q", Adst.INT64, 0x0C)
HRESULT = IntegerType("HRESULT", "i", Adst.INT32, 0x19)

REAL = RealType("REAL", "f", Adst.REAL32, 0x0D)
LREAL = RealType("LREAL", "d", Adst.REAL64, 0x0E)

# As wide as a pointer: here of a 64-bit target.
PVOID = IntegerType("PVOID", "Q", Adst.UINT64, 0x18)
UXINT = IntegerType("UXINT", "Q", Adst.UINT64, 0x71)
XINT = IntegerType("XINT", "q", Adst.INT64)
XWORD = IntegerType("XWORD", "Q", Adst.UINT64)

NARROW = (
    IntegerType("PVOID", "I", Adst.UINT32, 0x18),
    IntegerType("UXINT", "I", Adst.UINT32, 0x71),
    IntegerType("XINT", "i", Adst.INT32),
    IntegerType("XWORD", "I", Adst.UINT32),
)
"""The types as wide as a pointer on a 32-bit target."""

NUMERIC: tuple[BoolType | IntegerType | RealType, ...] = (
    BOOL, BIT, BYTE, USINT, SINT, WORD, UINT, INT, DWORD, UDINT, DINT, LWORD, ULINT, LINT,
    REAL, LREAL, HRESULT, PVOID, UXINT, XINT, XWORD,
)  # fmt: skip
