"""One AMS/TCP connection: bytes to frames to the router, and back.

Source: reference traffic for the port service (0x1000, 0x0001, 0x1002); 000 §3.2.
"""

import asyncio
import contextlib
import logging
import socket
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
from achse.codes import ReturnCode
from achse.router import Router
from achse.router.routes import Admission
from achse.transport.exchanges import Exchanges
from achse.transport.held import Held
from achse.transport.outbox import Outbox

__all__ = ["ConnectionOwner", "TcpConnection"]

log = logging.getLogger("achse.tcp")

_LEARNED_PER_CONNECTION = 1024
"""More source addresses than this on one connection are no client; the oldest is forgotten."""

_AGAIN_NS = 10_000_000_000
"""Circles of routes are told again after this time."""

_CONGESTED = 1024 * 1024
"""Bytes waiting for a peer at which devices keep notifications back."""

_FLUSH_SIZE = 256 * 1024
"""Answers are written once per turn of the loop, or when this many bytes have gathered."""

_SMALL = 4096
"""Gathered bytes below this are not counted until they are written, with the same turn."""

_PORTS_PER_CONNECTION = 256
"""Local ports of one peer; the programs of a computer share a connection at times."""

_PORTS_LEFT = 8192
"""So many client ports are only for peers that have none: they last for every connection."""

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
    held: Held

    def serves_ports(self, host: str) -> bool:
        """Whether a peer at `host` may register ports here."""
        ...

    def opened(self, connection: "TcpConnection") -> None: ...

    def closed(self, connection: "TcpConnection") -> None: ...


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
        self._out = Outbox()
        self._counted = 0
        """Bytes that `owner.held` counts for this peer."""
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
        self._transport.set_write_buffer_limits(high=0)  # so that each change is told
        self._open = True
        _keep_alive(transport.get_extra_info("socket"))
        name: Any = transport.get_extra_info("peername")
        if name:
            self.peer_host = name[0]
            self.peer = f"{name[0]}:{name[1]}"
        self.owner.opened(self)

    def pause_writing(self) -> None:
        self._count()

    def resume_writing(self) -> None:
        self._count()

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
            if self._stream.pending or self._counted:
                self._count()

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
        self._stream.drop()
        self._exchanges.clear()
        for source in self._sources:
            self._router.forget(source, self)
        self._sources.clear()
        while self.registered:
            self._router.unregister(self.registered.pop().port)
        self._count()
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
        held = len(self.registered)
        if held and (held >= _PORTS_PER_CONNECTION or self._router.free_ports <= _PORTS_LEFT):
            self._turn_out("it holds %d ports, further ones are for others", held)
            return
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
            self._out.added(self.owner.loop.time())
        elif frame.command == Command.NOTIFICATION and self._hold(packet):
            return True
        self._put(packet)
        return True

    def break_off(self, frame: Frame) -> None:
        """Send the first half of `frame`, then end the connection: a cable pulled in between."""
        packet = frame.encode_tcp()
        self._out.put(packet[: len(packet) // 2])
        self.close()

    def _put(self, packet: bytes) -> None:
        out = self._out
        out.gathered.append(packet)
        out.size += len(packet)
        if out.size > _FLUSH_SIZE:
            self._flush()
        elif not self._receiving:
            if not self._flush_due:
                self._flush_due = True
                self.owner.loop.call_soon(self._flush)
            if out.size > _SMALL:
                self._count()

    def _hold(self, packet: bytes) -> bool:
        """Keep a notification back if it must not come yet."""
        out, loop = self._out, self.owner.loop
        waited = out.due is not None
        if not out.hold(packet, loop.time()):
            return False
        if not waited:
            self._release_at(out.due)
        self._count()
        return True

    def _release_at(self, due: float | None) -> None:
        if due is not None:
            self.owner.loop.call_at(due, self._release)

    def _release(self) -> None:
        """Send the notifications that have waited long enough, in order."""
        out, due = self._out, self._out.due
        if self._open and due is not None:
            out.release(max(self.owner.loop.time(), due))  # timers may be early by their resolution
            self._release_at(out.due)
            self._flush()

    @property
    def congested(self) -> bool:
        """True while the peer leaves so much unread that notifications had better wait."""
        transport = self._transport
        return transport is not None and transport.get_write_buffer_size() > _CONGESTED

    @property
    def backlog(self) -> int:
        """Bytes that the peer has not taken yet."""
        transport = self._transport
        return self._out.size + (0 if transport is None else transport.get_write_buffer_size())

    @property
    def held(self) -> int:
        """Bytes kept for the peer: those it has not taken, and packets that lack their end.

        Those of a closed connection count until they are gone.
        """
        return 0 if self.cut_off else self.backlog + self._out.held_size + self._stream.pending

    def _count(self) -> None:
        """What is kept may have changed."""
        held = self.held
        if held != self._counted:
            self._counted = held
            self.owner.held.count(self, held)

    def cut(self, reason: str, *details: object) -> None:
        """Close at once because the peer takes too much room."""
        self.warn(reason, *details)
        self.cut_off = True
        self.abort()

    def _send(self, message: TcpMessage) -> None:
        self._out.put(message.encode_tcp())

    def _flush(self) -> None:
        self._flush_due = False
        transport = self._transport
        if not self._out.size or transport is None:
            return
        transport.write(self._out.take())
        unread = transport.get_write_buffer_size()
        if unread > self.owner.max_backlog:
            self.cut("it does not read what it asked for")
        elif unread or self._counted:
            self._count()

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


def _keep_alive(connected: socket.socket | None) -> None:
    if connected is None:
        return
    with contextlib.suppress(OSError):  # the peer may be gone already
        connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in _KEEPALIVE.items():
            if hasattr(socket, name):
                connected.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
