"""The limits are per client or for all, and refuse with the codes made for it."""

import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.server import ClientLimits


def add(bench: Any, length: int, **way: Any) -> int:
    body = struct.pack("<IIIIII16x", 0x4020, 0, length, 4, 0, 0)
    return int.from_bytes(bench.raw(6, body, **way)[:4], "little")


def test_notifications_per_client(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(notifications=2))
    assert [add(bench, 1) for _ in range(3)] == [0, 0, 0x716]
    other, address = bench.join()
    assert add(bench, 1, source=address, origin=other) == 0
    assert bench.raw(7, struct.pack("<I", 1)) == bytes(4)
    assert add(bench, 1) == 0


@pytest.mark.parametrize("length", [9, 0xFFFF_FFFF])
def test_bytes_of_one_sample(make_bench: Callable[..., Any], length: int) -> None:
    bench = make_bench(ClientLimits(sample_bytes=8))
    assert add(bench, 8) == 0
    assert add(bench, length) == 0x717


def test_bytes_of_all_samples_of_a_client(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(watched_bytes=10))
    assert [add(bench, 6), add(bench, 5), add(bench, 4)] == [0, 0x717, 0]
    bench.raw(7, struct.pack("<I", 1))
    assert add(bench, 6) == 0


def test_the_defaults_let_a_thousand_per_port_through(bench: Any) -> None:
    assert {add(bench, 4) for _ in range(1024)} == {0}


def test_bytes_of_one_answer(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(answer_bytes=16))
    assert bench.raw(2, struct.pack("<III", 0x4020, 0, 8))[:4] == bytes(4)
    assert bench.raw(2, struct.pack("<III", 0x4020, 0, 9))[:8] == b"\x05\x07" + bytes(6)


def test_many_addresses_hold_no_more_than_all_may(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(all_notifications=3))
    notifications = bench.device.notifications

    def add(client: bytes) -> int:
        return int(notifications.add(client, bench.address, None, lambda: b"x", 1, 3, 0, 0))

    handles = [add(bytes((number,)) * 8) for number in range(3)]
    with pytest.raises(DeviceError, match="0x716"):
        add(b"\x09" * 8)
    notifications.delete(handles[0], bytes(8))
    add(b"\x09" * 8)


def handle(bench: Any, **way: Any) -> int:
    return int(bench.exchange(0xF003, 0, 4, b"MAIN.nCounter", **way)[0])


def test_handles_of_one_client_and_of_all(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(handles=2, all_handles=3))
    assert [handle(bench) for _ in range(3)] == [0, 0, 0x716]
    other, address = bench.join()
    way = {"source": address, "origin": other}
    assert [handle(bench, **way) for _ in range(2)] == [0, 0x716]
    assert bench.device.symbols.handles.refused == 2
    bench.device.symbols_changed()  # those out of date count until they are released
    assert handle(bench, **way) == 0x716
    bench.device.end_client(bench.me)
    assert handle(bench, **way) == 0


def test_bytes_of_all_samples_of_all_clients(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(all_watched_bytes=10))
    other, address = bench.join()
    assert add(bench, 6) == 0
    assert add(bench, 5, source=address, origin=other) == 0x717
    assert bench.device.notifications.refused == 1
    assert add(bench, 4, source=address, origin=other) == 0
    bench.device.end_client(bench.me)
    assert add(bench, 6, source=address, origin=other) == 0


def test_other_limits_count_from_now_on(bench: Any) -> None:
    bench.device.limit(ClientLimits(all_handles=1))
    assert [handle(bench), handle(bench)] == [0, 0x716]


STAMP = 12 + 8 + 4
"""Bytes of a stamp with one sample of four bytes."""


def queued(bench: Any) -> int:
    return int(bench.device.notifications.queued)


def test_samples_kept_for_all_clients_have_a_limit_and_the_greediest_lose_theirs(
    make_bench: Callable[..., Any], caplog: pytest.LogCaptureFixture
) -> None:
    bench = make_bench(ClientLimits(all_queue_bytes=12 * STAMP))
    slow = [bench.join() for _ in range(3)]
    for number, (client, address) in enumerate(slow, 1):
        bench.subscribe(
            "MAIN.nCounter", mode=3, cycle_ms=10 * number, source=address, origin=client
        )
        bench.samples(client)
        client.congested = True
    bench.tick(60)
    assert queued(bench) == (6 + 3 + 2) * STAMP
    bench.tick(10)
    assert queued(bench) == (7 + 3 + 2) * STAMP
    bench.tick(10)  # the first has eight, the second four
    assert queued(bench) == (4 + 2) * STAMP
    assert bench.device.notifications.dropped == 8
    assert caplog.text.count("too much is kept for all clients together") == 1
    for client, _ in slow:
        client.congested = False
    bench.tick(10)
    assert [len(bench.samples(client)) for client, _ in slow] == [1, 4, 3]
    assert queued(bench) == 0
    assert "8 samples were dropped" in caplog.text


def test_samples_within_their_largest_delay_count_as_well(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(ClientLimits(all_queue_bytes=12 * STAMP))
    bench.subscribe("MAIN.nCounter", mode=3, cycle_ms=10, delay_ms=1000)
    bench.tick(110)
    assert queued(bench) == 12 * STAMP
    bench.tick(10)
    assert queued(bench) == 0
    bench.tick(1900)
    times = [time for time, _, _ in bench.samples()]
    assert times == [*range(910, 1001, 10), *range(1920, 2011, 10)]  # the newest of each second


@given(
    st.lists(
        st.tuples(
            st.sampled_from(("add", "end", "slow", "fast", "change", "wait")), st.integers(0, 2)
        ),
        max_size=30,
    )
)
def test_what_is_kept_is_counted_to_the_byte(
    make_bench: Callable[..., Any], steps: list[tuple[str, int]]
) -> None:
    bench = make_bench(ClientLimits(queue_bytes=3 * STAMP, all_queue_bytes=8 * STAMP))
    clients = [bench.join() for _ in range(3)]
    notifications = bench.device.notifications
    for what, number in steps:
        client, address = clients[number]
        match what:
            case "add":
                way = {"source": address, "origin": client}
                bench.subscribe("MAIN.nCounter", mode=3, delay_ms=25 * number, **way)
            case "end":
                bench.device.end_client(address)
            case "slow" | "fast":
                client.congested = what == "slow"
            case "change":
                bench.device.symbols_changed()
            case "wait":
                bench.tick(20)
        assert queued(bench) == sum(
            channel.buffered_bytes for channel in notifications._channels.values()
        )
        assert queued(bench) <= 8 * STAMP
    bench.device.end_clients()
    bench.tick(100)
    assert queued(bench) == notifications.usage.watched == 0
