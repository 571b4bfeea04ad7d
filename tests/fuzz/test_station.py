"""A running station under hostile frames, with a good client beside them."""

import asyncio
import gc
import logging
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import achse

FRAMES = 48_000
ATTACKERS = 4
CHUNK = 256


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


class Attacker(asyncio.Protocol):
    """Sends what it is given and throws away what comes back."""

    def __init__(self) -> None:
        self.writable = asyncio.Event()
        self.ended = asyncio.get_running_loop().create_future()
        self.answered = 0

    def connection_made(self, transport: Any) -> None:
        self.transport = transport
        self.writable.set()

    def data_received(self, data: bytes) -> None:
        self.answered += len(data)

    def pause_writing(self) -> None:
        self.writable.clear()

    def resume_writing(self) -> None:
        self.writable.set()

    def connection_lost(self, exc: Exception | None) -> None:
        self.writable.set()
        self.ended.set_result(None)


async def attack(port: int, frames: Iterator[bytes]) -> int:
    """Send all frames, over a new connection whenever the station has closed the last one."""
    connections = 0
    loop = asyncio.get_running_loop()
    attacker: Attacker | None = None
    while chunk := b"".join(islice(frames, CHUNK)):
        if attacker is None or attacker.ended.done():
            _, attacker = await loop.create_connection(Attacker, "127.0.0.1", port)
            connections += 1
        attacker.transport.write(chunk)
        await attacker.writable.wait()
        await asyncio.sleep(0)
    if attacker is not None:
        attacker.transport.close()
        await attacker.ended
    return connections


async def read_on(port: int, done: asyncio.Event) -> int:
    """A client that reads all the while; raises if a single request fails."""
    reads = 0
    async with achse.connect(f"127.0.0.1:{port}", timeout=3600) as plc:
        nc = plc.at_port(501)
        while not done.is_set():
            await plc.read("GVL.fLreal")
            assert len(await nc.read_raw(0x4101, 0, 112)) == 112
            reads += 2
            await asyncio.sleep(0.001)
        state = await plc.state()
        assert state.ads_state == 5
    return reads


def test_hostile_frames_leave_station_and_other_clients_unharmed(
    frames: ModuleType, caplog: pytest.LogCaptureFixture, many: Callable[[int], int]
) -> None:
    each = many(FRAMES) // ATTACKERS // 4
    escaped: list[dict[str, Any]] = []
    sizes: list[int] = []

    async def main() -> tuple[int, int]:
        asyncio.get_running_loop().set_exception_handler(lambda _, context: escaped.append(context))
        station = achse.Station.demo()
        async with station.running("127.0.0.1", 0) as running:
            done = asyncio.Event()
            good = asyncio.create_task(read_on(running.tcp_port, done))
            connections = 0
            for round_ in range(4):
                streams = [
                    islice(frames.mixed(17 * round_ + n, share=0.002), each)
                    for n in range(ATTACKERS)
                ]
                counts = await asyncio.gather(
                    *(attack(running.tcp_port, stream) for stream in streams)
                )
                connections += sum(counts)
                gc.collect()  # of the tests before as well: they share the process
                sizes.append(resident_bytes())
            done.set()
            return connections, await good

    with caplog.at_level(logging.ERROR, logger="achse"):
        connections, reads = asyncio.run(main())
    assert not escaped
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]
    assert connections > 4 * ATTACKERS  # broken streams were closed, not kept
    assert reads
    assert sizes[-1] - sizes[0] < 32 << 20, sizes
