"""Two connections and the wire between them."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from achse.ams import AmsAddress, Frame, TcpCommand, TcpMessage
from achse.testing import LinkedPair, LinkEnd, check_transport

FRAME = Frame(AmsAddress("5.0.0.1.1.1:851"), AmsAddress("5.0.0.2.1.1:30000"), 2, data=b"1234567890")
MESSAGE = TcpMessage(TcpCommand.PORT_CONNECT, b"\0\0")


def test_nothing_arrives_before_it_flows() -> None:
    pair = LinkedPair()
    pair.left.send(FRAME, MESSAGE)
    assert pair.right.received == []
    pair.flow()
    assert pair.right.received == [FRAME, MESSAGE]
    assert pair.right.frames == [FRAME]


def test_a_limit_stops_in_the_middle_of_a_frame() -> None:
    pair = LinkedPair()
    pair.left.send(FRAME)
    pair.flow(limit=47)
    assert pair.right.frames == []
    pair.flow(limit=1)
    assert pair.right.frames == [FRAME]


def test_a_cut_loses_what_is_on_the_wire() -> None:
    pair = LinkedPair()
    pair.right.send(FRAME)
    pair.cut()
    pair.flow()
    assert pair.left.frames == []
    assert not pair.left.deliver(FRAME)
    with pytest.raises(ConnectionResetError, match="cut"):
        pair.left.send(FRAME)


def test_bytes_that_are_no_ams_end_an_end() -> None:
    pair = LinkedPair()
    pair.left.send(b"GET / HTTP/1.1\r\n")
    pair.flow()
    pair.left.send(FRAME)
    pair.flow()
    assert pair.right.failure is not None
    assert pair.right.frames == []


@pytest.mark.parametrize("chunk", [0, 1000, 1461])
def test_it_keeps_what_a_transport_has_to_keep(chunk: int) -> None:
    pair = LinkedPair(chunk)

    @asynccontextmanager
    async def open() -> AsyncIterator[tuple[LinkEnd, LinkEnd]]:
        yield pair.left, pair.right

    asyncio.run(check_transport(open, pair.flow))
