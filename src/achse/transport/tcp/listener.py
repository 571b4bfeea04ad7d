"""AMS/TCP: the listener that lets clients, servers and other routers in.

Source: 000 §3.2.
"""

import asyncio
import logging
import os
from collections import Counter
from typing import cast

from achse.ams.connection import DEFAULT_MAX_LENGTH
from achse.router import Router
from achse.router.routes import Route
from achse.transport.connections.byte_transport import Scheduler
from achse.transport.connections.connection import TcpConnection
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.peer import Peer
from achse.transport.connections.send_budget import SendBudget
from achse.transport.own_address import is_loopback
from achse.transport.tcp.acceptor import Acceptor
from achse.transport.tcp.idle import IdleConnections
from achse.transport.tcp.refusal import NO_ROOM, RefusedConnections

log = logging.getLogger("achse.tcp")

TCP_PORT = 48898
"""0xBF02, where AMS routers listen (000 §3)."""


MOST_WAITING = 1024
"""Connections that wait to be taken; where more come at once, the rest dials again 1 s later."""

_ROOM = 16
"""Idle connections closed at once where the process has no descriptors left."""

_HOSTS = 32
"""Hosts whose connections are looked at for them."""


class TcpListener:
    """Accepts AMS/TCP connections for a router.

    - `strict`: one connection per remote host as the original does; a second one closes the
      first, unless that holds a registered port. Off by default: any number.
    - `routes_required`: a sender needs a route in the router's table, other connections are closed.
    - `external_registration`: serve the local port service to other hosts as well.
    - `max_length`: longest packet taken, bytes.
    - `max_backlog`: bytes that may wait for a peer that does not read.
    - `send_budget`: bytes that wait on all connections together, unfinished packets included;
      beyond its limit, the connection with the most of them is closed.
    - `fair_queue`: order of service of peers with many requests.
    - `max_connections`: the first request on a further one is answered with 0x508, then it is
      closed. `max_per_host`: the same for those of one host, if none of them is idle: an idle one
      is closed in favour of the newcomer.
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
        send_budget: SendBudget | None = None,
        fair_queue: FairQueue | None = None,
        max_connections: int = 4096,
        max_per_host: int = 2048,
    ) -> None:
        self.router = router
        self.strict = strict
        self.routes_required = routes_required
        self.external_registration = external_registration
        self.max_length = max_length
        self.max_backlog = max_backlog
        self.send_budget = send_budget or SendBudget()
        self.fair_queue = fair_queue or FairQueue()
        self.max_connections = max_connections
        self.max_per_host = max_per_host
        self.accepting = True
        """False: every new connection is closed at once."""
        self.refused = 0
        """Connections that were not taken: `max_connections` were open, or none was wanted."""
        self.cut_off = 0
        """Connections closed because their peer did not read, or left packets unfinished."""
        self.host = ""
        self.port = 0
        self.connections: set[Peer] = set()
        self.loop: asyncio.AbstractEventLoop
        self._server: asyncio.Server | None = None
        """Server of the listening sockets."""
        self._serving = False
        self._acceptor: Acceptor | None = None
        self._refusals = RefusedConnections()
        self._idle = IdleConnections(router)
        self._closing_idle: set[str] = set()
        """Hosts whose idle connections are closed; until a tenth is free again."""
        self._full: set[str] = set()
        """Hosts whose refusal is logged, "" for all of them: until a tenth is free again."""
        self._per_host: Counter[str] = Counter()
        self._last_closed = asyncio.Event()

    async def open(self, host: str = "127.0.0.1", port: int = TCP_PORT) -> None:
        """Listen on `host`:`port`; 0 takes a free one, see `self.port`. OSError if it is taken."""
        self.begin(asyncio.get_running_loop())
        try:
            await self._listen(host, port)
        except BaseException:
            self._serving = False
            raise
        self.router.routes.on_change(self._changed)

    def begin(self, loop: Scheduler) -> None:
        """Serve peers that begin a transport of their own, without a socket; `open` adds
        sockets."""
        self.loop = cast(asyncio.AbstractEventLoop, loop)
        self._serving = True

    async def _listen(self, host: str, port: int) -> None:
        self._server = await self.loop.create_server(
            self._connection,
            host,
            port,
            backlog=MOST_WAITING,
            start_serving=False,
        )
        self.host, self.port = self._server.sockets[0].getsockname()[:2]
        if os.name == "nt":  # its loop watches no descriptors, and there is no limit to meet
            await self._server.start_serving()
        else:
            try:
                self._acceptor = Acceptor(
                    self._server.sockets,
                    self._connection,
                    MOST_WAITING,
                    self._cannot_accept,
                    self._accepts_again,
                    self._make_room,
                )
            except BaseException:
                self._server.close()
                self._server = None
                raise

    def _cannot_accept(self, why: str) -> None:
        log.warning(
            "connections to %s:%d wait until some have left: %s (more: ulimit -n, or LimitNOFILE of"
            " the service)",
            *(self.host, self.port, why),
        )

    def _accepts_again(self) -> None:
        log.info("connections to %s:%d are accepted again", self.host, self.port)

    def _make_room(self) -> bool:
        """Close idle connections, as no descriptor is left: those of the host that has most first.

        False if all connections are in use. The closed ones stay a reserve for files as well.
        """
        now, closed = self.loop.time(), 0
        for host, _ in self._per_host.most_common(_HOSTS):
            while closed < _ROOM and (idle := self._idle.find(host, now)) is not None:
                log.info("closing the idle connection %s: no descriptor is left", idle.peer)
                self._remove(idle)
                idle.close()
                closed += 1
        return closed > 0

    def _changed(self, old: Route | None, new: Route | None) -> None:
        """Review the access of peers of a route that has changed."""
        for peer in list(self.connections):
            for route in filter(None, (old, new)):
                peer.review_access(route)

    def _connection(self) -> asyncio.Protocol:
        """Return the protocol of a new incoming connection."""
        return TcpConnection(Peer(self))

    async def close(self) -> None:
        """Stop listening and close every connection; a peer that does not read gets no time."""
        server, self._server = self._server, None
        self._serving = False
        if server is None:
            return
        self.router.routes.ignore(self._changed)
        if self._acceptor is not None:
            self._acceptor.close()
            self._acceptor = None
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
        return self.external_registration or is_loopback(host)

    def opened(self, peer: Peer) -> None:
        """Note that a connection came up: apply the limit and the one-per-host rule."""
        if not self._serving:
            peer.abort()
            return
        replaced = [
            other
            for other in self.connections
            if self.strict and other.peer_host == peer.peer_host and not other.registered
        ]
        host = peer.peer_host
        if not self.accepting:
            self._refuse(peer)
        elif len(self.connections) - len(replaced) >= self.max_connections:
            self._refuse(peer, "", "max_connections", self.max_connections)
        elif self._per_host[host] - len(replaced) >= self.max_per_host and not self._end_idle(peer):
            self._refuse(peer, host, "max_connections_per_host", self.max_per_host)
        else:
            for other in replaced:
                other.warn("%s replaces it", peer.peer)
                other.close()
            self.connections.add(peer)
            self._per_host[host] += 1
            self._idle.add(peer, self.loop.time())

    def _end_idle(self, newcomer: Peer) -> bool:
        """Close an idle connection of the newcomer's host; False if all of them are in use."""
        host = newcomer.peer_host
        idle = self._idle.find(host, self.loop.time())
        if idle is None:
            return False
        if host not in self._closing_idle:
            log.warning(
                "closing idle connections of %s for new ones, first %s:"
                " [router] max_connections_per_host is %d",
                *(host, idle.peer, self.max_per_host),
                extra={"client": idle.client, "peer": idle.peer},
            )
        self._remove(idle)
        self._closing_idle.add(host)  # room for one is none
        idle.close()
        return True

    def _refuse(self, peer: Peer, whose: str = "", name: str = "", limit: int = 0) -> None:
        """Refuse a connection; log the first refusal until there is room again."""
        self.refused += 1
        if not name:
            peer.warn("no connections are taken now")
            peer.abort()
            return
        if whose not in self._full:
            self._full.add(whose)
            log.warning(
                "no room for %s: refused with 0x%X %s, as all further clients%s until some have"
                " left; [router] %s is %d",
                *(peer.peer, NO_ROOM.number, NO_ROOM.name),
                *(f" from {whose}" if whose else "", name, limit),
                extra={"client": "", "peer": peer.peer},
            )
        self._refusals.add(cast(asyncio.Transport, peer.give_up()), self.loop)

    def closed(self, peer: Peer) -> None:
        """Note that a connection went down."""
        if peer in self.connections:
            if log.isEnabledFor(logging.INFO):
                facts = {"client": peer.client, "peer": peer.peer}
                client = f", client {peer.client}" if peer.client else ""
                log.info("%s has left%s", peer.peer, client, extra=facts)
            self._remove(peer)
        self.cut_off += peer.cut_off
        if not self.connections:
            self._last_closed.set()

    def _remove(self, peer: Peer) -> None:
        host = peer.peer_host
        self.connections.remove(peer)
        self._idle.remove(peer)
        self._per_host[host] -= 1
        if self._per_host[host] <= 0.9 * self.max_per_host:
            self._full.discard(host)
            self._closing_idle.discard(host)
        if not self._per_host[host]:
            del self._per_host[host]
        if len(self.connections) <= 0.9 * self.max_connections:
            self._full.discard("")
