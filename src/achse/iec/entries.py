"""The parts that symbol and type entries are made of: lengths, texts, bounds, attributes.

Source: recorded traffic of TwinCAT 3.1 targets and the code of public clients; no manual prints it.
"""

import struct
from collections.abc import Iterable, Mapping
from typing import Any

from achse.iec.errors import IecDecodeError, IecValueError
from achse.iec.text import Coding, decode_text, encode_name, encode_text

BOUNDS = struct.Struct("<iI")
"""Lower bound and element count of one dimension."""

_U16 = struct.Struct("<H")
_U32 = struct.Struct("<I")
_PAIR = struct.Struct("<BB")


class EntryReader:
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
    ) -> "EntryReader":
        """Return a cursor over one entry that starts with its own length, placed after the
        length."""
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
        """Return the next fields."""
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
        """Return a text of `length` bytes and the NUL behind it."""
        raw = self.take(length + 1)
        if raw[-1]:
            raise IecDecodeError(f"a text of a {self.what} has no NUL after {length} bytes")
        return decode_text(raw[:-1], self.coding)

    def bounds(self) -> tuple[int, int]:
        """Lower bound and element count of one dimension."""
        first, count = self.unpack(BOUNDS)
        return first, count

    def child(self, what: str, width: int = 4) -> "EntryReader":
        """Return a cursor over the entry at this position, which moves on behind it."""
        child = EntryReader.entry(
            self.data, self.position, self.end, what, self.coding, width=width
        )
        self.position = child.end
        return child

    def tail(self) -> bytes:
        """Return the rest of the entry, without the padding that `padded_entry` writes."""
        rest = self.take(self.left)
        padding = len(rest) < 8 and self.length % 8 == 0 and not any(rest)
        return b"" if padding else rest

    def attributes(self, count: int) -> tuple[tuple[str, str], ...]:
        """`count` attributes: u8 name length, u8 value length, name NUL, value NUL."""
        attributes = []
        for _ in range(count):
            name, value = self.unpack(_PAIR)
            attributes.append((self.text(name), self.text(value)))
        return tuple(attributes)


def open_entry(body: bytes, tail: bytes = b"") -> bytes:
    """Return an entry with its length before it, as long as it is."""
    return _U32.pack(4 + len(body) + len(tail)) + body + tail


def padded_entry(body: bytes, tail: bytes = b"") -> bytes:
    """Return an entry with its length before it, and zeros up to a multiple of 8.

    An unknown tail ends the entry as it came.
    """
    return open_entry(body, tail or bytes(-(4 + len(body)) % 8))


def text_bytes(text: str, coding: Coding, what: str, longest: int = 0xFFFF) -> bytes:
    """Return a table text without its NUL. Raises `IecValueError` if it has no code or is too
    long."""
    try:
        data = encode_text(text, coding)
    except UnicodeEncodeError:
        raise IecValueError(what, f"a text in {coding}", text) from None
    if len(data) > longest:
        raise IecValueError(what, f"a text of at most {longest} bytes", text)
    return data


def fitting(text: str, longest: int = 0xFFFF) -> str:
    """Return the part of a comment or attribute that a table can store: `longest` characters of
    cp1252."""
    if text.isascii() and len(text) <= longest:
        return text
    return text.encode("cp1252", "replace")[:longest].decode("cp1252", "replace")


def name_in_table(name: str, longest: int = 0xFFFF) -> str:
    """Return the form of a name of a PLC program that a table in cp1252 can store."""
    return name if name.isascii() else encode_name(name)[:longest].decode("cp1252")


def fitting_attributes(attributes: Mapping[str, str]) -> tuple[tuple[str, str], ...]:
    """Attributes as a table can hold them: names and values of at most 255 bytes."""
    return tuple((fitting(key, 0xFF), fitting(text, 0xFF)) for key, text in attributes.items())


def short_text(text: str, coding: Coding, what: str) -> bytes:
    """Return a table text whose length is one byte."""
    return text_bytes(text, coding, what, 0xFF)


def attribute_bytes(attributes: Iterable[tuple[str, str]], coding: Coding) -> bytes:
    """Attributes as both tables write them, without their count."""
    parts = []
    for name, value in attributes:
        raw_name = short_text(name, coding, "an attribute name")
        raw_value = short_text(value, coding, f"attribute {name}")
        parts.append(b"%c%c%b\0%b\0" % (len(raw_name), len(raw_value), raw_name, raw_value))
    return b"".join(parts)
