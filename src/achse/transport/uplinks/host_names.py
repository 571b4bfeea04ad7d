"""Host names of routes, looked up beside the loop: a sender's address is compared with them.

A look-up may take seconds, or hang; a thread of its own does it, and no caller waits for it.
"""

import asyncio
import logging
import queue
import socket
import threading
from collections.abc import Callable, Sequence

from achse.router.routes import Route, RouteTable

log = logging.getLogger("achse.router")

_AGAIN = 60.0
"""Seconds after which every name is looked up again: addresses change."""

_SOONEST = 1.0
"""Seconds between two look-ups of a name that senders cause."""


def addresses_of(name: str) -> Sequence[str]:
    """Return the addresses that a host name has now; none if it is unknown. Waits."""
    try:
        entries = socket.getaddrinfo(name, None, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        return ()
    return sorted({str(entry[4][0]) for entry in entries})


class HostNames:
    """Updates the addresses of host names in `routes`, from `start` to `close`."""

    def __init__(
        self, routes: RouteTable, look_up: Callable[[str], Sequence[str]] = addresses_of
    ) -> None:
        self._routes = routes
        self._look_up = look_up
        self._loop: asyncio.AbstractEventLoop
        self._last_look_up: dict[str, float] = {}
        """Time of the last look-up of each name, loop time in s."""
        self._pending: dict[str, asyncio.Event] = {}
        self._queue: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._closed = False

    def start(self) -> None:
        """Look all names up, and from now on those that are added."""
        self._loop = asyncio.get_running_loop()
        self._routes.on_change(self._changed)
        self._routes.look_up = self._look_up_soon
        self._look_all_up()

    def close(self) -> None:
        """Look nothing up any more."""
        self._closed = True
        self._routes.ignore(self._changed)
        self._routes.look_up = _nothing
        if self._timer is not None:
            self._timer.cancel()
        self._queue.put(None)

    async def known(self, seconds: float) -> None:
        """Wait until each name was looked up once, at most so long."""
        events = [self._pending[name] for name in self._routes.host_names if name in self._pending]
        if not events:
            return
        try:
            async with asyncio.timeout(seconds):
                await asyncio.gather(*(event.wait() for event in events))
        except TimeoutError:
            log.debug("some host names of routes are not known yet")

    def _look_all_up(self) -> None:
        for name in self._routes.host_names:
            self._start_look_up(name)
        self._timer = self._loop.call_later(_AGAIN, self._look_all_up)

    def _changed(self, old: Route | None, new: Route | None) -> None:
        names = self._routes.host_names
        self._last_look_up = {name: at for name, at in self._last_look_up.items() if name in names}
        self._pending = {name: event for name, event in self._pending.items() if name in names}
        if (
            new is not None
            and (name := new.host_name) is not None
            and name not in self._last_look_up
        ):
            self._start_look_up(name)

    def _look_up_soon(self, name: str) -> None:
        if self._loop.time() - self._last_look_up.get(name, -_SOONEST) >= _SOONEST:
            self._start_look_up(name)

    def _start_look_up(self, name: str) -> None:
        self._last_look_up[name] = self._loop.time()
        self._pending.setdefault(name, asyncio.Event())
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="host names", daemon=True)
            self._thread.start()
        self._queue.put(name)

    def _work(self) -> None:
        while (name := self._queue.get()) is not None and not self._closed:
            addresses = self._look_up(name)
            try:
                self._loop.call_soon_threadsafe(self._locate, name, addresses)
            except RuntimeError:  # the loop has ended
                return

    def _locate(self, name: str, addresses: Sequence[str]) -> None:
        event = self._pending.get(name)
        if event is None or self._closed:
            return
        if not addresses:
            level = logging.DEBUG if event.is_set() else logging.WARNING
            log.log(level, "host %s of a route is unknown: its senders are refused", name)
        self._routes.locate(name, addresses)
        event.set()


def _nothing(_: str) -> None:
    """Look up no more names."""
