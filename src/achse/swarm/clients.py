"""Clients of a world: they behave, hurry, vanish, flood or lie, as their acts say.

A client speaks AMS/TCP by itself, without the library of `achse.client`, so that it can do what no
sane client does. What it sends is a row of `CLIENT_ACTS`.
"""

import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import Any, Protocol

from achse.ams import (
    AmsAddress,
    Command,
    Connection,
    DecodeError,
    Frame,
    NetId,
    TcpCommand,
    TcpMessage,
)
from achse.client.nc.services import NcLayout, services
from achse.codes.groups import ReservedGroup
from achse.codes.nc.table import named_rows
from achse.swarm.link import NetworkLink
from achse.swarm.services.drawing import net_id_of
from achse.swarm.services.rights import ClientRights
from achse.swarm.talk import ConnectionLedger, SentRequest, Subscription
from achse.swarm.worlds.world import DrawnClient

NC_PORT = 501
PLC_PORT = 851

_ADD = struct.Struct("<6I16x")
"""Group, offset, length, mode, largest delay, cycle in 100 ns; 16 bytes unused (000 §3.2.3.6)."""

_PLC_TO_CHANNEL = struct.Struct("<HHH122x")
"""Skip mask, operation mode, granted M function: the begin of a PLCTONC_NCICHANNEL_REF."""

_RATIOS = 0x0100_4300, 0x1000 + 72
"""Place of the four gear ratios in the bytes that the PLC writes for an axis; the id is added."""

_GARBAGE = bytes(range(64))

_MOST_KEPT = 64
"""Handles that a client keeps in mind."""


class Dialling(Protocol):
    """Interface of the station to a client."""

    net_id: NetId

    def dial(self, client: "Client") -> tuple[NetworkLink, ConnectionLedger] | None:
        """Open a connection; None while the station is down."""

    def now_ns(self) -> int:
        """Time of the world."""


class Client:
    """A client of a world."""

    def __init__(
        self,
        number: int,
        part: DrawnClient,
        station: Dialling,
        names: Sequence[str],
        rights: ClientRights | None = None,
    ) -> None:
        self.part = part
        self._rights = rights
        self.number = number
        self._station = station
        self._names = names
        self._link: NetworkLink | None = None
        self._page: ConnectionLedger | None = None
        self._stream = Connection()
        # Programs behind routers all have one address, as each pyads of a computer.
        own = number if part.router < 0 else 0
        self._address = AmsAddress.of(NetId(net_id_of(own)), 40_000)
        self._waiting: list[bytes] | None = None
        """Packets for a router that has granted no port yet."""
        self._invoke = 0
        self._handles: list[tuple[int, str]] = []
        self._subscribed: list[tuple[int, int]] = []
        self.digest_parts: list[bytes] = []
        """Bytes that came, since they were taken for the digest."""
        self.requests = 0
        self._deaf_ns = 0
        """Time since which it has not read."""

    # of its link ----------------------------------------------------------------------------------

    def receive(self, data: bytes) -> None:
        """Take bytes that arrived."""
        self.digest_parts.append(data)
        try:
            for event in self._stream.receive(data):
                if isinstance(event, Frame):
                    if self._page is not None:
                        self._page.take(event)
                elif event.command is TcpCommand.PORT_CONNECT and len(event.data) == 8:
                    self._address = AmsAddress(event.data)
                    waiting, self._waiting = self._waiting, None
                    for packet in waiting or ():
                        self._write(self._readdressed(packet))
        except DecodeError as fault:
            page = self._page
            if page is not None and page.frames_ns() < page.clock():
                page.report("no-broken-stream", f"{page.name}: {fault}")
            self.vanish()

    def lost(self) -> None:
        """Note that the connection has ended: what was under way is not answered."""
        self._link = self._page = None
        self._handles.clear()
        self._subscribed.clear()

    def move_to(self, station: Dialling) -> None:
        """Dial another station from now on: the one that was there has ended."""
        self.lost()
        self._station = station

    def finish(self) -> None:
        """Check what is under way at the end of the world."""
        if self._page is not None:
            self._page.finish()

    @property
    def page(self) -> ConnectionLedger | None:
        """ConnectionLedger of its connection; None without one."""
        return self._page

    # its acts -------------------------------------------------------------------------------------

    def act(self, kind: str, values: Sequence[Any]) -> None:
        """Do what an act says."""
        CLIENT_ACTS[kind](self, *values)

    def dial(self) -> None:
        """Open a connection, if there is none."""
        if self._link is not None:
            return
        self._stream = Connection()
        opened = self._station.dial(self)
        if opened is None:
            return
        self._link, self._page = opened
        self._waiting = None
        if self.part.registers:
            self._waiting = []
            self._write(TcpMessage(TcpCommand.PORT_CONNECT, bytes(2)).encode_tcp())

    def leave(self) -> None:
        """Close the connection, after what was sent."""
        self._end(orderly=True)

    def vanish(self) -> None:
        """Break off: a cable is pulled."""
        self._end(orderly=False)

    def _end(self, *, orderly: bool) -> None:
        link = self._link
        if link is not None:
            link.hang_up(orderly=orderly)
            self.lost()

    def listen(self, reads: bool) -> None:
        """Read what comes from now on, or leave it unread."""
        if self._link is None or self._page is None or reads is self._link.reads:
            return
        if reads:
            self._page.excuse_unread(self._deaf_ns)
        else:
            self._deaf_ns = self._station.now_ns()
        self._link.read(reads)

    def nc(self, group: int, name: str, axis: int, numbers: Sequence[float]) -> None:
        """Request a service of an axis."""
        service = services()[group][name]
        place = struct.pack("<II", *service.place(axis))
        data = encode_service(group, name, numbers)
        if service.answer is not None and not service.writable:
            sizes = struct.pack("<II", service.answer.size, len(data))
            self._request(Command.READ_WRITE, place + sizes + data, NC_PORT, name)
        else:
            self._request(Command.WRITE, place + struct.pack("<I", len(data)) + data, NC_PORT, name)

    def channel(self, group: int, id: int, name: str, value: str | Sequence[float]) -> None:
        """Write a service of a channel or group: a text or numbers."""
        row = named_rows(group)[name]
        data = encode_service(group, name, value)
        where = struct.pack("<3I", group + id, row.offset, len(data))
        self._request(Command.WRITE, where + data, NC_PORT, name)

    def ratios(self, axis: int, numbers: Sequence[float]) -> None:
        """Write the gear ratios of the cyclic interface of an axis."""
        group, offset, data = encode_ratios(axis, numbers)
        where = struct.pack("<3I", group, offset, len(data))
        self._request(Command.WRITE, where + data, NC_PORT, "gear ratios")

    def handle(self, name: int) -> None:
        """Request a handle of the variable with this number."""
        text = self._names[name % len(self._names)]
        key = text.encode() + b"\0"
        where = struct.pack("<4I", ReservedGroup.SYMBOL_HANDLE_BY_NAME, 0, 4, len(key))

        def keep(code: int, data: bytes) -> None:
            if not code and len(data) == 8:
                self._handles.append((int.from_bytes(data[4:8], "little"), text))
                del self._handles[:-_MOST_KEPT]

        self._request(Command.READ_WRITE, where + key, PLC_PORT, f"handle of {text}", keep)

    def use(self, slot: int, value: int | None) -> None:
        """Read the variable of a handle, or write a number to it."""
        if not self._handles:
            return
        handle, name = self._handles[slot % len(self._handles)]
        where = struct.pack("<3I", ReservedGroup.SYMBOL_VALUE_BY_HANDLE, handle, 4)
        if value is None:
            self._request(Command.READ, where, PLC_PORT, f"read {name}")
        else:
            self._request(
                Command.WRITE, where + struct.pack("<I", value), PLC_PORT, f"write {name}"
            )

    def release(self, slot: int) -> None:
        """Give a handle back."""
        if not self._handles:
            return
        handle, name = self._handles.pop(slot % len(self._handles))
        where = struct.pack("<4I", ReservedGroup.RELEASE_SYMBOL_HANDLE, 0, 4, handle)
        self._request(Command.WRITE, where, PLC_PORT, f"release {name}")

    def subscribe(self, slot: int, cyclic: bool, cycle_ns: int, delay_ns: int) -> None:
        """Subscribe to the variable of a handle."""
        if self._handles:
            handle, name = self._handles[slot % len(self._handles)]
            group = ReservedGroup.SYMBOL_VALUE_BY_HANDLE
            self._add(PLC_PORT, group, handle, 4, cyclic, cycle_ns, delay_ns, name)

    def subscribe_axis(self, axis: int, cyclic: bool, cycle_ns: int, delay_ns: int) -> None:
        """Subscribe to the set position of an axis."""
        group, offset = services()[0x4100]["set_position"].place(axis)
        self._add(NC_PORT, group, offset, 8, cyclic, cycle_ns, delay_ns, f"axis {axis}")

    def _add(
        self,
        port: int,
        group: int,
        offset: int,
        size: int,
        cyclic: bool,
        cycle_ns: int,
        delay_ns: int,
        what: str,
    ) -> None:
        page, sent_ns = self._page, self._station.now_ns()
        data = _ADD.pack(group, offset, size, 3 if cyclic else 4, delay_ns // 100, cycle_ns // 100)

        def keep(code: int, data: bytes) -> None:
            if page is None or page is not self._page:
                return
            if code or len(data) != 4:
                page.unknown_handles |= page.frames_ns() >= 0
                return
            place = port, int.from_bytes(data, "little")
            now = self._station.now_ns()
            page.add(place, Subscription(cycle_ns if cyclic else 0, delay_ns, now), sent_ns)
            self._subscribed.append(place)

        self._request(Command.ADD_NOTIFICATION, data, port, f"subscribe to {what}", keep)

    def unsubscribe(self, slot: int) -> None:
        """End a subscription."""
        if not self._subscribed or self._page is None:
            return
        place = self._subscribed.pop(slot % len(self._subscribed))
        self._page.delete(place)
        self._request(
            Command.DELETE_NOTIFICATION, struct.pack("<I", place[1]), place[0], "unsubscribe"
        )

    def state(self, port: int) -> None:
        """Ask for the state of a device."""
        self._request(Command.READ_STATE, b"", port, f"state of {port}")

    def flood(self, count: int, size: int) -> None:
        """Send many reads at once."""
        data = struct.pack("<3I", ReservedGroup.SYMBOL_VERSION, 0, min(size, 1))
        for _ in range(count):
            self._request(Command.READ, data, PLC_PORT, "flood")

    def sum(self, count: int) -> None:
        """Read many values with one request."""
        one = struct.pack("<3I", ReservedGroup.SYMBOL_VERSION, 0, 1)
        where = struct.pack("<4I", ReservedGroup.SUM_READ, count, 5 * count, 12 * count)
        self._request(Command.READ_WRITE, where + one * count, PLC_PORT, "sum")

    def lie(self, kind: str, number: int) -> None:
        """Send what no honest client sends."""
        match kind:
            case "group":
                self._request(
                    Command.READ, struct.pack("<3I", number, number, 8), NC_PORT, "no group"
                )
            case "length":
                where = struct.pack("<3I", 0x4200 + 1, 0x16, number)
                self._request(Command.WRITE, where + bytes(number % 200), NC_PORT, "a wrong length")
            case "port":
                self._request(Command.READ_STATE, b"", number % 0x8000, "a port without a device")
            case "handle":
                where = struct.pack("<3I", ReservedGroup.SYMBOL_VALUE_BY_HANDLE, number, 4)
                self._request(Command.READ, where, PLC_PORT, "an unknown handle")
            case "delete":
                self._request(
                    Command.DELETE_NOTIFICATION, struct.pack("<I", number), PLC_PORT, "delete"
                )
            case "short":
                self._request(
                    number % 9 + 1,
                    _GARBAGE[: number % 16],
                    PLC_PORT,
                    "a short request",
                    optional=True,
                )
            case "command":
                self._request(10 + number % 1000, b"", PLC_PORT, "no command", optional=True)
            case "answer":
                self._send(Frame(self._target(PLC_PORT), self._address, 2, 5, 0, number, bytes(8)))
            case "samples":
                self._send(Frame(self._target(PLC_PORT), self._address, 8, 4, 0, 0, _GARBAGE))
            case _:
                self._write(_GARBAGE[number % 32 :])

    def _target(self, port: int) -> AmsAddress:
        return AmsAddress.of(self._station.net_id, port)

    def _request(
        self,
        command: int,
        data: bytes,
        port: int,
        what: str,
        done: Callable[[int, bytes], None] | None = None,
        *,
        optional: bool = False,
    ) -> None:
        if self._page is None:
            return
        self._invoke += 1
        now = self._station.now_ns()
        wrong = None
        if self._rights is not None and not optional:
            wrong = partial(self._rights.wrong_answer, command, data)
        self._page.pending[self._invoke] = SentRequest(command, now, what, optional, done, wrong)
        self.requests += 1
        self._send(Frame(self._target(port), self._address, command, 4, 0, self._invoke, data))

    def _send(self, frame: Frame) -> None:
        packet = frame.encode_tcp()
        if self._waiting is not None:
            self._waiting.append(packet)
        else:
            self._write(packet)

    def _readdressed(self, packet: bytes) -> bytes:
        """A packet from before the port was granted, with the address of now."""
        return packet[:14] + bytes(self._address) + packet[22:]

    def _write(self, data: bytes) -> None:
        if self._link is not None:
            self._link.send(data)


def encode_service(group: int, name: str, numbers: str | Sequence[float]) -> bytes:
    """Return the data of a request to a service: a text or numbers. Raises ValueError."""
    if isinstance(numbers, str):
        return numbers.encode() + b"\0"
    text = named_rows(group)[name].layout
    if text == "UINT32[n]":
        return struct.pack(f"<{len(numbers)}I", *map(int, numbers))
    if name == "plc_to_nc_written":
        return _PLC_TO_CHANNEL.pack(0, 0, int(numbers[0]))
    layout, kinds = _layout(group, name, len(numbers))
    return layout.encode(*(kind(value) for kind, value in zip(kinds, numbers, strict=True)))


def encode_ratios(axis: int, numbers: Sequence[float]) -> tuple[int, int, bytes]:
    """Return index group, offset and data that write four gear ratios of an axis."""
    group, offset = _RATIOS
    return group + axis, offset, struct.pack("<4d", *numbers)


@cache
def _layout(group: int, name: str, count: int) -> tuple[NcLayout, Sequence[type]]:
    """Return the layout of a service that has so many values, and their types."""
    for text in named_rows(group)[name].layouts:
        kinds = _types(text)
        if len(kinds) == count:
            return NcLayout(text), kinds
    raise ValueError(f"expected a service with {count} values, got {name}")


def _types(text: str) -> list[type]:
    """Return int or float for each value of a layout."""
    if text == "VOID":
        return []
    kinds: list[type] = []
    for part in text.strip("{}").split(";"):
        name = part.rpartition(":")[2].strip()
        if not name.endswith("unused"):
            count, _, type_name = name.rpartition(" ")
            kinds += [float if type_name.startswith("REAL") else int] * int(count or 1)
    return kinds


CLIENT_ACTS: Mapping[str, Callable[..., None]] = {
    "dial": Client.dial,
    "leave": Client.leave,
    "vanish": Client.vanish,
    "listen": Client.listen,
    "nc": Client.nc,
    "channel": Client.channel,
    "ratios": Client.ratios,
    "handle": Client.handle,
    "use": Client.use,
    "release": Client.release,
    "subscribe": Client.subscribe,
    "subscribe_axis": Client.subscribe_axis,
    "unsubscribe": Client.unsubscribe,
    "state": Client.state,
    "flood": Client.flood,
    "sum": Client.sum,
    "lie": Client.lie,
}
"""Acts of clients by name."""
