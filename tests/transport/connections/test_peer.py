"""Peers in virtual time, on wires that tests drain: what is kept for them is within limits."""

import asyncio
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Connection, Flags, Frame, NetId
from achse.router import FIRST_CLIENT_PORT, LOOPBACK_NET_ID, Router
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener
from tests.transport.connections.peers import (
    CLIENT,
    OURS,
    PLC,
    Device,
    Loop,
    Wire,
    connect_port,
    dial,
    listener,
    request,
)


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
def test_requests_are_done_in_order_however_much_others_query(
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
    for number, count, scheduler in portions:
        data = b"".join(numbered(sources[number], sent[number] + n) for n in range(count))
        sent[number] += count
        peers[number][0].receive(data)  # also from a line that was told to pause
        for _ in range(scheduler):
            loop.run()
    for _ in range(10_000):
        if not station.fair_queue:
            break
        loop.run()
    for (peer, wire), source, count in zip(peers, sources, sent, strict=True):
        done = [number for whose, number in slow.served if whose == bytes(source)]
        assert done == list(range(count))
        assert not wire.paused
        assert (peer.buffered_bytes, wire.gone) == (0, False)


class Recorded(Wire):
    """A wire that keeps what is written."""

    def __init__(self, loop: Loop) -> None:
        super().__init__(loop)
        self.stream = Connection()
        self.frames: list[Frame] = []

    def write(self, data: bytes | bytearray | memoryview) -> None:
        super().write(data)
        self.frames += [
            each for each in self.stream.receive(bytes(data)) if isinstance(each, Frame)
        ]


@given(
    st.lists(st.sampled_from(("add", "sample", "delete", "sum", "read", "wait")), max_size=40),
    st.booleans(),
)
@settings(max_examples=60)
def test_no_sample_comes_after_the_answer_to_a_delete(steps: list[str], forwarded: bool) -> None:
    """Samples wait behind the answer to an Add: the answer to a Delete waits behind them."""
    loop = Loop()
    wire = Recorded(loop)
    wire.peer = peer = Peer(listener(loop))
    peer.begin(wire, "10.0.0.1", 1)
    deletes, sent = [], 0
    for number, step in enumerate(steps):
        if step == "wait":
            loop.run(0.004)
            continue
        command = {"add": 6, "sample": 8, "delete": 7, "sum": 9, "read": 2}[step]
        frame = Frame(CLIENT, PLC, command, 4 if step == "sample" else 5, 0, number, bytes(4))
        if step == "sum" or (step == "delete" and not forwarded):
            peer.subscription_ended()
        if step in ("delete", "sum"):
            deletes.append(number)
        assert peer.deliver(frame)
        sent += 1
    loop.run(1.0)
    order = [frame.invoke_id for frame in wire.frames]
    assert len(order) == sent
    for delete in deletes:
        samples = [n for n, step in enumerate(steps) if step == "sample" and n < delete]
        assert all(order.index(each) < order.index(delete) for each in samples)


def test_a_peer_that_leaves_takes_what_waits_with_it() -> None:
    loop = Loop()
    station = listener(loop, fair_queue=FairQueue(loop.time))
    station.router.unregister(851)
    slow = Slow(station.router, loop)
    station.router.register(851, slow)
    peer, wire = dial(station)
    peer.receive(b"".join(numbered(CLIENT, number) for number in range(1000)))
    assert wire.paused
    assert peer.buffered_bytes > 30_000
    peer.ended()
    served = len(slow.served)
    loop.run(1.0)
    assert (len(slow.served), len(station.fair_queue), station.send_budget.total) == (served, 0, 0)


def test_connections_of_one_host_leave_room_for_others(caplog: Any) -> None:
    loop = Loop()
    station = listener(loop, max_connections=10, max_per_host=4)
    first = [dial(station, "10.0.0.1", number) for number in range(8)]
    other, _ = dial(station, "10.0.0.2")
    assert len(station.connections) == 5
    assert other in station.connections
    assert station.refused == 4
    assert caplog.text.count("as all further clients from 10.0.0.1 until") == 1
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
            if connection.connected:
                connection.receive(connect_port())
    assert station.router.free_ports >= 8192
    late = [dial(station, "127.0.0.1", number)[0] for number in range(4000)]
    for connection in late:
        connection.receive(connect_port())
    assert all(len(connection.registered) == 1 for connection in late)
    assert all(each.registered[0].port >= FIRST_CLIENT_PORT for each in late)


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
