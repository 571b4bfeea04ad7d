"""Stations in one process and in virtual time, with lines between them that are made of memory."""

import heapq
import math
import struct
from collections.abc import Callable
from typing import Any

from achse.ams import AmsAddress, Command, Connection, Flags, Frame, NetId
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteRequest,
)
from achse.ams.notification import NotificationStream
from achse.router import Router
from achse.router.routes import Route
from achse.server import Device, TableSizes
from achse.transport.connections.byte_transport import ByteTransport
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.peer import Peer
from achse.transport.connections.send_budget import SendBudget
from achse.transport.uplinks.uplink import Uplink

TASK = 10_000_000
VARIABLES = 8


class Loop:
    """The calls of a loop; time passes in `run`."""

    def __init__(self) -> None:
        self.now = 1000.0
        self._number = 0
        self._calls: list[Any] = []

    def time(self) -> float:
        return self.now

    def call_soon(self, callback: Callable[[], object]) -> object:
        return self.call_at(self.now, callback)

    def call_at(self, when: float, callback: Callable[[], object]) -> Any:
        self._number += 1
        call = [when, self._number, callback]
        heapq.heappush(self._calls, call)
        return _Timer(call)

    def run(self, seconds: float = 0.0, most: float = math.inf) -> None:
        """Let time pass, or make so many calls at most."""
        end = self.now + seconds
        while self._calls and self._calls[0][0] <= end:
            if most <= 0:
                return
            when, _, callback = heapq.heappop(self._calls)
            self.now = max(self.now, when)
            if callback is not None:
                callback()
                most -= 1
        self.now = end


class _Timer:
    def __init__(self, call: list[Any]) -> None:
        self._call = call

    def cancel(self) -> None:
        self._call[2] = None


class Wire:
    """One end of a line; `end` has what comes: `receive`, `close` and `ended`."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self.other: Wire
        self.end: Any
        self.over = False
        self.stalled = False
        """True while the other end takes nothing."""
        self._unread: list[bytes] = []

    def write(self, data: bytes) -> None:
        if self.over:
            return
        if self.stalled:
            self._unread.append(data)
            if len(self._unread) == 1:
                self.end.count()
        else:
            self.loop.call_soon(lambda: self.other.end.receive(data))

    def get_write_buffer_size(self) -> int:
        return sum(map(len, self._unread))

    def stall(self, stalled: bool) -> None:
        """Let the other end take nothing from now on, or again what waits."""
        self.stalled = stalled
        if self._unread and not stalled:
            unread, self._unread = self._unread, []
            for data in unread:
                self.write(data)
            self.end.count()

    def close(self) -> None:
        if not self.over:
            self.over = True
            self._unread.clear()
            self.loop.call_soon(self.end.ended)
            self.loop.call_soon(self.other.close)

    abort = close

    def pause_reading(self) -> None:
        """What comes is kept by the peer."""

    resume_reading = pause_reading


def wires(loop: Loop) -> tuple[Wire, Wire]:
    """Both ends of a new line."""
    one, other = Wire(loop), Wire(loop)
    one.other, other.other = other, one
    return one, other


class Variable:
    """A symbol of four bytes."""

    index_group, size, read_only, context, call = 0x4040, 4, False, 0, None

    def __init__(self, number: int) -> None:
        self.number = self.value = number
        self.index_offset = 4 * number

    def read(self) -> bytes:
        return self.value.to_bytes(4, "little")

    def write(self, data: bytes) -> None:
        self.value = int.from_bytes(data, "little")

    def entry(self) -> bytes:
        raise AssertionError


class Symbols:
    """Variables v0, v1, … whose values are their number, and VARIABLES more in each cycle."""

    version = 1

    def __init__(self) -> None:
        self.variables = [Variable(number) for number in range(VARIABLES)]

    def resolve(self, name: str) -> Variable | None:
        return self.variables[int(name[1:])] if name[1:].isdigit() else None

    def upload_info(self) -> TableSizes:
        return TableSizes(symbol_count=0, type_count=0)

    def symbol_table(self) -> bytes:
        return b""

    type_table = symbol_table

    def type_entry(self, name: str) -> None:
        return None


class Host:
    """A router that lets clients in and has uplinks; owner of the peers that came."""

    max_length = 1 << 20
    max_backlog = 1 << 26
    routes_required = False

    def __init__(self, loop: Loop, net_id: NetId, source_nat: bool = False) -> None:
        self.loop = loop
        self.router = Router(net_id, source_nat=source_nat)
        self.send_budget = SendBudget()
        self.fair_queue = FairQueue(loop.time)
        self.peers: list[Peer] = []
        self.uplinks: list[Uplink] = []

    def serves_ports(self, host: str) -> bool:
        return True

    def opened(self, peer: Peer) -> None:
        self.peers.append(peer)

    def closed(self, peer: Peer) -> None:
        if peer in self.peers:
            self.peers.remove(peer)

    def accept(self, line: Wire, host: str = "192.0.2.1") -> None:
        line.end = Peer(self)
        line.end.begin(line, host, 1, counts=True)

    def leads(self, net_id: NetId, to: "Callable[[], Host | None]") -> Uplink:
        """Route to `net_id` by the host that `to` gives; None: it cannot be reached."""

        def dial(uplink: Uplink) -> None:
            self.loop.call_soon(lambda: connect(uplink))

        def connect(uplink: Uplink) -> None:
            there = to()
            if there is None:
                uplink.failed("nobody there")
                return
            here, far = wires(self.loop)
            here.end = uplink.make_peer()
            there.accept(far)
            here.end.begin(here, "192.0.2.2", 48898)

        route = Route(name=f"to {net_id}", net_id=net_id, host="192.0.2.2")
        uplink = Uplink(self.router, route, self.loop, dial)
        self.router.add_route(net_id, uplink)
        self.uplinks.append(uplink)
        return uplink

    def kill(self) -> None:
        """End as a killed process: its connections end, and it does nothing more."""
        dialled = [each.peer for each in self.uplinks if each.peer is not None]
        for peer in [*self.peers, *dialled]:
            line_of(peer).abort()
        for uplink in self.uplinks:
            uplink.close()

    @property
    def forwarded(self) -> int:
        """Subscriptions and handles that it knows of, of clients that are there and gone."""
        peers = [*self.peers, *(each._connection for each in self.uplinks if each._connection)]
        tables = [peer._forwarding for peer in peers if peer._forwarding is not None]
        return sum(len(list(each.resources)) for each in tables)


class Target(Host):
    """A host with a device of variables."""

    def __init__(self, loop: Loop, net_id: NetId, ports: tuple[int, ...] = (851,)) -> None:
        super().__init__(loop, net_id)
        self.time_ns = 1_800_000_000_000_000_000
        self.symbols = Symbols()
        self.device = Device(
            *("PLC", (3, 1, 0), (), self.symbols),
            clock=lambda: self.time_ns,
            task_cycle_ns=TASK,
        )
        for port in ports:
            self.device.attach(self.router, port)

    def tick(self) -> None:
        """A task cycle: each variable changes."""
        for variable in self.symbols.variables:
            variable.value += VARIABLES
        self.time_ns += TASK
        self.device.notifications.tick(self.time_ns)
        self.device.sweep(self.time_ns)

    @property
    def abandoned(self) -> int:
        """Handles of clients that are gone, which any client may use."""
        assert self.device.symbols is not None
        return self.device.symbols.handles.usage.abandoned_handles

    @property
    def held_by_clients(self) -> tuple[int, int]:
        """Subscriptions and handles."""
        assert self.device.symbols is not None
        return len(self.device.notifications), len(self.device.symbols.handles)


class Client:
    """A program that shares its address with others; it uses the variable with its number.

    It notes answers by invoke id, samples by handle, and when its connection ends.
    """

    def __init__(
        self, host: Host, number: int, address: AmsAddress, target: AmsAddress, first_id: int = 1
    ) -> None:
        self.host = host
        self.number = number
        self.address = address
        self.target = target
        self.wire, there = wires(host.loop)
        self.wire.end = self
        host.accept(there)
        self.stream = Connection()
        self.gone = False
        self.answers: dict[int, Frame] = {}
        self.samples: dict[int, list[int]] = {}
        self.hints: list[int] = []
        self.foreign: list[Any] = []
        """What came that it did not ask for."""
        self.next_id = first_id
        self.pending: dict[int, int] = {}

    # the line

    def receive(self, data: bytes) -> None:
        for frame in self.stream.receive(data):
            assert isinstance(frame, Frame)
            if frame.target != self.address or frame.source[:6] != self.target[:6]:
                self.foreign.append(frame)
            elif frame.command == Command.NOTIFICATION:
                for _, samples in NotificationStream.decode(frame.data).stamps:
                    for handle, value in samples:
                        if not value:
                            self.hints.append(handle)
                            continue
                        number = int.from_bytes(value, "little")
                        self.samples.setdefault(handle, []).append(number)
                        if number % VARIABLES != self.number % VARIABLES:
                            self.foreign.append((handle, number))
            elif self.pending.pop(frame.invoke_id, None) != frame.command:
                self.foreign.append(frame)
            else:
                self.answers[frame.invoke_id] = frame

    def close(self) -> None:
        self.wire.close()

    def ended(self) -> None:
        self.gone = True

    # requests

    def send(self, command: int, data: bytes, flags: int = Flags.ADS_COMMAND) -> int:
        """Send a request; its invoke id."""
        frame = Frame(self.target, self.address, command, flags, 0, self.next_id, data)
        if not flags & Flags.NO_RESPONSE:
            self.pending[self.next_id] = command
        self.next_id += 1
        self.wire.write(frame.encode_tcp())
        return frame.invoke_id

    def ask(self, command: int, data: bytes) -> bytes:
        """The data of the answer; b"" if there is an AMS error, or none came."""
        number = self.send(command, data)
        self.host.loop.run()
        if number not in self.answers:
            self.host.loop.run(0.05)  # the answer to a Delete waits behind samples
        answer = self.answers.pop(number, None)
        return b"" if answer is None or answer.error else answer.data

    def exchange(self, group: int, offset: int, length: int, data: bytes) -> bytes:
        """The data of a ReadWrite without its head."""
        request = ReadWriteRequest(group, offset, length, data).encode()
        return self.ask(Command.READ_WRITE, request)[8:]

    def add_request(self, handle: int, mode: int = 4) -> AddNotificationRequest:
        return AddNotificationRequest(0xF005, handle, 4, mode, 0, 0)

    def name(self) -> bytes:
        return b"v%d" % (self.number % VARIABLES)

    def fetch(self) -> int:
        """A symbol handle of its variable, 0 if it was refused."""
        return int.from_bytes(self.exchange(0xF003, 0, 4, self.name()), "little")

    def fetch_many(self, count: int) -> list[int]:
        """The same in a sum command, with a part before each that fails."""
        parts = struct.pack("<IIII", 0xF003, 0, 4, 2) * (2 * count)
        answer = self.exchange(0xF082, 2 * count, 1 << 12, parts + (b"v?" + self.name()) * count)
        pairs = list(struct.iter_unpack("<II", answer[: 16 * count]))
        assert [not result for result, _ in pairs] == [False, True] * count
        return [handle for (handle,) in struct.iter_unpack("<I", answer[16 * count :])]

    def read(self, handle: int) -> int | None:
        """The value of a symbol handle."""
        answer = self.ask(Command.READ, ReadRequest(0xF005, handle, 4).encode())
        return int.from_bytes(answer[8:], "little") if len(answer) == 12 else None

    def subscribe(self, handle: int, mode: int = 4) -> int:
        """A notification handle, 0 if it was refused."""
        answer = self.ask(Command.ADD_NOTIFICATION, self.add_request(handle, mode).encode())
        return int.from_bytes(answer[4:], "little")

    def subscribe_many(self, handle: int, count: int) -> list[int]:
        """The same in a sum command."""
        bodies = self.add_request(handle).encode() * count
        answer = self.exchange(0xF085, count, 8 * count, bodies)
        return [number for _, number in struct.iter_unpack("<II", answer)]

    def unsubscribe(self, handle: int) -> int:
        """The result of deleting a subscription."""
        data = DeleteNotificationRequest(handle).encode()
        return int.from_bytes(self.ask(Command.DELETE_NOTIFICATION, data), "little")

    def unsubscribe_many(self, handles: list[int]) -> list[int]:
        """The same in a sum command."""
        data = struct.pack(f"<{len(handles)}I", *handles)
        answer = self.exchange(0xF086, len(handles), 4 * len(handles), data)
        return [result for (result,) in struct.iter_unpack("<I", answer)]

    def release(self, handle: int) -> int:
        """The result of releasing a symbol handle."""
        data = WriteRequest(0xF006, 0, handle.to_bytes(4, "little")).encode()
        return int.from_bytes(self.ask(Command.WRITE, data), "little")

    def release_many(self, handles: list[int]) -> list[int]:
        """The same in a sum command."""
        parts = struct.pack("<III", 0xF006, 0, 4) * len(handles)
        data = parts + struct.pack(f"<{len(handles)}I", *handles)
        answer = self.exchange(0xF081, len(handles), 4 * len(handles), data)
        return [result for (result,) in struct.iter_unpack("<I", answer)]


def line_of(peer: Peer) -> ByteTransport:
    """The line of a peer that is open."""
    assert peer._transport is not None
    return peer._transport
