"""The symbol table on the wire: entries (0xF009, 0xF00B) and upload info (0xF00C, 0xF00F).

Source: 002 names the groups (system services); entries: recorded traffic of TwinCAT 3.1 targets and
the code of public clients; no manual prints it.
"""

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntFlag
from typing import Any, Self

from achse.iec.derived import ReferenceType, resolved
from achse.iec.entries import (
    BOUNDS,
    EntryReader,
    attribute_bytes,
    fitting,
    fitting_attributes,
    name_in_table,
    padded_entry,
    text_bytes,
)
from achse.iec.errors import IecDecodeError
from achse.iec.text import Coding, encode_name
from achse.iec.types import IecType, no_attributes

_HEAD = struct.Struct("<IIIIHHHHH")
_FAST_HEAD = struct.Struct("<IIIIIHHHHH")
_U16 = struct.Struct("<H")
_U32 = struct.Struct("<I")


class SymbolFlag(IntFlag):
    """The flags of a symbol entry. Bits 8..11 are the context (task) mask."""

    PERSISTENT = 0x0001
    BIT_VALUE = 0x0002
    REFERENCE = 0x0004
    TYPE_GUID = 0x0008
    TCOM_POINTER = 0x0010
    READ_ONLY = 0x0020
    METHOD_ACCESS = 0x0040
    METHOD_DEREF = 0x0080
    ATTRIBUTES = 0x1000
    STATIC = 0x2000
    INIT_ON_RESET = 0x4000
    FLAGS2 = 0x8000


def fold(name: str) -> str:
    """Return a name as compared and sorted: without case."""
    return name.lower()


@dataclass(frozen=True, slots=True)
class SymbolEntry:
    """One symbol: a named piece of memory. `flags` decides which optional parts are there."""

    name: str
    type_name: str
    index_group: int
    index_offset: int
    size: int
    adst: int
    flags: int = 0
    comment: str = ""
    dimensions: tuple[tuple[int, int], ...] = ()
    """Lower bound and element count of each. Recorded tables leave it empty for arrays."""
    guid: bytes = bytes(16)
    attributes: tuple[tuple[str, str], ...] = ()
    flags2: int = 0
    tail: bytes = b""
    """Unknown parts of the entry."""

    @classmethod
    def of(
        cls,
        name: str,
        type: IecType[Any],
        index_group: int,
        index_offset: int,
        *,
        flags: int = 0,
        context: int = 1,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> Self:
        """Return the entry of a variable of `type`; `context` is the task mask (0 for none)."""
        flags |= SymbolFlag.TYPE_GUID | (context & 0xF) << 8
        if attributes:
            flags |= SymbolFlag.ATTRIBUTES
        if isinstance(resolved(type), ReferenceType):
            flags |= SymbolFlag.REFERENCE
        if type.is_bit:
            flags |= SymbolFlag.BIT_VALUE
        return cls(
            name_in_table(name),
            name_in_table(type.name),
            index_group,
            index_offset,
            type.size,
            int(type.adst),
            int(flags),
            fitting(comment),
            guid=type.guid,
            attributes=fitting_attributes(attributes),
        )

    @property
    def context(self) -> int:
        """The task mask, 0..15."""
        return self.flags >> 8 & 0xF

    def encode(self, coding: Coding = "cp1252") -> bytes:
        """Return the entry with its length, padded to 8 bytes. Raises `IecValueError`."""
        name = text_bytes(self.name, coding, "a symbol name")
        type_name = text_bytes(self.type_name, coding, "a type name")
        comment = text_bytes(self.comment, coding, "a comment")
        flags = self.flags
        parts = [
            _HEAD.pack(
                self.index_group,
                self.index_offset,
                self.size,
                self.adst,
                flags,
                len(self.dimensions),
                len(name),
                len(type_name),
                len(comment),
            ),
            name,
            b"\0",
            type_name,
            b"\0",
            comment,
            b"\0",
        ]
        parts += [BOUNDS.pack(*bounds) for bounds in self.dimensions]
        if flags & SymbolFlag.TYPE_GUID:
            parts.append(self.guid)
        if flags & SymbolFlag.ATTRIBUTES:
            parts.append(_U16.pack(len(self.attributes)))
            parts.append(attribute_bytes(self.attributes, coding))
        if flags & SymbolFlag.FLAGS2:
            parts.append(_U32.pack(self.flags2))
        return padded_entry(b"".join(parts), self.tail)

    @classmethod
    def decode(cls, data: bytes, coding: Coding = "cp1252") -> Self:
        """Return the entry at the start of `data`. Raises `IecDecodeError`."""
        return cls._read(EntryReader.entry(data, 0, len(data), "symbol entry", coding))

    @classmethod
    def _read(cls, cursor: EntryReader) -> Self:
        group, offset, size, adst, flags, dims, name, type_name, comment = cursor.unpack(_HEAD)
        texts = cursor.text(name), cursor.text(type_name), cursor.text(comment)
        dimensions = tuple(cursor.bounds() for _ in range(dims))
        guid = cursor.take(16) if flags & SymbolFlag.TYPE_GUID else bytes(16)
        attributes = cursor.attributes(cursor.u16()) if flags & SymbolFlag.ATTRIBUTES else ()
        flags2 = cursor.u32() if flags & SymbolFlag.FLAGS2 else 0
        return cls(
            texts[0],
            texts[1],
            group,
            offset,
            size,
            adst,
            flags,
            texts[2],
            dimensions,
            guid,
            attributes,
            flags2,
            cursor.tail(),
        )


class SymbolEncoder:
    """Encodes many variables as `SymbolEntry.of(…).encode()` does, several times as fast.

    A type is looked at once. What the table cannot hold does not stop the upload: signs outside
    cp1252 become `?`, attributes are cut at 255 bytes.
    """

    def __init__(self) -> None:
        self._types: dict[int, tuple[IecType[Any], bytes, int, bytes]] = {}

    def __call__(
        self,
        name: str,
        type: IecType[Any],
        index_group: int,
        index_offset: int,
        flags: int = 0,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
    ) -> bytes:
        """Return the entry; `flags` with the task mask, the flags of the type come by
        themselves."""
        known = self._types.get(id(type))
        if known is None:
            own = SymbolEntry.of("", type, 0, 0, context=0).flags
            raw = encode_name(type.name)
            known = self._types[id(type)] = (type, raw, own, type.guid)
        _, type_name, own, guid = known
        raw_name = encode_name(name)
        raw_comment = comment.encode("cp1252", "replace")[:0xFFFF] if comment else b""
        tail = b""
        if attributes:
            own |= SymbolFlag.ATTRIBUTES
            pairs = fitting_attributes(attributes)
            tail = _U16.pack(len(pairs)) + attribute_bytes(pairs, "cp1252")
        lengths = len(raw_name), len(type_name), len(raw_comment)
        size = 4 + _HEAD.size + sum(lengths) + 3 + 16 + len(tail)
        padding = -size % 8
        head = _FAST_HEAD.pack(
            size + padding,
            index_group,
            index_offset,
            type.size,
            type.adst,
            flags | own,
            0,
            *lengths,
        )
        return b"%b%b\0%b\0%b\0%b%b%b" % (
            head,
            raw_name,
            type_name,
            raw_comment,
            guid,
            tail,
            bytes(padding),
        )


def encode_symbols(symbols: Iterable[SymbolEntry], coding: Coding = "cp1252") -> bytes:
    """Return the upload of 0xF00B: entries back to back, sorted by name without case."""
    ordered = sorted(symbols, key=lambda symbol: symbol.name.lower())
    return b"".join([symbol.encode(coding) for symbol in ordered])


def decode_symbols(data: bytes, coding: Coding = "cp1252") -> list[SymbolEntry]:
    """Return all entries of an upload, in its order. Raises `IecDecodeError`."""
    symbols = []
    position = 0
    while position < len(data):
        cursor = EntryReader.entry(data, position, len(data), "symbol entry", coding)
        symbols.append(SymbolEntry._read(cursor))
        position = cursor.end
    return symbols


class UploadFlag(IntFlag):
    """The flags of upload info 2."""

    PLATFORM_64_BIT = 1
    BASE_TYPES = 2
    """The base types are in the type table."""
    UTF8 = 4


@dataclass(frozen=True, slots=True)
class UploadInfo:
    """Upload info 2 (0xF00F, 64 bytes); its first 8 bytes are upload info (0xF00C)."""

    symbol_count: int
    symbol_bytes: int
    type_count: int = 0
    type_bytes: int = 0
    max_dynamic_symbols: int = 2000
    used_dynamic_symbols: int = 0
    invalid_dynamic_symbols: int = 0
    code_page: int = 1252
    flags: int = UploadFlag.PLATFORM_64_BIT | UploadFlag.BASE_TYPES

    def encode(self) -> bytes:
        """64 bytes; answer as many as were requested."""
        return _INFO.pack(
            self.symbol_count,
            self.symbol_bytes,
            self.type_count,
            self.type_bytes,
            self.max_dynamic_symbols,
            self.used_dynamic_symbols,
            self.invalid_dynamic_symbols,
            self.code_page,
            self.flags,
        )

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """At least the 8 bytes of upload info; what an older target leaves out is 0."""
        if len(data) < 8:
            raise IecDecodeError(f"upload info has at least 8 bytes, got {len(data)}")
        return cls(*_INFO.unpack(data[:36].ljust(64, b"\0")))

    @property
    def coding(self) -> Coding:
        """Encoding of the texts in the tables."""
        return "utf-8" if self.flags & UploadFlag.UTF8 else "cp1252"


_INFO = struct.Struct("<9I28x")
