"""A TCP connection with a peer: what asyncio tells, handed on."""

import asyncio
import contextlib
import socket
from typing import Any, cast

from achse.transport.connections.peer import Peer

_KEEPALIVE = {"TCP_KEEPIDLE": 30, "TCP_KEEPINTVL": 10, "TCP_KEEPCNT": 3}
"""Seconds of silence before a peer is asked whether it is still there, and between such questions;
how many may stay unanswered. A peer that vanished without a word is gone after a minute."""


class TcpConnection(asyncio.Protocol):
    """The line of `peer` is a transport of asyncio: TCP, or TLS over it."""

    def __init__(self, peer: Peer) -> None:
        self.peer = peer
        # Bound, not called: there is one call less on the way of each request.
        self.data_received = peer.receive  # type: ignore[method-assign]

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        line = cast(asyncio.Transport, transport)
        line.set_write_buffer_limits(high=0)  # so that each change is told
        self.peer.socket = line.get_extra_info("socket")
        _keep_alive(self.peer.socket)
        name: Any = line.get_extra_info("peername")
        self.peer.begin(line, *(name[:2] if name else ()), counts=True)

    def pause_writing(self) -> None:
        self.peer.count()

    def resume_writing(self) -> None:
        self.peer.count()

    def eof_received(self) -> None:
        self.peer.close()

    def connection_lost(self, exc: Exception | None) -> None:
        self.peer.ended()


def _keep_alive(connected: socket.socket | None) -> None:
    if connected is None:
        return
    with contextlib.suppress(OSError):  # the peer may be gone already
        connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in _KEEPALIVE.items():
            if hasattr(socket, name):
                connected.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
