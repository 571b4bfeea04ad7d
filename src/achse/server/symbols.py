"""Symbol services: names, handles, values and the uploaded tables (index groups 0xF003 … 0xF011).

Source: 000 §5.3.2, 002 §6.3, 003; layouts and lengths as recorded from real targets. The symbols
themselves come from a `SymbolSource`, which a PLC, an NC or any other device implements.
"""

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from achse.ams import DeviceError, Endpoint
from achse.ams.text import terminated_text
from achse.codes import ReservedGroup, ReturnCode
from achse.server.handles import HandleTable
from achse.server.limits import ClientLimits
from achse.server.table import IndexGroup, RawGroup, Reader

_HANDLE = struct.Struct("<I")
_HANDLE_AND_TYPE = struct.Struct("<IIIH")
_ENTRY_SIZE = struct.Struct("<12xII")
_ENTRY_NAMES = struct.Struct("<24xHH2x")
_INFO = struct.Struct("<III")
_UPLOAD_INFO = struct.Struct("<II")
_UPLOAD_INFO_2 = struct.Struct("<9I28x")
_PIECE = 0x8000_0000
"""Table uploads in pieces: this bit in the offset, the byte position in the others."""


_LONGEST_SHARED = 256
"""Characters of a name whose handles share one symbol."""


class ResolvedSymbol(Protocol):
    """A variable, member, element or method that a name resolves to.

    Weak references to it must be possible: a class with slots has `__weakref__`.
    """

    @property
    def index_group(self) -> int: ...

    @property
    def index_offset(self) -> int: ...

    @property
    def size(self) -> int:
        """Bytes of the value."""
        ...

    @property
    def read_only(self) -> bool: ...

    @property
    def context(self) -> int:
        """Number of the task that owns the symbol (flag bits 8..11)."""
        ...

    @property
    def read(self) -> Callable[[], bytes]:
        """Takes the whole value, `size` bytes. Fetched once per handle, then called often."""
        ...

    @property
    def write(self) -> Callable[[bytes], None]:
        """Sets the first `len(data)` bytes of the value, 1 … `size`; the rest stays."""
        ...

    @property
    def call(self) -> Callable[[bytes], bytes] | None:
        """For a method: packed inputs to packed return value and outputs. None for a value."""
        ...

    def entry(self) -> bytes:
        """Return the symbol entry, as group 0xF009 answers it."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class TableSizes:
    """Counts and sizes of the tables, group 0xF00F; sizes are those of the table bytes."""

    symbol_count: int
    type_count: int
    max_dynamic_symbols: int = 2000
    used_dynamic_symbols: int = 0
    invalid_dynamic_symbols: int = 0
    code_page: int = 1252
    flags: int = 3
    """1 = 64-bit platform, 2 = base types are in the type table, 4 = strings are UTF-8."""


class SymbolSource(Protocol):
    """Symbols of a device, as the device provides them.

    A device that changes the table raises `version` and calls `Device.symbols_changed()`.
    """

    @property
    def version(self) -> int:
        """0..255; differs after each download or online change."""
        ...

    def resolve(self, name: str) -> ResolvedSymbol | None:
        """Return the symbol `name` in any case, with members, indices, `^` and `#`; None if
        unknown.

        May raise DeviceError for a more telling code, such as 0x721 for an array index.
        """
        ...

    def upload_info(self) -> TableSizes: ...

    def symbol_table(self) -> bytes:
        """Return all symbol entries back to back; kept, not built again at each call."""
        ...

    def type_table(self) -> bytes:
        """Return all data type entries back to back; kept."""
        ...

    def type_entry(self, name: str) -> bytes | None:
        """One data type entry, None if unknown."""
        ...


def _refuse_method() -> bytes:
    raise DeviceError(ReturnCode.INVALID_ACCESS, "a method has no value")


class SymbolServices:
    """The symbol services of one device; `handles` are those that its clients requested.

    `clock()` is the station's time, unix ns; `way()` the connection of the request that is being
    answered.
    """

    def __init__(
        self,
        source: SymbolSource,
        limits: ClientLimits,
        clock: Callable[[], int],
        way: Callable[[], Endpoint | None] = lambda: None,
    ) -> None:
        self.source = source
        self.handles: HandleTable[ResolvedSymbol] = HandleTable(limits, clock)
        self._handles = self.handles.valid
        self._way = way

    def groups(self) -> Iterator[IndexGroup]:
        """Yield the rows: one per index group."""
        yield RawGroup(
            ReservedGroup.SYMBOL_HANDLE_BY_NAME,
            "symbol handle by name",
            read_write=self._handle_by_name,
            request="name",
            response="UINT32 handle; if asked for: UINT32 size, ADST id, UINT16 length, type name",
            description="Gives a handle for a symbol or method (GET_SYMHANDLE_BYNAME).",
            source="002, 003",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_VALUE_BY_NAME,
            "symbol value by name",
            read_write=self._value_by_name,
            request="name",
            response="value",
            description="Reads a value in one call (READ_SYMVAL_BYNAME).",
            source="002",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_VALUE_BY_HANDLE,
            "symbol value by handle",
            read=self._read_value,
            write=self._write_value,
            read_write=self._call_method,
            watch=self._watch_value,
            context=self._context,
            last_offset=0xFFFF_FFFF,
            request="value, or method inputs packed",
            response="value, or method results packed",
            description="Offset = handle. ReadWrite calls a method (READ_/WRITE_SYMVAL_BYHANDLE).",
            source="000, 002, 003",
        )
        yield RawGroup(
            ReservedGroup.RELEASE_SYMBOL_HANDLE,
            "release symbol handle",
            write=self._release_handle,
            request="UINT32 handle, or nothing",
            description="Gives a handle back (RELEASE_SYMHANDLE). Without data: all that the client"
            " has abandoned, those that it requested over connections that have ended (achse).",
            source="000, 002, 003",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_INFO_BY_NAME,
            "symbol info by name",
            read_write=self._info_by_name,
            request="name",
            response="UINT32 group, offset, size",
            description="Address of the value of a symbol.",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_VERSION,
            "symbol version",
            read=lambda offset, length, client: bytes((self.source.version & 0xFF,)),
            response="UINT8",
            description="Changes with each download and online change; can be subscribed.",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_ENTRY_BY_NAME,
            "symbol entry by name",
            read_write=lambda offset, length, data, client: self._resolve(data).entry(),
            request="name",
            response="symbol entry",
            description="All facts of one symbol.",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_TABLE,
            "symbol table",
            read=lambda offset, length, client: _piece(self.source.symbol_table(), offset, length),
            last_offset=0xFFFF_FFFF,
            response="symbol entries",
            description="Upload of all symbols; offset 0x80000000 + position for pieces.",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_TABLE_SIZE,
            "symbol table size",
            read=self._upload_info,
            response="UINT32 count, bytes",
            description="What to expect from 0xF00B.",
        )
        yield RawGroup(
            ReservedGroup.TYPE_TABLE,
            "data type table",
            read=lambda offset, length, client: _piece(self.source.type_table(), offset, length),
            last_offset=0xFFFF_FFFF,
            response="data type entries",
            description="Upload of all data types; offset 0x80000000 + position for pieces.",
        )
        yield RawGroup(
            ReservedGroup.TABLE_SIZES,
            "table sizes",
            read=self._upload_info_2,
            response="UINT32[16]",
            description="Counts and bytes of both tables, code page, flags.",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_NOTIFICATION,
            "symbol notification",
            watch=self._watch_value,
            context=self._context,
            last_offset=0xFFFF_FFFF,
            description="Notification of a handle; offset = handle. Add Notification only.",
        )
        yield RawGroup(
            ReservedGroup.TYPE_ENTRY_BY_NAME,
            "data type entry by name",
            read_write=self._type_by_name,
            request="name",
            response="data type entry",
            description="All facts of one data type.",
        )

    # handles ---------------------------------------------------------------------------------

    def _resolve(self, data: bytes) -> ResolvedSymbol:
        name = terminated_text(data)
        symbol = self.source.resolve(name)
        if symbol is None:
            raise DeviceError(ReturnCode.SYMBOL_NOT_FOUND, name[:80])
        return symbol

    def _handle_by_name(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        if read_length < 4:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a handle is 4 bytes, asked {read_length}")
        way = self._way()
        if not getattr(way, "connected", True):
            raise DeviceError(ReturnCode.CLIENT_UNKNOWN, "its connection has ended")
        symbol = self._shared_symbol(data)
        read = symbol.read if symbol.call is None else _refuse_method
        handle = self.handles.add(symbol, read, client, way)
        return _HANDLE.pack(handle) if read_length == 4 else _handle_and_type(handle, symbol)

    def _shared_symbol(self, data: bytes) -> ResolvedSymbol:
        """Return the symbol of the handles that exist for a name, else resolve the name."""
        name = terminated_text(data)
        symbols = self.handles.symbols
        symbol = symbols.get(name)
        if symbol is None:
            symbol = self._resolve(data)
            if len(name) <= _LONGEST_SHARED:
                symbols[name] = symbol
        return symbol

    def _release_handle(self, offset: int, data: bytes, client: bytes) -> None:
        if not data:
            self.handles.release_abandoned(client)
            return
        if len(data) != 4:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a handle is 4 bytes, got {len(data)}")
        (handle,) = _HANDLE.unpack(data)
        self.handles.release(handle, client)

    # values ----------------------------------------------------------------------------------

    def _read_value(self, handle: int, length: int, client: bytes) -> bytes:
        entry = self._handles.get(handle) or self.handles.find(handle)
        return entry.read()

    def _watch_value(self, handle: int, length: int, client: bytes) -> Reader:
        symbol = self.handles.find(handle).symbol
        if symbol.call is not None:
            _refuse_method()
        read = symbol.read
        return read if symbol.size <= length else lambda: read()[:length]

    def _context(self, handle: int, client: bytes) -> int:
        return self.handles.find(handle).symbol.context

    def _write_value(self, handle: int, data: bytes, client: bytes) -> None:
        symbol = self.handles.find(handle).symbol
        if symbol.read_only or symbol.call is not None:
            raise DeviceError(ReturnCode.INVALID_ACCESS, "the symbol is read only")
        if len(data) > symbol.size:
            raise DeviceError(
                ReturnCode.INVALID_SIZE, f"the symbol has {symbol.size} bytes, got {len(data)}"
            )
        if data:
            symbol.write(data)

    def _call_method(self, handle: int, read_length: int, data: bytes, client: bytes) -> bytes:
        call = self.handles.find(handle).symbol.call
        if call is None:
            raise DeviceError(ReturnCode.INVALID_ACCESS, "the symbol is not a method")
        return call(data)

    def _value_by_name(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        symbol = self._resolve(data)
        return symbol.read() if symbol.call is None else _refuse_method()

    # tables ----------------------------------------------------------------------------------

    def _info_by_name(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        symbol = self._resolve(data)
        return _INFO.pack(symbol.index_group, symbol.index_offset, symbol.size)

    def _upload_info(self, offset: int, length: int, client: bytes) -> bytes:
        source = self.source
        return _UPLOAD_INFO.pack(source.upload_info().symbol_count, len(source.symbol_table()))

    def _upload_info_2(self, offset: int, length: int, client: bytes) -> bytes:
        source = self.source
        info = source.upload_info()
        return _UPLOAD_INFO_2.pack(
            info.symbol_count,
            len(source.symbol_table()),
            info.type_count,
            len(source.type_table()),
            info.max_dynamic_symbols,
            info.used_dynamic_symbols,
            info.invalid_dynamic_symbols,
            info.code_page,
            info.flags,
        )

    def _type_by_name(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        name = terminated_text(data)
        entry = self.source.type_entry(name)
        if entry is None:
            raise DeviceError(ReturnCode.SYMBOL_NOT_FOUND, name[:80])
        return entry


def _handle_and_type(handle: int, symbol: ResolvedSymbol) -> bytes:
    """Return the long answer to a handle request: handle, size, ADST id, name of the type."""
    entry = symbol.entry()
    size, adst = _ENTRY_SIZE.unpack_from(entry)
    name, type_name = _ENTRY_NAMES.unpack_from(entry)
    start = _ENTRY_NAMES.size + name + 1
    return (
        _HANDLE_AND_TYPE.pack(handle, size, adst, type_name) + entry[start : start + type_name + 1]
    )


def _piece(table: bytes, offset: int, length: int) -> bytes:
    """Return the part of an upload that `offset` asks for."""
    if offset == 0:
        return table
    if not offset & _PIECE:
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{offset:X}")
    position = offset & ~_PIECE
    return table[position : position + min(length, len(table))]
