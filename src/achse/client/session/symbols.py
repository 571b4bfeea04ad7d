"""Symbols of a device, as known to a client: their places, their types, their handles.

They are fetched at the first request, all requests of one turn of the loop together (entries
0xF009, types 0xF011, handles 0xF003), and shared by all clients of the same device. They are
dropped when the link is lost or the device reports that its symbols changed (0xF008).
"""

import asyncio
import contextlib
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple, ParamSpec, TypeVar

from achse.ams import (
    AdsError,
    AmsAddress,
    ConnectionLost,
    DecodeError,
    DeviceError,
    TransmissionMode,
)
from achse.ams.commands import ReadWriteRequest, WriteRequest
from achse.client.session.hints import hint_for, hint_inside
from achse.client.session.raw import AREAS, NOT_OFFERED, RawTarget
from achse.client.session.subscription import Subscription, Timing, VariableLocation
from achse.client.session.sums import Outcome
from achse.codes import ReservedGroup, ReturnCode
from achse.iec import USINT, DeclarationError, IecDecodeError, IecPathError
from achse.iec.datatypes import DataTypeEntry, decode_types
from achse.iec.names import name_within
from achse.iec.paths import follow, parse_path, split_symbol
from achse.iec.symbols import SymbolEntry, UploadFlag, UploadInfo, decode_symbols, fold
from achse.iec.text import Coding, decode_text, encode_name, encode_text
from achse.iec.typetable import TypeTable

_ENTRY_LENGTH = 0xFFFF
_TYPE_LENGTH = 0xF_FFFF
_HEAD = struct.Struct("<IIIIIHHHHH")
_NOT_THERE = frozenset(
    row.number for row in (ReturnCode.SYMBOL_NOT_FOUND, ReturnCode.INVALID_ARRAY_INDEX)
)
_HINT_TIME = 1.0
"""Seconds that a device may take to list its symbols for a hint; without hint after that."""
_LARGEST_LISTING = 8_000_000
_MOST_HINTS = 8
"""Of more names that are not there at once the others get no hint."""
_MOST_KEPT = 1000
_VERSION = Timing.of(TransmissionMode.SERVER_ON_CHANGE, 0.0, 0.0)


P = ParamSpec("P")
T = TypeVar("T")


class _Wish(NamedTuple):
    """A symbol that a caller waits for, as the caller spells it."""

    name: str
    wire_name: bytes
    place: "asyncio.Future[VariableLocation]"


class SymbolBook:
    """The symbols of one device, as far as they were requested.

    `watch` subscribes to the symbol version, so that a change is noticed before a stale handle is.
    """

    def __init__(self, device: RawTarget, watch: bool = True) -> None:
        self._device = device
        self._session = device.session
        self._watch = watch
        self._watches_version = False
        self._coding: Coding = "cp1252"
        self._places: dict[str, VariableLocation] = {}
        self._methods: dict[str, int] = {}
        self._types = TypeTable()
        self._requested_types: set[str] = set()
        self._entries: dict[str, SymbolEntry] | None = None
        self._listing: dict[str, SymbolEntry] | None = None
        self._hints: dict[str, str] = {}
        self._wishes: dict[str, _Wish] = {}
        self._edition = 0

    # asking ----------------------------------------------------------------------------------

    def known(self, name: str) -> VariableLocation | None:
        """Return the place of symbol `name`, if it has been asked for before."""
        return self._places.get(_key(name))

    async def place(self, name: str) -> VariableLocation:
        """Return the place of symbol `name`: its handle in 0xF005, size and type.

        Raises `DeviceError` 0x710 if the device does not know it.
        """
        key = _key(name)
        location = self._places.get(key)
        if location is not None:
            return location
        wish = self._wishes.get(key)
        if wish is None:
            self._session.check_loop()
            wish = _Wish(name, self._wire_name(name), asyncio.get_running_loop().create_future())
            wish.place.add_done_callback(_seen)
            if not self._wishes:
                self._session.spawn(self._fetch_wanted())
            self._wishes[key] = wish
        return await asyncio.shield(wish.place)

    async def places(self, names: Sequence[str]) -> list[VariableLocation | AdsError]:
        """Return the place of each, named as asked, or why there is none."""
        locations = await asyncio.gather(*map(self.place, names), return_exceptions=True)
        places: list[VariableLocation | AdsError] = []
        for name, item in zip(names, locations, strict=True):
            if isinstance(item, VariableLocation):
                places.append(item if item.name == name else item._replace(name=name))
            elif isinstance(item, AdsError):
                places.append(item)
            else:
                raise item
        return places

    async def locate(self, names: Sequence[str]) -> list[VariableLocation]:
        """The places of `names`; raises for the first that has none."""
        places = []
        for item in await self.places(names):
            if isinstance(item, AdsError):
                raise item
            places.append(item)
        return places

    async def entries(self) -> list[SymbolEntry]:
        """Return all symbols of the device, as it uploads them (0xF00B)."""
        info = await self._upload_info()
        self._coding = info.coding
        table = b""
        if info.symbol_bytes:
            table = await self._device.read_raw(ReservedGroup.SYMBOL_TABLE, 0, info.symbol_bytes)
        return _decoded(decode_symbols, table, info.coding)

    async def all_types(self) -> TypeTable:
        """Return every type of the device (0xF00E), or of one without that table those of its
        symbols."""
        await self._upload_types()
        if not len(self._types):
            self._requested_types.clear()
            await self._fetch_types(entry.type_name for entry in await self.entries())
        return self._types

    async def method_handle(self, path: str) -> int:
        """Return the handle of a method, like `MAIN.fbMotor#Start`; kept until it is out of
        date."""
        key = fold(path)
        handle = self._methods.get(key)
        if handle is None:
            edition = self._edition
            data = await self._device.read_write_raw(
                ReservedGroup.SYMBOL_HANDLE_BY_NAME, 0, 4, self._wire_name(path)
            )
            if len(data) < 4:
                raise DecodeError(f"handle of {path}: 4 bytes, got {len(data)}")
            handle = int.from_bytes(data[:4], "little")
            if edition == self._edition:
                self._methods[key] = handle
        return handle

    def forget_method(self, path: str) -> None:
        """Forget the handle of that method: it is out of date."""
        self._methods.pop(fold(path), None)

    # forgetting ------------------------------------------------------------------------------

    def forget(self, place: VariableLocation) -> None:
        """Mark this one as out of date; the next request gets a new one."""
        key = fold(place.name)
        known = self._places.get(key)
        if known is not None and known.offset == place.offset:
            del self._places[key]

    def clear(self) -> None:
        """Forget everything."""
        self._edition += 1
        self._places.clear()
        self._methods.clear()
        self._types = TypeTable()
        self._requested_types.clear()
        self._entries = None
        self._listing = None
        self._hints.clear()

    # calls of the session ------------------------------------------------------------------

    @property
    def target(self) -> AmsAddress:
        return self._device.address

    def interrupt(self) -> None:
        """Note that the link is gone, and our handles with it."""
        self.clear()

    def renew(self) -> None:
        """Note a new link; symbols are requested when they are needed."""

    def symbols_changed(self) -> None:
        """Forget all symbols and handles: an online change or download replaced them."""
        handles = self._handles()
        self.clear()
        if handles:
            self._session.spawn(self._release(handles))

    async def leave(self) -> None:
        """Release all handles."""
        await self._release(self._handles())

    def end(self, error: AdsError | None) -> None:
        """Forget all symbols and handles: the link does not come back."""
        self.clear()

    def _handles(self) -> list[int]:
        places = [
            place.offset
            for place in self._places.values()
            if place.group == ReservedGroup.SYMBOL_VALUE_BY_HANDLE
        ]
        return [*places, *self._methods.values()]

    async def _release(self, handles: Iterable[int]) -> None:
        parts = [
            WriteRequest(ReservedGroup.RELEASE_SYMBOL_HANDLE, 0, handle.to_bytes(4, "little"))
            for handle in handles
        ]
        with contextlib.suppress(AdsError):
            await self._device.send_each(parts)

    # fetching --------------------------------------------------------------------------------

    async def _fetch_wanted(self) -> None:
        wanted, self._wishes = self._wishes, {}
        if not self._watches_version:
            self._watches_version = True
            self._session.keep(self)
            if self._watch:
                self._session.spawn(self._watch_version())
        error: AdsError = ConnectionLost("the session ended")
        try:
            await self._fetch(list(wanted.values()))
        except AdsError as failure:
            error = failure
        finally:
            for wish in wanted.values():
                if not wish.place.done():
                    wish.place.set_exception(error)

    async def _fetch(self, wishes: Sequence[_Wish]) -> None:
        edition = self._edition
        entries: list[tuple[_Wish, SymbolEntry]] = []
        missing: list[tuple[_Wish, AdsError]] = []
        for wish, entry in zip(wishes, await self._fetch_entries(wishes), strict=True):
            if isinstance(entry, AdsError):
                missing.append((wish, entry))
            else:
                entries.append((wish, entry))
        await self._fetch_types(entry.type_name for _, entry in entries)
        handles = await self._device.send_each(
            [
                ReadWriteRequest(ReservedGroup.SYMBOL_HANDLE_BY_NAME, 0, 4, wish.wire_name)
                for wish, _ in entries
            ]
        )
        for (wish, entry), handle in zip(entries, handles, strict=True):
            try:
                place = self._placed(wish, entry, handle)
            except AdsError as error:
                wish.place.set_exception(error)
                continue
            if edition == self._edition:
                self._places[fold(wish.name)] = place
            wish.place.set_result(place)
        await self._refuse(missing)

    async def _refuse(self, missing: Sequence[tuple[_Wish, AdsError]]) -> None:
        """Fail the waits for symbols that do not exist, with a hint at similar names."""
        try:
            for wish, error in missing[:_MOST_HINTS]:
                if isinstance(error, DeviceError) and error.code in _NOT_THERE:
                    with contextlib.suppress(AdsError):
                        error.hint = await self._hint(wish.name)
        finally:
            for wish, error in missing:
                if not wish.place.done():
                    wish.place.set_exception(error)

    async def _hint(self, name: str) -> str:
        """Return a hint about the intended name, for a name that the device does not know."""
        hint = self._hints.get(name)
        if hint is None:
            listing = await self._listed_once()
            try:
                root, rest = split_symbol(name, listing)
            except IecPathError:
                hint = hint_for(name, listing)
            else:
                entry = listing[root]
                await self._fetch_types([entry.type_name] if rest else [])
                hint = hint_inside(_decoded(self._types.symbol_type, entry), rest) if rest else ""
            if len(self._hints) < _MOST_KEPT:
                self._hints[name] = hint
        return hint

    async def _listed_once(self) -> dict[str, SymbolEntry]:
        """Return the symbols of the device; none if that takes long, is not offered, or is a
        lot."""
        if self._entries is not None:
            return self._entries
        if self._listing is None:
            edition, listing = self._edition, {}
            with contextlib.suppress(AdsError, TimeoutError):
                async with asyncio.timeout(_HINT_TIME):
                    info = await self._upload_info()
                    if info.symbol_bytes <= _LARGEST_LISTING:
                        listing = {fold(entry.name): entry for entry in await self.entries()}
            if edition != self._edition:
                return listing
            self._listing = listing
        return self._listing

    def _placed(self, wish: _Wish, entry: SymbolEntry, handle: Outcome) -> VariableLocation:
        type = _decoded(self._types.symbol_type, entry)
        most = self._device.longest_read
        in_pieces = most is not None and entry.size > most and entry.index_group in AREAS
        if handle.result in NOT_OFFERED or in_pieces:
            return VariableLocation(
                wish.name, entry.index_group, entry.index_offset, entry.size, type
            )
        if handle.result:
            raise DeviceError(handle.result, f"handle of symbol {wish.name}")
        number = int.from_bytes(handle.data[:4], "little")
        return VariableLocation(
            wish.name, ReservedGroup.SYMBOL_VALUE_BY_HANDLE, number, entry.size, type
        )

    def _wire_name(self, name: str) -> bytes:
        if self._coding == "cp1252":
            return encode_name(name) + b"\0"
        try:
            return encode_text(name, self._coding) + b"\0"
        except UnicodeEncodeError:
            raise DeviceError(ReturnCode.SYMBOL_NOT_FOUND, f"symbol {name}") from None

    async def _fetch_entries(self, wishes: Sequence[_Wish]) -> list[SymbolEntry | AdsError]:
        if self._entries is None:
            outcomes = await self._device.send_each(
                [
                    ReadWriteRequest(
                        ReservedGroup.SYMBOL_ENTRY_BY_NAME, 0, _ENTRY_LENGTH, wish.wire_name
                    )
                    for wish in wishes
                ]
            )
            if not any(outcome.result in NOT_OFFERED for outcome in outcomes):
                return [
                    self._entry(wish.name, outcome)
                    for wish, outcome in zip(wishes, outcomes, strict=True)
                ]
            self._entries = {fold(entry.name): entry for entry in await self.entries()}
        return await self._listed(wishes, self._entries)

    async def _listed(
        self, wishes: Sequence[_Wish], listed: Mapping[str, SymbolEntry]
    ) -> list[SymbolEntry | AdsError]:
        """Return the symbols of a table, and parts of them by the types of the device."""
        roots: dict[str, tuple[SymbolEntry, str]] = {}
        for wish in wishes:
            with contextlib.suppress(IecPathError):
                key, rest = split_symbol(wish.name, listed)
                roots[wish.name] = listed[key], rest
        await self._fetch_types(root.type_name for root, rest in roots.values() if rest)
        entries: list[SymbolEntry | AdsError] = []
        for wish in wishes:
            try:
                root, rest = roots[wish.name]
                entries.append(self._part(wish.name, root, rest) if rest else root)
            except LookupError:
                entries.append(DeviceError(ReturnCode.SYMBOL_NOT_FOUND, f"symbol {wish.name}"))
            except DecodeError as error:
                entries.append(error)
        return entries

    def _part(self, name: str, root: SymbolEntry, path: str) -> SymbolEntry:
        """Return the entry of a part of a symbol. LookupError if there is none at a fixed place."""
        spot = follow(_decoded(self._types.symbol_type, root), parse_path(path))
        if spot.hops or spot.method is not None or spot.static is not None:
            raise LookupError(name)
        group, offset = root.index_group, root.index_offset + spot.offset
        if spot.bit is not None:  # Bits of an area have the group behind that of its bytes.
            group, offset = group + 1, 8 * offset + spot.bit
        return SymbolEntry.of(name, spot.type, group, offset, context=root.context)

    def _entry(self, name: str, outcome: Outcome) -> SymbolEntry | AdsError:
        if outcome.result:
            return DeviceError(outcome.result, f"symbol {name}")
        try:
            return SymbolEntry.decode(outcome.data, self._coding)
        except IecDecodeError as error:
            return _loose_entry(outcome.data, self._coding) or DecodeError(
                f"symbol {name}: {error}"
            )

    async def _fetch_types(self, texts: Iterable[str]) -> None:
        """Fetch the entries of all types that `texts` name, and of their parts."""
        missing = self._missing(texts)
        while missing:
            self._requested_types.update(missing)
            outcomes = await self._device.send_each(
                [
                    ReadWriteRequest(
                        ReservedGroup.TYPE_ENTRY_BY_NAME, 0, _TYPE_LENGTH, self._wire_name(name)
                    )
                    for name in missing
                ]
            )
            if any(outcome.result in NOT_OFFERED for outcome in outcomes):
                await self._upload_types()
                return
            parts: list[str] = []
            for outcome in outcomes:
                if outcome.result == 0:
                    entry = _decoded(DataTypeEntry.decode, outcome.data, self._coding)
                    self._types.add(entry)
                    parts += [entry.type_name, *(member.type_name for member in entry.members)]
                    for method in entry.methods:
                        parts += [method.return_type]
                        parts += [parameter.type_name for parameter in method.parameters]
            missing = self._missing(parts)

    def _missing(self, texts: Iterable[str]) -> list[str]:
        """Return the names in type texts that the device has not been asked about."""
        names = {name for name in map(name_within, texts) if name is not None}
        return sorted(
            name for name in names if name not in self._requested_types and name not in self._types
        )

    async def _upload_types(self) -> None:
        try:
            info = await self._upload_info()
            table = await self._device.read_raw(ReservedGroup.TYPE_TABLE, 0, info.type_bytes)
        except DeviceError as error:
            if error.code not in NOT_OFFERED:
                raise
            return
        narrow = info.code_page != 0 and not info.flags & UploadFlag.PLATFORM_64_BIT
        self._types = TypeTable(
            _decoded(decode_types, table, info.coding), pointer_size=4 if narrow else 8
        )

    async def _upload_info(self) -> UploadInfo:
        try:
            data = await self._device.read_raw(ReservedGroup.TABLE_SIZES, 0, 64)
        except DeviceError as error:
            if error.code not in NOT_OFFERED:
                raise
            data = await self._device.read_raw(ReservedGroup.SYMBOL_TABLE_SIZE, 0, 8)
        return _decoded(UploadInfo.decode, data)

    async def _watch_version(self) -> None:
        """Notify all listeners when the symbols of the device change, if it reports changes."""

        async def locate() -> Sequence[VariableLocation]:
            return [VariableLocation("symbol version", ReservedGroup.SYMBOL_VERSION, 0, 1, USINT)]

        seen: int | None = None
        with contextlib.suppress(AdsError):
            async with Subscription(self._device, locate, _VERSION, depth=1) as versions:
                async for sample in versions:
                    if not sample.gap and seen not in (None, sample.value):
                        self._session.symbols_changed(self.target)
                    seen = sample.value


def _decoded(read: Callable[P, T], *arguments: P.args, **options: P.kwargs) -> T:
    """Return what `read` decodes from bytes of the device; `DecodeError` for invalid bytes."""
    try:
        return read(*arguments, **options)
    except (IecDecodeError, DeclarationError) as error:
        raise DecodeError(str(error)) from error


def _loose_entry(data: bytes, coding: Coding) -> SymbolEntry | None:
    """Return a symbol entry whose texts have no NUL behind them, as some test servers write it."""
    if len(data) < _HEAD.size:
        return None
    _, group, offset, size, adst, _, _, name, type_name, _ = _HEAD.unpack_from(data)
    texts = data[_HEAD.size :]
    if len(texts) < name + 1 + type_name:
        return None
    return SymbolEntry(
        decode_text(texts[:name], coding),
        decode_text(texts[name + 1 : name + 1 + type_name], coding),
        group,
        offset,
        size,
        adst,
    )


def _seen(future: "asyncio.Future[VariableLocation]") -> None:
    """Retrieve the error, so that asyncio does not report it after its callers have left."""
    if not future.cancelled():
        future.exception()


def _key(name: str) -> str:
    """Return the key of a symbol. TypeError if `name` is not text."""
    if not isinstance(name, str):
        raise TypeError(f"the name of a symbol is text, got {name!r:.80}")
    return fold(name)
