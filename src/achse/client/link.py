"""Links: the ways a client's frames reach a router, over TCP or inside one process.

A dialer opens a link; the session that asked for it gets the frames. A dialer is kept and asked
again after a loss.
"""

import asyncio
import ipaddress
import logging
from typing import Any, Literal, Protocol, cast

from achse.ams import (
    AmsAddress,
    ConnectionLost,
    DecodeError,
    Frame,
    NetId,
)
from achse.router import LOOPBACK_NET_ID, Router
from achse.transport.caller import Caller
from achse.transport.tcp import TCP_PORT

__all__ = [
    "GRANT_TIME",
    "ClientLink",
    "Dialer",
    "LinkUser",
    "Mode",
    "RouterDialer",
    "RouterLink",
    "TcpDialer",
    "TcpLink",
]

log = logging.getLogger("achse.client")

Mode = Literal["auto", "router", "direct"]
"""Router mode asks the peer for a port of its own (0x1000), direct mode brings its own address."""

GRANT_TIME = 1.0
"""Seconds the router on this host gets to grant a port; it answers within a millisecond."""


class LinkUser(Protocol):
    """The session behind a link."""

    def received(self, frame: Frame) -> None:
        """A frame came."""
        ...

    def lost(self, link: "ClientLink", reason: str) -> None:
        """The link ended without our asking."""
        ...

    def held(self, link: "ClientLink", full: bool) -> None:
        """The way out is full, or has room again."""
        ...


class ClientLink(Protocol):
    """An open way to a router. `address` is ours on it, `peer_net_id` the NetId at its end."""

    @property
    def address(self) -> AmsAddress: ...

    @property
    def peer_net_id(self) -> NetId: ...

    def send(self, frame: Frame) -> None:
        """Send within this turn of the loop."""
        ...

    def close(self) -> None:
        """Give the port back and end, after what was sent."""
        ...

    def abort(self) -> None:
        """End at once, as if lost."""
        ...


class Dialer(Protocol):
    """Opens links, again and again."""

    @property
    def peer(self) -> str:
        """Where it dials, for messages."""
        ...

    async def open(self, user: LinkUser) -> ClientLink:
        """Open a link for `user`; raises `ConnectionLost` or `OSError`."""
        ...


class TcpLink(asyncio.Protocol):
    """A `Caller` on a TCP connection. Frames of one turn of the loop leave in one write."""

    def __init__(self, user: LinkUser) -> None:
        self._user = user
        self._loop = asyncio.get_running_loop()
        self._granted: asyncio.Future[AmsAddress] = self._loop.create_future()
        self._caller = Caller(user.received, self._grant)
        self._transport: asyncio.Transport | None = None
        self._failure = ""

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
        try:
            self._caller.receive(data)
        except DecodeError as failure:
            self._failure = str(failure)
            self.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        transport, self._transport = self._transport, None
        self._granted.cancel()
        if transport is not None:
            self._user.lost(self, self._failure or str(exc or "closed by the peer"))

    def pause_writing(self) -> None:
        self._user.held(self, True)

    def resume_writing(self) -> None:
        self._user.held(self, False)

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

    def abort(self) -> None:
        """End at once, as if lost."""
        if self._transport is not None:
            self._transport.abort()


class TcpDialer:
    """Opens AMS/TCP links to `host`:`port`.

    In mode "auto" a peer on this host is asked for a port first (router mode); if it does not
    grant one, or is elsewhere, the link uses `source` (direct mode). What worked is kept. Without
    `source` the NetId is our IP address with .1.1 behind it, and the AMS port the local TCP port:
    unique among the clients of one host.
    """

    def __init__(
        self,
        host: str,
        port: int = TCP_PORT,
        *,
        mode: Mode = "auto",
        source: AmsAddress | None = None,
        grant_time: float = GRANT_TIME,
    ) -> None:
        self.host = host
        self.port = port
        self.mode: Mode = "direct" if source is not None and mode == "auto" else mode
        self.source = source
        self.grant_time = grant_time

    @property
    def peer(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}"

    async def open(self, user: LinkUser) -> TcpLink:
        """Connect; raises OSError if nobody listens, `ConnectionLost` if a port is refused."""
        link = await self._connect(user)
        try:
            if self.mode == "router" or (self.mode == "auto" and _is_loopback(link)):
                try:
                    await link.register(self.grant_time)
                    self.mode = "router"
                except ConnectionLost:
                    if self.mode == "router":
                        raise
                    link.close()
                    link = await self._connect(user)
            if self.mode != "router":
                self.mode = "direct"
                address = self.source or _own_address(link)
                link.take_address(address, _net_id_of(link.extra("peername")))
            if not link.is_open:
                raise ConnectionLost("closed by the peer")
        except BaseException:
            link.close()
            raise
        return link

    async def _connect(self, user: LinkUser) -> TcpLink:
        loop = asyncio.get_running_loop()
        _, link = await loop.create_connection(lambda: TcpLink(user), self.host, self.port)
        return link


def _is_loopback(link: TcpLink) -> bool:
    return _ip(link.extra("peername")).is_loopback


def _ip(name: Any) -> ipaddress.IPv4Address:
    """The IPv4 address of a socket name; that of an IPv6 one by its last four bytes."""
    address = ipaddress.ip_address(name[0].partition("%")[0]) if name else None
    if address is None or (address.version == 6 and address.is_loopback):
        return ipaddress.IPv4Address("127.0.0.1")
    return ipaddress.IPv4Address(address.packed[-4:])


def _net_id_of(name: Any) -> NetId:
    return NetId(_ip(name).packed + b"\1\1")


def _own_address(link: TcpLink) -> AmsAddress:
    name = link.extra("sockname")
    net_id = _net_id_of(name)
    if net_id == LOOPBACK_NET_ID:
        # That one is every router's alias for itself; we are somebody else.
        net_id = NetId("127.0.0.1.1.2")
    return AmsAddress.of(net_id, name[1] if name else 30000)


class RouterLink:
    """A port of our own on a router in this process: no sockets, no bytes.

    Frames are handed over at the next turn of the loop, as over TCP, so that a client that reads
    in a circle does not keep the station from running.
    """

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
