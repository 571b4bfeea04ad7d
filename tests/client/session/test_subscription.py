"""Subscriptions: samples, bounded queue, and setting up again."""

import asyncio
import struct
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from typing import Any

import pytest

from achse.ams import AmsAddress, ConnectionLost, DeviceError, TransmissionMode
from achse.ams.commands import AddNotificationRequest, DeleteNotificationRequest
from achse.client.session.raw import RawTarget
from achse.client.session.session import Backoff, Session
from achse.client.session.subscription import Sample, Subscription, Timing, VariableLocation
from achse.iec import UDINT

Run = Callable[[Any], Any]
ON_CHANGE = Timing.of(TransmissionMode.SERVER_ON_CHANGE, 0.0, 0.1)


@asynccontextmanager
async def target_of(peer: Any, **options: Any) -> AsyncIterator[RawTarget]:
    session = Session(peer, **{"keep_alive": None, **options})
    await session.open()
    try:
        yield RawTarget(session, AmsAddress("5.4.3.2.1.1:851"), 5.0)
    finally:
        await session.close()


def subscription(
    target: RawTarget, *offsets: int, timing: Timing = ON_CHANGE, depth: int = 100
) -> Subscription:
    """A subscription to values at 0x4020."""

    async def locate() -> Sequence[VariableLocation]:
        return [VariableLocation(f"v{offset}", 0x4020, offset, 4, UDINT) for offset in offsets]

    return Subscription(target, locate, timing, depth)


async def take(samples: Subscription, count: int) -> list[Sample]:
    return [await anext(samples) for _ in range(count)]


async def everything(samples: Subscription) -> list[Sample]:
    return [sample async for sample in samples]


def test_times_travel_in_100_ns() -> None:
    assert Timing.of(TransmissionMode.SERVER_CYCLE, 0.25, 0.001) == (3, 2_500_000, 10_000)


@pytest.mark.parametrize("seconds", [-0.1, 430.0, float("inf"), float("nan")])
def test_a_time_that_does_not_fit_is_refused(seconds: float) -> None:
    with pytest.raises(ValueError, match=r"0\.\.429\.4967295 s"):
        Timing.of(TransmissionMode.SERVER_CYCLE, 0.0, seconds)


def test_samples_come_in_order_with_value_and_time(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target, subscription(target, 0) as samples:
            assert peer.requests_of(AddNotificationRequest) == [(0x4020, 0, 4, 4, 0, 1_000_000)]
            peer.push((1, struct.pack("<I", 5)), filetime=116_444_736_000_000_000)
            first, second = await take(samples, 2)
            assert first == Sample("v0", 0x0403_0201, 133_000_000_000_000_000)
            assert second.value == 5
            assert second.time == datetime(1970, 1, 1, tzinfo=UTC)

    run(main())


def test_leaving_deletes_and_ends_the_iterator(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            async with subscription(target, 0) as samples:
                waiting = asyncio.create_task(everything(samples))
                await asyncio.sleep(1)
            assert [sample.value for sample in await waiting] == [0x0403_0201]
            assert peer.requests_of(DeleteNotificationRequest) == [(1,)]
            assert peer.notifications == {}
            assert await everything(samples) == []

    run(main())


def test_several_variables_share_one_queue(run: Run, peer: Any) -> None:
    async def main() -> None:
        peer.raw |= {(0x4020, n): bytes([n, 0, 0, 0]) for n in range(4)}
        async with target_of(peer) as target, subscription(target, 1, 2, 3) as samples:
            assert [(s.name, s.value) for s in await take(samples, 3)] == [
                ("v1", 1),
                ("v2", 2),
                ("v3", 3),
            ]
            assert len(peer.notifications) == 3

    run(main())


def test_a_slow_reader_loses_the_oldest_and_gets_a_report(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target, subscription(target, 0, depth=3) as samples:
            await take(samples, 1)
            for value in range(10):
                peer.push((1, struct.pack("<I", value)))
            got = await take(samples, 3)
            assert [(s.value, s.lost) for s in got] == [(7, 7), (8, 0), (9, 0)]
            assert samples.dropped == 7

    run(main())


def test_a_refused_variable_undoes_the_others(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            with pytest.raises(DeviceError, match="subscribe to v99"):
                async with subscription(target, 0, 99):
                    pass
            assert peer.notifications == {}

    run(main())


def test_a_cancelled_set_up_leaves_no_subscription_on_the_target(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            frames: list[Any] = []
            reply = peer.reply
            peer.reply = frames.append
            task = asyncio.create_task(subscription(target, 0).__aenter__())
            await asyncio.sleep(0.1)
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
            peer.reply = reply
            for frame in frames:
                reply(frame)
            peer.push((1, b"\0\0\0\0"))
            await asyncio.sleep(1)
            assert peer.notifications == {}

    run(main())


def test_after_a_loss_it_is_set_up_again_and_says_gap(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target, subscription(target, 0) as samples:
            await take(samples, 1)
            peer.lose()
            peer.raw[0x4020, 0] = b"\x09\0\0\0"
            sample = await anext(samples)
            assert (sample.value, sample.gap, samples.interruptions) == (9, True, 1)
            peer.push((2, b"\x0a\0\0\0"))
            assert await anext(samples) == sample._replace(value=10, gap=False)

    run(main())


def test_it_waits_for_a_device_that_comes_up_later(run: Run, peer: Any) -> None:
    async def main() -> None:
        every_second = Backoff(1.0, 1.0)
        async with (
            target_of(peer, backoff=every_second) as target,
            subscription(target, 0) as samples,
        ):
            await take(samples, 1)
            peer.error = 6
            peer.lose()
            await asyncio.sleep(5)
            peer.error = 0
            assert (await anext(samples)).gap

    run(main())


def test_a_variable_that_is_gone_for_good_ends_it_with_the_reason(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target, subscription(target, 0) as samples:
            await take(samples, 1)
            peer.raw.clear()
            peer.lose()
            with pytest.raises(DeviceError) as caught:
                await anext(samples)
            assert caught.value.code == 0x702

    run(main())


def test_a_sample_without_data_means_set_up_again(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target, subscription(target, 0) as samples:
            await take(samples, 1)
            peer.push((1, b""))
            assert (await anext(samples)).gap
            await asyncio.sleep(1)
            assert len(peer.requests_of(AddNotificationRequest)) == 2

    run(main())


def test_a_final_loss_raises_in_the_iterator(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer, backoff=None) as target, subscription(target, 0) as samples:
            await take(samples, 1)
            peer.lose()
            with pytest.raises(ConnectionLost, match="cut"):
                await anext(samples)

    run(main())


def test_what_came_before_the_end_is_still_given(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            async with subscription(target, 0) as samples:
                await asyncio.sleep(0)
            assert [sample.value for sample in await everything(samples)] == [0x0403_0201]

    run(main())


def test_a_cancelled_reader_loses_nothing(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target, subscription(target, 0) as samples:
            await take(samples, 1)
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(1):
                    await anext(samples)
            peer.push((1, b"\5\0\0\0"))
            assert (await anext(samples)).value == 5

    run(main())


def test_two_readers_at_once_are_refused(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target, subscription(target, 0) as samples:
            await take(samples, 1)
            waiting = asyncio.create_task(anext(samples))
            await asyncio.sleep(0)
            with pytest.raises(RuntimeError, match="another task waits"):
                await anext(samples)
            peer.push((1, b"\5\0\0\0"))
            assert (await waiting).value == 5

    run(main())


def test_a_queue_without_room_is_refused(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            with pytest.raises(ValueError, match="at least 1"):
                subscription(target, 0, depth=0)

    run(main())


def test_subscription_that_is_not_set_up_cannot_be_iterated(run: Run, peer: Any) -> None:
    async def main() -> None:
        async with target_of(peer) as target:
            with pytest.raises(RuntimeError, match=r"not set up: `async with target\.subscribe"):
                await anext(subscription(target, 0))

    run(main())
