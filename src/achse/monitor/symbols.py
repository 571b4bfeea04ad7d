"""Known symbols of one device, learned from the tables, entries and handles in the traffic.

The monitor sends no requests: it learns when any client uploads a table, requests an entry or a
handle, or reads the symbol version.
"""

import struct
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

from achse.codes import ReservedGroup
from achse.iec import IecDecodeError, IecError, IecType, resolved
from achse.iec.arrays import ArrayType
from achse.iec.datatypes import DataTypeEntry
from achse.iec.paths import locate, split_symbol
from achse.iec.structs import StructType
from achse.iec.symbols import SymbolEntry, UploadFlag, UploadInfo, fold
from achse.iec.text import Coding
from achse.iec.typetable import TypeTable

_MOST = 1 << 18
"""Names that are kept, and handles; the oldest is forgotten."""

_NESTED = 64
"""Symbols that begin before a place and are looked at for one that covers it: those that clients
asked for may be parts of others."""

_LONGEST_REST = 1 << 20
"""Bytes of an entry that is not whole yet; no real one is as long."""

_UPLOADS = 16
"""Uploads in pieces that are followed at a time."""

_PIECE = 0x8000_0000
"""In the offset of 0xF00B and 0xF00E: a piece of the table, from the position in the other bits."""

_PLACE = struct.Struct("<III")
_HANDLE_AND_TYPE = struct.Struct("<IIIH")
_LENGTH = struct.Struct("<I")


class _Upload:
    """A table that comes in pieces: where the next one begins, and the entry cut in two."""

    def __init__(self) -> None:
        self.position = 0
        self.rest = b""


class KnownSymbols:
    """Names, places, types and handles of one device, as far as they have been received."""

    def __init__(self) -> None:
        self._entries: dict[str, SymbolEntry] = {}
        self._places: dict[int, dict[tuple[int, int], SymbolEntry]] = {}
        """By index group, then by offset and size: a structure begins where its first part does."""
        self._in_order: dict[int, list[SymbolEntry]] = {}
        """By index group, sorted by offset and size; made with the first query."""
        self._handles: dict[int, str] = {}
        self._types = TypeTable()
        self._type_by_name: dict[str, IecType[Any] | None] = {}
        self._uploads: dict[tuple[bytes, int], _Upload] = {}
        self._coding: Coding = "cp1252"
        self._version: bytes | None = None
        self.is_whole = False
        """True until a complete download has become out of date."""

    # learning --------------------------------------------------------------------------------

    def learn_symbol(self, entry: SymbolEntry) -> None:
        """Learn a symbol with its place, size and type."""
        _keep(self._entries, fold(entry.name), entry)
        if entry.index_group:
            _keep(self._places.setdefault(entry.index_group, {}), _place(entry), entry)
            self._in_order.pop(entry.index_group, None)
        self._type_by_name.clear()

    def learn_types(self, entries: Iterable[DataTypeEntry]) -> None:
        """Learn types that are not elementary."""
        for entry in entries:
            if entry.name and (len(self._types) < _MOST or entry.name in self._types):
                self._types.add(entry)
        self._type_by_name.clear()

    def learn_handle(self, name: str, data: bytes) -> None:
        """Learn from the answer to 0xF003: a handle, and the type if the client requested it."""
        if len(data) < _LENGTH.size:
            return
        _keep(self._handles, _LENGTH.unpack_from(data)[0], name)
        if len(data) > _HANDLE_AND_TYPE.size and fold(name) not in self._entries:
            _, size, adst, length = _HANDLE_AND_TYPE.unpack_from(data)
            start = _HANDLE_AND_TYPE.size
            type_name = self.text(data[start : start + length])
            self.learn_symbol(SymbolEntry(name, type_name, 0, 0, size, adst))

    def learn_place(self, name: str, data: bytes) -> None:
        """Learn from the answer to 0xF007: group, offset and size, but no type."""
        if len(data) == _PLACE.size and fold(name) not in self._entries:
            group, offset, size = _PLACE.unpack(data)
            self.learn_symbol(SymbolEntry(name, "", group, offset, size, 0))

    def learn_info(self, data: bytes) -> None:
        """Learn from the answer to 0xF00F: how texts are coded and how long pointers are."""
        try:
            info = UploadInfo.decode(data)
        except IecDecodeError:
            return
        self._coding = info.coding
        if info.code_page and not info.flags & UploadFlag.PLATFORM_64_BIT:
            self._types.pointer_size = 4

    def learn_table(self, client: bytes, group: int, offset: int, data: bytes) -> None:
        """Learn from an upload or its part (0xF00B, 0xF00E), or from entries (0xF009, 0xF011)."""
        if offset & _PIECE:
            data = self._joined(client, group, offset & ~_PIECE, data)
        if group in (ReservedGroup.TYPE_TABLE, ReservedGroup.TYPE_ENTRY_BY_NAME):
            self.learn_types(self._decoded(DataTypeEntry, data))
        else:
            for entry in self._decoded(SymbolEntry, data):
                self.learn_symbol(entry)

    def complete(self, other: "KnownSymbols") -> None:
        """Take types from another device with the same program where none are known."""
        for key, entry in other._entries.items():
            if key not in self._entries:
                self.learn_symbol(replace(entry, index_group=0, index_offset=0))
        self.learn_types(entry for entry in other._types if entry.name not in self._types)

    def learn_version(self, data: bytes) -> None:
        """Learn the symbol version (0xF008): another one makes all that was known out of date."""
        if self._version not in (None, data):
            for known in (
                self._entries,
                self._places,
                self._in_order,
                self._handles,
                self._uploads,
            ):
                known.clear()
            self._types = TypeTable(pointer_size=self._types.pointer_size)
            self._type_by_name.clear()
            self.is_whole = False
        self._version = data

    def _joined(self, client: bytes, group: int, position: int, data: bytes) -> bytes:
        """Return the whole entries that a piece completes."""
        if position == 0:
            self._uploads.pop((client, group), None)
            _keep(self._uploads, (client, group), _Upload(), _UPLOADS)
        upload = self._uploads.get((client, group))
        if upload is None or position != upload.position:
            return b""
        upload.position += len(data)
        data = upload.rest + data
        end = 0
        while end + _LENGTH.size <= len(data):
            length = _LENGTH.unpack_from(data, end)[0]
            if length < _LENGTH.size or end + length > len(data):
                break
            end += length
        upload.rest = data[end:]
        if len(upload.rest) > _LONGEST_REST:
            del self._uploads[client, group]
        return data[:end]

    def _decoded(self, kind: Any, data: bytes) -> Iterator[Any]:
        """Yield each entry that can be read; one that cannot does not hide those behind it."""
        position = 0
        while position + _LENGTH.size <= len(data):
            length = _LENGTH.unpack_from(data, position)[0]
            if length < _LENGTH.size or position + length > len(data):
                return
            with suppress(IecDecodeError):
                yield kind.decode(data[position : position + length], self._coding)
            position += length

    # asking ----------------------------------------------------------------------------------

    def text(self, raw: bytes) -> str:
        """Return a text of the device up to its NUL."""
        return raw.split(b"\0", 1)[0].decode(self._coding, "replace")

    def handle_name(self, handle: int) -> str:
        """Return the name of a handle; empty if unknown."""
        return self._handles.get(handle, "")

    def at(self, group: int, offset: int, length: int) -> str:
        """Return the name of what is at a place: a symbol, the part of one, or what begins
        there."""
        places = self._places.get(group)
        if places is None:
            return ""
        name = places.get((offset, length))
        if name is not None:
            return name.name
        entries = self._in_order.get(group)
        if entries is None:
            entries = self._in_order[group] = sorted(places.values(), key=_place)
        end = bisect_right(entries, offset, key=_offset)
        beginning = ""
        for entry in reversed(entries[max(end - _NESTED, 0) : end]):
            if entry.index_offset == offset:
                beginning = beginning or entry.name
            if offset + length <= entry.index_offset + entry.size:
                type = self.type_of(entry.name)
                part = _path(entry.name, type, offset - entry.index_offset, length) if type else ""
                return part or beginning
        return beginning

    def type_of(self, name: str) -> IecType[Any] | None:
        """Return the type of a symbol or of a part of one, None if it is not known."""
        if not self._entries:
            return None
        key = fold(name)
        if key not in self._type_by_name:
            _keep(self._type_by_name, key, self._find(name))
        return self._type_by_name[key]

    def _find(self, name: str) -> IecType[Any] | None:
        try:
            root, rest = split_symbol(name, self._entries)
            type = self._types.symbol_type(self._entries[root])
            if not rest:
                return type
            match = locate(type, rest)
        except IecError:
            return None
        return None if match.method is not None else match.type


def _offset(entry: SymbolEntry) -> int:
    return entry.index_offset


def _place(entry: SymbolEntry) -> tuple[int, int]:
    return entry.index_offset, entry.size


def _path(name: str, type: IecType[Any], offset: int, length: int) -> str:
    """Return the path from `name` to the `length` bytes at `offset` of its type, empty if none
    is."""
    while offset or type.size != length:
        real = resolved(type)
        if isinstance(real, StructType):
            for member in real.fields:
                if member.offset <= offset and offset + length <= member.offset + member.type.size:
                    break
            else:
                return ""
            name, type, offset = f"{name}.{member.name}", member.type, offset - member.offset
        elif isinstance(real, ArrayType) and real.element.size:
            number, offset = divmod(offset, real.element.size)
            indices = []
            for bounds in reversed(real.dimensions):
                number, index = divmod(number, bounds.length)
                indices.append(str(bounds.first + index))
            name, type = f"{name}[{','.join(reversed(indices))}]", real.element
        else:
            return ""
    return name


def _keep(known: dict[Any, Any], key: Any, value: Any, most: int = _MOST) -> None:
    """Note `value`, and forget the oldest if there are too many."""
    known[key] = value
    if len(known) > most:
        del known[next(iter(known))]
