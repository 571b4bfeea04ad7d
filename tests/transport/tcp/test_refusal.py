"""Refused connections over real loopback sockets: what they are told, and what they cost."""

import asyncio
import contextlib
import socket
import sys
from collections.abc import AsyncIterator
from typing import Any, cast

import pytest

from achse.ams import (
    AmsAddress,
    Command,
    Connection,
    Flags,
    Frame,
    NetId,
    TcpCommand,
    TcpMessage,
)
from achse.router import Router
from achse.transport.tcp import refusal
from achse.transport.tcp.listener import TcpListener
from achse.transport.tcp.refusal import RefusedConnections

PLC = AmsAddress("5.1.2.3.1.1:851")
CLIENT = AmsAddress("127.0.0.1.1.1:30000")
Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


class _Arrival(asyncio.Protocol):
    """A connection before it is refused."""

    def __init__(self, listener: "Full") -> None:
        self._listener = listener

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._listener.refusals.add(cast(asyncio.Transport, transport), asyncio.get_running_loop())
        self._listener.arrived.put_nowait(None)


class Full:
    """A listener that refuses everybody."""

    def __init__(self) -> None:
        self.refusals = RefusedConnections()
        self.arrived: asyncio.Queue[None] = asyncio.Queue()
        self.address: tuple[str, int] = ("", 0)
        self._open: list[asyncio.StreamWriter] = []

    async def dial(self) -> Streams:
        """A connection of a client, which is refused by now."""
        reader, writer = await asyncio.open_connection(*self.address)
        self._open.append(writer)
        await self.arrived.get()
        return reader, writer

    def hang_up(self) -> None:
        for writer in self._open:
            writer.transport.abort()


@contextlib.asynccontextmanager
async def full() -> AsyncIterator[Full]:
    listener = Full()
    server = await asyncio.get_running_loop().create_server(
        lambda: _Arrival(listener), "127.0.0.1", 0
    )
    listener.address = server.sockets[0].getsockname()
    async with server:
        yield listener
        listener.hang_up()
        listener.refusals.close()


def request(flags: int = 4, command: int = Command.READ, data: bytes = b"") -> Frame:
    return Frame(PLC, CLIENT, command, flags, 0, 7, data)


async def answered(streams: Streams, packet: bytes) -> bytes:
    """Everything that comes back for `packet`, to the end of the connection."""
    reader, writer = streams
    writer.write(packet)
    return await reader.read()


@pytest.mark.parametrize("size", [0, 12, 1_000_000])
async def test_a_request_is_answered_0x508_whatever_its_size(size: int) -> None:
    async with full() as listener:
        answer = await answered(await listener.dial(), request(data=bytes(size)).encode_tcp())
        [frame] = Connection().receive(answer)
        assert frame == request().reply(error=0x508)
        assert len(answer) == 38


async def test_the_head_alone_is_answered_and_so_are_single_bytes() -> None:
    async with full() as listener:
        announced = request(data=bytes(1000)).encode_tcp()[:38]
        assert len(await answered(await listener.dial(), announced)) == 38
        reader, writer = await listener.dial()
        for byte in request().encode_tcp():
            writer.write(bytes((byte,)))
            await asyncio.sleep(0)
        assert len(await reader.read()) == 38


@pytest.mark.parametrize(
    "packet",
    [
        request(flags=4 | Flags.NO_RESPONSE).encode_tcp(),
        request().reply().encode_tcp(),
        request(command=Command.NOTIFICATION).encode_tcp(),
        TcpMessage(TcpCommand.PORT_CONNECT, b"\0\0").encode_tcp(),
        b"GET / HTTP/1.0\r\n\r\n",
    ],
)
async def test_what_has_no_answer_ends_without_one(packet: bytes) -> None:
    async with full() as listener:
        assert await answered(await listener.dial(), packet) == b""


async def test_only_the_first_request_is_answered() -> None:
    async with full() as listener:
        assert len(await answered(await listener.dial(), request().encode_tcp() * 100)) == 38


async def test_a_client_that_closes_is_forgotten() -> None:
    async with full() as listener:
        reader, writer = await listener.dial()
        writer.write_eof()
        assert await reader.read() == b""
        assert len(listener.refusals) == 0


@pytest.mark.parametrize("packet", [b"", b"\0\0", request().encode_tcp()])
async def test_a_client_that_stays_is_dropped_after_a_while(
    packet: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(refusal, "_PATIENCE", 0.05)
    async with full() as listener:
        reader, writer = await listener.dial()
        writer.write(packet)
        assert len(listener.refusals) == 1
        with contextlib.suppress(ConnectionError):
            assert len(await reader.read()) in (0, 38)
        while len(listener.refusals):  # noqa: ASYNC110 - sockets tell nobody
            await asyncio.sleep(0)


async def test_of_many_that_stay_the_oldest_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refusal, "_AT_ONCE", 3)
    async with full() as listener:
        dialled = [await listener.dial() for _ in range(6)]
        for reader, _ in dialled[:3]:
            with contextlib.suppress(ConnectionError):
                assert await reader.read() == b""
        assert len(listener.refusals) == 3
        for streams in dialled[3:]:
            assert len(await answered(streams, request().encode_tcp())) == 38


# at the listener ---------------------------------------------------------------------------------


@contextlib.asynccontextmanager
async def listening(**settings: Any) -> AsyncIterator[TcpListener]:
    listener = TcpListener(Router(NetId("5.1.2.3.1.1")), **settings)
    await listener.open(port=0)
    try:
        yield listener
    finally:
        await listener.close()


@contextlib.asynccontextmanager
async def client_of(listener: TcpListener) -> AsyncIterator[Streams]:
    reader, writer = await asyncio.open_connection(listener.host, listener.port)
    try:
        yield reader, writer
    finally:
        writer.transport.abort()
        with contextlib.suppress(ConnectionError):
            await writer.wait_closed()


async def code_of_answer(streams: Streams) -> int:
    """The AMS error of the answer to a request; nobody is at that port."""
    reader, writer = streams
    writer.write(request(data=bytes(12)).encode_tcp())
    [answer] = Connection().receive(await reader.readexactly(38))
    assert isinstance(answer, Frame)
    return answer.error


async def test_beyond_the_limit_requests_are_refused_until_there_is_room_and_it_is_reported_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with listening(max_connections=2) as listener, client_of(listener) as first:
        assert await code_of_answer(first) == 0x6
        async with client_of(listener) as second:
            assert await code_of_answer(second) == 0x6
            for _ in range(2):
                async with client_of(listener) as third:
                    assert await code_of_answer(third) == 0x508
                    assert await third[0].read() == b""
            assert (listener.refused, len(listener.connections)) == (2, 2)
            [message] = [each for each in caplog.messages if "no room" in each]
            assert "refused with 0x508 ROUTER_NO_MORE_QUEUES" in message
            assert message.endswith("[router] max_connections is 2")
        while len(listener.connections) > 1:  # noqa: ASYNC110 - sockets tell nobody
            await asyncio.sleep(0)
        async with client_of(listener) as fourth:
            assert await code_of_answer(fourth) == 0x6
            async with client_of(listener) as fifth:
                assert await code_of_answer(fifth) == 0x508
    assert len([each for each in caplog.messages if "no room" in each]) == 2


async def test_a_listener_without_clients_closes_at_once() -> None:
    async with listening(max_connections=2) as listener:
        listener.accepting = False
        async with client_of(listener) as (reader, _):
            with contextlib.suppress(ConnectionError):
                assert await reader.read() == b""
        assert listener.refused == 1
        listener.accepting = True
        async with client_of(listener) as streams:
            assert await code_of_answer(streams) == 0x6


async def test_what_a_strict_listener_replaces_makes_room() -> None:
    async with (
        listening(max_connections=1, strict=True) as listener,
        client_of(listener) as first,
    ):
        assert await code_of_answer(first) == 0x6
        async with client_of(listener) as second:
            assert await code_of_answer(second) == 0x6
            assert await first[0].read() == b""
        assert listener.refused == 0


def test_many_who_come_at_once_are_let_in() -> None:
    """The server takes none of them meanwhile: they wait in its queue, nobody dials again."""

    async def main() -> None:
        station = TcpListener(Router(NetId("5.1.2.3.1.1")))
        await station.open(port=0)
        callers = []
        try:
            for _ in range(120):  # 128 are the most that an old Linux lets wait
                caller = socket.socket()
                callers.append(caller)
                caller.connect(("127.0.0.1", station.port))
                if sys.platform == "linux":  # who finds the queue full tries again after 1 s
                    facts = caller.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 104)
                    assert int.from_bytes(facts[100:], sys.byteorder) == 0  # tcpi_total_retrans
        finally:
            for caller in callers:
                caller.close()
            await station.close()

    asyncio.run(main())
