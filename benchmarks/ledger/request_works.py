"""Works of clients and the station's cycle: requests on the router of a demo station, ticks."""

import asyncio
import itertools
import struct
from collections.abc import Callable
from typing import Any

Call = Callable[[], object]
READ, WRITE, ADD_NOTIFICATION, NOTIFICATION, READ_WRITE = 2, 3, 6, 8, 9
"""Command ids of ADS."""
BY_NAME, BY_HANDLE, HANDLE, SUM_READ = 0xF004, 0xF005, 0xF003, 0xF080
NAMES = ("MAIN.nCounter", "GVL.nInt", "GVL.fLreal", "GVL.sString", "GVL.stPoint.fX")


class Requester:
    """A client on the router of a station, without a connection."""

    def __init__(self, station: Any) -> None:
        from achse.ams import AmsAddress, Command, Frame

        self._frame, self._command, self._address = Frame, Command, AmsAddress
        self._router = station.router
        self.address = AmsAddress.of(station.router.net_id, 40_000)
        self.data = b""
        self._ids = itertools.count(1)
        station.router.register(self.address.port, self)

    def deliver(self, frame: Any) -> bool:
        """Keep the data of an answer; samples are dropped."""
        if frame.command != NOTIFICATION:
            self.data = frame.data
        return True

    def request(self, port: int, command: int, data: bytes) -> Call:
        """Return a function that sends the request and checks the answer."""
        target = self._address.of(self._router.net_id, port)
        command = self._command(command)

        def send() -> bytes:
            frame = self._frame(
                target, self.address, command, invoke_id=next(self._ids) & 0xFFFF, data=data
            )
            self._router.deliver(frame)
            assert self.data[:4] == bytes(4), self.data[:4].hex()
            return self.data

        return send

    def handle(self, name: str) -> int:
        """Return a handle of a symbol."""
        text = name.encode()
        head = struct.pack("<IIII", HANDLE, 0, 4, len(text))
        answer = self.request(851, READ_WRITE, head + text)()
        assert isinstance(answer, bytes)
        return int(struct.unpack("<I", answer[8:12])[0])


def demo() -> tuple[Any, Requester]:
    """Return the demo station after its first 100 ms, and a client."""
    from achse.station import Station

    station = Station.demo()
    station.advance(0.1)
    return station, Requester(station)


def read() -> Call:
    """Set up the read of a variable."""
    _, client = demo()
    place = struct.pack("<III", BY_HANDLE, client.handle("MAIN.nCounter"), 4)
    return client.request(851, READ, place)


def read_by_name() -> Call:
    """Set up the read of a variable by name."""
    _, client = demo()
    name = b"MAIN.nCounter\0"
    return client.request(851, READ_WRITE, struct.pack("<IIII", BY_NAME, 0, 4, len(name)) + name)


def write() -> Call:
    """Set up the write of a variable."""
    _, client = demo()
    place = struct.pack("<III", BY_HANDLE, client.handle("GVL.nInt"), 2)
    return client.request(851, WRITE, place + struct.pack("<h", 7))


def sum_read() -> Call:
    """Set up the sum command."""
    _, client = demo()
    handles = [client.handle(name) for name in NAMES * 10]
    parts = b"".join(struct.pack("<III", BY_HANDLE, handle, 4) for handle in handles)
    head = struct.pack("<IIII", SUM_READ, len(handles), 8 * len(handles), len(parts))
    return client.request(851, READ_WRITE, head + parts)


def axis_read() -> Call:
    """Set up the read of an axis state."""
    _, client = demo()
    return client.request(501, READ, struct.pack("<III", 0x4101, 0x0A, 8))


def upload() -> Call:
    """Set up the upload of symbols."""
    _, client = demo()
    sizes = client.request(851, READ, struct.pack("<III", 0xF00F, 0, 24))()
    assert isinstance(sizes, bytes)
    (size,) = struct.unpack_from("<I", sizes, 12)
    return client.request(851, READ, struct.pack("<III", 0xF00B, 0, size))


def samples() -> Call:
    """Set up subscriptions that sample in each cycle of the PLC."""
    station, client = demo()
    handle = client.handle("MAIN.nCounter")
    body = struct.pack("<IIIIII16x", BY_HANDLE, handle, 4, 3, 0, 100_000)
    subscribe = client.request(851, ADD_NOTIFICATION, body)
    for _ in range(100):
        subscribe()
    return lambda: station.advance(0.01)


def tick_at_rest() -> Call:
    """Set up a station without clients."""
    station, _ = demo()
    return lambda: station.advance(0.01)


def move_without_end(station: Any, client: Requester, axis: int) -> None:
    """Enable an axis, give it full override, and start it without end."""
    for group, offset, data in (
        (0x4300, 0x01, struct.pack("<I", 7)),
        (0x4300, 0x21, struct.pack("<I", 1_000_000)),
        (0x4200, 0x20, struct.pack("<I4xdd", 3, 0.0, 100.0)),
    ):
        place = struct.pack("<III", group + axis, offset, len(data))
        client.request(501, WRITE, place + data)()
        station.advance(0.1)


def tick_moving() -> Call:
    """Set up a station whose axes move without end."""
    station, client = demo()
    for axis in range(1, 4):
        move_without_end(station, client, axis)
    station.advance(2.0)
    return lambda: station.advance(0.01)


class Scheduler:
    """A loop in which nothing happens by itself: `run` calls what was left for its next turn."""

    def __init__(self) -> None:
        self._now = 0.0
        self._calls: list[Call] = []

    def time(self) -> float:
        return self._now

    def call_soon(self, callback: Call) -> None:
        self._calls.append(callback)

    def call_at(self, when: float, callback: Call) -> None:
        self._now = max(self._now, when)
        self._calls.append(callback)

    def run(self) -> None:
        """Make the pending calls."""
        calls, self._calls = self._calls, []
        for each in calls:
            each()


class Wire:
    """A connection whose far end takes everything."""

    def write(self, data: bytes) -> None:
        pass

    def get_write_buffer_size(self) -> int:
        return 0


WATCHED = (
    (0x01, 4), (0x0A, 8), (0x0B, 8), (0x0C, 4), (0x0D, 8), (0x0E, 8), (0x0F, 8), (0x10, 8),
    (0x11, 8), (0x12, 8), (0x13, 8), (0x14, 16), (0x15, 4), (0x16, 8), (0x17, 8), (0x1A, 8),
    (0x1D, 8), (0x1E, 8), (0x1F, 8), (0x20, 4),
)  # fmt: skip
"""Offset and size of axis states, as in `benchmarks/virtual_time.py`."""


def _watched(moving: bool, other_cycle_ns: int = 0) -> Call:
    """Return 100 ms of a station with 4 axes, 80 values of which a client watches over TCP.

    With `other_cycle_ns` something else is due so often.
    """
    from achse.ams import AmsAddress, Command, Frame
    from achse.station import Station
    from achse.station.clocks.cycle import CyclicPhase, PhasePlace
    from achse.station.configuration.station_file import parse
    from achse.transport.connections.peer import Peer
    from achse.transport.tcp.listener import TcpListener

    axes = [{"id": number, "name": f"A{number}"} for number in range(1, 5)]
    configuration = {"axis": axes, "nc": {"cycle": "2ms", "code": "machine"}}
    station = Station(parse(configuration, "watched"))
    client = Requester(station)
    scheduler = Scheduler()
    listener: Any = TcpListener(station.router)
    listener.begin(scheduler)
    peer = Peer(listener)
    peer.begin(Wire(), "127.0.0.1", 1)  # type: ignore[arg-type]
    if other_cycle_ns:
        station.cycle.add(CyclicPhase(PhasePlace.INPUTS, "other", other_cycle_ns, lambda now: None))
    target = AmsAddress.of(station.router.net_id, 501)
    for axis in range(1, 5):
        if moving:
            move_without_end(station, client, axis)
        for offset, size in WATCHED:
            body = struct.pack("<IIIIII16x", 0x4100 + axis, offset, size, 4, 0, 100_000)
            frame = Frame(
                target, AmsAddress("127.0.0.1.1.2:40000"), Command.ADD_NOTIFICATION, data=body
            )
            peer.receive(frame.encode_tcp())
            scheduler.run()
    station.advance(2.0)
    scheduler.run()
    scheduler.run()

    def pass_time() -> None:
        station.advance(0.1)
        scheduler.run()

    return pass_time


def watched_at_rest() -> Call:
    """Set up axes at rest."""
    return _watched(moving=False)


def watched_moving() -> Call:
    """Set up axes that move without end."""
    return _watched(moving=True)


def watched_in_turns() -> Call:
    """Set up moving axes and a phase that is due in each cycle of the samples."""
    return _watched(moving=True, other_cycle_ns=10_000_000)


def frames() -> Call:
    """Set up a TCP connection of a router with a device that answers 4 bytes."""
    from achse.ams import AmsAddress, Command, Frame, NetId
    from achse.ams.commands import DataResponse, ReadRequest
    from achse.router import Router
    from achse.transport.connections.connection import TcpConnection
    from achse.transport.connections.peer import Peer
    from achse.transport.tcp.listener import TcpListener

    plc, client = AmsAddress("127.0.0.1.1.1:851"), AmsAddress("127.0.0.1.1.1:30000")
    answer = DataResponse(0, bytes(4)).encode()
    router = Router(NetId("127.0.0.1.1.1"))

    class Device:
        def deliver(self, frame: Any) -> bool:
            return router.deliver(frame.reply(answer))

    class Sink(asyncio.Transport):
        def write(self, data: Any) -> None:
            pass

        def get_write_buffer_size(self) -> int:
            return 0

        def set_write_buffer_limits(self, high: Any = None, low: Any = None) -> None:
            pass

        def abort(self) -> None:
            pass

    async def connected() -> Any:
        router.register(plc.port, Device())
        listener = TcpListener(router)
        await listener.open(port=0)
        protocol = TcpConnection(Peer(listener))
        protocol.connection_made(Sink({"peername": ("127.0.0.1", 1)}))
        return protocol

    protocol = asyncio.new_event_loop().run_until_complete(connected())
    read = Frame(plc, client, Command.READ, data=ReadRequest(0x4020, 0, 4).encode()).encode_tcp()
    portion = read * 64
    return lambda: protocol.data_received(portion)
