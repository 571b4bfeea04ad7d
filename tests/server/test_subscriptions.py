"""Sample group, batch and channel: the samples that they gather, and the bytes that they send."""

import struct
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.ams.filetime import from_unix_ns
from achse.ams.notification import NotificationStream
from achse.native.backend import compiler_installed
from achse.native.declare import Slot, lay_out
from achse.native.memory import MemoryCell, Rows
from achse.server.subscriptions import (
    Batch,
    Channel,
    NotificationHandle,
    SampleGroup,
    SampleTimer,
    Series,
    hint,
)

CLIENT = bytes(8)


@pytest.fixture
def channel() -> Channel:
    return Channel(CLIENT, b"\1" * 8, None)


@pytest.fixture
def batch(channel: Channel) -> Batch:
    return Batch(channel, 0)


def subscription(batch: Batch, values: list[bytes], length: int = 2) -> NotificationHandle:
    """One whose value is the last of `values`."""
    return NotificationHandle(7, CLIENT, batch, lambda: values[-1], values[-1], length, False)


def decoded(channel: Channel, size: int = 1000) -> list[Any]:
    frame = channel.frame(size)
    assert frame is not None
    stream = NotificationStream.decode(frame.data)
    return [(stamp.filetime, [tuple(sample) for sample in stamp.samples]) for stamp in stream[0]]


@pytest.mark.parametrize("value", [b"", b"a", b"ab", b"abc"])
def test_a_value_is_fitted_to_the_requested_length(batch: Batch, value: bytes) -> None:
    assert len(subscription(batch, [value]).fit(value)) == 2
    assert subscription(batch, [value]).last == value[:2].ljust(2, b"\0")


def test_a_beat_samples_all_cyclic_and_the_changed(batch: Batch) -> None:
    values = [b"ab"]
    group = SampleGroup(batch, (10, 10), SampleTimer((10, 0)))
    group.cyclic.add(subscription(batch, values))
    group.on_change.add(subscription(batch, values))
    group.sample()
    assert len(batch.parts) == 2
    values.append(b"cd")
    group.sample()
    assert batch.parts[2:] == [struct.pack("<II", 7, 2), b"cd"] * 2


def test_a_change_beyond_the_requested_length_is_none(batch: Batch) -> None:
    values = [b"abX"]
    group = SampleGroup(batch, (10, 10), SampleTimer((10, 0)))
    group.on_change.add(subscription(batch, values))
    values.append(b"abY")
    group.sample()
    assert batch.parts == []


class Words:
    first: int = 0
    second: int = 0
    third: int = 0


ROWS = Rows(lay_out("Words", [Words], Slot), 1)
MEMORY = ROWS.memory


class Failing:
    """Reads a byte of the memory; a value of 0 is none."""

    def __init__(self, at: int) -> None:
        self.at = at

    def __call__(self) -> bytes:
        if not MEMORY[self.at]:
            raise DeviceError(0x703)
        return bytes(MEMORY[self.at : self.at + 2])


def fixed(word: int, size: int) -> MemoryCell:
    """A place that machine code reads."""
    return MemoryCell(MEMORY, 8 * word, size, ROWS.address + 8 * word)


READERS = st.builds(Failing, st.integers(0, 20)) | st.builds(
    partial(MemoryCell, MEMORY), st.integers(0, 20), st.integers(0, 4)
)
if compiler_installed():
    READERS |= st.builds(fixed, st.integers(0, 2), st.integers(0, 8))


def one_by_one(
    members: dict[int, NotificationHandle], last: dict[int, Any], always: bool
) -> list[bytes]:
    """What a series has to send, from the definition of the modes."""
    parts = []
    for handle, member in members.items():
        before = last[handle]
        try:
            value = member.read()[: member.length].ljust(member.length, b"\0")
        except DeviceError:
            last[handle] = None
            if before is not None:
                parts += [struct.pack("<II", handle, 0), b""]
            continue
        last[handle] = value
        if always or value != before:
            parts += [struct.pack("<II", handle, len(value)), value]
    return parts


@given(st.booleans(), st.data())
def test_values_taken_together_are_sent_as_if_taken_one_by_one(
    on_change: bool, data: st.DataObject
) -> None:
    MEMORY[:] = bytes(range(24))
    batch = Batch(Channel(CLIENT, b"\1" * 8, None), 0)
    series, members, last = Series(on_change), {}, {}
    for handle in range(1, data.draw(st.integers(1, 30))):
        match data.draw(st.sampled_from(["add", "discard", "write", "sample", "sample"])):
            case "add":
                read, length = data.draw(READERS), data.draw(st.integers(0, 4))
                member = NotificationHandle(handle, CLIENT, batch, read, b"first", length, False)
                series.add(member)
                members[handle], last[handle] = member, member.last
            case "discard" if members:
                series.discard(members.pop(data.draw(st.sampled_from(list(members)))))
            case "write":
                MEMORY[data.draw(st.integers(0, 23))] = data.draw(st.integers(0, 2))
            case "sample" if members:
                batch.clear()
                series.sample(batch)
                expected = one_by_one(members, last, always=not on_change)
                assert b"".join(batch.parts) == b"".join(expected)
                assert batch.count == len(expected) // 2


def test_subscriptions_with_the_cycle_of_an_earlier_one_keep_time_with_it(bench: Any) -> None:
    """The first sample comes at once, the next when the client's others come, then each cycle."""
    other, other_address = bench.join()
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=100)
    bench.tick(30)
    bench.subscribe("MAIN.fixed", mode=3, cycle_ms=100, length=2)
    bench.subscribe("MAIN.fast", mode=3, cycle_ms=50)
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=100, source=other_address, origin=other)
    bench.tick(200)
    samples = bench.samples()
    by_handle = {n: [time for time, handle, _ in samples if handle == n] for n in (1, 2, 3)}
    assert by_handle == {1: [0, 100, 200], 2: [30, 100, 200], 3: [30, 80, 130, 180, 230]}
    assert [time for time, _, _ in bench.samples(other)] == [30, 130, 230]


def test_a_batch_stamps_and_releases(batch: Batch, channel: Channel) -> None:
    for time in (5, 6):
        batch.take(struct.pack("<II", time, 1), b"x")
        batch.close_stamp(time, 1000)
    assert channel.queued == 0
    batch.release()
    assert channel.queued == 2 * (12 + 9)
    assert decoded(channel) == [(5, [(5, b"x")]), (6, [(6, b"x")])]
    assert channel.queued == 0


def test_a_large_stamp_is_split_at_samples(batch: Batch, channel: Channel) -> None:
    for handle in range(10):
        batch.take(struct.pack("<II", handle, 4), b"data")
    batch.close_stamp(5, 30)
    batch.release()
    assert [count for count, _ in channel.queue] == [3, 3, 3, 1]
    frames = []
    while channel.queue:
        frames += decoded(channel, 60)
    assert [sample for _, samples in frames for sample in samples] == [
        (handle, b"data") for handle in range(10)
    ]


def test_a_frame_takes_at_least_one_stamp(batch: Batch, channel: Channel) -> None:
    batch.take(struct.pack("<II", 1, 100), bytes(100))
    batch.close_stamp(5, 10)
    batch.release()
    assert decoded(channel, 10) == [(5, [(1, bytes(100))])]


def test_a_shortened_queue_keeps_the_newest(batch: Batch, channel: Channel) -> None:
    for time in range(5):
        batch.take(struct.pack("<II", 1, 1), b"x")
        batch.close_stamp(time, 1000)
    batch.release()
    assert channel.shorten(2 * 21 + 5) == 3
    assert channel.dropped == 3
    assert [time for time, _ in decoded(channel)] == [3, 4]


def test_a_hint_is_a_sample_without_data(batch: Batch, channel: Channel) -> None:
    hint(subscription(batch, [b"ab"]))
    batch.close_stamp(5, 1000)
    batch.release()
    assert decoded(channel) == [(5, [(7, b"")])]


def test_congestion_is_read_from_the_connection() -> None:
    class Full:
        congested = True

        def deliver(self, frame: Any) -> bool:
            return True

    assert Channel(CLIENT, CLIENT, Full()).congested
    assert not Channel(CLIENT, CLIENT, None).congested


@pytest.mark.parametrize("mode", [1, 2, 3, 4, 5, 6, 10])
def test_the_largest_delay_never_ends_early_and_never_late(bench: Any, mode: int) -> None:
    variable = bench.source.symbols["main.ncounter"]

    def count() -> None:
        variable.number += 1

    begin = from_unix_ns(bench.now)
    bench.subscribe("MAIN.nCounter", mode=mode, cycle_ms=10, delay_ms=100)
    sent = []
    for milliseconds in range(2, 502, 2):
        before = len(bench.client.frames)
        bench.tick(2, count)
        if len(bench.client.frames) > before:
            sent.append(milliseconds)
    oldest = [
        (NotificationStream.decode(frame.data).stamps[0].filetime - begin) // 10_000
        for frame in bench.client.frames
    ]
    assert len(sent) == (1 if mode == 10 else 4)
    assert all(100 <= end - start <= 102 for start, end in zip(oldest, sent, strict=True))


@given(
    st.lists(
        st.tuples(
            st.sampled_from(("add", "delete", "delete", "sum", "tick", "congest", "read")),
            st.sampled_from((0, 0, 15, 60)),
            st.integers(0, 9),
        ),
        min_size=4,
        max_size=40,
    )
)
@settings(max_examples=40)
def test_no_sample_comes_after_the_answer_to_a_delete(
    make_bench: Callable[..., Any], steps: list[tuple[str, int, int]]
) -> None:
    bench = make_bench()
    counter = bench.source.symbols["main.ncounter"]
    there = [bench.subscribe("MAIN.nCounter", mode=3, delay_ms=delay) for delay in (0, 60)]
    deleted: set[int] = set()
    late: list[int] = []
    for what, delay, number in (*steps, ("read", 0, 0), ("tick", 0, 9)):
        if what == "add":
            there.append(bench.subscribe("MAIN.nCounter", mode=3 + number % 2, delay_ms=delay))
        elif what in ("delete", "sum") and there:
            handles = [there.pop(number % len(there))]
            if what == "sum" and there:
                handles.append(there.pop())
            late += [handle for _, handle, _ in bench.samples() if handle in deleted]
            packed = struct.pack(f"<{len(handles)}I", *handles)
            if what == "sum":
                bench.exchange(0xF086, len(handles), 4 * len(handles), packed)
            else:
                bench.raw(7, packed)
            deleted |= set(handles)
        elif what == "tick":
            counter.number += 1
            bench.tick(10 * number)
        else:
            bench.client.congested = what == "congest"
    late += [handle for _, handle, _ in bench.samples() if handle in deleted]
    assert late == []
    assert all(
        not each.deleted or each.buffered_bytes for each in bench.device.notifications.channels
    )
