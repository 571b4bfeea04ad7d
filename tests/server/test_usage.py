"""What clients hold of several devices counts together."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, DeviceError, Frame
from achse.server import ClientLimits, Usage
from achse.server.usage import host_share

MS = 1_000_000


class Way:
    """A connection that takes what it gets, or lets it wait."""

    def __init__(self, host: str = "") -> None:
        self.peer_host = host
        self.congested = False
        self.open = True
        self.frames: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return self.open


@pytest.fixture(scope="session")
def make_devices(make_bench: Callable[..., Any]) -> Callable[..., Any]:
    """Several devices that share one usage, each with its router and clock at the same time."""

    def make(limits: ClientLimits, count: int = 3) -> tuple[Usage, list[Any]]:
        usage = Usage(limits)
        benches = [make_bench(limits) for _ in range(count)]
        for bench in benches:
            bench.device.share(usage)
        return usage, benches

    return make


def test_limits_for_all_hold_for_all_devices(make_devices: Callable[..., Any]) -> None:
    usage, benches = make_devices(ClientLimits(all_notifications=5, all_handles=4))
    added = handles = 0
    for bench in benches:
        for _ in range(3):
            with suppress(DeviceError):
                bench.device.notifications.add(
                    bench.me, bench.address, None, lambda: b"x", 1, 3, 0, 0
                )
                added += 1
            handles += bench.exchange(0xF003, 0, 4, b"MAIN.nCounter")[0] == 0
    assert (added, usage.notifications) == (5, 5)
    assert (handles, usage.handles) == (4, 4)
    benches[0].device.end_clients()
    assert (usage.notifications, usage.handles) == (2, 1)


def test_too_much_kept_goes_where_most_is_kept_in_whatever_device(
    make_devices: Callable[..., Any],
) -> None:
    usage, benches = make_devices(ClientLimits(all_queue_bytes=2000), 2)
    ways = [Way(), Way()]
    for bench, way, length in zip(benches, ways, (4, 60), strict=True):
        way.congested = True
        bench.device.notifications.add(bench.me, bench.address, way, lambda: b"x", length, 3, 0, 0)
    for _ in range(30):
        for bench in benches:
            bench.tick(10)
        usage.budget.serve(benches[0].now)
        assert usage.queued <= 2000
    dropped = [bench.device.notifications.dropped for bench in benches]
    assert dropped[0] == 0
    assert dropped[1] > 0


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("add"), st.integers(0, 7), st.integers(1, 3000), st.integers(0, 5)),
        st.tuples(st.just("handle"), st.integers(0, 7), st.integers(1, 5)),
        st.tuples(st.just("close"), st.integers(0, 7)),
        st.tuples(st.just("client"), st.integers(0, 7)),
        st.tuples(st.sampled_from(("slow", "fast")), st.integers(0, 7)),
        st.tuples(st.just("change"), st.integers(0, 2)),
        st.tuples(st.just("restart"), st.integers(0, 2)),
        st.tuples(st.just("wait"), st.integers(1, 10)),
    ),
    max_size=40,
)


@given(
    steps=STEPS,
    limits=st.builds(
        ClientLimits,
        handles=st.integers(1, 20),
        all_handles=st.integers(1, 40),
        abandoned_handles=st.integers(0, 40),
        notifications=st.integers(1, 10),
        all_notifications=st.integers(1, 30),
        sample_bytes=st.integers(1, 3000),
        watched_bytes=st.integers(1, 5000),
        all_watched_bytes=st.integers(1, 20_000),
        queue_bytes=st.integers(100, 10_000),
        all_queue_bytes=st.integers(100, 30_000),
        samples=st.integers(50, 20_000),
    ),
)
def test_whatever_connections_do_no_sum_exceeds_its_limit_and_no_frame_goes_astray(
    make_devices: Callable[..., Any], steps: list[tuple[Any, ...]], limits: ClientLimits
) -> None:
    """Eight connections with four addresses between them (two share each) at three devices."""
    usage, benches = make_devices(limits)
    ways = [Way(f"10.0.0.{number % 3}") for number in range(8)]
    closed: list[Way] = []

    def address(number: int) -> AmsAddress:
        return AmsAddress(f"192.168.0.{number % 4}.1.1:30000")

    for step in steps:
        what, number = step[0], step[1]
        way = ways[number % 8]
        bench = benches[number % 3]
        notifications = bench.device.notifications
        match what:
            case "add":
                client, server = address(number), bench.address
                for delay in (0, 250_000):
                    with suppress(DeviceError):
                        notifications.add(
                            *(client, server, way, lambda: b"x", step[2], 3, delay),
                            step[3] * 100_000,
                        )
            case "handle":
                for _ in range(step[2]):
                    bench.exchange(
                        0xF003, 0, 4, b"MAIN.nCounter", source=address(number), origin=way
                    )
            case "close":
                closed.append(way)
                for each in benches:
                    each.router.close_way(way)
                way.frames.clear()
                ways[number % 8] = Way(way.peer_host)  # it comes back at its old address
            case "client":
                bench.device.end_client(address(number))
            case "slow" | "fast":
                way.congested = what == "slow"
            case "change":
                bench.device.symbols_changed()
            case "restart":
                bench.device.end_clients()
            case "wait":
                for _ in range(number):
                    for each in benches:
                        each.tick(10)
                    usage.budget.serve(benches[0].now)
        _check(usage, benches, limits)
        for each in benches:
            assert not {channel.via for channel in each.device.notifications.channels} & set(closed)
    assert all(not way.frames for way in closed)
    for bench in benches:
        bench.device.end_clients()
        bench.tick(1000)
    usage.budget.serve(benches[0].now)
    assert (usage.notifications, usage.handles, usage.watched, usage.queued) == (0, 0, 0, 0)
    assert (usage.abandoned_handles, len(usage.abandoned)) == (0, 0)
    assert usage.budget.waiting == 0 or usage.budget.left <= 0
    assert not usage.notifications_by_host
    assert not usage.handles_by_host


def _check(usage: Usage, benches: list[Any], limits: ClientLimits) -> None:
    everything = [bench.device.notifications for bench in benches]
    tables = [bench.device.symbols.handles for bench in benches]
    assert usage.handles == sum(map(len, tables)) <= limits.all_handles
    assert usage.abandoned_handles <= limits.abandoned_handles
    assert usage.notifications == sum(len(each._subscriptions) for each in everything)
    assert usage.notifications <= limits.all_notifications
    by_host: dict[str, int] = {}
    for each in everything:
        for channel in each.channels:
            host = channel.via.peer_host
            by_host[host] = by_host.get(host, 0) + len(channel.subscriptions)
    for host, count in by_host.items():
        assert usage.notifications_by_host[host] == count <= host_share(limits.all_notifications)
        assert usage.handles_by_host[host] <= host_share(limits.all_handles)
    watched = sum(sum(each.sample_sizes) for each in everything)
    assert usage.watched == watched <= limits.all_watched_bytes
    buffered = sum(channel.buffered_bytes for each in everything for channel in each.channels)
    assert usage.queued == buffered <= limits.all_queue_bytes
    for each in everything:
        counted: dict[bytes, int] = {}
        for channel in each.channels:
            counted[channel.client] = counted.get(channel.client, 0) + len(channel.subscriptions)
            if not channel.batches or channel.congested:
                assert channel.queued <= limits.queue_bytes
        assert all(0 < count <= limits.notifications for count in counted.values())
        assert set(counted) == set(each.clients)
        for timer in each._timers.values():
            assert timer.cost == sum(group.cost for group in timer.groups)
            for group in timer.groups:
                members = (
                    *group.cyclic.subscriptions.values(),
                    *group.on_change.subscriptions.values(),
                )
                assert group.cost == 64 + sum(member.cost for member in members)
