"""Uplinks: connections that we dial, one for each route, to the routers of other computers.

An uplink connects when a request wants to go there, and again after a loss for as long as it is in
use. What waits for it is limited; what cannot go is refused with the router's own codes.
"""

import asyncio
import contextlib
import ipaddress
import logging
from collections import deque
from collections.abc import Iterator

from achse.ams import AmsAddress, Command, Connection, Frame, NetId
from achse.ams.connection import DEFAULT_MAX_LENGTH, Event
from achse.codes import ReturnCode
from achse.router import Router
from achse.router.routes import Route
from achse.transport.connection import TcpConnection
from achse.transport.held import Held
from achse.transport.peer import Peer
from achse.transport.reason import reason

__all__ = ["Uplink", "Uplinks"]

log = logging.getLogger("achse.uplink")

_FIRST_PAUSE, _LONGEST_PAUSE = 0.1, 5.0
"""Seconds between attempts to connect, doubled each time."""

_IDLE = 60.0
"""Seconds after the last request in which a lost connection is dialled again by itself."""

_SETTLED = 5.0
"""Seconds after which a connection counts as good; a peer that closes at once is no better than one
that is not there: it does not know us."""

_NO_ANSWER = 0x0003
"""Flags of frames that are not answered: responses, and requests that want no response."""


class Uplink:
    """The endpoint behind one route; owner of the connection to its host.

    At most `queue_frames` frames and `queue_bytes` bytes wait while it connects (0x502 beyond). A
    host that cannot be reached answers 0x1B at once until the next attempt is due; a packet longer
    than the route's `max_fragment` is refused with 0x1C, since nobody says how to split it.
    """

    routes_required = False

    def __init__(
        self,
        router: Router,
        route: Route,
        *,
        local_host: str = "",
        max_length: int = DEFAULT_MAX_LENGTH,
        max_backlog: int = 64 * 1024 * 1024,
        queue_frames: int = 1024,
        queue_bytes: int = 4 * 1024 * 1024,
        held: Held | None = None,
    ) -> None:
        self.router = router
        self.route = route
        self.local_host = local_host
        self.max_length = max_length
        self.max_backlog = max_backlog
        self.queue_frames = queue_frames
        self.queue_bytes = queue_bytes
        self.held = held or Held()
        self.loop = asyncio.get_running_loop()
        self.refused = 0
        """Frames that could not go."""
        self._connection: Peer | None = None
        self._queue = _Queue(self)
        self._dialling: asyncio.Task[None] | None = None
        self._retry: asyncio.TimerHandle | None = None
        self._pause = 0.0
        self._not_before = 0.0
        self._opened_at = 0.0
        self._last_request = 0.0
        self._closed = False

    # endpoint ----------------------------------------------------------------------------------

    @property
    def connected(self) -> bool:
        return self._connection is not None

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
                self._last_request = self.loop.time()
                if connection.congested:
                    return self.refuse(frame, ReturnCode.ROUTER_MAILBOX_FULL)
            return connection.deliver(frame)
        if self._dialling is None and self.loop.time() < self._not_before:
            return self.refuse(frame, ReturnCode.HOST_UNREACHABLE)
        queue = self._queue
        if len(queue.frames) >= self.queue_frames or queue.held + size > self.queue_bytes:
            return self.refuse(frame, ReturnCode.ROUTER_MAILBOX_FULL)
        queue.put(frame, size)
        self._last_request = self.loop.time()
        self._dial()
        return True

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

    def _dial(self) -> None:
        if self._dialling is None and not self._closed:
            self._dialling = self.loop.create_task(self._connect())

    async def _connect(self) -> None:
        if self._retry is not None:
            self._retry.cancel()
        host, port = self.route.endpoint()
        make = Peer if self.route.nat_net_id is None else _NatPeer
        leave_by = (self.local_host, 0) if self._may_leave_by_it(host) else None
        try:
            async with asyncio.timeout(self.route.timeout):
                await self.loop.create_connection(
                    lambda: TcpConnection(make(self)), host, port, local_addr=leave_by
                )
        except TimeoutError:
            self._failed(f"no answer within {self.route.timeout:g} s")
        except OSError as failure:
            self._failed(reason(failure))
        except UnicodeError as failure:
            self._failed(str(failure))
        finally:
            self._dialling = None

    def _may_leave_by_it(self, host: str) -> bool:
        """Whether a connection to `host` can come from the address at which we listen.

        The other side knows us by it; but from a loopback address only such ones can be reached.
        """
        try:
            ours, theirs = ipaddress.ip_address(self.local_host), ipaddress.ip_address(host)
        except ValueError:
            return False
        return not ours.is_unspecified and ours.is_loopback == theirs.is_loopback

    def _failed(self, reason: str) -> None:
        self._back_off("%s cannot be reached: %s", self.route.host, reason)
        self._queue.refuse(ReturnCode.HOST_UNREACHABLE)

    def _back_off(self, what: str, *details: str) -> None:
        """Say so once, and try again by and by unless nobody has wanted to go there for a while."""
        level = logging.DEBUG if self._pause else logging.WARNING
        log.log(level, f"route %s: {what}", self.route.name, *details)
        now = self.loop.time()
        self._pause = min(self._pause * 2 or _FIRST_PAUSE, _LONGEST_PAUSE)
        self._not_before = now + self._pause
        if not self._closed and now - self._last_request < _IDLE:
            self._retry = self.loop.call_at(self._not_before, self._dial)

    # owner of the connection -------------------------------------------------------------------

    def serves_ports(self, host: str) -> bool:
        """A remote router registers no ports here."""
        return False

    def opened(self, peer: Peer) -> None:
        """The connection is up: send what waited for it."""
        if self._closed:
            peer.abort()
            return
        log.info("route %s: connected to %s", self.route.name, peer.peer)
        self._connection = peer
        self._opened_at = self.loop.time()
        for frame in self._queue.take():
            if not peer.deliver(frame):
                self.refuse(frame, ReturnCode.TARGET_MACHINE_NOT_FOUND)

    def closed(self, peer: Peer) -> None:
        """The connection is gone."""
        if peer is self._connection:
            self._connection = None
            if self.loop.time() - self._opened_at > _SETTLED:
                self._pause = 0.0
            if not self._closed:
                self._back_off("connection to %s lost", peer.peer)

    async def close(self) -> None:
        """End the connection and stop dialling; what waits is refused."""
        self._closed = True
        if self._retry is not None:
            self._retry.cancel()
        dialling = self._dialling
        if dialling is not None:
            dialling.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await dialling
        self._queue.refuse(ReturnCode.HOST_UNREACHABLE)
        if self._connection is not None:
            self._connection.abort()
            await asyncio.sleep(0)


class _Queue:
    """Frames that wait for a connection; they count for what all connections hold."""

    def __init__(self, uplink: Uplink) -> None:
        self.frames: deque[Frame] = deque()
        self.held = 0
        """Bytes of them."""
        self._uplink = uplink

    def put(self, frame: Frame, size: int) -> None:
        self.frames.append(frame)
        self.held += size
        self._uplink.held.count(self, self.held)

    def take(self) -> deque[Frame]:
        """All of them; none waits any more."""
        frames, self.frames, self.held = self.frames, deque(), 0
        self._uplink.held.count(self, 0)
        return frames

    def refuse(self, code: ReturnCode) -> None:
        """Answer `code` to all of them."""
        for frame in self.take():
            self._uplink.refuse(frame, code)

    def cut(self, reason: str, *details: object) -> None:
        """They take too much room."""
        log.warning("route %s: what waits is refused: " + reason, self._uplink.route.name, *details)
        self.refuse(ReturnCode.ROUTER_MAILBOX_FULL)


class Uplinks:
    """The uplinks of a router, one for each route of its table, from `start` to `close`."""

    def __init__(
        self, router: Router, *, local_host: str = "", max_length: int, held: Held | None = None
    ) -> None:
        self.router = router
        self.held = held or Held()
        self.local_host = local_host
        self.max_length = max_length
        self._uplinks: dict[NetId, Uplink] = {}
        self._closing: set[asyncio.Task[None]] = set()

    def __iter__(self) -> Iterator[Uplink]:
        return iter(list(self._uplinks.values()))

    def start(self) -> None:
        """Follow the router's table of routes."""
        for route in self.router.routes:
            self._changed(None, route)
        self.router.routes.on_change(self._changed)

    async def close(self) -> None:
        """End all connections."""
        self.router.routes.ignore(self._changed)
        for route in self.router.routes:
            self._changed(route, None)
        await asyncio.gather(*self._closing)

    def _changed(self, old: Route | None, new: Route | None) -> None:
        if old is not None and (uplink := self._uplinks.pop(old.net_id, None)) is not None:
            self.router.remove_route(old.net_id)
            closing = uplink.loop.create_task(uplink.close())
            self._closing.add(closing)
            closing.add_done_callback(self._closing.discard)
        if new is not None:
            uplink = Uplink(
                *(self.router, new),
                local_host=self.local_host,
                max_length=self.max_length,
                held=self.held,
            )
            self._uplinks[new.net_id] = uplink
            self.router.add_route(new.net_id, uplink)


class _NatPeer(Peer):
    """A connection to a router that has another NetId than the one by which we know it."""

    def __init__(self, owner: Uplink) -> None:
        super().__init__(owner)
        assert owner.route.nat_net_id is not None
        self._ours = bytes(owner.route.net_id)
        self._theirs = bytes(owner.route.nat_net_id)
        self._stream = _NatStream(owner.max_length, self._ours, self._theirs)

    def _put(self, packet: bytes) -> None:
        if packet[6:12] == self._ours:
            packet = packet[:6] + self._theirs + packet[12:]
        super()._put(packet)


class _NatStream(Connection):
    """Frames with their sender as we know it."""

    __slots__ = ("_ours", "_theirs")

    def __init__(self, max_length: int, ours: bytes, theirs: bytes) -> None:
        super().__init__(max_length)
        self._ours = ours
        self._theirs = theirs

    def receive(self, data: bytes) -> Iterator[Event]:
        """Yield every event that `data` completes."""
        for event in super().receive(data):
            if isinstance(event, Frame) and event.source[:6] == self._theirs:
                event.source = self._ours + event.source[6:]
            yield event
