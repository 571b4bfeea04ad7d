"""The limits are per client or for all, and refuse with the codes made for it."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.server import Limits


def add(bench: Any, length: int, **way: Any) -> int:
    body = struct.pack("<IIIIII16x", 0x4020, 0, length, 4, 0, 0)
    return int.from_bytes(bench.raw(6, body, **way)[:4], "little")


def test_notifications_per_client(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(Limits(notifications=2))
    assert [add(bench, 1) for _ in range(3)] == [0, 0, 0x716]
    other, address = bench.join()
    assert add(bench, 1, source=address, origin=other) == 0
    assert bench.raw(7, struct.pack("<I", 1)) == bytes(4)
    assert add(bench, 1) == 0


@pytest.mark.parametrize("length", [9, 0xFFFF_FFFF])
def test_bytes_of_one_sample(make_bench: Callable[..., Any], length: int) -> None:
    bench = make_bench(Limits(sample_bytes=8))
    assert add(bench, 8) == 0
    assert add(bench, length) == 0x717


def test_bytes_of_all_samples_of_a_client(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(Limits(watched_bytes=10))
    assert [add(bench, 6), add(bench, 5), add(bench, 4)] == [0, 0x717, 0]
    bench.raw(7, struct.pack("<I", 1))
    assert add(bench, 6) == 0


def test_the_defaults_let_a_thousand_per_port_through(bench: Any) -> None:
    assert {add(bench, 4) for _ in range(1024)} == {0}


def test_bytes_of_one_answer(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(Limits(answer_bytes=16))
    assert bench.raw(2, struct.pack("<III", 0x4020, 0, 8))[:4] == bytes(4)
    assert bench.raw(2, struct.pack("<III", 0x4020, 0, 9))[:8] == b"\x05\x07" + bytes(6)


def test_many_addresses_hold_no_more_than_all_may(make_bench: Callable[..., Any]) -> None:
    bench = make_bench(Limits(all_notifications=3))
    notifications = bench.device.notifications

    def add(client: bytes) -> int:
        return int(notifications.add(client, bench.address, None, lambda: b"x", 1, 3, 0, 0))

    handles = [add(bytes((number,)) * 8) for number in range(3)]
    with pytest.raises(DeviceError, match="0x716"):
        add(b"\x09" * 8)
    notifications.delete(handles[0], bytes(8))
    add(b"\x09" * 8)
