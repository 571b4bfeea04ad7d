"""Feeds: what is watched is asked for once, however many pages watch it."""

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
from achse.web.outbox import PageOutbox

__all__ = ["MOST_FEEDS", "Feed", "Feeds", "Pause", "Topic"]

log = logging.getLogger("achse.web")

Pause = Callable[[float], Awaitable[Any]]
"""Waits for seconds; tests hand in their own."""

MOST_FEEDS = 256
"""Of all pages: those that watch the same share one."""

_AGAIN = 1.0
"""Seconds until a target that refused is asked again."""

_KEPT_LINES = 500
"""Lines that a page gets which begins to watch later than others."""


class Topic(NamedTuple):
    """A kind of thing that can be watched."""

    run: "Callable[[Feed, Arguments], Awaitable[None]]"
    """Shows values until it is cancelled."""
    lines: bool = False
    """True if each value counts (a log), not only the newest (a state)."""
    needs: Right = Right.READ
    """Right that the station must grant, even to pages that may only look."""


class Feed:
    """One running topic and the pages that watch it."""

    def __init__(self, name: str, topic: Topic, given: Arguments, pause: Pause) -> None:
        self.name = name
        self.pause = pause
        self._topic = topic
        self._given = given
        self._watchers: dict[tuple[PageOutbox, int], None] = {}
        self._newest = ""
        self._history: deque[str] = deque(maxlen=_KEPT_LINES)
        self._task: asyncio.Task[None] | None = None

    @property
    def watchers(self) -> int:
        """Number of pages that watch."""
        return len(self._watchers)

    def add(self, outbox: PageOutbox, watch: int) -> None:
        """Show everything to a page from now on, and at once what is known already."""
        self._watchers[outbox, watch] = None
        if self._newest:
            outbox.put_state(watch, self._newest)
        if self._history:
            outbox.put_lines(watch, list(self._history))
        if self._task is None:
            self._task = asyncio.create_task(self._go())

    def remove(self, outbox: PageOutbox, watch: int) -> None:
        """A page watches no longer."""
        self._watchers.pop((outbox, watch), None)

    def close(self) -> None:
        """End."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def show(self, value: Any) -> None:
        """A new value of a state; one that is the same is not sent again."""
        self._say(f'"value":{dumped(value)}')

    def show_lines(self, lines: list[Any]) -> None:
        """New lines."""
        if self._newest:  # an error is over
            self._newest = ""
        texts = [dumped(line) for line in lines]
        self._history.extend(texts)
        for outbox, watch in self._watchers:
            outbox.put_lines(watch, texts)

    def _say(self, fields: str) -> None:
        if fields == self._newest:
            return
        self._newest = fields
        for outbox, watch in self._watchers:
            outbox.put_state(watch, fields)

    async def _go(self) -> None:
        while True:
            try:
                await self._topic.run(self, self._given)
                return
            except (AdsError, CallError, ValueError) as failure:
                self._say(f'"value":null,"error":{dumped(error_of(failure))}')
            except Exception as failure:
                log.exception("watching %s", self.name)
                self._say(f'"value":null,"error":{dumped(error_of(failure))}')
            await self.pause(_AGAIN)


class Feeds:
    """The feeds of all pages of a server."""

    def __init__(
        self,
        topics: Mapping[str, Topic],
        pause: Pause = asyncio.sleep,
        rights: Right = ALL_RIGHTS,
    ) -> None:
        self._topics = topics
        self._rights = rights
        self._pause = pause
        self._running: dict[str, Feed] = {}

    def __len__(self) -> int:
        return len(self._running)

    def watch(self, outbox: PageOutbox, watch: int, fields: dict[str, Any]) -> Feed:
        """The feed that shows what was asked for; a page is one of its watchers from now on.

        Raises CallError for an unknown topic, DeviceError 0x723 for one without the right to it.
        """
        name = Arguments(fields).text("topic")
        topic = self._topics.get(name)
        if topic is None:
            raise CallError(f"topic: expected {', '.join(sorted(self._topics))}, got {name!r:.60}")
        if topic.needs & ~self._rights:
            raise DeviceError(ReturnCode.DEVICE_ACCESS_DENIED, f"{name}: not on this page")
        wish = dumped(dict(sorted(fields.items())))
        feed = self._running.get(wish)
        if feed is None:
            if len(self._running) >= MOST_FEEDS:
                raise CallError(f"all pages together watch up to {MOST_FEEDS} different things")
            feed = self._running[wish] = Feed(name, topic, Arguments(fields), self._pause)
        feed.add(outbox, watch)
        return feed

    def unwatch(self, feed: Feed, outbox: PageOutbox, watch: int) -> None:
        """A page watches no longer; a feed without pages ends."""
        feed.remove(outbox, watch)
        if not feed.watchers:
            feed.close()
            self._running = {key: each for key, each in self._running.items() if each is not feed}

    def close(self) -> None:
        """End all."""
        for feed in self._running.values():
            feed.close()
        self._running.clear()
