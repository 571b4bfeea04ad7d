"""Samples ahead: clients get what they get of samples one by one."""

from collections.abc import Callable, MutableSequence, Sequence
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import Frame, TransmissionMode
from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out
from achse.native.memory import Rows, RowView
from achse.server import ClientLimits
from achse.server.ahead import SamplesAhead
from achse.server.notifications import Notifications

pytest.importorskip("llvmlite")

MS = 1_000_000
START = 1_800_000_000_000_000_000
CHANGE, CYCLE = TransmissionMode.SERVER_ON_CHANGE, TransmissionMode.SERVER_CYCLE


class Words:
    first: int = 0
    second: int = 0
    third: int = 0


WORDS = lay_out("Words", [Words], Slot)


def step(words: MutableSequence[int], first: int, second: int, third: int) -> None:
    """Change each word once in so many steps; 0 for never."""
    words[3] += 1
    if first > 0 and words[3] % first == 0:
        words[0] = words[0] * 3 + 1 & 0xFFFF_FFFF_FFFF
    if second > 0 and words[3] % second == 0:
        words[1] = words[1] * 3 + 1 & 0xFFFF_FFFF_FFFF
    if third > 0 and words[3] % third == 0:
        words[2] = words[2] * 3 + 1 & 0xFFFF_FFFF_FFFF


STEP = Kernel("step-of-words", step, {})


class Connection:
    """A client's connection that keeps what comes."""

    def __init__(self, room: int) -> None:
        self.room = room
        self.came = b""

    def deliver(self, frame: Frame) -> bool:
        self.came += frame.encode_tcp()
        return True

    def room_for_notifications(self) -> int:
        return self.room

    def put(self, packets: Sequence[bytes], size: int) -> None:
        self.came += b"".join(packets)


class Way:
    """A router that only delivers."""

    def __init__(self) -> None:
        self.attended = False

    def deliver(self, frame: Frame) -> bool:
        assert frame.via is not None
        return frame.via.deliver(frame)

    def reaches(self, address: bytes) -> bool:
        return True


class World:
    """A device with three words, and clients that watch them."""

    def __init__(self, clients: int, room: int = 1 << 18) -> None:
        self.now = 0
        rows = Rows(WORDS, 2)
        self.view = RowView(rows, 0)
        self.words: Any = rows.memory.cast("q")
        self.notifications = Notifications(
            lambda: START + self.now, lambda context: 10 * MS, ClientLimits()
        )
        self.notifications.share(self.notifications.usage, lambda: START)
        self.notifications.sender = Way()
        self.connections = [Connection(room) for _ in range(clients)]
        self.place = rows.address

    def subscribe(self, client: int, name: str, size: int, **changed: Any) -> int:
        settings = {"mode": CHANGE, "max_delay": 0, "cycle_time": 100_000} | changed
        via = settings.pop("via", self.connections[client])
        return self.notifications.add(
            *(bytes([client] * 8), b"\1" * 8, via),
            self.view.place(WORDS.fields[name], size),  # type: ignore[arg-type]
            size,
            **settings,
        )

    def pass_time(self, moments: int, change: Callable[[], object]) -> None:
        """Take samples one by one."""
        for _ in range(moments):
            self.now += 10 * MS
            change()
            self.notifications.tick(self.now)
            self.notifications.usage.budget.serve(self.now)

    def run_ahead(self, moments: int, cycles: tuple[int, ...]) -> int:
        """Take samples by machine code; how many moments, 0 if it cannot."""
        ahead = SamplesAhead([self.notifications])
        samples = ahead.next_samples(self.now + moments * 10 * MS)
        if samples is None:
            return 0
        source, due_ns, cycle_ns = samples
        assert (source, due_ns, cycle_ns) == (self.notifications, self.now + 10 * MS, 10 * MS)
        done = ahead.run(source, START + due_ns, moments, STEP.bind(self.place, 6, *cycles))
        self.now += done * 10 * MS
        return done


SUBSCRIPTIONS = st.lists(
    st.tuples(st.integers(0, 1), st.sampled_from(["first", "second", "third"]), st.integers(1, 8)),
    min_size=1,
    max_size=8,
)
CYCLES = st.tuples(*[st.integers(0, 4)] * 3)


@given(SUBSCRIPTIONS, CYCLES, st.lists(st.integers(1, 40), min_size=1, max_size=4))
def test_clients_get_the_same_as_one_by_one(
    subscriptions: list[tuple[int, str, int]], cycles: tuple[int, ...], runs: list[int]
) -> None:
    worlds = [World(2), World(2, room=400)]
    for each in worlds:
        for client, name, size in subscriptions:
            each.subscribe(client, name, size)
        each.notifications.send_first()
        each.pass_time(3, lambda words=each.words: step(words, *cycles))  # type: ignore[misc]
    slow, fast = worlds
    for moments in runs:
        slow.pass_time(moments, lambda: step(slow.words, *cycles))
        while moments:
            done = fast.run_ahead(moments, cycles)
            assert 1 <= done <= moments
            moments -= done
        assert [each.came for each in fast.connections] == [each.came for each in slow.connections]
        assert list(fast.words) == list(slow.words)
        for world in worlds:  # now and then one by one
            world.pass_time(1, lambda words=world.words: step(words, *cycles))  # type: ignore[misc]
    ends = [
        (
            each.notifications.due_ns,
            each.notifications.usage.budget.remaining,
            each.notifications.queued,
        )
        for each in worlds
    ]
    assert ends[0] == ends[1]
    assert [each.came for each in fast.connections] == [each.came for each in slow.connections]


@pytest.mark.parametrize(
    "other",
    [
        {"mode": CYCLE},
        {"max_delay": 500_000},
        {"cycle_time": 200_000},
        {"via": None},
    ],
    ids=str,
)
def test_what_machine_code_cannot_do_is_left_to_others(other: dict[str, Any]) -> None:
    world = World(1)
    world.subscribe(0, "first", 8)
    world.notifications.send_first()
    world.pass_time(3, lambda: None)
    assert world.run_ahead(5, (1, 0, 0)) == 5
    handle = world.subscribe(0, "second", 8, **other)
    world.notifications.send_first()
    world.pass_time(4, lambda: None)
    assert world.run_ahead(5, (1, 0, 0)) == 0
    world.notifications.delete(handle, bytes(8))
    world.pass_time(4, lambda: None)
    assert world.run_ahead(5, (1, 0, 0)) == 5


def test_nothing_is_taken_ahead_where_frames_are_seen_or_kept_back() -> None:
    world = World(1)
    world.subscribe(0, "first", 8)
    assert world.run_ahead(5, (1, 0, 0)) == 0
    world.notifications.send_first()
    world.pass_time(3, lambda: None)
    way: Any = world.notifications.sender
    way.attended = True
    assert world.run_ahead(5, (1, 0, 0)) == 0
    way.attended = False
    world.connections[0].room = 0
    assert world.run_ahead(5, (1, 0, 0)) == 0
    world.connections[0].room = 1000
    world.notifications.usage.budget.remaining = -1
    assert world.run_ahead(5, (1, 0, 0)) == 0
    world.notifications.usage.budget.remaining = 100
    assert world.run_ahead(5, (1, 0, 0)) == 5


def test_samples_of_two_devices_are_not_taken_ahead() -> None:
    worlds = [World(1), World(1)]
    for world in worlds:
        world.subscribe(0, "first", 8)
        world.notifications.send_first()
        world.pass_time(3, lambda: None)
    ahead = SamplesAhead([each.notifications for each in worlds])
    assert ahead.next_samples(100 * MS) is None
    worlds[0].pass_time(9, lambda: None)
    assert ahead.next_samples(100 * MS) == (worlds[1].notifications, 40 * MS, 10 * MS)
