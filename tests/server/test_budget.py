"""Who asks for more samples than there is time for gets them late; nobody else notices."""

from collections.abc import Callable
from itertools import chain
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Frame
from achse.ams.notification import NotificationStream
from achse.server import ClientLimits, SampleBudget

MS = 1_000_000
SECOND = 1_000_000_000
TICK_MS = 10
FRAME, CALL = 64, 8
"""Cost of a frame, and of a value that is computed, in samples."""


class Way:
    """A connection of a host; notes which handles came in which frame."""

    def __init__(self, host: str, number: int = 1) -> None:
        self.peer_host = host
        self.address = AmsAddress(f"{host}.1.1:{30_000 + number}")
        self.frames: list[Frame] = []
        self.count = 0

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return True

    def samples(self) -> int:
        """How many have come since the last call."""
        frames, self.frames = self.frames, []
        stamps = [stamp for f in frames for stamp in NotificationStream.decode(f.data).stamps]
        return sum(len(stamp.samples) for stamp in stamps)


def subscribe(bench: Any, way: Way, count: int, *, cycle_ms: int = 0, length: int = 1) -> None:
    notifications = bench.device.notifications
    for _ in range(count):
        cycle = cycle_ms * 10_000
        notifications.add(way.address, bench.address, way, lambda: b"x", length, 3, 0, cycle)
    notifications.send_first()
    way.frames.clear()


def test_what_comes_in_a_second_and_at_once() -> None:
    budget = SampleBudget(1000)
    assert budget.remaining == 20
    budget.remaining = 0
    budget.refill(0)
    budget.refill(5 * MS)
    assert budget.remaining == 5
    budget.refill(SECOND)
    assert budget.remaining == 995  # a tick as long as that gives what is due to it
    budget.refill(SECOND)
    assert budget.remaining == 995
    budget.refill(SECOND - MS)  # a clock that was set back
    assert budget.remaining == 995
    budget.refill(SECOND + MS)
    assert budget.remaining == 20


def test_a_station_behind_the_clock_samples_less_until_it_keeps_up() -> None:
    budget = SampleBudget(1000)
    budget.press(9 * MS)
    budget.press(10 * MS)
    assert budget.share == 1
    for _ in range(100):
        budget.press(11 * MS)
    assert budget.share == 0.1
    budget.remaining = 0
    budget.refill(0)
    budget.refill(SECOND)
    assert budget.remaining == 100
    budget.press(0)
    assert budget.share == pytest.approx(0.11)
    for _ in range(89):
        budget.press(0)
    assert budget.share == pytest.approx(1)
    for _ in range(9):
        budget.press(0)
    assert budget.share == 1


def test_a_client_that_requests_everything_delays_no_other(
    make_bench: Callable[..., Any], caplog: pytest.LogCaptureFixture
) -> None:
    """5,000 subscriptions at each cycle, of a fifth of which there is time."""
    bench = make_bench(ClientLimits(samples=1_000_000))
    greedy, modest = Way("10.0.0.1"), Way("10.0.0.2")
    subscribe(bench, greedy, 5_000)
    subscribe(bench, modest, 10)
    each_tick = []
    for _ in range(50):
        bench.tick(TICK_MS)
        assert modest.samples() == 10
        each_tick.append(greedy.samples())
    assert 1_000 <= sum(each_tick[10:]) / 40 <= 1_250
    assert bench.device.notifications.usage.budget.late > 0
    assert caplog.text.count("requests more samples") == 1
    assert f"{greedy.address} requests" in caplog.text


def test_connections_of_one_host_share_what_the_host_gets(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(samples=400_000))
    many = [Way("10.0.0.1", number) for number in range(50)]
    alone = Way("10.0.0.2")
    neighbour = Way("10.0.0.1", 99)
    for way in many:
        subscribe(bench, way, 200)
    subscribe(bench, alone, 10)
    subscribe(bench, neighbour, 1)
    for _ in range(10):
        bench.tick(TICK_MS)
    alone.samples()
    bench.tick(1000)
    assert 990 <= alone.samples() <= 1010
    counts = [way.samples() for way in many]
    assert max(counts) <= 2.5 * min(counts)
    assert neighbour.samples() > 10


class Sampled:
    """Notes which beats a budget samples, and when it sends them."""

    def __init__(self, per_second: int = 1000) -> None:
        self.budget = SampleBudget(per_second)
        self.budget.remaining = 0
        self.names: list[str] = []
        self.sent: list[int] = []

    def sample(self, group: Any) -> int:
        self.names.append(group.name)
        return int(group.cost)

    def send(self, now: int) -> None:
        self.sent.append(now)

    def put(
        self, name: str, via: Any = None, *, client: str = "", cost: int = 10, count: int = 1
    ) -> list[Any]:
        channel = SimpleNamespace(client=(client or name).encode(), via=via, reader={})
        batch = SimpleNamespace(channel=channel)
        groups = [
            SimpleNamespace(name=name, cost=cost, samples=3, batch=batch, waits=False)
            for _ in range(count)
        ]
        for group in groups:
            self.budget.put(self, group)  # type: ignore[arg-type]
        return groups

    def serve(self, left: int, now: int = 0) -> str:
        """Serve so many samples; the names of the beats that were sampled."""
        self.names.clear()
        self.budget.remaining = left
        self.budget.serve(now)
        return "".join(self.names)


def test_hosts_clients_of_this_process_and_connections_take_turns() -> None:
    sampled = Sampled()
    connections = [Way("10.0.0.1") for _ in range(2)]
    sampled.put("a", count=3)
    sampled.put("b", count=3)
    sampled.put("x", connections[0], count=2)
    sampled.put("x", connections[0], count=1)
    sampled.put("y", connections[1], count=2)
    assert sampled.serve(1000) == "abxabyabxyx"
    assert sampled.budget.waiting == 0
    assert sampled.budget._hosts == {}
    assert sampled.sent == [0]


def test_connections_of_one_client_address_take_turns() -> None:
    sampled = Sampled()
    connections = [Way("10.0.0.1") for _ in range(2)]
    sampled.put("a", connections[0], client="x", count=2)
    sampled.put("b", connections[1], client="x")
    assert sampled.serve(1000) == "aba"


@pytest.mark.parametrize(("left", "served"), [(0, ""), (1, "a"), (10, "a"), (11, "ab")])
def test_beat_is_sampled_while_anything_is_left(left: int, served: str) -> None:
    sampled = Sampled()
    for name in "abc":
        sampled.put(name)
    assert sampled.serve(left) == served
    assert sampled.budget.remaining == left - 10 * len(served)
    assert sampled.budget.waiting == 3 - len(served)


def test_budget_grows_before_it_is_spent() -> None:
    sampled = Sampled()
    sampled.serve(0)
    sampled.put("a")
    assert sampled.serve(0, MS) == "a"
    assert sampled.sent == [MS]


def test_beat_that_waits_is_late_and_the_log_says_so_each_minute(
    caplog: pytest.LogCaptureFixture,
) -> None:
    sampled = Sampled()
    groups = sampled.put("client 8")
    for now, count in ((None, 1), (60 * SECOND - 1, 1), (60 * SECOND, 2), (120 * SECOND - 1, 2)):
        if now is not None:
            sampled.budget.refill(now)
        sampled.budget.put(sampled, groups[0])  # type: ignore[arg-type]
        assert caplog.text.count("requests more samples") == count
    assert sampled.budget.late == 4 * 3
    assert sampled.budget.waiting == 1


def test_host_that_was_served_is_forgotten_when_the_others_have_got_as_much() -> None:
    sampled = Sampled()
    sampled.put("a")
    sampled.put("b", count=3)
    assert sampled.serve(1) == "a"
    assert sampled.budget._hosts.keys() == {b"a", b"b"}
    assert sampled.serve(1) == "b"
    assert sampled.budget._hosts.keys() == {b"a", b"b"}
    assert sampled.serve(1) == "b"
    assert sampled.budget._hosts.keys() == {b"b"}


@pytest.mark.parametrize(("count", "is_forgotten"), [(66, False), (67, True)])
def test_connections_that_were_served_are_forgotten_when_they_are_many(
    count: int, is_forgotten: bool
) -> None:
    """One has got more than the others, one waits; 66 are more than twice those that wait by 64."""
    sampled = Sampled()
    connections = [Way("10.0.0.1") for _ in range(count)]
    sampled.put("a", connections[0], cost=50)
    for connection in connections[1:-1]:
        sampled.put("x", connection)
    sampled.put("z", connections[-1], count=3)
    while sampled.budget.waiting > 1:
        sampled.serve(1)
    [host] = sampled.budget._hosts.values()
    assert len(host.connections) == (2 if is_forgotten else count)
    assert {id(connections[0]), id(connections[-1])} <= {
        id(connection) for connection in host.connections
    }


def test_connections_that_wait_or_have_got_more_than_others_are_not_forgotten() -> None:
    """Ten new connections, nine of which are served at once, beside 66 older ones."""
    sampled = Sampled()
    old, new = ([Way("10.0.0.1") for _ in range(count)] for count in (66, 10))
    for connection in old[1:]:
        sampled.put("x", connection)
    sampled.put("y", old[0], count=3)
    assert sampled.serve(670) == "x" * 65 + "yy"
    [host] = sampled.budget._hosts.values()
    assert len(host.connections) == 66
    for connection in new:
        sampled.put("z", connection)
    assert sampled.serve(90) == "z" * 9
    assert host.connections.keys() == {old[0], *new}


@settings(max_examples=13)
@given(
    per_second=st.integers(20_000, 400_000),
    hosts=st.lists(
        st.lists(
            st.tuples(st.integers(1, 60), st.sampled_from((0, 10, 20, 50)), st.integers(1, 1000)),
            min_size=1,
            max_size=3,
        ),
        min_size=1,
        max_size=4,
    ),
)
def test_in_any_mix_the_budget_holds_and_clients_within_their_share_miss_nothing(
    make_bench: Callable[..., Any],
    per_second: int,
    hosts: list[list[tuple[int, int, int]]],
) -> None:
    """Connections of hosts, each with a number of subscriptions, a cycle and a size."""
    bench = make_bench(ClientLimits(samples=per_second))
    notifications = bench.device.notifications
    budget = notifications.usage.budget
    ways: list[tuple[Way, float, bool]] = []
    groups: list[int] = []
    for number, connections in enumerate(hosts):
        for connection, (count, cycle, length) in enumerate(connections):
            way = Way(f"10.0.0.{number}", connection)
            subscribe(bench, way, count, cycle_ms=cycle, length=length)
            cost = FRAME + count * (CALL + length // 256)
            groups.append(cost)
            rate = 1000 / max(cycle, TICK_MS)
            share = per_second / len(hosts) / len(connections)
            ways.append((way, count * rate, cost * rate <= 0.9 * share))
    spent = 0
    for _ in range(100):
        bench.now += TICK_MS * MS
        before = budget.remaining
        notifications.tick(bench.now)
        gain = min(before + per_second // 100, per_second // 50)
        spent += gain - budget.remaining
        assert budget.remaining > -max(groups)
        assert budget.waiting <= sum(len(timer.groups) for timer in notifications._timers.values())
    assert spent <= per_second + per_second // 50 + max(groups)
    patient = max(groups) <= per_second / 100 / len(hosts) / max(map(len, hosts))
    for (way, wanted, is_modest), (count, _, _) in zip(ways, chain(*hosts), strict=True):
        came = way.samples()
        assert came <= wanted + count
        if is_modest and patient:
            assert came >= wanted - 4 * count


@given(
    st.integers(1, 10_000),
    st.integers(1, 1000),
    st.integers(1, 50),
    st.integers(-20, 400),
    st.floats(0.1, 1.0),
    st.integers(1, 30),
)
def test_even_costs_are_taken_at_once_as_one_by_one(
    per_second: int, cost: int, cycle_ms: int, left: int, share: float, count: int
) -> None:
    """Where the budget lasts for all of them."""
    single, together = SampleBudget(per_second), SampleBudget(per_second)
    for each in (single, together):
        each.refill(SECOND)
        each.share, each.remaining = share, min(left, per_second // 50)
    cycle_ns = cycle_ms * MS
    covered = together.covers(cost, SECOND + cycle_ns, cycle_ns)
    assert not together.covers(cost, SECOND + cycle_ns + 1, cycle_ns)
    lasts = single.remaining >= 0
    for n in range(1, count + 1):
        single.refill(SECOND + n * cycle_ns)
        lasts &= cost <= single.remaining
        single.remaining -= cost
    assert lasts or not covered
    if covered:
        together.take_evenly(cost, cycle_ns, count)
        assert together.remaining == single.remaining
        assert together.covers(cost, SECOND + (count + 1) * cycle_ns, cycle_ns)


def test_budget_covers_what_each_cycle_gives() -> None:
    budget = SampleBudget(1000)
    budget.refill(SECOND)
    assert budget.covers(1, SECOND + MS, MS)
    assert not budget.covers(2, SECOND + MS, MS)
