"""Symbol services: names, handles, values and the uploaded tables (index groups 0xF003 … 0xF011).

Source: 000 §5.3.2, 002 §6.3, 003; layouts and lengths as recorded from real targets. The symbols
themselves come from a `SymbolSource`, which a PLC, an NC or any other device implements.
"""

import struct
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

from achse.ams import DeviceError, Endpoint
from achse.codes import ReservedGroup, ReturnCode
from achse.server.limits import ClientLimits
from achse.server.table import IndexGroup, RawGroup, Reader
from achse.server.usage import Usage

__all__ = ["ResolvedSymbol", "SymbolServices", "SymbolSource", "TableSizes", "decode_name"]

_HANDLE = struct.Struct("<I")
_HANDLE_AND_TYPE = struct.Struct("<IIIH")
_ENTRY_SIZE = struct.Struct("<12xII")
_ENTRY_NAMES = struct.Struct("<24xHH2x")
_INFO = struct.Struct("<III")
_UPLOAD_INFO = struct.Struct("<II")
_UPLOAD_INFO_2 = struct.Struct("<9I28x")
_FIRST_HANDLE = 0x1B80_0001
"""Handles are opaque; this start only keeps them apart from notification handles in a log."""

_FREED_AT_ONCE = 10_000
"""Handles of a connection that is gone that are cleared in one go."""

_PIECE = 0x8000_0000
"""Table uploads in pieces: this bit in the offset, the byte position in the others."""


class ResolvedSymbol(Protocol):
    """A variable, member, element or method that a name resolves to."""

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
        """The symbol entry, as group 0xF009 answers it."""
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
    """What a device knows about its symbols.

    Anyone who changes the table raises `version` and calls `Device.symbols_changed()`.
    """

    @property
    def version(self) -> int:
        """0..255; differs after each download or online change."""
        ...

    def resolve(self, name: str) -> ResolvedSymbol | None:
        """The symbol `name` in any case, with members, indices, `^` and `#`; None if unknown.

        May raise DeviceError for a more telling code, such as 0x721 for an array index.
        """
        ...

    def upload_info(self) -> TableSizes: ...

    def symbol_table(self) -> bytes:
        """All symbol entries back to back; kept, not built again at each call."""
        ...

    def type_table(self) -> bytes:
        """All data type entries back to back; kept."""
        ...

    def type_entry(self, name: str) -> bytes | None:
        """One data type entry, None if unknown."""
        ...


def decode_name(data: bytes) -> str:
    """A name as clients send it, with or without NUL (texts are cp1252)."""
    return data.split(b"\0", 1)[0].decode("cp1252", "replace")


def _refuse_method() -> bytes:
    raise DeviceError(ReturnCode.INVALID_ACCESS, "a method has no value")


class _Handle:
    """A symbol as one client holds it, who asked over the connection `way`."""

    __slots__ = ("client", "read", "symbol", "way")

    def __init__(self, symbol: ResolvedSymbol, client: bytes, way: Endpoint | None) -> None:
        self.symbol = symbol
        self.client = client
        self.way = way
        self.read: Reader = symbol.read if symbol.call is None else _refuse_method


class SymbolServices:
    """The symbol services of one device, with the handles its clients hold.

    Handles are opaque and not zero, in a number space of their own; each belongs to the client
    address that asked for it, and ends with the connection by which it asked. After a change of the
    symbol table the old ones answer 0x711 until released; a handle that is not out answers 0x710,
    to its release 0x711. `way()` is the connection of the request
    that is being answered.
    """

    def __init__(
        self,
        source: SymbolSource,
        limits: ClientLimits,
        way: Callable[[], Endpoint | None] = lambda: None,
    ) -> None:
        self.source = source
        self.limits = limits
        self.usage = Usage(limits)
        self._way = way
        self.refused = 0
        """Handles that were not given because too many are out."""
        self._handles: dict[int, _Handle] = {}
        self._stale: dict[int, _Handle] = {}
        self._held: dict[bytes, dict[Endpoint | None, set[int]]] = {}
        self._clients_by_way: dict[Endpoint, set[bytes]] = {}
        self._over: list[set[int]] = []
        """Handles whose client or connection is gone, which are still to be cleared."""
        self._next = _FIRST_HANDLE

    @property
    def clients(self) -> Iterable[bytes]:
        """The addresses that hold handles."""
        return self._held

    def groups(self) -> Iterator[IndexGroup]:
        """The rows: one per index group."""
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
            request="UINT32 handle",
            description="Gives a handle back (RELEASE_SYMHANDLE).",
            source="000, 002, 003",
        )
        yield RawGroup(
            ReservedGroup.SYMBOL_INFO_BY_NAME,
            "symbol info by name",
            read_write=self._info_by_name,
            request="name",
            response="UINT32 group, offset, size",
            description="Where the value of a symbol lies.",
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
        name = decode_name(data)
        symbol = self.source.resolve(name) if name else None
        if symbol is None:
            raise DeviceError(ReturnCode.SYMBOL_NOT_FOUND, name[:80])
        return symbol

    def _handle_by_name(self, offset: int, read_length: int, data: bytes, client: bytes) -> bytes:
        if read_length < 4:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a handle is 4 bytes, asked {read_length}")
        way = self._way()
        if not getattr(way, "connected", True):
            raise DeviceError(ReturnCode.CLIENT_UNKNOWN, "its connection has ended")
        symbol = self._resolve(data)
        self._make_sure_of_room(client)
        handle = self._next
        while handle in self._handles or handle in self._stale:
            handle = handle + 1 & 0xFFFF_FFFF or 1
        self._next = handle + 1 & 0xFFFF_FFFF or 1
        self._handles[handle] = _Handle(symbol, client, way)
        self._held.setdefault(client, {}).setdefault(way, set()).add(handle)
        if way is not None:
            self._clients_by_way.setdefault(way, set()).add(client)
        self.usage.handles += 1
        return _HANDLE.pack(handle) if read_length == 4 else _handle_and_type(handle, symbol)

    def _make_sure_of_room(self, client: bytes) -> None:
        held = sum(map(len, self._held.get(client, {}).values()))
        if held >= self.limits.handles or self.usage.handles >= self.limits.all_handles:
            self.refused += 1
            raise DeviceError(
                ReturnCode.NO_MORE_HANDLES,
                f"{held} handles of the client, {self.usage.handles} of all",
            )

    def _release_handle(self, offset: int, data: bytes, client: bytes) -> None:
        if len(data) != 4:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a handle is 4 bytes, got {len(data)}")
        (handle,) = _HANDLE.unpack(data)
        entry = self._handles.get(handle) or self._stale.get(handle)
        ways = self._held.get(client, {})
        if entry is None or handle not in (held := ways.get(entry.way, set())):
            raise DeviceError(ReturnCode.SYMBOL_VERSION_INVALID, f"handle 0x{handle:X}")
        self._drop(handle)
        held.remove(handle)
        if not held:
            self._forget(client, entry.way)

    def _drop(self, handle: int) -> None:
        if self._handles.pop(handle, None) is None:
            del self._stale[handle]
        self.usage.handles -= 1

    def _forget(self, client: bytes, way: Endpoint | None) -> set[int]:
        """The client holds nothing by this way any more; what it held."""
        ways = self._held[client]
        handles = ways.pop(way)
        if not ways:
            del self._held[client]
        if way is not None:
            clients = self._clients_by_way[way]
            clients.remove(client)
            if not clients:
                del self._clients_by_way[way]
        return handles

    def _missing(self, handle: int, client: bytes) -> DeviceError:
        stale = self._stale.get(handle)
        if stale is not None and stale.client == client:
            return DeviceError(ReturnCode.SYMBOL_VERSION_INVALID, f"handle 0x{handle:X}")
        return DeviceError(ReturnCode.SYMBOL_NOT_FOUND, f"handle 0x{handle:X}")

    def _symbol(self, handle: int, client: bytes) -> ResolvedSymbol:
        entry = self._handles.get(handle)
        if entry is None or entry.client != client:
            raise self._missing(handle, client)
        return entry.symbol

    @property
    def count(self) -> int:
        """Handles that are out, those out of date among them."""
        return len(self._handles) + len(self._stale)

    def held(self, handle: int) -> ResolvedSymbol | None:
        """The symbol that a valid handle of any client stands for."""
        entry = self._handles.get(handle)
        return None if entry is None else entry.symbol

    def release_all(self, client: bytes) -> None:
        """Forget the handles of a client that is gone."""
        for way in list(self._held.get(client, ())):
            self._over.append(self._forget(client, way))
        self.clear()

    def release_way(self, way: Endpoint) -> None:
        """Forget the handles that were asked for by a connection that is gone."""
        clients = self._clients_by_way.get(way)
        if clients is not None:
            for client in list(clients):
                self._over.append(self._forget(client, way))
            self.clear()

    def clear(self) -> None:
        """Clear some of the handles of those who are gone; called about once a second."""
        count = _FREED_AT_ONCE
        while self._over and count:
            handles = self._over[-1]
            while handles and count:
                self._drop(handles.pop())
                count -= 1
            if not handles:
                self._over.pop()

    def invalidate(self) -> None:
        """The symbol table has changed: every handle is out of date."""
        self._stale.update(self._handles)
        self._handles.clear()

    # values ----------------------------------------------------------------------------------

    def _read_value(self, handle: int, length: int, client: bytes) -> bytes:
        entry = self._handles.get(handle)
        if entry is None or entry.client != client:
            raise self._missing(handle, client)
        return entry.read()

    def _watch_value(self, handle: int, length: int, client: bytes) -> Reader:
        symbol = self._symbol(handle, client)
        if symbol.call is not None:
            _refuse_method()
        read = symbol.read
        return read if symbol.size <= length else lambda: read()[:length]

    def _context(self, handle: int, client: bytes) -> int:
        return self._symbol(handle, client).context

    def _write_value(self, handle: int, data: bytes, client: bytes) -> None:
        symbol = self._symbol(handle, client)
        if symbol.read_only or symbol.call is not None:
            raise DeviceError(ReturnCode.INVALID_ACCESS, "the symbol is read only")
        if len(data) > symbol.size:
            raise DeviceError(
                ReturnCode.INVALID_SIZE, f"the symbol has {symbol.size} bytes, got {len(data)}"
            )
        if data:
            symbol.write(data)

    def _call_method(self, handle: int, read_length: int, data: bytes, client: bytes) -> bytes:
        call = self._symbol(handle, client).call
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
        name = decode_name(data)
        entry = self.source.type_entry(name) if name else None
        if entry is None:
            raise DeviceError(ReturnCode.SYMBOL_NOT_FOUND, name[:80])
        return entry


def _handle_and_type(handle: int, symbol: ResolvedSymbol) -> bytes:
    """What a client gets that asks for more than the handle: size, ADST id, name of the type."""
    entry = symbol.entry()
    size, adst = _ENTRY_SIZE.unpack_from(entry)
    name, type_name = _ENTRY_NAMES.unpack_from(entry)
    start = _ENTRY_NAMES.size + name + 1
    return (
        _HANDLE_AND_TYPE.pack(handle, size, adst, type_name) + entry[start : start + type_name + 1]
    )


def _piece(table: bytes, offset: int, length: int) -> bytes:
    """The part of an upload that `offset` asks for."""
    if offset == 0:
        return table
    if not offset & _PIECE:
        raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{offset:X}")
    position = offset & ~_PIECE
    return table[position : position + min(length, len(table))]
