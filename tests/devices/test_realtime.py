"""Real-time settings, port 200: lateness of the cycle."""

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.realtime import REALTIME_PORT, RealtimeDevice
from achse.router import Router


@dataclass
class Times:
    behind_ns: float
    latest_ns: float
    tick_ns: float = 2_000_000.0


def _client(client_of: Callable[..., Any], times: Times | None) -> Any:
    router = Router(NetId("5.1.2.3.1.1"))
    RealtimeDevice(lambda: times, clock=lambda: 0).attach(router, REALTIME_PORT)
    return client_of(router, REALTIME_PORT)


def _latency(client: Any, offset: int) -> tuple[int, ...]:
    return struct.unpack("<III", client.exchange(1, offset, 12, struct.pack("<I", 0)))


def test_latency_is_that_of_the_cycle_until_it_is_reset(client_of: Callable[..., Any]) -> None:
    times = Times(40_400.0, 1_500_000.0)
    client = _client(client_of, times)
    assert _latency(client, 0x2) == (40, 1500, 2000)
    assert client.get(1, 0x2, "<III") == (40, 1500, 2000)
    assert _latency(client, 0xB) == (40, 1500, 2000)
    assert _latency(client, 0x2) == (40, 0, 2000)
    times.latest_ns = 1e18
    assert _latency(client, 0x2)[1] == 0xFFFF_FFFF


def test_virtual_time_is_never_late(client_of: Callable[..., Any]) -> None:
    client = _client(client_of, None)
    assert _latency(client, 0x2) == _latency(client, 0xB) == (0, 0, 0)


@pytest.mark.parametrize("processor", [1, 7, 0xFFFF_FFFF])
def test_other_processors_have_no_latency(
    client_of: Callable[..., Any], refused: Any, processor: int
) -> None:
    client = _client(client_of, None)
    for offset in (0x2, 0xB):
        with refused(0x706):
            client.exchange(1, offset, 12, struct.pack("<I", processor))


def test_settings_have_one_processor_for_the_cycle(client_of: Callable[..., Any]) -> None:
    shared, isolated, mask, cycle, *_ = struct.unpack(
        "<IIQIIII", _client(client_of, None).read(1, 0xD, 32)
    )
    assert shared >= 1
    assert (isolated, mask, cycle) == (0, 1, 1)
