"""Notifications come when they should, stamped with the cycle, and end when they should."""

import asyncio
import itertools
import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Connection, Frame, TcpCommand, TcpMessage
from achse.ams.commands import AddNotificationRequest
from achse.ams.notification import NotificationStream
from achse.server import ClientLimits
from achse.transport.tcp.listener import TcpListener

FILETIME_OF_START = 116_444_736_000_000_000 + 18_000_000_000_000_000
"""2027-01-15 08:00 UTC, where the bench's clock starts, in 100 ns since 1601."""


@pytest.fixture
def counter(bench: Any) -> Any:
    return bench.source.symbols["main.ncounter"]


def times(samples: list[tuple[int, int, bytes]]) -> list[int]:
    return [time for time, _, _ in samples]


def counting(variable: Any) -> Callable[[], None]:
    def cycle() -> None:
        variable.number += 1

    return cycle


# the first sample ------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", [1, 2, 3, 4, 5, 6, 10])
def test_the_first_sample_comes_directly_behind_the_answer(
    bench: Any, counter: Any, mode: int
) -> None:
    counter.number = 0x11223344
    handle = bench.handle("MAIN.nCounter")
    body = struct.pack("<IIIIII16x", 0xF005, handle, 4, mode, 0, 10_000)
    bench.client.frames.clear()
    bench.send(6, body)
    answer, notification = bench.client.frames
    assert (answer.command, answer.data) == (6, struct.pack("<II", 0, 1))
    assert notification.command == 8
    assert (notification.target, notification.source) == (bench.me, bench.address)
    assert notification.data == (
        struct.pack("<II", 28, 1)
        + struct.pack("<QI", FILETIME_OF_START, 1)
        + struct.pack("<II", 1, 4)
        + bytes.fromhex("44332211")
    )


def test_the_first_sample_is_held_by_the_largest_delay(bench: Any) -> None:
    bench.subscribe("MAIN.nCounter", delay_ms=2000)
    bench.tick(1998)
    assert bench.samples() == []
    bench.tick(2)
    assert bench.samples() == [], "asked for between two ticks, so less than 2 s ago"
    bench.tick(2)
    assert bench.samples() == [(0, 1, bytes(4))]
    bench.tick(5000)
    assert bench.samples() == []


def test_a_delay_below_a_millisecond_means_at_once(bench: Any, counter: Any) -> None:
    """pyads asks for 100 ns unless it is told otherwise."""
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, delay_ms=0.0001)
    assert times(bench.samples()) == [0]
    bench.tick(10)
    assert times(bench.samples()) == [10]


def test_the_first_samples_of_a_sum_come_in_one_frame_behind_its_answer(bench: Any) -> None:
    body = struct.pack("<IIIIII16x", 0x4020, 0, 1, 4, 0, 0)
    bench.exchange(0xF085, 500, 4000, body * 500)
    assert len(bench.client.frames) == 1
    assert len(bench.samples()) == 500


# cycles ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cycle_ms", "expected"),
    [
        (0, 10),  # each task cycle
        (1, 10),
        (10, 10),
        (10.0001, 20),  # rounded up to whole task cycles
        (25, 30),
        (100, 100),
    ],
)
@pytest.mark.parametrize("mode", [1, 3])
def test_a_cyclic_sample_comes_once_per_cycle(
    bench: Any, counter: Any, mode: int, cycle_ms: float, expected: int
) -> None:
    bench.subscribe("MAIN.nCounter", mode=mode, cycle_ms=cycle_ms)
    bench.tick(600)
    assert times(bench.samples()) == list(range(0, 601, expected))


@pytest.mark.parametrize("mode", [2, 4, 6])
def test_on_change_sends_only_changes(bench: Any, counter: Any, mode: int) -> None:
    bench.subscribe("MAIN.nCounter", mode=mode, cycle_ms=10)
    bench.tick(100)
    assert times(bench.samples()) == [0]
    counter.number = 5
    bench.tick(100)
    assert bench.samples() == [(110, 1, b"\5\0\0\0")]
    counter.number = 6
    counter.number = 5
    bench.tick(100)
    assert bench.samples() == []


def test_on_change_sends_at_most_once_per_cycle(bench: Any, counter: Any) -> None:
    bench.subscribe("MAIN.nCounter", mode=4, cycle_ms=100)
    bench.tick(500, counting(counter))
    assert times(bench.samples()) == [0, 100, 200, 300, 400, 500]


def test_the_stamp_is_the_time_of_the_task_cycle(bench: Any, counter: Any) -> None:
    """The client subscribes between cycles; its samples are on the grid of the 10 ms task."""
    bench.tick(14)
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=20)
    bench.tick(60)
    assert times(bench.samples()) == [10, 30, 50, 70]


@pytest.mark.parametrize(("mode", "cycle"), [(3, 10), (5, 2)])
def test_a_mode_in_context_follows_the_task_of_the_symbol(
    bench: Any, mode: int, cycle: int
) -> None:
    bench.subscribe("MAIN.fast", mode=mode)
    bench.tick(40)
    assert times(bench.samples()) == list(range(0, 41, cycle))


def test_once_is_once(bench: Any, counter: Any) -> None:
    handle = bench.subscribe("MAIN.nCounter", mode=10)
    bench.tick(500, counting(counter))
    assert times(bench.samples()) == [0]
    assert bench.raw(7, struct.pack("<I", handle)) == bytes(4)


@pytest.mark.parametrize("mode", [0, 7, 9, 11, 0xFFFF_FFFF])
def test_another_mode_is_refused(bench: Any, mode: int) -> None:
    body = struct.pack("<IIIIII16x", 0x4020, 0, 1, mode, 0, 0)
    assert bench.raw(6, body) == struct.pack("<II", 0x713, 0)


def test_ticks_that_were_missed_do_not_pile_up(bench: Any) -> None:
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10)
    bench.samples()
    bench.now += 1_000_000_000
    bench.device.notifications.tick(bench.now)
    bench.tick(20)
    assert times(bench.samples()) == [1000, 1010, 1020]


@given(
    cycle=st.integers(0, 60),
    delay=st.integers(0, 200),
    start=st.integers(0, 20),
    on_change=st.booleans(),
)
def test_each_sample_comes_once_in_order_and_in_time(
    make_bench: Callable[..., Any], cycle: int, delay: int, start: int, on_change: bool
) -> None:
    bench = make_bench()
    bench.tick(2 * start)
    bench.subscribe("MAIN.nCounter", mode=4 if on_change else 3, cycle_ms=cycle, delay_ms=delay)
    counter = bench.source.symbols["main.ncounter"]
    now = 2 * start
    arrived = [(now, *sample) for sample in bench.samples()]
    for _ in range(500):
        counter.number += 1
        bench.tick(2)
        now += 2
        arrived += [(now, *sample) for sample in bench.samples()]
    period = max(-(-cycle // 10), 1) * 10
    grid = range(2 * start // 10 * 10, now + 1, period)
    stamps = [time for _, time, _, _ in arrived]
    assert stamps == list(grid[: len(stamps)])
    assert len(stamps) >= (998 - delay) // period
    assert all(came - max(time, 2 * start) < delay + 4 for came, time, _, _ in arrived)
    values = [int.from_bytes(data, "little") for _, _, _, data in arrived]
    assert values == [max(time // 2 - start, 0) for time in stamps]


# batches ---------------------------------------------------------------------------------------


def test_samples_gather_up_to_the_largest_delay(bench: Any, counter: Any) -> None:
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, delay_ms=100)
    bench.tick(98, counting(counter))
    assert bench.client.frames == []
    bench.tick(2, counting(counter))
    assert bench.client.frames == []
    bench.tick(2, counting(counter))
    (frame,) = bench.client.frames
    stamps = NotificationStream.decode(frame.data).stamps
    assert times(bench.samples()) == list(range(0, 101, 10))
    assert all(len(stamp.samples) == 1 for stamp in stamps)
    assert frame.data[:8] == struct.pack("<II", 4 + 11 * 24, 11)


def test_samples_of_one_cycle_share_a_stamp(bench: Any) -> None:
    for name, mode in (("MAIN.nCounter", 3), ("MAIN.fixed", 3), ("MAIN.nCounter", 3)):
        bench.subscribe(name, mode, cycle_ms=10, length=2)
    bench.samples()
    bench.tick(10)
    (frame,) = bench.client.frames
    (stamp,) = NotificationStream.decode(frame.data).stamps
    assert [sample.handle for sample in stamp.samples] == [1, 2, 3]


def test_a_delayed_and_a_prompt_subscription_do_not_disturb_each_other(bench: Any) -> None:
    prompt = bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10)
    slow = bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, delay_ms=100)
    bench.tick(90)
    assert {handle for _, handle, _ in bench.samples()} == {prompt}
    bench.tick(12)
    assert sum(handle == slow for _, handle, _ in bench.samples()) == 11


def test_a_batch_that_grows_large_does_not_wait(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(frame_bytes=240))
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, delay_ms=10_000)
    bench.tick(90)
    (frame,) = bench.client.frames
    assert times(bench.samples()) == list(range(0, 91, 10))
    assert len(frame.data) == 8 + 10 * 24
    bench.tick(9_910)
    assert times(bench.samples()) == list(range(100, 10_000, 10))


def test_many_samples_of_a_cycle_go_in_several_frames(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(frame_bytes=1000))
    body = struct.pack("<IIIIII16x", 0x4020, 0, 4, 3, 0, 0)
    bench.exchange(0xF085, 200, 1600, body * 200)
    assert max(len(frame.data) for frame in bench.client.frames) < 1100
    assert [handle for _, handle, _ in bench.samples()] == list(range(1, 201))
    bench.tick(10)
    assert [handle for _, handle, _ in bench.samples()] == list(range(1, 201))


# values ----------------------------------------------------------------------------------------


def test_a_sample_has_the_requested_length(bench: Any, counter: Any) -> None:
    counter.number = 0x11223344
    bench.subscribe("MAIN.nCounter", length=2)
    bench.subscribe("MAIN.nCounter", length=6)
    bench.subscribe("MAIN.nCounter", length=0)
    data = [sample[2] for sample in bench.samples()]
    assert data == [b"\x44\x33", b"\x44\x33\x22\x11\0\0", b""]
    counter.number = 0x55663344
    bench.tick(10)
    assert [sample[1:] for sample in bench.samples()] == [(2, b"\x44\x33\x66\x55\0\0")]


def test_plain_addresses_state_and_version_can_be_watched(bench: Any) -> None:
    def watch(group: int, offset: int, length: int) -> None:
        body = struct.pack("<IIIIII16x", group, offset, length, 4, 0, 0)
        assert bench.raw(6, body)[:4] == bytes(4)

    watch(0x4020, 1, 1)
    watch(0xF100, 0, 4)
    watch(0xF008, 0, 1)
    watch(0x1000, 1, 8)
    first = {handle: data for _, handle, data in bench.samples()}
    assert first == {1: b"\1", 2: b"\5\0\0\0", 3: b"\7", 4: struct.pack("<d", 1.5)}
    bench.raw(5, struct.pack("<HHI", 6, 0, 0))
    bench.source.version = 8
    bench.machine.velocity = 2.5
    bench.memory[1] = 9
    bench.tick(10)
    changed = {handle: data for _, handle, data in bench.samples()}
    assert changed == {1: b"\x09", 2: b"\6\0\0\0", 3: b"\x08", 4: struct.pack("<d", 2.5)}


def test_a_released_symbol_handle_leaves_its_notification_alone(bench: Any, counter: Any) -> None:
    symbol = bench.handle("MAIN.nCounter")
    body = struct.pack("<IIIIII16x", 0xF005, symbol, 4, 4, 0, 0)
    bench.raw(6, body)
    bench.write(0xF006, 0, struct.pack("<I", symbol))
    bench.samples()
    counter.number = 3
    bench.tick(10)
    assert bench.samples() == [(10, 1, b"\3\0\0\0")]


@pytest.mark.parametrize(("handle", "code"), [(1, 0x710), (0, 0x710)])
def test_an_unknown_symbol_handle_cannot_be_watched(bench: Any, handle: int, code: int) -> None:
    body = struct.pack("<IIIIII16x", 0xF005, handle, 4, 4, 0, 0)
    assert bench.raw(6, body) == struct.pack("<II", code, 0)


@pytest.mark.parametrize("mode", [3, 4])
def test_a_value_that_cannot_be_read_is_hinted_at_once_and_comes_back(
    bench: Any, counter: Any, mode: int, caplog: pytest.LogCaptureFixture
) -> None:
    bench.subscribe("MAIN.nCounter", mode=mode, cycle_ms=10)
    bench.samples()
    counter.fault = RuntimeError("gone")
    bench.tick(100)
    assert bench.samples() == [(10, 1, b"")]
    assert caplog.text.count("notification 1 cannot be read") == 1
    counter.fault = None
    bench.tick(10)
    assert bench.samples() == [(110, 1, bytes(4))]


# handles and life time -------------------------------------------------------------------------


def test_handles_count_up_from_one_in_their_own_space(bench: Any) -> None:
    assert [bench.subscribe("MAIN.nCounter") for _ in range(3)] == [1, 2, 3]
    bench.raw(7, struct.pack("<I", 2))
    assert bench.subscribe("MAIN.nCounter") == 4


def test_a_deleted_notification_is_silent(bench: Any) -> None:
    handle = bench.subscribe("MAIN.nCounter", mode=3)
    bench.samples()
    bench.raw(7, struct.pack("<I", handle))
    bench.tick(100)
    assert bench.samples() == []
    assert list(bench.device.notifications.clients) == []


def test_no_client_deletes_the_notification_of_another(bench: Any) -> None:
    handle = bench.subscribe("MAIN.nCounter", mode=3)
    other, address = bench.join()
    answer = bench.raw(7, struct.pack("<I", handle), source=address, origin=other)
    assert answer == struct.pack("<I", 0x714)


def test_two_processes_behind_one_address_each_get_their_own(bench: Any) -> None:
    shared = AmsAddress("192.168.0.9.1.1:30000")
    ways = [bench.join()[0], bench.join()[0]]
    handles = [bench.subscribe("MAIN.nCounter", mode=3, source=shared, origin=way) for way in ways]
    bench.tick(20)
    for way, handle in zip(ways, handles, strict=True):
        assert {sample[1] for sample in bench.samples(way)} == {handle}


def test_connection_is_used_while_it_has_subscriptions(bench: Any) -> None:
    remote = AmsAddress("192.168.0.9.1.1:30000")
    way, other = bench.join()[0], bench.join()[0]
    handle = bench.subscribe("MAIN.nCounter", source=remote, origin=way)
    assert (bench.router.is_used(way), bench.router.is_used(other)) == (True, False)
    bench.raw(7, struct.pack("<I", handle), source=remote, origin=way)
    assert not bench.router.is_used(way)


def test_no_client_gets_samples_of_an_earlier_client_at_its_address(bench: Any) -> None:
    remote = AmsAddress("192.168.0.9.1.1:30000")
    old, new = bench.join()[0], bench.join()[0]
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, source=remote, origin=old)
    old.open = False
    bench.tick(50)
    assert bench.router.lost_frames == 1  # nothing is sampled for nobody
    bench.router.learn(remote, new)
    bench.tick(50)
    assert new.frames == []


def test_a_restart_ends_everything(bench: Any) -> None:
    handle = bench.subscribe("MAIN.nCounter", mode=3)
    bench.samples()
    bench.device.end_notifications()
    bench.tick(100)
    assert bench.samples() == []
    assert bench.raw(7, struct.pack("<I", handle)) == struct.pack("<I", 0x714)


def test_an_online_change_ends_symbols_with_a_hint_and_reports_the_version(bench: Any) -> None:
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10)
    bench.raw(6, struct.pack("<IIIIII16x", 0xF008, 0, 1, 4, 0, 0))
    bench.samples()
    bench.source.version = 8
    bench.device.symbols_changed()
    bench.tick(100)
    samples = bench.samples()
    assert sorted(sample[1:] for sample in samples) == [(1, b""), (2, b"\x08")]
    assert bench.raw(7, struct.pack("<I", 1)) == bytes(4)


# diagnosis -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("delay", "cycle"), [(0, 2), (0, 9_999), (100, 0)])
def test_a_client_that_counts_in_ms_is_reported_once(
    bench: Any, caplog: pytest.LogCaptureFixture, delay: int, cycle: int
) -> None:
    body = struct.pack("<IIIIII16x", 0x4020, 0, 1, 3, delay, cycle)
    for _ in range(3):
        assert bench.raw(6, body)[:4] == bytes(4)
    assert caplog.text.count("the unit is 100 ns") == 1
    assert str(bench.me) in caplog.text


def test_usual_times_need_no_word(bench: Any, caplog: pytest.LogCaptureFixture) -> None:
    bench.subscribe("MAIN.nCounter", cycle_ms=1, delay_ms=0)
    bench.subscribe("MAIN.nCounter", cycle_ms=0, delay_ms=100)
    pyads_default = struct.pack("<IIIIII16x", 0x4020, 0, 1, 4, 1, 1)
    assert bench.raw(6, pyads_default)[:4] == bytes(4)
    assert caplog.text == ""


# a client that does not read -------------------------------------------------------------------


def test_a_slow_reader_loses_its_oldest_samples_and_disturbs_no_other(
    make_bench: Callable[..., Any], caplog: pytest.LogCaptureFixture
) -> None:
    bench = make_bench(ClientLimits(queue_bytes=240))
    counter = bench.source.symbols["main.ncounter"]
    slow, address = bench.join()
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, source=address, origin=slow)
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10)
    bench.samples(slow)
    bench.samples()
    slow.congested = True
    bench.tick(1000, counting(counter))
    assert slow.frames == []
    assert times(bench.samples()) == list(range(10, 1001, 10))
    assert bench.device.notifications.dropped == 90
    slow.congested = False
    bench.tick(10)
    assert times(bench.samples(slow)) == list(range(910, 1011, 10))
    assert caplog.text.count("does not read") == 1
    assert "90 samples were dropped" in caplog.text


def test_over_tcp_too_a_slow_reader_disturbs_no_other(make_bench: Callable[..., Any]) -> None:
    """Half a megabyte per cycle: the one that reads gets all, the other one loses some."""
    bench = make_bench(ClientLimits(queue_bytes=1 << 20))
    big = bench.source.symbols["main.big"] = type(bench.source.symbols["main.text"])(1 << 19)

    async def run() -> None:
        listener = TcpListener(bench.router)
        await listener.open(port=0)
        clients = []
        for _ in range(2):
            reader, writer = await asyncio.open_connection("127.0.0.1", listener.port)
            writer.write(TcpMessage(TcpCommand.PORT_CONNECT, bytes(2)).encode_tcp())
            source = (await reader.readexactly(14))[6:]
            bench.handle("MAIN.big", source=source, origin=Sink())
            symbol = next(reversed(bench.device.symbols._handles))
            add = AddNotificationRequest(0xF005, symbol, 1 << 19, 3, 0, 0)
            writer.write(Frame(bench.address, source, 6, 4, 0, 1, add.encode()).encode_tcp())
            clients.append((reader, writer))
        (good, _), (slow, _) = clients
        slow._transport.pause_reading()  # type: ignore[attr-defined]
        stream = Connection()
        numbers: list[int] = []
        while bench.device.notifications.dropped < 10:
            big.number += 1
            bench.tick(10)
            while not numbers or numbers[-1] < big.number:
                for frame in stream.receive(await good.read(1 << 20)):
                    if frame.command == 8:
                        (stamp,) = NotificationStream.decode(frame.data).stamps
                        numbers.append(int.from_bytes(stamp.samples[0].data, "little"))
        assert numbers == list(range(big.number + 1))
        for _, writer in clients:
            writer.close()
        await listener.close()

    asyncio.run(run())


def test_over_tcp_a_client_has_time_to_note_its_handle(bench: Any) -> None:
    """pyads drops samples of a handle it has not noted: they come a moment behind the answer."""

    async def run() -> None:
        listener = TcpListener(bench.router)
        await listener.open(port=0)
        reader, writer = await asyncio.open_connection("127.0.0.1", listener.port)
        writer.write(TcpMessage(TcpCommand.PORT_CONNECT, bytes(2)).encode_tcp())
        source = (await reader.readexactly(14))[6:]
        stream = Connection()
        for offset in range(2):
            add = AddNotificationRequest(0x4020, offset, 1, 3, 0, 0)
            writer.write(Frame(bench.address, source, 6, 4, 0, 1, add.encode()).encode_tcp())
            (answer,) = stream.receive(await reader.read(1000))
            assert answer.command == 6
            bench.tick(10)
        values: list[Any] = []
        while len(values) < 5:
            for frame in stream.receive(await reader.read(1000)):
                for stamp in NotificationStream.decode(frame.data).stamps:
                    values += [tuple(sample) for sample in stamp.samples]
        assert values == [(1, b"\0"), (1, b"\0"), (2, b"\1"), (1, b"\0"), (2, b"\1")]
        writer.close()
        await listener.close()

    asyncio.run(run())


class Sink:
    """Takes the answer to a request made for somebody else."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return True


def test_a_failed_client_disturbs_no_other(bench: Any, caplog: pytest.LogCaptureFixture) -> None:
    faulty, address = bench.join()
    bench.subscribe("MAIN.nCounter", mode=3, source=address, origin=faulty)
    bench.subscribe("MAIN.nCounter", mode=3)
    bench.samples()
    faulty.frames = None
    bench.tick(20)
    assert times(bench.samples()) == [10, 20]
    assert caplog.text.count("failed to take its notifications") == 2


def test_what_waits_for_a_deleted_subscription_is_forgotten(bench: Any) -> None:
    handle = bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10)
    bench.samples()
    bench.client.congested = True
    bench.tick(100)
    bench.raw(7, struct.pack("<I", handle))
    bench.client.congested = False
    bench.tick(100)
    assert bench.samples() == []


# scale -----------------------------------------------------------------------------------------


def test_thousands_come_complete(bench: Any, counter: Any) -> None:
    """8,192 subscriptions at 100 ms in 16 groups: each sample of a second, each group's phase."""
    body = struct.pack("<IIIIII16x", 0xF005, bench.handle("MAIN.nCounter"), 4, 3, 0, 1_000_000)
    for _ in range(16):
        result, answer = bench.exchange(0xF085, 500, 4000, body * 500)
        assert (result, len(answer)) == (0, 4000)
        bench.tick(10)
    bench.exchange(0xF085, 192, 192 * 8, body * 192)
    bench.samples()
    bench.tick(1000, counting(counter))
    samples = bench.samples()
    assert len(samples) == 81_920
    by_handle = {
        handle: [time for time, _, _ in group]
        for handle, group in itertools.groupby(
            sorted(samples, key=lambda sample: (sample[1], sample[0])), key=lambda sample: sample[1]
        )
    }
    assert len(by_handle) == 8192
    for stamps in by_handle.values():
        assert [b - a for a, b in itertools.pairwise(stamps)] == [100] * 9


def test_coming_and_going_leaves_nothing_behind(bench: Any) -> None:
    notifications = bench.device.notifications
    symbol = bench.handle("MAIN.nCounter")
    bench.raw(6, struct.pack("<IIIIII16x", 0xF005, symbol, 4, 4, 0, 0))
    for i in range(2000):
        body = struct.pack("<IIIIII16x", 0xF005, symbol, 4, 3, i * 10_000, i * 100_000)
        handle = bench.raw(6, body)[4:]
        assert bench.raw(7, handle) == bytes(4)
    bench.samples()
    assert len(notifications) == 1
    assert len(notifications._due) < 200
    (channel,) = notifications._channels.values()
    assert len(channel.batches) == 1


def test_batches_of_subscriptions_that_come_and_go_do_not_wait_for_their_largest_delay(
    bench: Any,
) -> None:
    notifications = bench.device.notifications
    delayed = bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, delay_ms=400)
    for _ in range(1000):
        body = struct.pack("<IIIIII16x", 0x4020, 0, 4, 3, 4_000_000_000, 0)
        bench.raw(7, bench.raw(6, body)[4:])
    assert len(notifications._deadlines) < 200
    assert sum(len(batch.stamps) for _, _, batch in notifications._deadlines) <= 2
    bench.tick(402)
    assert {handle for _, handle, _ in bench.samples()} == {delayed}
