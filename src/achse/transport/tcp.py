"""AMS/TCP: the listener that lets clients, servers and other routers in, and their connections.

Source: reference traffic for the port service (0x1000, 0x0001, 0x1002); 000 §3.2.
"""

import asyncio
import ipaddress
import logging
from typing import Any, cast

from achse.ams import (
    AmsAddress,
    Connection,
    DecodeError,
    Frame,
    RouterError,
    TcpCommand,
    TcpMessage,
)
from achse.ams.connection import DEFAULT_MAX_LENGTH
from achse.router import Router

__all__ = ["TCP_PORT", "TcpListener"]

log = logging.getLogger("achse.tcp")

TCP_PORT = 48898
"""0xBF02, where AMS routers listen (000 §3)."""

_LEARNED_PER_CONNECTION = 1024
"""More source addresses than this on one connection are no client; the oldest is forgotten."""


class TcpConnection(asyncio.Protocol):
    """One accepted connection: bytes to frames to the router, and back.

    Frames for the peer are gathered and written once per turn of the loop. A peer that does not
    read is cut off when more than `max_backlog` bytes wait for it.
    """

    def __init__(self, listener: "TcpListener") -> None:
        self._listener = listener
        self._router = listener.router
        self._stream = Connection(listener.max_length)
        self._sources: dict[bytes, None] = {}
        self._last_source = b""
        self._registered: list[AmsAddress] = []
        self._out: list[bytes] = []
        self._flush_due = False
        self._receiving = False
        self._transport: asyncio.Transport | None = None
        self.peer = "?"
        self.peer_host = ""

    # asyncio ---------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        name: Any = transport.get_extra_info("peername")
        if name:
            self.peer_host = name[0]
            self.peer = f"{name[0]}:{name[1]}"
        self._listener.opened(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self._transport = None
        for source in self._sources:
            self._router.forget(source, self)
        self._sources.clear()
        for address in self._registered:
            self._router.unregister(address.port)
        self._registered.clear()
        self._listener.closed(self)

    def data_received(self, data: bytes) -> None:
        router = self._router
        self._receiving = True
        try:
            for event in self._stream.receive(data):
                if self._transport is None:
                    break
                if isinstance(event, Frame):
                    event.origin = self
                    if event.source != self._last_source:
                        self._learn(event.source)
                    router.deliver(event)
                else:
                    self._serve(event)
        except DecodeError as failure:
            log.warning("closing %s: %s", self.peer, failure)
            self.close()
        finally:
            self._receiving = False
            self._flush()

    def _learn(self, source: bytes) -> None:
        self._last_source = source
        self._sources[source] = None
        self._router.learn(source, self)
        if len(self._sources) > _LEARNED_PER_CONNECTION:
            oldest = next(iter(self._sources))
            del self._sources[oldest]
            self._router.forget(oldest, self)

    # the port service of a local router --------------------------------------------------------

    def _serve(self, message: TcpMessage) -> None:
        if not (self._listener.external_registration or _is_loopback(self.peer_host)):
            log.warning("%s is not on this host: port service refused", self.peer)
            self.close()
        elif message.command is TcpCommand.PORT_CONNECT and len(message.data) == 2:
            self._register(int.from_bytes(message.data, "little"))
        elif message.command is TcpCommand.PORT_CLOSE and len(message.data) == 2:
            self._unregister(int.from_bytes(message.data, "little"))
        elif message.command is TcpCommand.GET_LOCAL_NET_ID:
            self._send(TcpMessage(TcpCommand.GET_LOCAL_NET_ID, bytes(self._router.net_id)))
        elif message.command is not TcpCommand.ROUTER_NOTE:
            log.warning(
                "closing %s: %s with %d bytes of data is no port service",
                self.peer,
                message.command.name,
                len(message.data),
            )
            self.close()

    def _register(self, port: int) -> None:
        try:
            address = self._router.register(port, self)
        except RouterError as refusal:
            log.warning("closing %s: %s", self.peer, refusal)
            self.close()
            return
        self._registered.append(address)
        self._send(TcpMessage(TcpCommand.PORT_CONNECT, bytes(address)))

    def _unregister(self, port: int) -> None:
        for address in self._registered:
            if address.port == port:
                self._registered.remove(address)
                self._router.unregister(port)
                return

    # out ---------------------------------------------------------------------------------------

    def deliver(self, frame: Frame) -> bool:
        """Send `frame` to the peer; False if the connection is gone."""
        if self._transport is None:
            return False
        self._out.append(frame.encode_tcp())
        if not (self._receiving or self._flush_due):
            self._flush_due = True
            self._listener.loop.call_soon(self._flush)
        return True

    def _send(self, message: TcpMessage) -> None:
        self._out.append(message.encode_tcp())

    def _flush(self) -> None:
        self._flush_due = False
        if not self._out:
            return
        out, self._out = self._out, []
        transport = self._transport
        if transport is None:
            return
        transport.write(b"".join(out) if len(out) > 1 else out[0])
        if transport.get_write_buffer_size() > self._listener.max_backlog:
            log.warning("cutting off %s: it does not read what it asked for", self.peer)
            self.abort()

    def abort(self) -> None:
        """Close at once; what waits for the peer is lost."""
        if self._transport is not None:
            self._transport.abort()
            self._transport = None

    def close(self) -> None:
        """Send what is due and close."""
        if self._transport is not None:
            self._flush()
            self._transport.close()


class TcpListener:
    """Accepts AMS/TCP connections for a router.

    - `strict`: one connection per remote host as the original does; a second one closes the
      first. Off by default: any number.
    - `external_registration`: serve the local port service to other hosts as well.
    - `max_length`: longest packet taken, bytes.
    - `max_backlog`: bytes that may wait for a peer that does not read.
    - `max_connections`: further ones are closed at once.
    """

    def __init__(
        self,
        router: Router,
        *,
        strict: bool = False,
        external_registration: bool = False,
        max_length: int = DEFAULT_MAX_LENGTH,
        max_backlog: int = 64 * 1024 * 1024,
        max_connections: int = 4096,
    ) -> None:
        self.router = router
        self.strict = strict
        self.external_registration = external_registration
        self.max_length = max_length
        self.max_backlog = max_backlog
        self.max_connections = max_connections
        self.host = ""
        self.port = 0
        self.connections: set[TcpConnection] = set()
        self.loop: asyncio.AbstractEventLoop
        self._server: asyncio.Server | None = None

    async def open(self, host: str = "127.0.0.1", port: int = TCP_PORT) -> None:
        """Listen on `host`:`port`; 0 takes a free one, see `self.port`. OSError if it is taken."""
        self.loop = asyncio.get_running_loop()
        self._server = await self.loop.create_server(lambda: TcpConnection(self), host, port)
        self.host, self.port = self._server.sockets[0].getsockname()[:2]

    async def close(self) -> None:
        """Stop listening and close every connection."""
        if self._server is not None:
            self._server.close()
            for connection in list(self.connections):
                connection.close()
            await asyncio.sleep(0)
            for connection in list(self.connections):
                connection.abort()
            await self._server.wait_closed()
            self._server = None

    def opened(self, connection: TcpConnection) -> None:
        """A connection came up: apply the limit and the one-per-host rule."""
        if len(self.connections) >= self.max_connections:
            log.warning(
                "closing %s: %d connections are open", connection.peer, len(self.connections)
            )
            connection.close()
            return
        if self.strict:
            for other in [c for c in self.connections if c.peer_host == connection.peer_host]:
                log.warning("closing %s: %s replaces it", other.peer, connection.peer)
                other.close()
        self.connections.add(connection)

    def closed(self, connection: TcpConnection) -> None:
        """A connection went down."""
        self.connections.discard(connection)


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host.partition("%")[0]).is_loopback
    except ValueError:
        return False
