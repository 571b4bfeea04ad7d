"""Selection of the requests that a fault hits: by client, device, service or variable."""

import struct
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import model_validator

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.text import terminated_text
from achse.codes import ReservedGroup, code_of
from achse.faults.fault import CountedFault, FaultError, number, text
from achse.faults.target import FaultyStation
from achse.server import Device, ResolvedSymbol

COMMANDS = {command.name.lower(): command for command in Command}
"""Commands by the names that the field `command` accepts."""

_PLACE = struct.Struct("<II")
_WITH_PLACE = frozenset((Command.READ, Command.WRITE, Command.READ_WRITE, Command.ADD_NOTIFICATION))

PortNumber = Annotated[int, number(int, 0, 0xFFFF)]
Code = Annotated[int, number(int, 1, 0xFFFF_FFFF)]
_Number = Annotated[int, number(int, 0, 0xFFFF_FFFF)]


class RequestFault(CountedFault):
    """A fault of requests. Fields that are not given select everything."""

    client: Annotated[str, text()] = ""
    """A NetId, an AMS address or an IP address."""
    port: PortNumber | None = None
    """The AMS port of the device."""
    command: Annotated[str, text(*COMMANDS)] = ""
    """An ADS command in lower case: read, write, read_write, notification, …"""
    group: _Number | None = None
    """Index group of the requests; empty: all."""
    offset: _Number | None = None
    """Index offset of the requests, with a group; empty: all."""
    symbol: Annotated[str, text()] = ""
    """Variable whose reads and writes are hit: by name, handle or address."""

    @model_validator(mode="after")
    def _offset_in_group(self) -> "RequestFault":
        if self.offset is not None and self.group is None:
            raise ValueError("offset: needs a group")
        return self

    def format_value(self, name: str, value: Any) -> str:
        """Return a field's value in words: codes with their names, groups and offsets in
        hexadecimal."""
        if name == "code":
            row = code_of(value)
            return f"0x{value:X}" + (f" ({row.name})" if row else "")
        return f"0x{value:X}" if name in ("group", "offset") else str(value)

    def resolve_symbol(self, target: FaultyStation) -> tuple[Device, ResolvedSymbol]:
        """Return the variable, and the device that has it; raises FaultError."""
        for device in devices_at(self.port, target):
            if device.symbols is not None:
                symbol = device.symbols.source.resolve(self.symbol)
                if symbol is not None:
                    return device, symbol
        raise FaultError(f"symbol: no device of the station has {self.symbol!r}")

    def selection(self, target: FaultyStation) -> "Selection":
        """Return the selection of requests at the station as it is now; raises FaultError."""
        symbol = self.resolve_symbol(target) if self.symbol else None
        return Selection(self, None if symbol is None else _Touch(*symbol))


class Sided(CountedFault):
    """A fault that can hit either half of an exchange."""

    side: Annotated[str, text("request", "answer")] = "answer"
    """`answer` (the request was carried out) or `request`."""


def devices_at(port: int | None, target: FaultyStation) -> list[Device]:
    """Return the device at a port, or all; raises FaultError."""
    devices = [
        device
        for device in target.devices
        if port is None or any(item.port == port for item in device.addresses)
    ]
    if not devices:
        raise FaultError(f"port: expected one of the station's devices, got {port}")
    return devices


def client_test(client: str) -> Callable[[bytes, str], bool]:
    """Return a test for an AMS address and its host: True for the client that a fault names."""
    if not client:
        return lambda address, host: True
    try:
        wanted = bytes(AmsAddress(client)) if ":" in client else bytes(NetId(client))
    except ValueError:
        if client.count(".") != 3:
            raise FaultError(
                f"client: expected a NetId, an AMS address or an IP address, got {client!r}"
            ) from None
        return lambda address, host: host == client
    return lambda address, host: address.startswith(wanted)


class _Touch:
    """Test for requests that read or write one variable: by name, by handle or by address."""

    def __init__(self, device: Device, symbol: ResolvedSymbol) -> None:
        assert device.symbols is not None
        self.ports = [address.port for address in device.addresses]
        self._symbols = device.symbols
        self._group = symbol.index_group
        self._start = symbol.index_offset
        self._end = symbol.index_offset + symbol.size

    def __call__(self, group: int, offset: int, length: int, data: bytes) -> bool:
        if group == self._group:
            return offset < self._end and self._start < offset + max(length, 1)
        symbol: ResolvedSymbol | None = None
        if group == ReservedGroup.SYMBOL_VALUE_BY_HANDLE:
            handle = self._symbols.handles.valid.get(offset)
            symbol = None if handle is None else handle.symbol
        elif group == ReservedGroup.SYMBOL_VALUE_BY_NAME:
            symbol = self._symbols.source.resolve(terminated_text(data))
        return (
            symbol is not None
            and symbol.index_group == self._group
            and symbol.index_offset < self._end
            and self._start < symbol.index_offset + symbol.size
        )


class Selection:
    """Selection of the requests that a fault hits."""

    def __init__(self, fault: RequestFault, touch: _Touch | None) -> None:
        self.command = COMMANDS[fault.command] if fault.command else None
        self.is_client = client_test(fault.client)
        self.port = fault.port
        self._group = fault.group
        self._offset = fault.offset
        self._touch = touch
        self._placed = fault.group is not None or touch is not None

    def peer(self, address: bytes, host: str, port: int) -> bool:
        """Client and device fit."""
        return (self.port is None or self.port == port) and self.is_client(address, host)

    def place(self, group: int, offset: int, length: int, data: bytes) -> bool:
        """Service or symbol fit."""
        if self._touch is not None:
            return self._touch(group, offset, length, data)
        return (self._group is None or group == self._group) and (
            self._offset is None or offset == self._offset
        )

    def request(self, frame: Frame) -> bool:
        """The frame is one of them."""
        command = frame.command
        if self.command is not None and command != self.command:
            return False
        if not self.peer(frame.source, host_of(frame.origin), port_of(frame.target)):
            return False
        if not self._placed:
            return True
        data = frame.data
        if command not in _WITH_PLACE or len(data) < 12:
            return False
        group, offset = _PLACE.unpack_from(data)
        length = int.from_bytes(data[8:12], "little")
        return self.place(group, offset, length, data[16:])

    def sample(self, frame: Frame) -> bool:
        """The frame is a notification for them; asked only of a fault of notifications."""
        return self.peer(frame.target, host_of(frame.via), port_of(frame.source))


def host_of(endpoint: object) -> str:
    """Return the IP address at the far end of a connection; empty for what has none."""
    return getattr(endpoint, "peer_host", "")


def port_of(address: bytes) -> int:
    """Return the port of an AMS address."""
    return address[6] | address[7] << 8
