"""The AMS/TCP listener over real loopback sockets: port service, hostile and dead peers."""

import asyncio
import logging
import socket
import struct
from collections.abc import AsyncIterator, Awaitable, Iterable
from contextlib import asynccontextmanager
from typing import Any

import pytest

from achse.ams import AmsAddress, Connection, Event, Frame, NetId, TcpCommand, TcpMessage
from achse.router import FIRST_CLIENT_PORT, LOOPBACK_NET_ID, Router
from achse.transport.connections import peer as peer_module
from achse.transport.connections.connection import TcpConnection
from achse.transport.connections.peer import Peer as Far
from achse.transport.connections.send_budget import SendBudget
from achse.transport.tcp import listener as tcp
from achse.transport.tcp.listener import TcpListener

OURS = NetId("5.1.2.3.1.1")
PLC = AmsAddress.of(OURS, 851)
CLIENT = AmsAddress("127.0.0.1.1.1:30000")
"""What every pyads on this host calls itself."""

PORT_CONNECT, PORT_CLOSE = TcpCommand.PORT_CONNECT, TcpCommand.PORT_CLOSE


class Device:
    """Answers each request with its data, or with `size` zero bytes; keeps what it got."""

    def __init__(self, router: Router, size: int | None = None) -> None:
        self.router = router
        self.size = size
        self.frames: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        self.router.deliver(frame.reply(frame.data if self.size is None else bytes(self.size)))
        return True


class Station(TcpListener):
    """A listener that tells when connections come and go."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(Router(OURS), **settings)
        self.device = Device(self.router)
        self.router.register(851, self.device)
        self.freed: asyncio.Queue[int] = asyncio.Queue()
        self.router.on_port_closed(lambda address: self.freed.put_nowait(address.port))
        self.went: asyncio.Queue[Far] = asyncio.Queue()

    def closed(self, peer: Far) -> None:
        super().closed(peer)
        self.went.put_nowait(peer)


class Peer:
    """A client on a plain socket."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader = reader
        self.writer = writer
        self._stream = Connection()
        self._events: list[Event] = []

    def send(self, *events: Event | bytes) -> None:
        for event in events:
            self.writer.write(event if isinstance(event, bytes) else event.encode_tcp())

    async def next(self) -> Event:
        while not self._events:
            data = await self.reader.read(65536)
            if not data:
                raise EOFError
            self._events.extend(self._stream.receive(data))
        return self._events.pop(0)

    async def next_frame(self) -> Frame:
        event = await self.next()
        assert isinstance(event, Frame)
        return event

    async def ask(self, frame: Frame) -> Frame:
        self.send(frame)
        return await self.next_frame()

    async def register(self, port: int = 0) -> AmsAddress:
        self.send(TcpMessage(PORT_CONNECT, port.to_bytes(2, "little")))
        answer = await self.next()
        assert isinstance(answer, TcpMessage)
        assert answer.command is PORT_CONNECT
        return AmsAddress(answer.data)

    async def is_closed(self) -> bool:
        """True once the other side has ended the connection, False if it talks instead."""
        try:
            await self.next()
        except (EOFError, ConnectionError):
            return True
        return False

    def reset(self) -> None:
        """End without a FIN: the other side gets an RST."""
        raw = self.writer.get_extra_info("socket")
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.writer.transport.abort()


@asynccontextmanager
async def running(**settings: Any) -> AsyncIterator[Station]:
    station = Station(**settings)
    await station.open(port=0)
    try:
        yield station
    finally:
        await station.close()
        assert not station.connections


@asynccontextmanager
async def peers(station: TcpListener, count: int = 1) -> AsyncIterator[list[Peer]]:
    peers = [Peer(*await asyncio.open_connection(station.host, station.port)) for _ in range(count)]
    try:
        yield peers
    finally:
        for peer in peers:
            peer.writer.transport.abort()
        await _all(peer.writer.wait_closed() for peer in peers)


async def _all(awaitables: Iterable[Awaitable[Any]]) -> None:
    await asyncio.gather(*awaitables, return_exceptions=True)


def request(
    invoke_id: int = 1, data: bytes = b"", *, target: bytes = PLC, source: bytes = CLIENT
) -> Frame:
    return Frame(target, source, 2, 0x0004, 0, invoke_id, data)


# the stream


async def test_a_request_is_answered_on_its_connection() -> None:
    async with running() as station, peers(station) as (peer,):
        assert await peer.ask(request(7, b"ping")) == Frame(CLIENT, PLC, 2, 0x0005, 0, 7, b"ping")


async def test_coalesced_requests_are_all_answered_in_order() -> None:
    async with running() as station, peers(station) as (peer,):
        peer.send(b"".join(request(i, bytes(i % 50)).encode_tcp() for i in range(1, 5001)))
        for i in range(1, 5001):
            answer = await peer.next_frame()
            assert (answer.invoke_id, len(answer.data)) == (i, i % 50)


async def test_a_request_in_single_bytes_is_answered() -> None:
    async with running() as station, peers(station) as (peer,):
        stream = request(1).encode_tcp() + request(2, b"data").encode_tcp()
        for i in range(len(stream)):
            peer.send(stream[i : i + 1])
            await peer.writer.drain()
            await asyncio.sleep(0)
        assert (await peer.next_frame()).invoke_id == 1
        assert (await peer.next_frame()).data == b"data"


async def test_two_connections_with_one_source_address_get_their_own_answers() -> None:
    async with running() as station, peers(station, 2) as (first, second):
        for i in range(20):
            first.send(request(i, b"first"))
            second.send(request(i, b"second"))
        for i in range(20):
            for peer, name in ((first, b"first"), (second, b"second")):
                answer = await peer.next_frame()
                assert (answer.invoke_id, answer.data) == (i, name)


async def test_router_errors_stand_in_the_header() -> None:
    async with running() as station, peers(station) as (peer,):
        nobody = await peer.ask(request(target=AmsAddress.of(OURS, 1000)))
        assert (nobody.error, nobody.flags, nobody.data) == (0x6, 0x0005, b"")
        nowhere = await peer.ask(request(target=AmsAddress("9.9.9.9.1.1:851")))
        assert (nowhere.error, nowhere.flags, nowhere.data) == (0x7, 0x0005, b"")


async def test_a_notification_reaches_a_client_that_never_registered() -> None:
    async with running() as station, peers(station) as (peer,):
        await peer.ask(request())
        assert station.router.deliver(Frame(CLIENT, PLC, 8, data=b"sample"))
        assert (await peer.next_frame()).data == b"sample"


async def test_an_exception_over_one_frame_is_reported_and_closes_nothing(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Broken:
        def deliver(self, frame: Frame) -> bool:
            raise RecursionError

    async with running() as station, peers(station, 2) as (peer, other):
        station.router.register(852, Broken())
        peer.send(request(1, target=AmsAddress.of(OURS, 852)), request(2))
        assert [(await peer.next_frame()).error for _ in range(2)] == [1, 0]
        assert (await other.ask(request(3))).error == 0
    assert "could not be delivered" in caplog.text


# the port service


async def test_any_port_is_granted_from_32768_up_with_our_net_id() -> None:
    async with running() as station, peers(station, 2) as (first, second):
        assert await first.register() == AmsAddress.of(OURS, FIRST_CLIENT_PORT)
        assert await second.register() == AmsAddress.of(OURS, FIRST_CLIENT_PORT + 1)


async def test_the_registration_as_bytes() -> None:
    async with running() as station, peers(station) as (peer,):
        peer.send(bytes.fromhex("0010 02000000 2c75"))
        assert await peer.reader.readexactly(14) == bytes.fromhex("0010 08000000 050102030101 2c75")
        peer.send(bytes.fromhex("0110 04000000 00000000"))  # a note has no answer
        peer.send(bytes.fromhex("0210 00000000"))
        assert await peer.reader.readexactly(12) == bytes.fromhex("0210 06000000 050102030101")


async def test_a_taken_port_closes_the_connection_that_queries(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with running() as station, peers(station, 2) as (holder, second):
        await holder.register(30012)
        second.send(TcpMessage(PORT_CONNECT, (30012).to_bytes(2, "little")))
        assert await second.is_closed()
        assert "ROUTER_PORT_IN_USE" in caplog.text
        assert 30012 in station.router.ports


async def test_port_close_frees_the_port_and_with_the_last_one_ends_the_connection() -> None:
    """npm ads-client waits for the end of the connection before it calls itself disconnected."""
    async with running() as station, peers(station) as (peer,):
        first, second = await peer.register(), await peer.register()
        peer.send(TcpMessage(PORT_CLOSE, first[6:]))
        assert (await peer.ask(request(source=second))).target == second
        assert station.router.ports == [851, second.port]
        peer.send(TcpMessage(PORT_CLOSE, second[6:]))
        assert await peer.is_closed()
        assert station.router.ports == [851]


async def test_no_client_closes_the_port_of_another() -> None:
    async with running() as station, peers(station, 2) as (holder, other):
        address = await holder.register()
        other.send(TcpMessage(PORT_CLOSE, address[6:]), TcpMessage(PORT_CLOSE, PLC[6:]))
        await other.ask(request())
        assert station.router.ports == [851, address.port]


@pytest.mark.parametrize(
    ("command", "size"), [(PORT_CONNECT, 0), (PORT_CONNECT, 8), (PORT_CLOSE, 1), (PORT_CLOSE, 3)]
)
async def test_a_port_service_of_wrong_size_closes(
    command: TcpCommand, size: int, caplog: pytest.LogCaptureFixture
) -> None:
    async with running() as station, peers(station) as (peer,):
        peer.send(TcpMessage(command, bytes(size)), request())
        assert await peer.is_closed()
        assert f"{command.name} with {size} bytes" in caplog.text
        assert station.device.frames == []


async def test_peers_on_other_hosts_get_no_port_service_unless_let_in(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(tcp, "is_loopback", lambda host: False)
    async with running() as station, peers(station, 2) as (asker, client):
        asker.send(TcpMessage(PORT_CONNECT, bytes(2)), request())
        assert await asker.is_closed()
        assert "port service refused" in caplog.text
        assert station.router.ports == [851]
        assert (await client.ask(request(5))).invoke_id == 5
        station.external_registration = True
        assert (await client.register()).port == FIRST_CLIENT_PORT


# foreign servers


async def test_a_registered_foreign_server_is_queried_and_answers() -> None:
    async with running() as station, peers(station, 2) as (server, client):
        address = await server.register(30012)
        for net_id in (OURS, LOOPBACK_NET_ID):
            client.send(request(9, b"question", target=AmsAddress.of(net_id, address.port)))
            question = await server.next_frame()
            assert (question.source, question.data) == (CLIENT, b"question")
            server.send(question.reply(b"answer"))
            answer = await client.next_frame()
            assert (answer.data, answer.source) == (b"answer", question.target)


async def test_askers_with_one_address_get_their_own_answers_from_a_foreign_server() -> None:
    async with running() as station, peers(station, 3) as (server, first, second):
        address = await server.register(30012)
        for i in range(1, 6):
            for peer, name in ((first, b"first"), (second, b"second")):
                peer.send(request(i, name, target=address))
                question = await server.next_frame()
                assert question.data == name
                server.send(question.reply(question.data))
        for i in range(1, 6):
            for peer, name in ((first, b"first"), (second, b"second")):
                answer = await peer.next_frame()
                assert (answer.invoke_id, answer.data) == (i, name)


async def test_the_same_invoke_id_from_two_askers_at_once() -> None:
    async with running() as station, peers(station, 3) as (server, first, second):
        address = await server.register(30012)
        questions = []
        for peer in (first, second):
            peer.send(request(1, target=address))
            questions.append(await server.next_frame())
        for question, name in zip(questions, (b"first", b"second"), strict=True):
            server.send(question.reply(name))
        assert (await first.next_frame()).data == b"first"
        assert (await second.next_frame()).data == b"second"


async def test_a_vanished_server_frees_its_port_and_its_clients_hear_0x6() -> None:
    async with running() as station, peers(station, 2) as (server, client):
        address = await server.register(30012)
        server.reset()
        assert await station.freed.get() == 30012
        assert (await client.ask(request(target=address))).error == 0x6


# connections


async def test_many_connections_per_host_are_usual() -> None:
    async with running() as station, peers(station, 50) as many:
        for i, peer in enumerate(many):
            assert (await peer.ask(request(i))).invoke_id == i
        assert len(station.connections) == 50


async def test_strict_a_second_connection_of_a_host_closes_one_without_port() -> None:
    async with running(strict=True) as station, peers(station) as (registered,):
        address = await registered.register()
        async with peers(station) as (first,):
            await first.ask(request())
            async with peers(station) as (second,):
                assert await first.is_closed()
                assert (await second.ask(request(2))).invoke_id == 2
                assert (await registered.ask(request(3, source=address))).invoke_id == 3


async def test_sources_on_one_connection_are_bounded() -> None:
    async with running() as station, peers(station) as (peer,):
        for i in range(1500):
            peer.send(request(i, source=struct.pack("<Q", i)))
        for _ in range(1500):
            await peer.next()
        assert len(station.router._learned) == 1024
        peer.reset()
        await station.went.get()
        assert station.router._learned == {}


# hostile and dead peers


@pytest.mark.parametrize(
    ("stream", "says"),
    [
        (b"GET / HTTP/1.1\r\n\r\n", "AMS/TCP command 0x4547 is not known"),
        (struct.pack("<HI", 0, 64 * 1024 * 1024 + 1), "the limit is 67108864"),
        (struct.pack("<HI", 0, 0xFFFFFFFF), "a packet of 4294967295 bytes is announced"),
        (struct.pack("<HI", 0, 4), "at least 32 bytes"),
        (request().encode_tcp()[:26] + b"\xff" * 12, "announces 4294967295 bytes"),
    ],
)
async def test_garbage_closes_with_a_log_line_after_the_answers_before_it(
    stream: bytes, says: str, caplog: pytest.LogCaptureFixture
) -> None:
    async with running() as station, peers(station, 2) as (bad, good):
        bad.send(request(1).encode_tcp() + stream)
        assert (await bad.next_frame()).invoke_id == 1
        assert await bad.is_closed()
        assert says in caplog.text
        assert [record.levelno for record in caplog.records] == [logging.WARNING]
        assert (await good.ask(request(2))).invoke_id == 2


async def test_the_length_limit_is_configurable() -> None:
    async with running(max_length=100) as station, peers(station) as (peer,):
        assert len((await peer.ask(request(1, bytes(68)))).data) == 68
        peer.send(request(1, bytes(69)))
        assert await peer.is_closed()


async def test_an_abrupt_reset_leaves_nothing_behind() -> None:
    async with running() as station, peers(station) as (peer,):
        address = await peer.register()
        peer.send(request(source=address).encode_tcp()[:20])
        peer.reset()
        connection = await station.went.get()
        assert await station.freed.get() == address.port
        assert not connection.deliver(request(target=address))
        assert station.router.ports == [851]


async def test_after_a_half_close_the_answers_still_come() -> None:
    async with running() as station, peers(station) as (peer,):
        station.device.size = 1024 * 1024
        peer.send(request(1), request(2))
        peer.writer.write_eof()
        assert [(await peer.next_frame()).invoke_id for _ in range(2)] == [1, 2]
        assert await peer.is_closed()


async def test_a_peer_that_does_not_read_is_cut_off(caplog: pytest.LogCaptureFixture) -> None:
    async with running(max_backlog=1024 * 1024) as station, peers(station, 2) as (slow, good):
        station.device.size = 256 * 1024
        slow.reader._transport.pause_reading()  # type: ignore[attr-defined]
        slow.send(b"".join(request(i).encode_tcp() for i in range(200)))
        await station.went.get()
        [record] = caplog.records
        assert "does not read" in record.getMessage()
        assert record.client == str(CLIENT)  # type: ignore[attr-defined]
        assert record.peer.startswith("127.0.0.1:")  # type: ignore[attr-defined]
        assert len(station.device.frames) < 200, "requests behind the cut are not worked on"
        station.device.size = 4
        assert (await good.ask(request(2))).invoke_id == 2


async def test_a_server_that_does_not_read_has_a_full_mailbox() -> None:
    async with running() as station, peers(station, 2) as (server, client):
        address = await server.register()
        server.reader._transport.pause_reading()  # type: ignore[attr-defined]
        client.send(*(request(i, bytes(1 << 20), target=address) for i in range(40)))
        refused = await client.next_frame()
        assert refused.error == 0x502
        assert len(station.connections) == 2


async def test_a_peer_that_vanished_is_looked_for() -> None:
    async with running() as station, peers(station) as (peer,):
        await peer.ask(request())
        [connection] = station.connections
        transport: Any = connection._transport
        accepted = transport.get_extra_info("socket")
        assert accepted.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE) == 1


async def test_answers_to_one_burst_do_not_gather_beyond_the_backlog() -> None:
    """Requests of 38 bytes each ask for a megabyte: 6800 of them fit into one read."""
    station = Station(max_backlog=8 * 1024 * 1024)
    station.begin(asyncio.get_running_loop())
    station.device.size = 1024 * 1024
    transport = _Deaf()
    connection = TcpConnection(Far(station))
    connection.connection_made(transport)
    connection.data_received(b"".join(request(i).encode_tcp() for i in range(1000)))
    while not transport.aborted:  # noqa: ASYNC110 - a slow machine does not do all in one turn
        await asyncio.sleep(0)
    assert transport.waiting < 10 * 1024 * 1024
    connection.connection_lost(None)
    await station.close()


async def test_of_unfinished_packets_that_are_too_much_together_the_largest_goes(
    caplog: pytest.LogCaptureFixture,
) -> None:
    mb = 1 << 20
    budget = SendBudget(8 * mb)
    async with running(send_budget=budget) as station, peers(station, 3) as (large, small, last):
        half = request(1, bytes(32 * mb)).encode_tcp()
        large.send(half[: 4 * mb])
        small.send(half[: 3 * mb])
        while sum(each.buffered_bytes for each in station.connections) < 7 * mb:  # noqa: ASYNC110 - sockets tell nobody
            await asyncio.sleep(0)
        last.send(half[: 2 * mb])
        gone = await station.went.get()
        assert gone.peer.endswith(f":{large.writer.get_extra_info('sockname')[1]}")
        [record] = caplog.records
        assert "hold too much" in record.getMessage()
        assert (station.cut_off, len(station.connections), gone.buffered_bytes) == (1, 2, 0)


class _Deaf(asyncio.Transport):
    """A transport whose peer reads nothing."""

    def __init__(self) -> None:
        super().__init__({"peername": ("127.0.0.1", 1)})
        self.waiting = 0
        self.aborted = False

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.waiting += len(data)

    def get_write_buffer_size(self) -> int:
        return self.waiting

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        pass

    def pause_reading(self) -> None:  # a slow machine reaches the limit of time for one read
        pass

    def resume_reading(self) -> None:
        pass

    def abort(self) -> None:
        self.aborted = True


async def test_a_closed_peer_that_does_not_read_is_cut_off(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(peer_module, "_LINGER", 0.0)
    async with running() as station, peers(station) as (peer,):
        station.device.size = 16 * 1024 * 1024
        peer.reader._transport.pause_reading()  # type: ignore[attr-defined]
        peer.send(request(), b"garbage")
        await station.went.get()


# opening and closing


async def test_closing_ends_every_connection_and_frees_every_port() -> None:
    async with running() as station, peers(station, 3) as clients:
        ports = [(await client.register()).port for client in clients]
        await station.close()
        for client in clients:
            assert await client.is_closed()
        assert sorted([station.freed.get_nowait() for _ in ports]) == ports
        with pytest.raises(ConnectionRefusedError):
            await asyncio.open_connection(station.host, station.port)


async def test_closing_does_not_wait_for_clients_that_never_read() -> None:
    station = Station()
    await station.open(port=0)
    async with peers(station, 5) as clients:
        station.device.size = 16 * 1024 * 1024
        for client in clients:
            client.send(request())
            await client.reader.readexactly(1)
            client.reader._transport.pause_reading()  # type: ignore[attr-defined]
        await station.close()
        assert not station.connections


async def test_a_connection_made_while_closing_is_ended() -> None:
    station = Station()
    await station.open(port=0)
    connecting = asyncio.create_task(asyncio.open_connection(station.host, station.port))
    await asyncio.sleep(0)
    await station.close()
    try:
        peer = Peer(*await connecting)
    except ConnectionError:
        return
    assert await peer.is_closed()
    peer.writer.close()
    await _all([peer.writer.wait_closed()])


async def test_a_taken_tcp_port_is_an_os_error() -> None:
    async with running() as station:
        second = Station()
        with pytest.raises(OSError, match="in use"):
            await second.open(station.host, station.port)
        await second.close()


async def test_a_listener_can_open_again_and_close_twice() -> None:
    station = Station()
    for _ in range(2):
        await station.open(port=0)
        async with peers(station) as (peer,):
            await peer.ask(request())
        await station.close()
        await station.close()
