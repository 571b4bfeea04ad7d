"""AMS/TCP: the listener that lets clients, servers and other routers in, and their connections.

Source: reference traffic for the port service (0x1000, 0x0001, 0x1002); 000 §3.2.
"""

import asyncio
import contextlib
import ipaddress
import logging
import socket
from collections import deque
from collections.abc import Iterable
from typing import Any, Protocol, cast

from achse.ams import (
    AmsAddress,
    Command,
    Connection,
    DecodeError,
    Endpoint,
    Flags,
    Frame,
    RouterError,
    TcpCommand,
    TcpMessage,
)
from achse.ams.connection import DEFAULT_MAX_LENGTH
from achse.codes import ReturnCode
from achse.router import Router
from achse.router.routes import Admission
from achse.transport.exchanges import Exchanges
from achse.transport.refusal import NO_ROOM, Refusals

__all__ = ["DEFAULT_MAX_HELD", "TCP_PORT", "ConnectionOwner", "TcpConnection", "TcpListener"]

log = logging.getLogger("achse.tcp")

TCP_PORT = 48898
"""0xBF02, where AMS routers listen (000 §3)."""

_LEARNED_PER_CONNECTION = 1024
"""More source addresses than this on one connection are no client; the oldest is forgotten."""

_AGAIN_NS = 10_000_000_000
"""Circles of routes are told again after this time."""

_CONGESTED = 1024 * 1024
"""Bytes waiting for a peer at which devices keep notifications back."""

DEFAULT_MAX_HELD = 256 * 1024 * 1024
"""Bytes; four times the longest packet."""

_FLUSH_SIZE = 256 * 1024
"""Answers are written once per turn of the loop, or when this many bytes have gathered."""

_HOLD = 0.01
"""Seconds that notifications wait behind the answer to an Add: pyads and others drop a sample that
comes before they have noted its handle."""

_KEEPALIVE = {"TCP_KEEPIDLE": 30, "TCP_KEEPINTVL": 10, "TCP_KEEPCNT": 3}
"""Seconds of silence before a peer is asked whether it is still there, and between such questions;
how many may stay unanswered. A peer that vanished without a word is gone after a minute."""

_LINGER = 5.0
"""Seconds a closed connection has to take the rest of what was sent to it."""


class ConnectionOwner(Protocol):
    """Who accepted or dialled a connection, and its limits."""

    router: Router
    loop: asyncio.AbstractEventLoop
    max_length: int
    max_backlog: int
    routes_required: bool

    def serves_ports(self, host: str) -> bool:
        """Whether a peer at `host` may register ports here."""
        ...

    def opened(self, connection: "TcpConnection") -> None: ...

    def closed(self, connection: "TcpConnection") -> None: ...

    def grown(self) -> None:
        """A connection holds a lot of bytes: time to look at all of them."""
        ...


class TcpConnection(asyncio.Protocol):
    """One connection: bytes to frames to the router, and back.

    Frames for the peer are gathered and written once per turn of the loop. A peer that does not
    read is cut off when more than `max_backlog` bytes wait for it.
    """

    def __init__(self, owner: ConnectionOwner) -> None:
        self.owner = owner
        self._router = owner.router
        self._stream = Connection(owner.max_length)
        self._sources: dict[bytes, None] = {}
        self._last_source = b""
        self._refused: set[bytes] = set()
        self._exchanges = Exchanges()
        self._circles_told = -_AGAIN_NS
        self._out: list[bytes] = []
        self._out_size = 0
        self._held: deque[tuple[float, bytes]] = deque()
        self._hold_until = 0.0
        self._flush_due = False
        self._receiving = False
        self.cut_off = False
        """True once the peer was closed because it took too much room."""
        self._open = False
        self._transport: asyncio.Transport | None = None
        self.registered: list[AmsAddress] = []
        """Local ports that the peer holds."""
        self.peer = "?"
        self.peer_host = ""

    # asyncio ---------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        self._open = True
        _keep_alive(transport.get_extra_info("socket"))
        name: Any = transport.get_extra_info("peername")
        if name:
            self.peer_host = name[0]
            self.peer = f"{name[0]}:{name[1]}"
        self.owner.opened(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self._transport = None
        self._leave()
        self.owner.closed(self)

    def eof_received(self) -> None:
        self.close()

    def data_received(self, data: bytes) -> None:
        if not self._open:
            return
        router = self._router
        self._receiving = True
        try:
            for event in self._stream.receive(data):
                if isinstance(event, Frame):
                    event.origin = self
                    if event.source != self._last_source and not self._learn(event.source):
                        break
                    if self._refused and self._refuse(event):
                        continue
                    if event.is_response:
                        event.via = self._exchanges.take(event)
                    elif event.command == Command.NOTIFICATION:
                        event.via = self._exchanges.answered(event)
                    try:
                        router.deliver(event)
                    except Exception:  # a fault of one frame is not one of its connection
                        self._apologize(event)
                else:
                    self._serve(event)
                if not self._open:
                    break
        except DecodeError as failure:
            self._turn_out("%s", failure)
        finally:
            self._receiving = False
            self._flush()
        if self._stream.pending > _CONGESTED:
            self.owner.grown()

    def _apologize(self, frame: Frame) -> None:
        """Something in here broke over this frame: tell the log and whoever asked."""
        log.exception(
            "a frame of %s to %s could not be delivered",
            *(AmsAddress(frame.source), AmsAddress(frame.target)),
            extra=frame.sender,
        )
        backwards = frame.is_response or frame.command == Command.NOTIFICATION
        if not backwards and not frame.flags & Flags.NO_RESPONSE:
            self.deliver(frame.reply(error=ReturnCode.INTERNAL_ERROR.number))

    def _leave(self) -> None:
        """From here on the peer is unreachable and holds nothing."""
        was_open = self._open
        self._open = False
        self._out.clear()
        self._out_size = 0
        self._exchanges.clear()
        for source in self._sources:
            self._router.forget(source, self)
        self._sources.clear()
        while self.registered:
            self._router.unregister(self.registered.pop().port)
        if was_open:
            self._router.close_way(self)

    @property
    def sources(self) -> Iterable[bytes]:
        """The AMS addresses that the peer sent from."""
        return self._sources

    # addresses -------------------------------------------------------------------------------

    def _learn(self, source: bytes) -> bool:
        """Note where `source` is; False if it may not come here and the connection ends."""
        router = self._router
        self._last_source = source
        ours = router.is_local(source[:6]) and self.owner.serves_ports(self.peer_host)
        if source not in self._sources and not ours:
            admission = router.routes.admission(source[:6], self.peer_host)
            if admission is Admission.ONE_WAY:
                self._refused.add(source)
            elif admission is Admission.UNKNOWN and self.owner.routes_required:
                client = AmsAddress(source).net_id
                self._turn_out(
                    "client %s from %s has no route here; add it with"
                    " `achse ads route add` or a [[route]] in the station's configuration:"
                    ' net_id = "%s", host = "%s"',
                    *(client, self.peer_host, client, self.peer_host),
                )
                return False
        self._sources[source] = None
        self._router.learn(source, self)
        if len(self._sources) > _LEARNED_PER_CONNECTION:
            oldest = next(iter(self._sources))
            del self._sources[oldest]
            self._refused.discard(oldest)
            self._router.forget(oldest, self)
        return True

    def _refuse(self, frame: Frame) -> bool:
        """Refuse a request from the far end of a one-way route."""
        backwards = frame.is_response or frame.command == Command.NOTIFICATION
        if backwards or frame.source not in self._refused:
            return False
        if not frame.flags & Flags.NO_RESPONSE:
            self.deliver(frame.reply(error=ReturnCode.DEVICE_ACCESS_DENIED.number))
        return True

    def _note(self, asker: Endpoint, request: Frame) -> ReturnCode | None:
        """Remember who asks the far end; what refuses the request, None if it may go.

        One for a port of ours cannot circle: the server behind this connection registered it.
        """
        circles = not self._router.is_local(request.target[:6])
        now = int(self.owner.loop.time() * 1e9)
        refusal = self._exchanges.ask(asker, request, now, circles=circles)
        if refusal is ReturnCode.TARGET_MACHINE_NOT_FOUND and now >= self._circles_told + _AGAIN_NS:
            self._circles_told = now
            log.warning(
                "requests of %s to %s go in circles by way of %s: look at the routes",
                *(AmsAddress(request.source), AmsAddress(request.target), self.peer),
                extra=request.sender,
            )
        return refusal

    # the port service of a local router --------------------------------------------------------

    def _serve(self, message: TcpMessage) -> None:
        if not self.owner.serves_ports(self.peer_host):
            self._turn_out("it is not on this host, port service refused")
        elif message.command is TcpCommand.PORT_CONNECT and len(message.data) == 2:
            self._register(int.from_bytes(message.data, "little"))
        elif message.command is TcpCommand.PORT_CLOSE and len(message.data) == 2:
            self._unregister(int.from_bytes(message.data, "little"))
        elif message.command is TcpCommand.GET_LOCAL_NET_ID:
            self._send(TcpMessage(TcpCommand.GET_LOCAL_NET_ID, bytes(self._router.net_id)))
        elif message.command is not TcpCommand.ROUTER_NOTE:
            self._turn_out(
                "%s with %d bytes of data is no port service",
                *(message.command.name, len(message.data)),
            )

    def _register(self, port: int) -> None:
        try:
            address = self._router.register(port, self)
        except RouterError as refusal:
            self._turn_out("%s", refusal)
            return
        self.registered.append(address)
        self._send(TcpMessage(TcpCommand.PORT_CONNECT, bytes(address)))

    def _unregister(self, port: int) -> None:
        """Free a port of this peer. With the last one gone its connection ends: clients wait."""
        address = AmsAddress.of(self._router.net_id, port)
        if address in self.registered:
            self.registered.remove(address)
            self._router.unregister(port)
            if not self.registered:
                self.close()

    # out ---------------------------------------------------------------------------------------

    def deliver(self, frame: Frame) -> bool:
        """Send `frame` to the peer; False if the connection is gone.

        A request for a peer that leaves too much unread is answered with 0x502 instead.
        """
        if not self._open:
            return False
        asker = frame.origin
        if asker and not (frame.is_response or frame.command == Command.NOTIFICATION):
            quiet = frame.flags & Flags.NO_RESPONSE
            refusal = ReturnCode.ROUTER_MAILBOX_FULL if self.congested and not quiet else None
            refusal = refusal or self._note(asker, frame)
            if refusal is ReturnCode.ROUTER_MAILBOX_FULL and not quiet:
                self._router.deliver(frame.reply(error=refusal.number))
                return True
            if refusal is not None:
                return False
        packet = frame.encode_tcp()
        if frame.command == Command.ADD_NOTIFICATION and frame.is_response:
            self._hold_until = self.owner.loop.time() + _HOLD
        elif frame.command == Command.NOTIFICATION and self._hold(packet):
            return True
        self._put(packet)
        return True

    def break_off(self, frame: Frame) -> None:
        """Send the first half of `frame`, then end the connection: a cable pulled in between."""
        packet = frame.encode_tcp()
        self._out.append(packet[: len(packet) // 2])
        self.close()

    def _put(self, packet: bytes) -> None:
        self._out.append(packet)
        self._out_size += len(packet)
        if self._out_size > _FLUSH_SIZE:
            self._flush()
        elif not (self._receiving or self._flush_due):
            self._flush_due = True
            self.owner.loop.call_soon(self._flush)

    def _hold(self, packet: bytes) -> bool:
        """Keep a notification back if an Add was answered a moment ago, or others are kept."""
        loop = self.owner.loop
        if not self._held:
            if loop.time() >= self._hold_until:
                return False
            loop.call_at(self._hold_until, self._release)
        self._held.append((self._hold_until, packet))
        return True

    def _release(self) -> None:
        """Send the notifications that have waited long enough, in order."""
        held, loop = self._held, self.owner.loop
        if not (held and self._open):
            return
        due = max(loop.time(), held[0][0])  # timers may be early by their resolution
        while held and held[0][0] <= due:
            self._put(held.popleft()[1])
        if held:
            loop.call_at(held[0][0], self._release)

    @property
    def congested(self) -> bool:
        """True while the peer leaves so much unread that notifications had better wait."""
        transport = self._transport
        return transport is not None and transport.get_write_buffer_size() > _CONGESTED

    @property
    def backlog(self) -> int:
        """Bytes that the peer has not taken yet."""
        transport = self._transport
        return self._out_size + (0 if transport is None else transport.get_write_buffer_size())

    @property
    def held(self) -> int:
        """Bytes kept for the peer: those it has not taken, and packets that lack their end."""
        return self.backlog + self._stream.pending if self._open else 0

    def cut(self, reason: str, *details: object) -> None:
        """Close at once because the peer takes too much room."""
        self.warn(reason, *details)
        self.cut_off = True
        self.abort()

    def _send(self, message: TcpMessage) -> None:
        self._out.append(message.encode_tcp())

    def _flush(self) -> None:
        self._flush_due = False
        out, transport = self._out, self._transport
        if not out or transport is None:
            return
        self._out = []
        self._out_size = 0
        transport.write(b"".join(out) if len(out) > 1 else out[0])
        unread = transport.get_write_buffer_size()
        if unread > self.owner.max_backlog:
            self.cut("it does not read what it asked for")
        elif unread > _CONGESTED:
            self.owner.grown()

    @property
    def client(self) -> str:
        """The AMS address that the peer last sent from, or else registered; "" if neither."""
        address = self._last_source or next(iter(self.registered), b"")
        return str(AmsAddress(address)) if address else ""

    def warn(self, reason: str, *details: object) -> None:
        """Log why the connection ends, and whose it is."""
        client = self.client
        whom = f"{self.peer}, client {client}" if client else self.peer
        facts = {"client": client, "peer": self.peer}
        log.warning("closing %s: " + reason, whom, *details, extra=facts)

    def _turn_out(self, reason: str, *details: object) -> None:
        self.warn(reason, *details)
        self.close()

    def give_up(self) -> asyncio.Transport:
        """The transport, for somebody else to use: nothing more comes or goes here."""
        transport, self._transport = self._transport, None
        assert transport is not None
        self._leave()
        return transport

    def abort(self) -> None:
        """Close at once; what waits for the peer is lost."""
        self._leave()
        if self._transport is not None:
            self._transport.abort()

    def close(self) -> None:
        """Send what is due and close; a peer that does not take it in time is cut off."""
        self._flush()
        if self._open and self._transport is not None:
            self._leave()
            self._transport.close()
            if self._transport.get_write_buffer_size():
                self.owner.loop.call_later(_LINGER, self.abort)


class TcpListener:
    """Accepts AMS/TCP connections for a router.

    - `strict`: one connection per remote host as the original does; a second one closes the
      first, unless that holds a registered port. Off by default: any number.
    - `routes_required`: a sender needs a route in the router's table, other connections are closed.
    - `external_registration`: serve the local port service to other hosts as well.
    - `max_length`: longest packet taken, bytes.
    - `max_backlog`: bytes that may wait for a peer that does not read.
    - `max_held`: bytes that may wait on all connections together, packets that lack their end
      included; beyond, the connection with the most of them is closed.
    - `max_connections`: the first request on a further one is answered with 0x508, then it is
      closed.
    """

    def __init__(
        self,
        router: Router,
        *,
        strict: bool = False,
        routes_required: bool = False,
        external_registration: bool = False,
        max_length: int = DEFAULT_MAX_LENGTH,
        max_backlog: int = 64 * 1024 * 1024,
        max_held: int = DEFAULT_MAX_HELD,
        max_connections: int = 4096,
    ) -> None:
        self.router = router
        self.strict = strict
        self.routes_required = routes_required
        self.external_registration = external_registration
        self.max_length = max_length
        self.max_backlog = max_backlog
        self.max_held = max_held
        self.max_connections = max_connections
        self.accepting = True
        """False: every new connection is closed at once."""
        self.refused = 0
        """Connections that were not taken: `max_connections` were open, or none was wanted."""
        self.cut_off = 0
        """Connections closed because their peer did not read, or left packets unfinished."""
        self.host = ""
        self.port = 0
        self.connections: set[TcpConnection] = set()
        self.loop: asyncio.AbstractEventLoop
        self._server: asyncio.Server | None = None
        self._refusals = Refusals()
        self._full = False
        """True from the first refusal until a tenth of the connections is free again."""
        self._last_closed = asyncio.Event()

    async def open(self, host: str = "127.0.0.1", port: int = TCP_PORT) -> None:
        """Listen on `host`:`port`; 0 takes a free one, see `self.port`. OSError if it is taken."""
        self.loop = asyncio.get_running_loop()
        self._server = await self.loop.create_server(
            lambda: TcpConnection(self), host, port, start_serving=False
        )
        self.host, self.port = self._server.sockets[0].getsockname()[:2]
        await self._server.start_serving()

    async def close(self) -> None:
        """Stop listening and close every connection; a peer that does not read gets no time."""
        server, self._server = self._server, None
        if server is None:
            return
        server.close()
        self._refusals.close()
        for connection in list(self.connections):
            connection.close()
        await asyncio.sleep(0)
        for connection in list(self.connections):
            connection.abort()
        self._last_closed.clear()
        if self.connections:
            await self._last_closed.wait()
        await server.wait_closed()

    def serves_ports(self, host: str) -> bool:
        """Peers on this host may register ports, others if that is allowed."""
        return self.external_registration or _is_loopback(host)

    def opened(self, connection: TcpConnection) -> None:
        """A connection came up: apply the limit and the one-per-host rule."""
        if self._server is None:
            connection.abort()
            return
        replaced = [
            other
            for other in self.connections
            if self.strict and other.peer_host == connection.peer_host and not other.registered
        ]
        full = len(self.connections) - len(replaced) >= self.max_connections
        if full or not self.accepting:
            self._refuse(connection)
            return
        for other in replaced:
            other.warn("%s replaces it", connection.peer)
            other.close()
        self.connections.add(connection)

    def _refuse(self, connection: TcpConnection) -> None:
        """Turn a connection away; the log is told once, until there is room again."""
        self.refused += 1
        if not self.accepting:
            connection.warn("no connections are taken now")
            connection.abort()
            return
        if not self._full:
            self._full = True
            log.warning(
                "no room for %s: refused with 0x%X %s, as whoever comes until some have left;"
                " [router] max_connections is %d",
                *(connection.peer, NO_ROOM.number, NO_ROOM.name, self.max_connections),
                extra={"client": "", "peer": connection.peer},
            )
        self._refusals.add(connection.give_up(), self.loop)

    def closed(self, connection: TcpConnection) -> None:
        """A connection went down."""
        self.connections.discard(connection)
        self._full = self._full and len(self.connections) > 0.9 * self.max_connections
        self.cut_off += connection.cut_off
        if not self.connections:
            self._last_closed.set()

    def grown(self) -> None:
        """Cut off connections, the largest first, until the rest hold no more than `max_held`."""
        held = {connection: connection.held for connection in self.connections}
        total = sum(held.values())
        while total > self.max_held:
            largest = max(held, key=held.__getitem__)
            total -= held.pop(largest)
            largest.cut("all connections together hold too much, and it the most")


def _keep_alive(connected: socket.socket | None) -> None:
    if connected is None:
        return
    with contextlib.suppress(OSError):  # the peer may be gone already
        connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in _KEEPALIVE.items():
            if hasattr(socket, name):
                connected.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host.partition("%")[0]).is_loopback
    except ValueError:
        return False
