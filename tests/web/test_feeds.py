"""Feeds: one look for all who watch the same."""

import asyncio
import json

import pytest

from achse.ams import DeviceError
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right
from achse.web.arguments import Arguments
from achse.web.feeds import MOST_FEEDS, Feed, Feeds, Topic
from achse.web.messages import CallError
from achse.web.outbox import PageOutbox


class Counted:
    """A topic that counts how often it looks, and how often it was started."""

    def __init__(self, fails: int = 0) -> None:
        self.started = self.looks = 0
        self.fails = fails

    async def run(self, feed: Feed, given: Arguments) -> None:
        self.started += 1
        while True:
            self.looks += 1
            if self.looks <= self.fails:
                raise DeviceError(0x706)
            feed.show({"looks": self.looks // 10})
            await feed.pause(1.0)


def pause(seconds: float) -> "asyncio.Future[None]":
    return asyncio.ensure_future(asyncio.sleep(0))


async def test_pages_with_the_same_wish_share_one_look() -> None:
    counted = Counted()
    feeds = Feeds({"t": Topic(counted.run)}, pause)
    first, second = PageOutbox(), PageOutbox()
    feed = feeds.watch(first, 1, {"topic": "t", "every": 1})
    await first.take()
    assert feeds.watch(second, 5, {"every": 1, "topic": "t"}) is feed
    message = json.loads(await second.take())
    assert (message["watch"], message["value"]) == (5, {"looks": 0})
    assert counted.started == 1
    other = feeds.watch(second, 6, {"topic": "t", "every": 2})
    assert other is not feed
    assert len(feeds) == 2
    feeds.unwatch(feed, first, 1)
    assert feed.watchers == 1
    feeds.unwatch(feed, second, 5)
    feeds.unwatch(other, second, 6)
    assert len(feeds) == 0
    before = counted.looks
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert counted.looks == before


async def test_a_value_that_stays_is_sent_once() -> None:
    counted = Counted()
    feeds = Feeds({"t": Topic(counted.run)}, pause)
    outbox = PageOutbox()
    feeds.watch(outbox, 1, {"topic": "t"})
    values = [json.loads(await outbox.take())["value"]["looks"] for _ in range(3)]
    assert values == sorted(set(values))
    assert counted.looks > 10
    feeds.close()


async def test_a_refusal_is_shown_and_the_target_asked_again() -> None:
    counted = Counted(fails=3)
    feeds = Feeds({"t": Topic(counted.run)}, pause)
    outbox = PageOutbox()
    feeds.watch(outbox, 1, {"topic": "t"})
    message = json.loads(await outbox.take())
    assert message["value"] is None
    assert message["error"]["code"] == 0x706
    while json.loads(await outbox.take())["value"] is None:
        pass
    assert counted.started == 4
    feeds.close()


async def test_who_comes_later_gets_the_lines_before() -> None:
    async def run(feed: Feed, given: Arguments) -> None:
        feed.show_lines(["a", "b"])
        await asyncio.Event().wait()

    feeds = Feeds({"t": Topic(run, lines=True)}, pause)
    first, second = PageOutbox(), PageOutbox()
    feeds.watch(first, 1, {"topic": "t"})
    assert json.loads(await first.take())["value"] == ["a", "b"]
    feeds.watch(second, 1, {"topic": "t"})
    assert json.loads(await second.take())["value"] == ["a", "b"]
    feeds.close()


async def test_all_pages_together_watch_so_much() -> None:
    feeds = Feeds({"t": Topic(Counted().run)}, pause)
    outbox = PageOutbox()
    for number in range(MOST_FEEDS):
        feeds.watch(outbox, number, {"topic": "t", "number": number})
    with pytest.raises(CallError, match="all pages together watch up to 256"):
        feeds.watch(outbox, 1, {"topic": "t", "number": "more"})
    shared = feeds.watch(PageOutbox(), 1, {"topic": "t", "number": 1})
    assert (len(feeds), shared.watchers) == (MOST_FEEDS, 2)
    feeds.close()


async def test_an_unknown_topic_is_refused() -> None:
    feeds = Feeds({"t": Topic(Counted().run)})
    with pytest.raises(CallError, match="topic: expected t, got 'x'"):
        feeds.watch(PageOutbox(), 1, {"topic": "x"})


async def test_a_topic_needs_what_the_station_allows() -> None:
    counted = Counted()
    topics = {"t": Topic(counted.run), "all": Topic(counted.run, needs=ALL_RIGHTS)}
    for rights, allowed in (
        (NO_RIGHTS, []),
        (Right.WRITE, []),
        (Right.READ, ["t"]),
        (ALL_RIGHTS & ~Right.FILES, ["t"]),
        (ALL_RIGHTS, ["t", "all"]),
    ):
        feeds = Feeds(topics, pause, rights)
        for name in topics:
            if name in allowed:
                feeds.watch(PageOutbox(), 1, {"topic": name})
            else:
                with pytest.raises(DeviceError) as refusal:
                    feeds.watch(PageOutbox(), 1, {"topic": name})
                assert refusal.value.code == 0x723
        feeds.close()
