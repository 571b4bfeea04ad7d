"""Sources of the values of scope channels: any symbol or row of any device."""

from collections.abc import Callable, Iterable

from achse.ams import DeviceError
from achse.iec.nearest import did_you_mean
from achse.iec.symbols import SymbolEntry, decode_symbols
from achse.scope import ScopeChannel, ScopeError, ScopeSource, ScopeType, type_of_number
from achse.scope.types import SCOPE_TYPES, type_of_words
from achse.server import Device, RowFacts

NC_PORTS = frozenset((500, 501))

_AXIS_DISPLAY = (*range(0x82, 0x86), *range(0x88, 0x91), 0x9A, 0x9B)
"""Single states of the cyclic interface."""

NOT_SCOPED: dict[int, frozenset[int]] = {
    0x1100: frozenset((0x10, 0x14, 0x20)),
    0x2100: frozenset((0x3, 0x8, 0x10, 0x11, 0x100)),
    0x2300: frozenset((0x1, *range(0x1000_0000, 0x1000_0000 + 1000), 0x2000_0001)),
    0x3100: frozenset((0x9, 0xA, 0xE, 0xF, 0x11)),
    0x4100: frozenset(
        (
            *(0x0, 0x50, 0x51, 0x60, 0x1000B, 0x10101, 0x20003, 0x20004),
            *(0x20202, 0x20203, 0x30004, 0x30014),
        )
    ),
    0x4300: frozenset((0x2, 0x3, 0x4, 0x7, *_AXIS_DISPLAY)),
    0x5100: frozenset((0x101, 0x201, 0x206, 0x207, 0x208, 0x210, 0x211, 0x212, 0x213)),
    0x6100: frozenset((0x3, 0x4, 0x202, 0x203)),
    0x7100: frozenset((0x4, 0x14)),
    0xA100: frozenset((0xA,)),
}
"""Index group and offsets of the NC that are "not oscilloscopeable" (002 §6.4), for the first id
and sub-element."""

_ID, _ELEMENT = 0xFF, 0x00F0_0000


class ScopeChannels:
    """Finds the values of channels among the devices of one station.

    `devices()` gives those that are there now; a channel without port means `port`, without sample
    time the cycle of its task.
    """

    def __init__(self, devices: Callable[[], Iterable[Device]], port: int) -> None:
        self._devices = devices
        self._port = port
        self._rows: dict[int, _Rows] = {}
        """The rows of each device, by its identity."""

    def find(self, channel: ScopeChannel) -> ScopeSource:
        """Return the source of a channel's values. Raises ScopeError."""
        port = channel.port or self._port
        device = self._device(port, channel)
        expected = type_of_words(channel.type) if channel.type else None
        try:
            if channel.symbol:
                source = self._symbol(device, port, channel, expected)
            else:
                source = self._row(device, port, channel, expected)
            size = len(source.read())
        except DeviceError as refusal:
            raise ScopeError(f"{channel.name}: {refusal.context or refusal}") from None
        except ScopeError:
            raise
        except Exception as failure:  # a value that the user's code computes
            raise ScopeError(f"{channel.name}: cannot be read: {failure}") from None
        if size < source.type.size:
            raise ScopeError(
                f"{channel.name}: a {source.type.name} has {source.type.size} bytes,"
                f" the value {size}"
            )
        return source

    def _device(self, port: int, channel: ScopeChannel) -> Device:
        ports: set[int] = set()
        for device in self._devices():
            at = {address.port for address in device.addresses}
            if port in at:
                return device
            ports |= at
        there = ", ".join(map(str, sorted(ports)))
        raise ScopeError(f"{channel.name}: no device at port {port}, there are {there}")

    def _rows_of(self, device: Device) -> "_Rows":
        rows = self._rows.get(id(device))
        if rows is None:
            rows = self._rows[id(device)] = _Rows(device)
        return rows

    def _symbol(
        self, device: Device, port: int, channel: ScopeChannel, expected: ScopeType | None
    ) -> ScopeSource:
        if device.symbols is None:
            raise ScopeError(f"{channel.name}: the device at port {port} has no symbols")
        symbol = device.symbols.source.resolve(channel.symbol)
        if symbol is None:
            known = (entry.name for entry in decode_symbols(device.symbols.source.symbol_table()))
            near = did_you_mean(channel.symbol, known)
            raise ScopeError(f"{channel.name}: port {port} has no symbol {channel.symbol!r}{near}")
        entry = SymbolEntry.decode(symbol.entry())
        if port in NC_PORTS:
            _check_scoped(channel, entry.index_group, entry.index_offset)
        type = expected or type_of_number(entry.adst)
        if type is None or symbol.call is not None or symbol.size > 8:
            raise ScopeError(
                f"{channel.name}: expected a number or a BOOL, {channel.symbol} is a"
                f" {entry.type_name or 'method'}"
            )
        return ScopeSource(symbol.read, type, device.task_cycle(symbol.context))

    def _row(
        self, device: Device, port: int, channel: ScopeChannel, expected: ScopeType | None
    ) -> ScopeSource:
        group, offset = channel.index_group, channel.index_offset
        if port in NC_PORTS:
            _check_scoped(channel, group, offset)
        type = expected or self._rows_of(device).type_at(group, offset)
        if type is None:
            raise ScopeError(
                f"{channel.name}: expected a type ({', '.join(SCOPE_TYPES)}), the row has none"
            )
        services = device.services.find(group)
        read = services.watch(group, offset, type.size, b"")
        return ScopeSource(read, type, device.task_cycle(services.context(group, offset, b"")))


class _Rows:
    """The rows of a device that are one number, to look up."""

    def __init__(self, device: Device) -> None:
        self.device = device
        """So that its identity stays its own."""
        self._at: dict[int, list[RowFacts]] = {}
        self._ranges: list[RowFacts] = []
        for row in device.services.describe():
            if type_of_words(row.layout) is None:
                continue
            if row.index_offset == row.last_index_offset:
                self._at.setdefault(row.index_offset, []).append(row)
            else:
                self._ranges.append(row)

    def type_at(self, group: int, offset: int) -> ScopeType | None:
        """Return the type of a row with one number; None if it has another layout, or is not a
        row."""
        for row in (*self._at.get(offset, ()), *self._ranges):
            if (
                row.index_group <= group <= row.last_index_group
                and row.index_offset <= offset <= row.last_index_offset
            ):
                return type_of_words(row.layout)
        return None


def _check_scoped(channel: ScopeChannel, group: int, offset: int) -> None:
    base = group & 0xFFFF
    offsets = NOT_SCOPED.get(base if base in (0x1100,) else base & ~_ID)
    if offsets is not None and (offset & ~_ELEMENT) in offsets:
        raise ScopeError(
            f"{channel.name}: the NC's manual says that a scope cannot have this value"
        )
