"""What asyncio tells is handed on to the peer."""

import asyncio
import socket
from typing import Any

import pytest

from achse.transport.connections.connection import TcpConnection


class Peer:
    """Notes what it is told."""

    def __init__(self) -> None:
        self.calls: list[Any] = []

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **settings: self.calls.append(
            (name, *arguments, *settings.items())
        )


class Transport(asyncio.Transport):
    limits: Any = None

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        self.limits = (high, low)


@pytest.mark.parametrize(
    ("name", "where"),
    [(("10.0.0.7", 5000), ("10.0.0.7", 5000)), (("fe80::1", 7, 0, 2), ("fe80::1", 7)), (None, ())],
)
def test_each_event_reaches_the_peer(name: Any, where: tuple[Any, ...]) -> None:
    peer: Any = Peer()
    connection = TcpConnection(peer)
    transport = Transport({"peername": name})
    connection.connection_made(transport)
    assert transport.limits == (0, None)
    connection.data_received(b"bytes")
    connection.pause_writing()
    connection.resume_writing()
    connection.eof_received()
    connection.connection_lost(None)
    assert peer.calls == [
        ("begin", transport, *where, ("counts", True)),
        ("receive", b"bytes"),
        ("count",),
        ("count",),
        ("close",),
        ("ended",),
    ]


def test_a_peer_that_vanishes_is_looked_for() -> None:
    with socket.socket() as connected:
        peer: Any = Peer()
        TcpConnection(peer).connection_made(Transport({"socket": connected}))
        assert connected.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE) == 1
