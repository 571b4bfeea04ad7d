"""Shared subscriptions: pages that watch the same topic have one subscription at the station."""

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, NamedTuple

from achse.ams import AdsError, DeviceError
from achse.codes import ReturnCode
from achse.router.rights import ALL_RIGHTS, Right
from achse.web.arguments import Arguments
from achse.web.messages import CallError, dumped, error_of
from achse.web.send_queue import PageSendQueue

log = logging.getLogger("achse.web")

Pause = Callable[[float], Awaitable[Any]]
"""Function that waits for seconds; tests pass their own."""

MOST_SUBSCRIPTIONS = 256
"""Subscriptions of all pages; pages that watch the same topic share one."""

_AGAIN = 1.0
"""Seconds until the next request to a target that refused."""

_KEPT_LINES = 500
"""Earlier lines for a page that begins to watch later than others."""


class Topic(NamedTuple):
    """Subject that pages can watch."""

    run: "Callable[[SharedSubscription, Arguments], Awaitable[None]]"
    """Function that shows values until it is cancelled."""
    lines: bool = False
    """True if each value counts (a log), not only the newest (a state)."""
    needs: Right = Right.READ
    """Right that the station must grant, even to pages that may only look."""


class SharedSubscription:
    """One running topic and the pages that watch it."""

    def __init__(self, name: str, topic: Topic, arguments: Arguments, pause: Pause) -> None:
        self.name = name
        self.pause = pause
        self._topic = topic
        self._arguments = arguments
        self._watchers: dict[tuple[PageSendQueue, int], None] = {}
        self._newest = ""
        self._history: deque[str] = deque(maxlen=_KEPT_LINES)
        self._task: asyncio.Task[None] | None = None

    @property
    def watchers(self) -> int:
        """Number of pages that watch."""
        return len(self._watchers)

    def add(self, send_queue: PageSendQueue, watch: int) -> None:
        """Add a page: it gets the newest value or earlier lines at once, and all that follow."""
        self._watchers[send_queue, watch] = None
        if self._newest:
            send_queue.put_state(watch, self._newest)
        if self._history:
            send_queue.put_lines(watch, list(self._history))
        if self._task is None:
            self._task = asyncio.create_task(self._run())

    def remove(self, send_queue: PageSendQueue, watch: int) -> None:
        """Remove a page."""
        self._watchers.pop((send_queue, watch), None)

    def close(self) -> None:
        """End the subscription."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def show(self, value: Any) -> None:
        """Send the value of a state to all pages, unless they have it."""
        self._send(f'"value":{dumped(value)}')

    def show_lines(self, lines: list[Any]) -> None:
        """Send lines to all pages, and keep them for later ones."""
        if self._newest:  # the error has ended
            self._newest = ""
        texts = [dumped(line) for line in lines]
        self._history.extend(texts)
        for send_queue, watch in self._watchers:
            send_queue.put_lines(watch, texts)

    def _send(self, fields: str) -> None:
        if fields == self._newest:
            return
        self._newest = fields
        for send_queue, watch in self._watchers:
            send_queue.put_state(watch, fields)

    async def _run(self) -> None:
        while True:
            try:
                await self._topic.run(self, self._arguments)
                return
            except (AdsError, CallError, ValueError) as failure:
                self._send(f'"value":null,"error":{dumped(error_of(failure))}')
            except Exception as failure:
                log.exception("watching %s", self.name)
                self._send(f'"value":null,"error":{dumped(error_of(failure))}')
            await self.pause(_AGAIN)


class SharedSubscriptions:
    """Subscriptions of all pages of a server."""

    def __init__(
        self,
        topics: Mapping[str, Topic],
        pause: Pause = asyncio.sleep,
        rights: Right = ALL_RIGHTS,
    ) -> None:
        self._topics = topics
        self._rights = rights
        self._pause = pause
        self._running: dict[str, SharedSubscription] = {}

    def __len__(self) -> int:
        return len(self._running)

    def watch(
        self, send_queue: PageSendQueue, watch: int, fields: dict[str, Any]
    ) -> SharedSubscription:
        """Return the subscription to a topic, with the page among its watchers.

        Raises CallError for an unknown topic, DeviceError 0x723 for one without the right to it.
        """
        name = Arguments(fields).text("topic")
        topic = self._topics.get(name)
        if topic is None:
            raise CallError(f"topic: expected {', '.join(sorted(self._topics))}, got {name!r:.60}")
        if topic.needs & ~self._rights:
            raise DeviceError(ReturnCode.DEVICE_ACCESS_DENIED, f"{name}: not on this page")
        key = dumped(dict(sorted(fields.items())))
        subscription = self._running.get(key)
        if subscription is None:
            if len(self._running) >= MOST_SUBSCRIPTIONS:
                raise CallError(
                    f"all pages together watch up to {MOST_SUBSCRIPTIONS} different things"
                )
            subscription = self._running[key] = SharedSubscription(
                name, topic, Arguments(fields), self._pause
            )
        subscription.add(send_queue, watch)
        return subscription

    def unwatch(
        self, subscription: SharedSubscription, send_queue: PageSendQueue, watch: int
    ) -> None:
        """Remove a page from a subscription; one without pages ends."""
        subscription.remove(send_queue, watch)
        if not subscription.watchers:
            subscription.close()
            self._running = {
                key: each for key, each in self._running.items() if each is not subscription
            }

    def close(self) -> None:
        """End all subscriptions."""
        for subscription in self._running.values():
            subscription.close()
        self._running.clear()
