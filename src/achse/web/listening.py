"""uvicorn in a loop that is not its own: without its signals, and patient for a while only."""

import asyncio
import contextlib
import socket
from collections import Counter
from collections.abc import Collection, Iterator
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.wsproto_impl import WSProtocol

REQUEST_WITHIN = 10.0
"""Seconds until a connection must have sent a whole request."""

ANSWER_WITHIN = 120.0
"""Seconds that reading an answer may take."""

MOST_WAITING = 256
"""Connections at most, pages that are open among them."""

_BACKLOG = 64


class BoundedHttp(H11Protocol):
    """HTTP with a time limit for every request and every answer, and a bound on connections."""

    _timer: asyncio.TimerHandle | None = None
    waits_since: float | None = None
    """Time since which the connection waits for a request, s; None while an answer is under way."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Note that a connection came; of too many one gives way: see `_one_too_many`."""
        super().connection_made(transport)
        self.waits_since = self.loop.time()
        self._within(REQUEST_WITHIN)
        if len(self.connections) > MOST_WAITING:
            _one_too_many(self.connections, self).give_way()

    def give_way(self) -> None:
        """End at once, for another."""
        self.waits_since = None
        self.connections.discard(self)
        self.transport.abort()

    def data_received(self, data: bytes) -> None:
        """Process received bytes; a complete request starts the time limit of its answer."""
        super().data_received(data)
        if self._timer is not None and self.conn.their_state in (h11.DONE, h11.MUST_CLOSE):
            self.waits_since = None
            self._within(ANSWER_WITHIN)

    def send_400_response(self, msg: str) -> None:
        """Refuse a broken request; what the application still says to it is dropped."""
        if self.cycle is not None:
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        if self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE):
            super().send_400_response(msg)
        else:
            self.transport.close()

    def on_response_complete(self) -> None:
        """Restart the time limit for the next request."""
        super().on_response_complete()
        self.waits_since = self.loop.time()
        self._within(REQUEST_WITHIN)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Note that a page has come to stay."""
        self.waits_since = None
        self._end_timer()
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        """End the timer with the connection."""
        self._end_timer()
        super().connection_lost(exc)

    def _within(self, seconds: float) -> None:
        self._end_timer()
        self._timer = self.loop.call_later(seconds, self._too_late)

    def _end_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _too_late(self) -> None:
        self._timer = None
        if not self.transport.is_closing():
            self.transport.abort()


class BoundedSocket(WSProtocol):
    """A WebSocket that reads no more while what it has to send is not taken: pings as well."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.opened_at = self.loop.time()
        """Time at which the connection became a WebSocket, s."""

    def give_way(self) -> None:
        """End at once, for another."""
        self.connections.discard(self)
        self.transport.abort()

    def pause_writing(self) -> None:
        """Pause reading, too: the page does not read."""
        super().pause_writing()
        if not self.transport.is_closing():
            self.transport.pause_reading()

    def resume_writing(self) -> None:
        """Resume reading: the page reads again."""
        super().resume_writing()
        if not self.read_paused and not self.transport.is_closing():
            self.transport.resume_reading()


def _host(connection: Any) -> str:
    return connection.client[0] if connection.client else ""


def _one_too_many(connections: Collection[Any], newest: BoundedHttp) -> BoundedHttp | BoundedSocket:
    """Return the connection that gives way.

    It is one of the host that has most: the one that has waited for a request for longest (`newest`
    perhaps); without one, the newest page. An answer under way goes on: then `newest` gives way,
    whatever its host.
    """
    hosts = Counter(_host(each) for each in connections)
    most = max(hosts, key=lambda host: (hosts[host], host == _host(newest)))
    of_host = [each for each in connections if _host(each) == most]
    waiting = [
        each for each in of_host if isinstance(each, BoundedHttp) and each.waits_since is not None
    ]
    if waiting:
        return min(waiting, key=lambda each: each.waits_since or 0.0)
    pages = [each for each in of_host if isinstance(each, BoundedSocket)]
    return max(pages, key=lambda each: each.opened_at, default=newest)


class QuietServer(uvicorn.Server):
    """uvicorn's server without signal handlers: the owner of the loop ends it."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.ready = asyncio.Event()
        """Set when it listens."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen, and say so."""
        await super().startup(sockets)
        self.ready.set()

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave signals alone."""
        yield


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens there. Raises OSError."""
    family, *_, where = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if family == socket.AF_INET6:
            listener.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
        listener.bind(where)
        listener.listen(_BACKLOG)
        listener.setblocking(False)
    except BaseException:
        listener.close()
        raise
    return listener


def server_for(app: Any, most_bytes: int) -> QuietServer:
    """Return a server for an application; messages of pages have at most so many bytes."""
    return QuietServer(
        uvicorn.Config(
            app,
            http=BoundedHttp,
            ws=BoundedSocket,
            ws_max_size=most_bytes,
            ws_per_message_deflate=False,
            ws_ping_interval=20.0,
            ws_ping_timeout=20.0,
            lifespan="off",
            log_config=None,
            log_level="error",
            access_log=False,
            proxy_headers=False,
            server_header=False,
            date_header=False,
            timeout_keep_alive=5,
            timeout_graceful_shutdown=2,
            h11_max_incomplete_event_size=16 * 1024,
        )
    )
