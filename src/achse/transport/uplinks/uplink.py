"""Uplink along one route: its queue, its dialling and its refusals.

An uplink connects when a request wants to go there, and again after a loss for as long as it is in
use. What waits for it is limited; what cannot go is refused with the router's own codes. It does no
I/O: `Uplinks` dials.
"""

import logging
from collections import deque
from collections.abc import Callable

from achse.ams import AmsAddress, Command, Frame
from achse.ams.connection import DEFAULT_MAX_LENGTH
from achse.codes import ReturnCode
from achse.router import Router
from achse.router.forwarding.restoring import LinkMemory
from achse.router.routes import Route
from achse.transport.connections.byte_transport import Scheduler, Timer
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.peer import Peer
from achse.transport.connections.send_budget import SendBudget
from achse.transport.uplinks.dialled import DialledPeer
from achse.transport.uplinks.nat import NatPeer

log = logging.getLogger("achse.uplink")

_FIRST_PAUSE, _LONGEST_PAUSE = 0.1, 5.0
"""Seconds between attempts to connect, doubled each time."""

_IDLE = 60.0
"""Seconds after the last request in which a lost connection is dialled again by itself."""

_SETTLED = 5.0
"""Seconds after which a connection counts as good; a peer that closes at once is no better than one
that is not there: it does not know us."""

_SMALL = 1024
"""Bytes of a packet that goes to a host that leaves much unread, if its client waits for nothing
else there."""

_NO_ANSWER = 0x0003
"""Flags of frames that are not answered: responses, and requests that want no response."""


class Uplink:
    """The endpoint behind one route; owner of the peer at its host.

    At most `queue_frames` frames and `queue_bytes` bytes wait while it connects (0x502 beyond). A
    host that cannot be reached answers 0x1B at once until the next attempt is due; a packet longer
    than the route's `max_fragment` is refused with 0x1C, since no document says how to split it.

    With `strict` the far end asks nothing here under a NetId without a route.

    `dial(uplink)` begins to connect: it ends with `begin` of what `make_peer` gives, or with
    `failed`.
    """

    routes_required = False

    def __init__(
        self,
        router: Router,
        route: Route,
        scheduler: Scheduler,
        dial: "Callable[[Uplink], None]",
        *,
        max_length: int = DEFAULT_MAX_LENGTH,
        max_backlog: int = 64 * 1024 * 1024,
        queue_frames: int = 1024,
        queue_bytes: int = 4 * 1024 * 1024,
        send_budget: SendBudget | None = None,
        fair_queue: FairQueue | None = None,
        strict: bool = False,
    ) -> None:
        self.router = router
        self.route = route
        self.strict = strict
        self.loop = scheduler
        self.max_length = max_length
        self.max_backlog = max_backlog
        self.queue_frames = queue_frames
        self.queue_bytes = queue_bytes
        self.send_budget = send_budget or SendBudget()
        self.fair_queue = fair_queue or FairQueue()
        self.refused = 0
        """Frames that could not go."""
        self.connections = 0
        """Connections that came up so far."""
        self.losses = 0
        """Of these, those that were lost."""
        self.memory: LinkMemory | None = None
        if (choice := router.resubscription) is not None:
            self.memory = LinkMemory(
                lambda client, source: choice.applies(client, source, route.resubscribe)
            )
        elif route.resubscribe:
            self.memory = LinkMemory()
        if self.memory is not None:
            router.on_way_closed(self.memory.forget, self.memory.uses)
        self.trouble = ""
        """Reason for having no connection; empty before the first attempt and while connected."""
        self.denied = False
        """True if the host did not accept our certificate at the last attempt."""
        self._dial = dial
        self._dialling = False
        self._connection: Peer | None = None
        self._opening: Peer | None = None
        """Connection that is up and releases what earlier ones left."""
        self._queue = _Queue(self)
        self._retry: Timer | None = None
        self._pause = 0.0
        self._not_before = 0.0
        self._opened_at = 0.0
        self.last_request = 0.0
        """Time of the last request that went or wanted to go here, s."""
        self._closed = False

    # endpoint ----------------------------------------------------------------------------------

    @property
    def connected(self) -> bool:
        return self._connection is not None

    @property
    def peer(self) -> Peer | None:
        """Far end of the connection; None without one."""
        return self._connection

    def drop(self, reason: str) -> None:
        """End a connection whose far end is silent; it is dialled again."""
        if self._connection is not None:
            self._connection.warn("%s", reason)
            self._connection.abort()

    def deliver(self, frame: Frame) -> bool:
        """Send `frame` to the host, or keep it until there is a connection."""
        if self._closed:
            return False
        connection = self._connection
        size = 32 + len(frame.data)
        if self.route.max_fragment and size > self.route.max_fragment:
            return self.refuse(frame, ReturnCode.INVALID_AMS_FRAGMENT)
        if connection is not None:
            if not frame.flags & _NO_ANSWER:
                self.last_request = self.loop.time()
                if connection.congested and size > _SMALL:
                    return self.refuse(frame, ReturnCode.ROUTER_MAILBOX_FULL)
            return connection.deliver(frame)
        if not self._dialling and self.loop.time() < self._not_before:
            return self.refuse(frame, ReturnCode.HOST_UNREACHABLE)
        queue = self._queue
        if len(queue.frames) >= self.queue_frames or queue.buffered_bytes + size > self.queue_bytes:
            return self.refuse(frame, ReturnCode.ROUTER_MAILBOX_FULL)
        queue.put(frame, size)
        self.last_request = self.loop.time()
        self._connect()
        return True

    def way_for_known(self, client: Peer) -> Peer | None:
        """Return the far end of the connection if any request of `client` may go there now."""
        far = self._connection
        if far is None or self.route.max_fragment or client is far or far.congested:
            return None
        return far if far.takes_known() else None

    def remembered(self) -> None:
        """Dial again: resources of a client are to be made again."""
        self.last_request = self.loop.time()
        if self._retry is not None:
            self._retry.cancel()
        if not (self._dialling or self._closed or self.connected):
            self._retry = self.loop.call_at(self._not_before, self._connect)

    def refuse(self, frame: Frame, code: ReturnCode) -> bool:
        """Answer `code` to a request that cannot go; True, as `deliver` says it."""
        self.refused += 1
        if not frame.flags & _NO_ANSWER and frame.command != Command.NOTIFICATION:
            log.info(
                "%s asked for %s by route %s: %s",
                *(AmsAddress(frame.source), AmsAddress(frame.target), self.route.name, code.name),
                extra=frame.sender,
            )
            self.router.deliver(frame.reply(error=code.number))
        return True

    # connecting --------------------------------------------------------------------------------

    def _connect(self) -> None:
        if not (self._dialling or self._closed):
            if self._retry is not None:
                self._retry.cancel()
            self._dialling = True
            self._dial(self)

    def make_peer(self) -> Peer:
        """Return the peer for the dialled transport."""
        nat = self.route.nat_net_id
        return DialledPeer(self) if nat is None else NatPeer(self, self.route.net_id, nat)

    def review_access(self, route: Route) -> None:
        """Note that another route came, went or changed: the far end may send by it as well."""
        if self._connection is not None:
            self._connection.review_access(route)

    def failed(self, reason: str, code: ReturnCode = ReturnCode.HOST_UNREACHABLE) -> None:
        """Answer waiting requests with `code`: the host is not reached, or does not admit us."""
        self._dialling = False
        self.trouble, self.denied = reason, code is ReturnCode.ACCESS_DENIED
        self._back_off("%s cannot be reached: %s", self.route.host, reason)
        self._queue.refuse(code)

    def _back_off(self, what: str, *details: str) -> None:
        """Log the first failure; dial again later if requests have come lately."""
        level = logging.DEBUG if self._pause else logging.WARNING
        log.log(level, f"route %s: {what}", self.route.name, *details)
        now = self.loop.time()
        self._pause = min(self._pause * 2 or _FIRST_PAUSE, _LONGEST_PAUSE)
        self._not_before = now + self._pause
        remembers = self.memory is not None and self.memory.wanted
        if not self._closed and (remembers or now - self.last_request < _IDLE):
            self._retry = self.loop.call_at(self._not_before, self._connect)

    # owner of the peer -------------------------------------------------------------------------

    def serves_ports(self, host: str) -> bool:
        """Return a remote router registers no ports here."""
        return False

    def opened(self, peer: Peer) -> None:
        """Note that the connection is up: release what earlier ones left, and send what waited for
        it."""
        if self._closed:
            peer.abort()
            return
        log.info("route %s: connected to %s", self.route.name, peer.peer)
        self._opening = peer
        self.connections += 1
        self.trouble, self.denied = "", False
        self._opened_at = self.loop.time()
        if isinstance(peer, DialledPeer):
            peer.release_orphans(lambda: self._take_over(peer))
        else:
            self._take_over(peer)

    def _take_over(self, peer: Peer) -> None:
        """Send requests by this connection from now on."""
        self._opening, self._dialling = None, False
        self._connection = peer
        if isinstance(peer, DialledPeer):
            peer.restore()
        for frame in self._queue.take():
            if not peer.deliver(frame):
                self.refuse(frame, ReturnCode.TARGET_MACHINE_NOT_FOUND)

    def closed(self, peer: Peer) -> None:
        """Note the end of the connection."""
        opening = peer is self._opening
        if opening or peer is self._connection:
            self._connection = self._opening = None
            if opening:
                self._dialling = False
                self._queue.refuse(ReturnCode.HOST_UNREACHABLE)
            if self.loop.time() - self._opened_at > _SETTLED:
                self._pause = 0.0
            if not self._closed:
                self.losses += 1
                self.trouble = "connection lost"
                self._back_off("connection to %s lost", peer.peer)

    def close(self) -> None:
        """End the connection and dial no more; what waits is refused."""
        self._closed = True
        memory, self.memory = self.memory, None
        if memory is not None:
            self.router.ignore_way_closed(memory.forget)
            for session in memory.sessions:
                for hint in session.end_hints():
                    self.router.deliver(hint)
                if isinstance(session.client, Peer):
                    session.client.drop_client(self.route.name)
        if self._retry is not None:
            self._retry.cancel()
        self._queue.refuse(ReturnCode.HOST_UNREACHABLE)
        peer = self._connection or self._opening
        if peer is not None:
            peer.abort()


class _Queue:
    """Frames that wait for a connection; they count for what all connections hold."""

    def __init__(self, uplink: Uplink) -> None:
        self.frames: deque[Frame] = deque()
        self.buffered_bytes = 0
        """Bytes of them."""
        self._uplink = uplink

    def put(self, frame: Frame, size: int) -> None:
        self.frames.append(frame)
        self.buffered_bytes += size
        self._uplink.send_budget.count(self, self.buffered_bytes)

    def take(self) -> deque[Frame]:
        """Return all of them; none waits any more."""
        frames, self.frames, self.buffered_bytes = self.frames, deque(), 0
        self._uplink.send_budget.count(self, 0)
        return frames

    def refuse(self, code: ReturnCode) -> None:
        """Answer `code` to all of them."""
        for frame in self.take():
            self._uplink.refuse(frame, code)

    def cut(self, reason: str, *details: object) -> None:
        """Refuse the queued requests: they take too much room."""
        log.warning("route %s: what waits is refused: " + reason, self._uplink.route.name, *details)
        self.refuse(ReturnCode.ROUTER_MAILBOX_FULL)
