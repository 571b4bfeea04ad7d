"""STRING(n) of 8-bit text, WSTRING(n) of UTF-16LE, both ended by a NUL.

Source: IEC 61131-3 (2013) table 10, no. 13 and 14; bytes as in TwinCAT 3.
"""

from functools import lru_cache

from achse.iec.elementary import base_guid
from achse.iec.errors import DeclarationError, IecDecodeError
from achse.iec.text import Coding, decode_text, decode_wide, encode_text, encode_wide
from achse.iec.types import Adst, Buffer, IecType

_LONGEST = 0x7FFF_FFFF


class StringType(IecType[str]):
    """`length` bytes of text and a NUL. `coding` is cp1252, or UTF-8 (`TcEncoding`)."""

    unit = 1
    family = "STRING"

    def __init__(self, length: int, coding: Coding = "cp1252") -> None:
        if not 0 <= length <= _LONGEST // self.unit - 1:
            raise DeclarationError(f"{self.family}(n) needs n from 0, got {length}")
        self.length = length
        self.coding = coding
        adst = Adst.STRING if self.unit == 1 else Adst.WSTRING
        super().__init__(f"{self.family}({length})", (length + 1) * self.unit, self.unit, adst)
        if self.unit == 1:
            self.guid = base_guid(length)[:11] + b"\1" + base_guid(length)[12:]

    def encode(self, value: object) -> bytes:
        return self.short(value).ljust(self.size, b"\0")

    def short(self, value: object) -> bytes:
        """Return the text and one NUL, without the rest: what a shorter write carries."""
        if not isinstance(value, str) or "\0" in value:
            raise self.reject(value)
        try:
            data = encode_text(value, self.coding)
        except UnicodeEncodeError:
            raise self.reject(value) from None
        if len(data) > self.length:
            raise self.reject(value)
        return data + b"\0"

    def cut(self, text: str) -> str:
        """As much of a text as there is room for, from the left."""
        text = text[: self.length]
        while text and self._room(text) > self.length:
            text = text[:-1]
        return text

    def _room(self, text: str) -> int:
        """Return the number of bytes of `length` that a text needs."""
        return len(text) if self.coding == "cp1252" else len(text.encode("utf-8", "replace"))

    def decode(self, data: bytes | Buffer) -> str:
        """Return the text up to the first NUL or the full length. Fewer bytes are a shorter
        text."""
        return decode_text(bytes(data[: self.length]).partition(b"\0")[0], self.coding)

    def read(self, buffer: Buffer, offset: int) -> str:
        return self.decode(buffer[offset : offset + self.size])

    @property
    def expected(self) -> str:
        return f"a str without NUL of at most {self.length} bytes in {self.coding}"


class WStringType(StringType):
    """`length` UTF-16 units and a NUL. A character beyond U+FFFF takes two units."""

    unit = 2
    family = "WSTRING"

    def short(self, value: object) -> bytes:
        if not isinstance(value, str) or "\0" in value:
            raise self.reject(value)
        try:
            data = encode_wide(value)
        except UnicodeEncodeError:
            raise self.reject(value) from None
        if len(data) > 2 * self.length:
            raise self.reject(value)
        return data + b"\0\0"

    def _room(self, text: str) -> int:
        return len(text.encode("utf-16-le", "replace")) // 2

    def decode(self, data: bytes | Buffer) -> str:
        if len(data) % 2:
            raise IecDecodeError(f"{self.name} has 2 bytes per unit, got {len(data)} bytes")
        units = bytes(data[: 2 * self.length])
        end = units.find(b"\0\0")
        while end % 2 and end > 0:
            end = units.find(b"\0\0", end + 1)
        return decode_wide(units if end < 0 else units[:end])

    @property
    def expected(self) -> str:
        return f"a str without NUL of at most {self.length} UTF-16 units"


def STRING(length: int = 80, coding: Coding = "cp1252") -> StringType:  # noqa: N802
    """`STRING(n)`: n bytes of text; 80 as in IEC 61131-3 if nothing is said."""
    return _string(length, coding)


def WSTRING(length: int = 80) -> WStringType:  # noqa: N802
    """`WSTRING(n)`: n UTF-16 units of text; 80 if nothing is said."""
    return _wide_string(length)


@lru_cache(maxsize=1024)
def _string(length: int, coding: Coding) -> StringType:
    return StringType(length, coding)


@lru_cache(maxsize=1024)
def _wide_string(length: int) -> WStringType:
    return WStringType(length)
