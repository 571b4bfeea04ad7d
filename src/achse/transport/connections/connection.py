"""TCP connection with a peer: passes events of asyncio on to it."""

import asyncio
import contextlib
import socket
from typing import Any, cast

from achse.transport.connections.peer import Peer

_KEEPALIVE = {"TCP_KEEPIDLE": 30, "TCP_KEEPINTVL": 10, "TCP_KEEPCNT": 3}
"""Seconds of silence before a TCP keep-alive probe, and between probes; number of probes without an
answer. A peer that vanished without notice is disconnected after a minute."""


class TcpConnection(asyncio.Protocol):
    """Protocol of asyncio whose transport, TCP or TLS over it, is that of `peer`."""

    def __init__(self, peer: Peer) -> None:
        self.peer = peer
        # Bound, not called: there is one call less on the way of each request.
        self.data_received = peer.receive  # type: ignore[method-assign]

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        byte_transport = cast(asyncio.Transport, transport)
        byte_transport.set_write_buffer_limits(high=0)  # so that each change is reported
        self.peer.socket = byte_transport.get_extra_info("socket")
        _keep_alive(self.peer.socket)
        name: Any = byte_transport.get_extra_info("peername")
        self.peer.begin(byte_transport, *(name[:2] if name else ()), counts=True)

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
