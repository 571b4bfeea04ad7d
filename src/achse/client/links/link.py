"""Links: the ways a client's frames reach a router, over TCP or inside one process.

A dialer opens a link; the session that asked for it gets the frames. A dialer is kept and asked
again after a loss.
"""

import asyncio
import ipaddress
import logging
from collections.abc import Callable
from enum import StrEnum
from typing import Any, Literal, Protocol, cast

from achse.ams import (
    AmsAddress,
    ConnectionLost,
    DecodeError,
    Frame,
    NetId,
)
from achse.ams.discovery import UDP_PORT
from achse.router import LOOPBACK_NET_ID, Router
from achse.transport.connections.caller import Caller
from achse.transport.tcp.listener import TCP_PORT

log = logging.getLogger("achse.client")

Mode = Literal["auto", "router", "direct"]
"""Names of `LinkMode`."""


class LinkMode(StrEnum):
    """Origin of the address of a link."""

    AUTO = "auto"
    """The peer is asked for a port; without an answer the link brings its own address."""
    ROUTER = "router"
    """The peer grants a port of its own (0x1000)."""
    DIRECT = "direct"
    """The link brings its own address."""


GRANT_TIME = 1.0
"""Seconds the router on this host gets to grant a port; it answers within a millisecond."""

ANSWER_TIME = 0.3
"""Seconds the router on another host gets to return its NetId over UDP; a firewall may drop it."""

_AGAIN = 0.05
"""Seconds between attempts to reach a server that ended when it was asked for a port."""

_MOST_WITHOUT = 256
"""Peers without port service that are kept in mind."""

_without_service: dict[tuple[str, int], None] = {}
"""Peers of this process that ended a connection when they were asked for a port, oldest first.

Some servers know no TCP command but 0, and end or even crash on 0x1000. They are not asked again,
by no client of this process, until one of them ends a link without having answered anything.
"""


class LinkUser(Protocol):
    """The session behind a link."""

    def received(self, frame: Frame) -> None:
        """Note that a frame came."""
        ...

    def lost(self, link: "ClientLink", reason: str) -> None:
        """Note that the link ended without our asking."""
        ...

    def buffer_changed(self, link: "ClientLink", full: bool) -> None:
        """Note that the write buffer is full, or has room again."""
        ...


class Onlooker:
    """User of a link that only checks that it can be opened, or its far end."""

    def received(self, frame: Frame) -> None: ...

    def lost(self, link: "ClientLink", reason: str) -> None: ...

    def buffer_changed(self, link: "ClientLink", full: bool) -> None: ...


class ClientLink(Protocol):
    """An open way to a router. `address` is ours on it, `peer_net_id` the NetId at its end."""

    @property
    def address(self) -> AmsAddress: ...

    @property
    def peer_net_id(self) -> NetId: ...

    @property
    def max_packet(self) -> int | None:
        """Bytes of the longest AMS packet it carries; None: no limit worth to know of."""
        ...

    def send(self, frame: Frame) -> None:
        """Send within this turn of the loop."""
        ...

    def close(self) -> None:
        """Give the port back and end, after what was sent."""
        ...

    async def wait_closed(self) -> None:
        """Wait after `close` until another program can open what this link had open."""
        ...

    def abort(self) -> None:
        """End at once, as if lost."""
        ...


class Dialer(Protocol):
    """Opens links, again and again."""

    @property
    def peer(self) -> str:
        """Address that the dialer dials, for messages."""
        ...

    async def open(self, user: LinkUser) -> ClientLink:
        """Open a link for `user`; raises `ConnectionLost` or `OSError`."""
        ...


class TcpLink(asyncio.Protocol):
    """A `Caller` on a TCP connection. Frames of one turn of the loop leave in one write."""

    max_packet = None

    def __init__(self, user: LinkUser) -> None:
        self._user = user
        self._loop = asyncio.get_running_loop()
        self._granted: asyncio.Future[AmsAddress] = self._loop.create_future()
        self._caller = Caller(user.received, self._grant)
        self._transport: asyncio.Transport | None = None
        self._failure = ""
        self.heard = False
        """True once the far end has sent anything."""
        self.when_mute: Callable[[], object] | None = None
        """Called if the far end closes without having sent anything."""

    @property
    def address(self) -> AmsAddress:
        return self._caller.address

    @property
    def peer_net_id(self) -> NetId:
        return self._caller.peer_net_id

    def take_address(self, address: AmsAddress, peer_net_id: NetId) -> None:
        """Use an address of our own, without a port of the router."""
        self._caller.address, self._caller.peer_net_id = address, peer_net_id

    # asyncio ---------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)

    def data_received(self, data: bytes) -> None:
        self.heard = True
        try:
            self._caller.receive(data)
        except DecodeError as failure:
            self._failure = str(failure)
            self.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        transport, self._transport = self._transport, None
        self._granted.cancel()
        if transport is not None and not self.heard and self.when_mute is not None:
            self.when_mute()
        if transport is not None:
            self._user.lost(self, self._failure or str(exc or "closed by the peer"))

    def pause_writing(self) -> None:
        self._user.buffer_changed(self, True)

    def resume_writing(self) -> None:
        self._user.buffer_changed(self, False)

    # port service ----------------------------------------------------------------------------

    async def register(self, grant_time: float) -> None:
        """Ask the router on this host for a port; `ConnectionLost` if it grants none in time."""
        assert self._transport is not None
        self._transport.write(self._caller.port_request())
        done, _ = await asyncio.wait((self._granted,), timeout=grant_time)
        if not done or self._granted.cancelled():
            raise ConnectionLost("the peer granted no port")

    def _grant(self, address: AmsAddress) -> None:
        if not self._granted.done():
            self._granted.set_result(address)

    # out -------------------------------------------------------------------------------------

    @property
    def is_open(self) -> bool:
        return self._transport is not None

    def extra(self, name: str) -> Any:
        """`sockname` or `peername` of the socket."""
        return None if self._transport is None else self._transport.get_extra_info(name)

    def send(self, frame: Frame) -> None:
        """Send within this turn of the loop. After a loss frames vanish; the session knows."""
        if self._caller.send(frame):
            self._loop.call_soon(self._flush)

    def _flush(self) -> None:
        data = self._caller.take()
        if self._transport is not None and data:
            self._transport.write(data)

    def close(self) -> None:
        """Give the port back and end, after what was sent."""
        data = self._caller.last_words()
        transport, self._transport = self._transport, None
        if transport is not None:
            if data:
                transport.write(data)
            transport.close()

    async def wait_closed(self) -> None:
        """Return at once: a connection excludes no other."""

    def abort(self) -> None:
        """End at once, as if lost."""
        if self._transport is not None:
            self._transport.abort()


class TcpDialer:
    """Opens AMS/TCP links to `host`:`port`.

    In mode "auto" a peer on this host is asked for a port first (router mode); if it does not
    grant one, or is elsewhere, the link uses `source` (direct mode). What worked is kept. A peer
    that ends the connection over the question is not asked again by this process. Without
    `source` the NetId is our IP address with .1.1 behind it, and the AMS port the local TCP port:
    unique among the clients of one host.

    With `needs_net_id` a router that granted no port is asked for its NetId at `udp_port` of its
    host (None: 48899 if `port` is 48898; another TCP port may belong to another router). Without
    an answer within `ANSWER_TIME` the NetId is derived from its IP address.
    """

    def __init__(
        self,
        host: str,
        port: int = TCP_PORT,
        *,
        mode: Mode = "auto",
        source: AmsAddress | None = None,
        grant_time: float = GRANT_TIME,
        needs_net_id: bool = False,
        udp_port: int | None = None,
    ) -> None:
        self.host = host
        self.port = port
        if mode not in set(LinkMode):
            words = ", ".join(repr(str(word)) for word in LinkMode)
            raise ValueError(f"mode: expected one of {words}, got {mode!r:.80}")
        self.mode = LinkMode(mode)
        if source is not None and self.mode is LinkMode.AUTO:
            self.mode = LinkMode.DIRECT
        self.source = source
        self.grant_time = grant_time
        self.needs_net_id = needs_net_id
        self.udp_port = UDP_PORT if udp_port is None and port == TCP_PORT else udp_port
        self.peer_net_id: NetId | None = None
        """NetId of the router without a port service, from the first link on."""
        self.assumed_net_id: NetId | None = None
        """The same if it was derived from the IP address; None if the router returned it."""

    @property
    def peer(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}"

    async def open(self, user: LinkUser) -> TcpLink:
        """Connect; raises OSError if no router listens, `ConnectionLost` if a port is refused."""
        link = await self._connect(user)
        try:
            if self.mode is LinkMode.ROUTER or (
                self.mode is LinkMode.AUTO and self._may_request_port(link)
            ):
                try:
                    await link.register(self.grant_time)
                    self.mode = LinkMode.ROUTER
                except ConnectionLost:
                    if self.mode is LinkMode.ROUTER:
                        raise
                    link = await self._open_directly(link, user)
            if self.mode is not LinkMode.ROUTER:
                if self.mode is LinkMode.AUTO and self._peer_key in _without_service:
                    link.when_mute = self._request_port_again
                elif self.mode is LinkMode.AUTO:
                    self.mode = LinkMode.DIRECT
                peer_net_id = await self._find_net_id(link.extra("peername"))
                address = self.source or address_of(link.extra("sockname"), peer_net_id)
                link.take_address(address, peer_net_id)
            if not link.is_open:
                raise ConnectionLost("closed by the peer")
        except BaseException:
            link.close()
            raise
        return link

    async def _find_net_id(self, name: Any) -> NetId:
        """Return the NetId of the router behind a socket name: its answer, or from its address."""
        if self.peer_net_id is None and self.needs_net_id and self.udp_port is not None:
            # loaded when a router on another host needs it
            from achse.transport.net_id_query import query_net_id

            self.peer_net_id = await query_net_id(str(_ip(name)), self.udp_port, ANSWER_TIME)
        if self.peer_net_id is None:
            self.peer_net_id = net_id_of(name)
            if self.needs_net_id:
                self.assumed_net_id = self.peer_net_id
        return self.peer_net_id

    @property
    def _peer_key(self) -> tuple[str, int]:
        return (self.host, self.port)

    def _may_request_port(self, link: TcpLink) -> bool:
        """Return True if a port may be requested: the peer is local and may offer the service."""
        return _is_loopback(link) and self._peer_key not in _without_service

    def _request_port_again(self) -> None:
        """Forget that the peer lacks the service: a router closes links without a port request."""
        _without_service.pop(self._peer_key, None)

    async def _open_directly(self, link: TcpLink, user: LinkUser) -> TcpLink:
        """Open a link to a router that granted no port, later if the request has ended the link."""
        if link.is_open:
            link.close()
            return await self._connect(user)
        while len(_without_service) >= _MOST_WITHOUT:
            del _without_service[next(iter(_without_service))]
        _without_service[self._peer_key] = None
        loop = asyncio.get_running_loop()
        deadline = loop.time() + self.grant_time
        while True:
            try:
                return await self._connect(user)
            except ConnectionRefusedError:
                if loop.time() + _AGAIN > deadline:
                    message = f"{self.peer} ended when it was asked for a port (0x1000)"
                    raise ConnectionLost(
                        f'{message}; it is not asked again: mode "direct" never asks'
                    ) from None
            await asyncio.sleep(_AGAIN)

    async def _connect(self, user: LinkUser) -> TcpLink:
        loop = asyncio.get_running_loop()
        _, link = await loop.create_connection(lambda: TcpLink(user), self.host, self.port)
        return link


def _is_loopback(link: TcpLink) -> bool:
    return _ip(link.extra("peername")).is_loopback


def _ip(name: Any) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """Return the IP address of a socket name; 127.0.0.1 for a socket that is closed already."""
    return ipaddress.ip_address(name[0].partition("%")[0] if name else "127.0.0.1")


def net_id_of(name: Any) -> NetId:
    """Return the NetId derived from the IP address of a socket name."""
    return NetId.of_ip(_ip(name))


def address_of(name: Any, peer_net_id: NetId = LOOPBACK_NET_ID) -> AmsAddress:
    """Return the AMS address of a client whose socket has this name, at a router with
    `peer_net_id`.

    A NetId that is the router's own, or every router's loopback alias, gets the next last number.
    """
    net_id = net_id_of(name)
    while net_id in (peer_net_id, LOOPBACK_NET_ID):
        net_id = NetId(net_id[:5] + bytes((net_id[5] + 1,)))
    return AmsAddress.of(net_id, name[1] if name else 30000)


class RouterLink:
    """A port of our own on a router in this process: no sockets, no bytes.

    Frames are handed over at the next turn of the loop, as over TCP, so that a client that reads
    in a circle does not keep the station from running.
    """

    max_packet = None

    def __init__(self, router: Router, user: LinkUser) -> None:
        self._router = router
        self._user = user
        self._loop = asyncio.get_running_loop()
        self._out: list[Frame] = []
        self._open = True
        self.address = router.register(0, self)
        self.peer_net_id = router.net_id

    def deliver(self, frame: Frame) -> bool:
        """Take a frame from the router; False after the end."""
        if self._open:
            self._user.received(frame)
        return self._open

    def send(self, frame: Frame) -> None:
        """Hand `frame` to the router at the next turn of the loop."""
        if not self._out:
            self._loop.call_soon(self._flush)
        frame.origin = self
        self._out.append(frame)

    def _flush(self) -> None:
        out, self._out = self._out, []
        if self._open:
            for frame in out:
                self._router.deliver(frame)

    def close(self) -> None:
        """Give the port back, after what was sent."""
        self._flush()
        if self._open:
            self._open = False
            self._router.unregister(self.address.port)

    async def wait_closed(self) -> None:
        """Return at once: the port is free already."""

    def abort(self) -> None:
        """End at once, as if lost."""
        if self._open:
            self._open = False
            self._router.unregister(self.address.port)
            self._loop.call_soon(self._user.lost, self, "aborted")


class RouterDialer:
    """Opens links to a router in this process."""

    def __init__(self, router: Router) -> None:
        self.router = router

    @property
    def peer(self) -> str:
        return f"router {self.router.net_id}"

    async def open(self, user: LinkUser) -> RouterLink:
        """Register a port; RouterError if none is left."""
        return RouterLink(self.router, user)
