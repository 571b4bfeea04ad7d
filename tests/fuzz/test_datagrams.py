"""Hostile datagrams: nothing escapes, nothing grows, no route is made, answers stay sound.

`python tests/fuzz/test_datagrams.py 10000000` throws as many as one likes and prints CPU
time and memory.
"""

import asyncio
import gc
import importlib.util
import logging
import sys
import tracemalloc
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from achse.ams import NetId
from achse.ams.discovery import DiscoveryPacket, OsVersion, RouterInfo, status_of
from achse.router.access import PasswordHash, Users
from achse.router.rate import Rates
from achse.router.routes import RouteTable
from achse.transport.udp import DiscoveryEndpoint

COUNT = 40_000
HASH = PasswordHash(2, 1, 1, bytes(3), bytes(16))
INFO = RouterInfo(NetId("5.1.2.3.1.1"), "press", (3, 1, 4024), OsVersion(6, 1, 0, 0, "Linux"))


def _datagrams(seed: int) -> Iterator[bytes]:
    path = Path(__file__).with_name("datagrams.py")
    spec = importlib.util.spec_from_file_location("achse_fuzz_datagrams", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    datagrams: Iterator[bytes] = module.datagrams(seed)
    return datagrams


class _Answers(asyncio.DatagramTransport):
    """Counts answers, and looks at each."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0
        self.closed = False

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return ("127.0.0.1", 1)

    def sendto(self, data: bytes | bytearray | memoryview, addr: Any = None) -> None:
        answer = DiscoveryPacket.decode(bytes(data))
        assert answer.answer
        if answer.service == 1:
            assert RouterInfo.decode(answer) == INFO
        else:
            assert len(data) == 32
            assert status_of(answer) in (0x701, 0x704)
        self.count += 1

    def close(self) -> None:
        self.closed = True


def _no_password(*request: object) -> bool:
    """Fail: without users no password is checked."""
    raise AssertionError(request)


async def _throw(count: int, seed: int, users: Users) -> tuple[int, int]:
    routes = RouteTable()
    endpoint = DiscoveryEndpoint(lambda: INFO, routes, users)
    endpoint._answers = Rates(1 << 30, 1 << 30)
    if not users:
        endpoint._passwords.put = _no_password  # type: ignore[method-assign, assignment]
    answers = _Answers()
    endpoint.connection_made(answers)
    for number, data in enumerate(islice(_datagrams(seed), count)):
        endpoint.datagram_received(data, (f"192.0.2.{number % 100}", 9))
        if number % 50 == 0:
            await asyncio.sleep(0)
    await endpoint.close()
    assert len(routes) == 0
    return answers.count, endpoint.ignored


def test_without_users(many: Callable[[int], int]) -> None:
    count = many(COUNT)
    answered, ignored = asyncio.run(_throw(count, 1, Users()))
    assert answered > count / 5
    assert ignored > count / 5


def test_with_users_whose_password_they_do_not_know(many: Callable[[int], int]) -> None:
    count = many(COUNT // 4)
    answered, ignored = asyncio.run(_throw(count, 2, Users({"Administrator": HASH})))
    assert answered > count / 10
    assert ignored > count / 10


def test_nothing_grows(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.CRITICAL, "achse")  # pytest keeps each record

    async def grown() -> int:
        await _throw(1000, 3, Users())
        tracemalloc.start()
        await _throw(2000, 4, Users())
        gc.collect()
        before, _ = tracemalloc.get_traced_memory()
        await _throw(10_000, 5, Users())
        gc.collect()
        after, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return after - before

    assert asyncio.run(grown()) < 50_000


if __name__ == "__main__":
    import resource

    total = int(sys.argv[1])
    done = asyncio.run(_throw(total, 11, Users({"Administrator": HASH})))
    used = resource.getrusage(resource.RUSAGE_SELF)
    print(
        f"{total} datagrams in {used.ru_utime + used.ru_stime:.1f} s of CPU:"
        f" {done[0]} answered, {done[1]} ignored, {used.ru_maxrss} kB"
    )
