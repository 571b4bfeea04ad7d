"""Reading table entries: a position in bytes that never goes beyond what is there."""

import struct
from collections.abc import Iterable
from typing import Any

from achse.iec.errors import IecDecodeError, IecValueError
from achse.iec.text import Coding, decode_text, encode_text

__all__ = ["Cursor", "attribute_bytes", "short_text", "text_bytes"]

_U16 = struct.Struct("<H")
_U32 = struct.Struct("<I")
_PAIR = struct.Struct("<BB")


class Cursor:
    """Reads `data` from `position` up to `end`; every fault is an `IecDecodeError`.

    `what` names the thing being read, for the message.
    """

    __slots__ = ("coding", "data", "end", "position", "start", "what")

    def __init__(
        self, data: bytes, position: int, end: int, what: str, coding: Coding = "cp1252"
    ) -> None:
        self.data = data
        self.start = position
        self.position = position
        self.end = end
        self.what = what
        self.coding = coding

    @classmethod
    def entry(
        cls, data: bytes, position: int, limit: int, what: str, coding: Coding, *, width: int = 4
    ) -> "Cursor":
        """A cursor over one entry that starts with its own length, placed after the length."""
        cursor = cls(data, position, limit, what, coding)
        length = cursor.u32() if width == 4 else cursor.u16()
        if not width <= length <= limit - position:
            raise IecDecodeError(f"a {what} announces {length} bytes, {limit - position} are left")
        cursor.end = position + length
        return cursor

    @property
    def length(self) -> int:
        return self.end - self.start

    @property
    def left(self) -> int:
        return self.end - self.position

    def take(self, count: int) -> bytes:
        """The next `count` bytes."""
        start = self.position
        if count > self.end - start:
            raise IecDecodeError(f"a {self.what} ends {count - self.left} bytes too early")
        self.position = start + count
        return self.data[start : start + count]

    def unpack(self, layout: struct.Struct) -> tuple[Any, ...]:
        """The next fields."""
        start = self.position
        if layout.size > self.end - start:
            raise IecDecodeError(f"a {self.what} ends {layout.size - self.left} bytes too early")
        self.position = start + layout.size
        return layout.unpack_from(self.data, start)

    def u16(self) -> int:
        value: int = self.unpack(_U16)[0]
        return value

    def u32(self) -> int:
        value: int = self.unpack(_U32)[0]
        return value

    def text(self, length: int) -> str:
        """A text of `length` bytes and the NUL behind it."""
        raw = self.take(length + 1)
        if raw[-1]:
            raise IecDecodeError(f"a text of a {self.what} has no NUL after {length} bytes")
        return decode_text(raw[:-1], self.coding)

    def attributes(self, count: int) -> tuple[tuple[str, str], ...]:
        """`count` attributes: u8 name length, u8 value length, name NUL, value NUL."""
        found = []
        for _ in range(count):
            name, value = self.unpack(_PAIR)
            found.append((self.text(name), self.text(value)))
        return tuple(found)


def text_bytes(text: str, coding: Coding, what: str, longest: int = 0xFFFF) -> bytes:
    """A table text without its NUL. Raises `IecValueError` if it has no code or is too long."""
    try:
        data = encode_text(text, coding)
    except UnicodeEncodeError:
        raise IecValueError(what, f"a text in {coding}", text) from None
    if len(data) > longest:
        raise IecValueError(what, f"a text of at most {longest} bytes", text)
    return data


def short_text(text: str, coding: Coding, what: str) -> bytes:
    """A table text whose length is one byte."""
    return text_bytes(text, coding, what, 0xFF)


def attribute_bytes(attributes: Iterable[tuple[str, str]], coding: Coding) -> bytes:
    """Attributes as both tables write them, without their count."""
    parts = []
    for name, value in attributes:
        raw_name = short_text(name, coding, "an attribute name")
        raw_value = short_text(value, coding, f"attribute {name}")
        parts.append(b"%c%c%b\0%b\0" % (len(raw_name), len(raw_value), raw_name, raw_value))
    return b"".join(parts)
