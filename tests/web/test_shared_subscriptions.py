"""Shared subscriptions: one for all pages that watch the same topic."""

import asyncio
import json

import pytest

from achse.ams import DeviceError
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right
from achse.web.arguments import Arguments
from achse.web.messages import CallError
from achse.web.send_queue import PageSendQueue
from achse.web.shared_subscriptions import (
    MOST_SUBSCRIPTIONS,
    SharedSubscription,
    SharedSubscriptions,
    Topic,
)


class Counted:
    """A topic that counts how often it looks, and how often it was started."""

    def __init__(self, fails: int = 0) -> None:
        self.started = self.looks = 0
        self.fails = fails

    async def run(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        self.started += 1
        while True:
            self.looks += 1
            if self.looks <= self.fails:
                raise DeviceError(0x706)
            subscription.show({"looks": self.looks // 10})
            await subscription.pause(1.0)


def pause(seconds: float) -> "asyncio.Future[None]":
    return asyncio.ensure_future(asyncio.sleep(0))


async def test_pages_with_the_same_wish_share_one_look() -> None:
    counted = Counted()
    subscriptions = SharedSubscriptions({"t": Topic(counted.run)}, pause)
    first, second = PageSendQueue(), PageSendQueue()
    subscription = subscriptions.watch(first, 1, {"topic": "t", "every": 1})
    await first.take()
    assert subscriptions.watch(second, 5, {"every": 1, "topic": "t"}) is subscription
    message = json.loads(await second.take())
    assert (message["watch"], message["value"]) == (5, {"looks": 0})
    assert counted.started == 1
    other = subscriptions.watch(second, 6, {"topic": "t", "every": 2})
    assert other is not subscription
    assert len(subscriptions) == 2
    subscriptions.unwatch(subscription, first, 1)
    assert subscription.watchers == 1
    subscriptions.unwatch(subscription, second, 5)
    subscriptions.unwatch(other, second, 6)
    assert len(subscriptions) == 0
    before = counted.looks
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert counted.looks == before


async def test_a_value_that_stays_is_sent_once() -> None:
    counted = Counted()
    subscriptions = SharedSubscriptions({"t": Topic(counted.run)}, pause)
    send_queue = PageSendQueue()
    subscriptions.watch(send_queue, 1, {"topic": "t"})
    values = [json.loads(await send_queue.take())["value"]["looks"] for _ in range(3)]
    assert values == sorted(set(values))
    assert counted.looks > 10
    subscriptions.close()


async def test_a_refusal_is_shown_and_the_target_queried_again() -> None:
    counted = Counted(fails=3)
    subscriptions = SharedSubscriptions({"t": Topic(counted.run)}, pause)
    send_queue = PageSendQueue()
    subscriptions.watch(send_queue, 1, {"topic": "t"})
    message = json.loads(await send_queue.take())
    assert message["value"] is None
    assert message["error"]["code"] == 0x706
    while json.loads(await send_queue.take())["value"] is None:
        pass
    assert counted.started == 4
    subscriptions.close()


async def test_who_comes_later_gets_the_lines_before() -> None:
    async def run(subscription: SharedSubscription, arguments: Arguments) -> None:
        subscription.show_lines(["a", "b"])
        await asyncio.Event().wait()

    subscriptions = SharedSubscriptions({"t": Topic(run, lines=True)}, pause)
    first, second = PageSendQueue(), PageSendQueue()
    subscriptions.watch(first, 1, {"topic": "t"})
    assert json.loads(await first.take())["value"] == ["a", "b"]
    subscriptions.watch(second, 1, {"topic": "t"})
    assert json.loads(await second.take())["value"] == ["a", "b"]
    subscriptions.close()


async def test_all_pages_together_watch_so_much() -> None:
    subscriptions = SharedSubscriptions({"t": Topic(Counted().run)}, pause)
    send_queue = PageSendQueue()
    for number in range(MOST_SUBSCRIPTIONS):
        subscriptions.watch(send_queue, number, {"topic": "t", "number": number})
    with pytest.raises(CallError, match="all pages together watch up to 256"):
        subscriptions.watch(send_queue, 1, {"topic": "t", "number": "more"})
    shared = subscriptions.watch(PageSendQueue(), 1, {"topic": "t", "number": 1})
    assert (len(subscriptions), shared.watchers) == (MOST_SUBSCRIPTIONS, 2)
    subscriptions.close()


async def test_an_unknown_topic_is_refused() -> None:
    subscriptions = SharedSubscriptions({"t": Topic(Counted().run)})
    with pytest.raises(CallError, match="topic: expected t, got 'x'"):
        subscriptions.watch(PageSendQueue(), 1, {"topic": "x"})


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
        subscriptions = SharedSubscriptions(topics, pause, rights)
        for name in topics:
            if name in allowed:
                subscriptions.watch(PageSendQueue(), 1, {"topic": name})
            else:
                with pytest.raises(DeviceError) as refusal:
                    subscriptions.watch(PageSendQueue(), 1, {"topic": name})
                assert refusal.value.code == 0x723
        subscriptions.close()
