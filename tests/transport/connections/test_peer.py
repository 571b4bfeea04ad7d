"""Peers in virtual time, on wires that tests drain: what is kept for them is within limits."""

import asyncio
import heapq
from collections.abc import Callable
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Flags, Frame, NetId, TcpCommand, TcpMessage
from achse.router import FIRST_CLIENT_PORT, LOOPBACK_NET_ID, Router
from achse.transport.connections import peer as peer_module
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.held import Held
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener

OURS = NetId("5.1.2.3.1.1")
PLC = AmsAddress.of(OURS, 851)
KB = 1024


class Loop:
    """The calls of a loop that connections make; time passes in `run`."""

    def __init__(self) -> None:
        self.now = 0.0
        self._number = 0
        self._calls: list[tuple[float, int, Callable[..., Any], tuple[Any, ...]]] = []

    def time(self) -> float:
        return self.now

    def call_soon(self, callback: Callable[..., Any], *arguments: Any) -> None:
        self.call_at(self.now, callback, *arguments)

    def call_later(self, delay: float, callback: Callable[..., Any], *arguments: Any) -> Any:
        return self.call_at(self.now + delay, callback, *arguments)

    def call_at(self, when: float, callback: Callable[..., Any], *arguments: Any) -> Any:
        self._number += 1
        heapq.heappush(self._calls, (when, self._number, callback, arguments))
        return self

    def cancel(self) -> None:
        """Timers of refusals: they end what has ended."""

    def run(self, seconds: float = 0.0) -> None:
        end = self.now + seconds
        while self._calls and self._calls[0][0] <= end:
            when, _, callback, arguments = heapq.heappop(self._calls)
            self.now = max(self.now, when)
            callback(*arguments)
        self.now = max(self.now, end)


class Wire:
    """Keeps what is written until the peer reads; a peer that reads leaves nothing."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self.reads = True
        self.waiting = 0
        self.came = 0
        self.gone = False
        self.paused = False
        self.peer: Peer

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.came += len(data)
        if not self.reads and not self.gone:
            before, self.waiting = self.waiting, self.waiting + len(data)
            if not before:
                self.peer.count()

    def read(self, size: int) -> None:
        """The peer takes so many bytes."""
        if 0 < self.waiting <= size:
            self.waiting = 0
            if not self.gone:
                self.peer.count()
        else:
            self.waiting = max(self.waiting - size, 0)

    def get_write_buffer_size(self) -> int:
        return self.waiting

    def pause_reading(self) -> None:
        self.paused = True

    def resume_reading(self) -> None:
        self.paused = False

    def abort(self) -> None:
        self.waiting = 0
        self._end()

    def close(self) -> None:
        self._end()

    def _end(self) -> None:
        if not self.gone:
            self.gone = True
            self.loop.call_soon(self._lost)

    def _lost(self) -> None:
        if self.waiting:  # a closed transport stays until its peer has read
            self.loop.call_later(0.01, self._lost)
        else:
            self.peer.ended()


class Device:
    """Answers with as many bytes as the request asks for."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        self.router.deliver(frame.reply(bytes(int.from_bytes(frame.data[:4], "little"))))
        return True


class Refused:
    """Peers that are turned away: their wires are cut."""

    def add(self, wire: Any, loop: object) -> None:
        wire.abort()


def listener(loop: Loop, **settings: Any) -> TcpListener:
    found: Any = TcpListener(Router(OURS), **settings)
    found.begin(loop)
    found._refusals = Refused()
    found.router.register(851, Device(found.router))
    return found  # type: ignore[no-any-return]


def dial(station: TcpListener, host: str = "10.0.0.1", port: int = 1) -> tuple[Peer, Wire]:
    wire = Wire(station.loop)  # type: ignore[arg-type]
    wire.peer = Peer(station)
    wire.peer.begin(wire, host, port)
    return wire.peer, wire


def request(size: int, source: AmsAddress, data: bytes = b"") -> bytes:
    return Frame(PLC, source, 2, 4, 0, 1, size.to_bytes(4, "little") + data).encode_tcp()


def connect_port(port: int = 0) -> bytes:
    return TcpMessage(TcpCommand.PORT_CONNECT, port.to_bytes(2, "little")).encode_tcp()


CLIENT = AmsAddress("10.0.0.1.1.1:30000")


class Slow(Device):
    """Takes a millisecond for each request; notes whose it was."""

    def __init__(self, router: Router, loop: Loop) -> None:
        super().__init__(router)
        self.loop = loop
        self.served: list[tuple[bytes, int]] = []

    def deliver(self, frame: Frame) -> bool:
        self.loop.now += 0.001
        self.served.append((bytes(frame.source), frame.invoke_id))
        return super().deliver(frame)


def numbered(source: AmsAddress, number: int) -> bytes:
    return Frame(PLC, source, 2, 4, 0, number, bytes(4)).encode_tcp()


@given(
    st.lists(
        st.tuples(st.integers(0, 3), st.integers(1, 400), st.integers(0, 3)),
        min_size=1,
        max_size=12,
    )
)
@settings(max_examples=17)
def test_requests_are_done_in_order_however_much_others_ask(
    portions: list[tuple[int, int, int]],
) -> None:
    """Portions of so many requests from peers at hosts; in between, turns of the loop."""
    loop = Loop()
    station = listener(loop, fair_queue=FairQueue(loop.time))
    station.router.unregister(851)
    slow = Slow(station.router, loop)
    station.router.register(851, slow)
    peers = [dial(station, f"10.0.0.{number // 2}", number) for number in range(4)]
    sources = [AmsAddress(f"10.0.0.{number}.1.1:30000") for number in range(4)]
    sent = [0] * 4
    for number, count, turns in portions:
        data = b"".join(numbered(sources[number], sent[number] + n) for n in range(count))
        sent[number] += count
        peers[number][0].receive(data)  # also from a line that was told to pause
        for _ in range(turns):
            loop.run()
    for _ in range(10_000):
        if not station.fair_queue:
            break
        loop.run()
    for (peer, wire), source, count in zip(peers, sources, sent, strict=True):
        done = [number for whose, number in slow.served if whose == bytes(source)]
        assert done == list(range(count))
        assert not wire.paused
        assert (peer.held, wire.gone) == (0, False)


def test_a_peer_that_leaves_takes_what_waits_with_it() -> None:
    loop = Loop()
    station = listener(loop, fair_queue=FairQueue(loop.time))
    station.router.unregister(851)
    slow = Slow(station.router, loop)
    station.router.register(851, slow)
    peer, wire = dial(station)
    peer.receive(b"".join(numbered(CLIENT, number) for number in range(1000)))
    assert wire.paused
    assert peer.held > 30_000
    peer.ended()
    served = len(slow.served)
    loop.run(1.0)
    assert (len(slow.served), len(station.fair_queue), station.held.total) == (served, 0, 0)


def test_a_thousand_small_debts_count_together() -> None:
    """Each below a megabyte, which nobody looked at once: 1.5 GB where 256 MB were the limit."""
    loop = Loop()
    station = listener(loop, held=Held(4096 * KB))
    wires = []
    for number in range(100):
        connection, wire = dial(station, port=number)
        wire.reads = False
        wires.append(wire)
        connection.receive(request(100 * KB, CLIENT))
        assert sum(each.waiting for each in wires) <= 4096 * KB
    loop.run(1)
    assert station.cut_off > 50


def test_what_a_closed_peer_does_not_read_counts_until_it_is_gone() -> None:
    loop = Loop()
    station = listener(loop, held=Held(1000 * KB))
    connection, wire = dial(station)
    wire.reads = False
    connection.receive(request(300 * KB, CLIENT))
    connection.close()
    assert connection.held == station.held.total > 300 * KB
    loop.run(peer_module._LINGER + 1)
    assert station.held.total == 0
    assert not station.connections


def test_connections_of_one_host_leave_room_for_others(caplog: Any) -> None:
    loop = Loop()
    station = listener(loop, max_connections=10, max_per_host=4)
    first = [dial(station, "10.0.0.1", number) for number in range(8)]
    other, _ = dial(station, "10.0.0.2")
    assert len(station.connections) == 5
    assert other in station.connections
    assert station.refused == 4
    assert caplog.text.count("as anyone who comes from 10.0.0.1 until") == 1
    assert "max_connections_per_host is 4" in caplog.text
    for connection, _ in first[:4]:
        connection.abort()
    loop.run()
    again, _ = dial(station, "10.0.0.1", 99)
    assert again in station.connections


def test_a_connection_holds_so_many_ports_and_every_client_gets_its_first() -> None:
    loop = Loop()
    station = listener(loop, max_connections=5000, max_per_host=5000)
    greedy, _ = dial(station, "127.0.0.1")
    greedy.receive(connect_port() * 256)
    assert len(greedy.registered) == 256
    greedy.receive(connect_port())
    assert not greedy.registered
    many = [dial(station, "127.0.0.1", number)[0] for number in range(200)]
    for connection in many:
        for _ in range(255):
            if connection._open:
                connection.receive(connect_port())
    assert station.router.free_ports >= 8192
    late = [dial(station, "127.0.0.1", number)[0] for number in range(4000)]
    for connection in late:
        connection.receive(connect_port())
    assert all(len(connection.registered) == 1 for connection in late)
    assert all(each.registered[0].port >= FIRST_CLIENT_PORT for each in late)


STEPS = st.lists(
    st.tuples(
        st.sampled_from(
            ("dial", "ask", "half", "rest", "sample", "add", "deaf", "read", "eof", "abort", "wait")
        ),
        st.integers(0, 11),
        st.sampled_from((0, 1, 100, 5 * KB, 30 * KB, 60 * KB, 120 * KB)),
    ),
    max_size=100,
)


@settings(max_examples=38)
@given(st.integers(100 * KB, 300 * KB), st.integers(50 * KB, 400 * KB), STEPS)
def test_whatever_connections_do_what_is_kept_stays_within_the_limits(
    limit: int, backlog: int, steps: list[tuple[str, int, int]]
) -> None:
    """Requests, halves of packets, samples, readers that stop, ends of all kinds."""
    loop = Loop()
    station = listener(
        loop, held=Held(limit), max_backlog=backlog, max_connections=8, max_per_host=5
    )
    made: list[tuple[Peer, Wire, AmsAddress]] = []
    good, good_wire = dial(station, "10.9.9.9")
    for number, (what, which, size) in enumerate(steps, 1):
        if what == "dial":
            host = f"10.0.0.{which % 3}"
            address = AmsAddress(f"{host}.1.1:3000{which % 5}")
            made.append((*dial(station, host, number), address))
            made[-1][1].reads = which % 4 == 3
        elif made:
            connection, wire, address = made[which % len(made)]
            if what == "ask" and not wire.gone:
                connection.receive(request(size, address))
            elif what == "half" and not wire.gone:
                connection.receive(request(0, address, bytes(size))[: size // 2 + 7])
            elif what == "rest" and not wire.gone:
                connection.receive(bytes(size))
            elif what in ("sample", "add"):
                command, flags = (8, 4) if what == "sample" else (6, 5)
                frame = Frame(address, PLC, command, flags, 0, 1, bytes(size))
                frame.via = connection
                station.router.deliver(frame)
            elif what in ("deaf", "read"):
                wire.reads = what == "read"
                wire.read(size)
            elif what == "eof" and not wire.gone:
                connection.close()
            elif what == "abort":
                connection.abort()
        if what == "wait":
            loop.run(size / KB / 1000)
        good.receive(request(10, AmsAddress("10.9.9.9.1.1:30000")))
        assert good_wire.came == number * (38 + 10)
        every = [(good, good_wire), *((each, wire) for each, wire, _ in made)]
        kept = [
            each._out.size + each._out.held_size + each._stream.pending + wire.waiting
            for each, wire in every
        ]
        assert sum(kept) <= limit + len(every) * peer_module._SMALL
        assert station.held.total <= limit
        assert max(wire.waiting for _, wire in every) <= backlog + peer_module._FLUSH_SIZE
        assert len(station.connections) <= 8
        assert max(station._per_host.values()) <= 5
        assert sum(station._per_host.values()) == len(station.connections)
    for each, wire, _ in made:
        each.abort()
        wire.abort()
    loop.run(10)
    assert station.held.total == 0
    assert station.connections == {good}
    assert dict(station._per_host) == {"10.9.9.9": 1}


@given(
    of_device=st.booleans(),
    loopback=st.booleans(),
    host=st.sampled_from(("127.0.0.1", "10.0.0.7")),
    first=st.booleans(),
    command=st.sampled_from((Command.READ, Command.DELETE_NOTIFICATION, Command.NOTIFICATION)),
    flags=st.sampled_from((4, 4 | Flags.RESPONSE, 4 | Flags.NO_RESPONSE)),
    to_client=st.booleans(),
)
@settings(max_examples=40)
def test_address_of_a_port_is_used_by_its_holder_alone(
    of_device: bool,
    loopback: bool,
    host: str,
    first: bool,
    command: Command,
    flags: int,
    to_client: bool,
) -> None:
    """Before, anyone ended subscriptions of another program, or sent it answers of a device."""
    loop = Loop()
    station = listener(loop)
    came: list[Frame] = []
    station.router.put_watcher(came.append)
    holder, wire = dial(station, "127.0.0.1")
    holder.receive(connect_port())
    other, other_wire = dial(station, host, 2)
    [client] = holder.registered
    if first:
        other.receive(request(4, CLIENT))
    loop.run()
    came.clear()
    before = wire.came, other_wire.came
    whose = AmsAddress.of(OURS, 852 if of_device else client.port)
    if of_device:
        station.router.register(852, Device(station.router))
    source = AmsAddress.of(LOOPBACK_NET_ID, whose.port) if loopback else whose
    target = client if to_client else PLC
    frame = Frame(target, source, command, flags, 0, 7, bytes(4))
    other.receive(frame.encode_tcp())
    loop.run()
    assert wire.came == before[0]
    assert not [each for each in came if each.source == source]
    answered = flags == 4 and command != Command.NOTIFICATION
    assert (other_wire.came > before[1]) is answered
    assert not other_wire.gone
    other.receive(request(4, CLIENT))
    holder.receive(request(4, client))
    loop.run()
    assert wire.came > before[0]


class Uplink:
    """The endpoint behind a route, and owner of the peer at its host."""

    def __init__(self, listener: TcpListener, loop: Loop) -> None:
        self.listener, self.loop = listener, loop
        self.peer: Peer

    def __getattr__(self, name: str) -> Any:
        return getattr(self.listener, name)

    def deliver(self, frame: Frame) -> bool:
        return self.peer.deliver(frame)


@given(
    by=st.sampled_from(("target", "other target", "stranger")),
    command=st.sampled_from((Command.READ, Command.READ_WRITE, Command.NOTIFICATION)),
    registered=st.booleans(),
    invoke_id=st.sampled_from((7, 8)),
    port=st.sampled_from((851, 852)),
)
@settings(max_examples=40)
def test_answers_in_the_name_of_a_target_come_from_the_target_alone(
    by: str, command: Command, registered: bool, invoke_id: int, port: int
) -> None:
    """Another connection may claim its NetId, and guess the invoke id of a request."""
    loop = Loop()
    station = listener(loop)
    peers: dict[str, Peer] = {}
    for number, name in enumerate(("target", "other target"), 2):
        uplink = Uplink(station, loop)
        station.router.add_route(NetId(f"5.9.9.{number}.1.1"), uplink)
        uplink.peer = peers[name] = Peer(uplink)
        wire = Wire(loop)
        wire.peer = uplink.peer
        uplink.peer.begin(wire, f"10.0.0.{number}", 48898)
    client, client_wire = dial(station, "127.0.0.1", 2)
    if registered:
        client.receive(connect_port())
        [source] = client.registered
    else:
        source = CLIENT
    peers["stranger"] = dial(station, "10.0.0.7", 3)[0]
    for number in (2, 3):  # something is under way to both targets
        target = AmsAddress.of(NetId(f"5.9.9.{number}.1.1"), 851)
        client.receive(Frame(target, source, Command.READ, 4, 0, 7, bytes(12)).encode_tcp())
    loop.run()
    before, lost = client_wire.came, station.router.lost_frames
    claimed = AmsAddress.of(NetId("5.9.9.2.1.1"), port)
    flags = 4 if command == Command.NOTIFICATION else 5
    forged = Frame(source, claimed, command, flags, 0, invoke_id, bytes(8))
    peers[by].receive(forged.encode_tcp())
    loop.run()
    assert (client_wire.came > before) is (by == "target")
    assert (station.router.lost_frames > lost) is (by != "target")


async def test_lines_without_sockets_are_let_in_from_begin_until_close() -> None:
    owner = TcpListener(Router(OURS))

    def dial() -> Peer:
        peer = Peer(owner)
        peer.begin(Wire(Loop()), "127.0.0.1", 1)
        return peer

    assert not dial().connected
    owner.begin(asyncio.get_running_loop())
    peer = dial()
    assert peer.connected
    assert peer in owner.connections
    await owner.close()
    assert not dial().connected
