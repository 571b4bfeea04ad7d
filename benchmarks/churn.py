"""1,000 clients with 10 subscriptions each come and go while faults fire; a steady one watches.

Clients stay for a while and leave as clients do: some say good-bye, some vanish, some stop reading,
some send garbage, some only knock. Beside them one client has a cyclic subscription and must miss
nothing. Printed at the end: memory of the station, samples missed, connections, what was logged,
and how long the station had to wait for a processor (Linux): what it lost then is not its fault.

Usage: python benchmarks/churn.py [SECONDS] [CLIENTS]     (default: 600 s, 1000 clients)
"""

import asyncio
import contextlib
import json
import random
import re
import struct
import subprocess
import sys
import tempfile
import time
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import IO

from achse.ams import AmsAddress, Command, Connection, DecodeError, Frame
from achse.ams.commands import ADD_NOTIFICATION_BODY, ReadWriteRequest
from achse.ams.notification import NotificationStream
from achse.devices.station import FAULTS, STATISTICS
from achse.testing import free_host

HOST = free_host()
PLC = AmsAddress(f"{HOST}.1.1:851")
OWN = AmsAddress(f"{HOST}.1.1:26000")
SUBSCRIPTIONS = 10
CYCLE_MS = 100
STAY_S = 30.0
"""Mean time that a client stays."""

FAULT_EVERY_S = 2.0
FAULTS_TO_FIRE = (
    {"kind": "drop", "port": 851, "count": 5},
    {"kind": "delay", "port": 851, "by": 0.05, "count": 20},
    {"kind": "duplicate", "port": 851, "count": 20},
    {"kind": "reorder", "port": 851, "by": 0.05, "count": 20},
    {"kind": "cut", "port": 851, "count": 2},
    {"kind": "wrong_invoke_id", "port": 851, "count": 5},
    {"kind": "error", "port": 851, "group": 0x4020, "offset": 8, "code": 0x706, "count": 5},
)
"""None of them hits the steady client: each is of one churning client's NetId."""


class Client(asyncio.Protocol):
    """A bare client: requests with an answer each, and samples that are handed on."""

    def __init__(self, address: AmsAddress) -> None:
        self.address = address
        self.answers: dict[int, asyncio.Future[bytes]] = {}
        self.samples: list[tuple[int, bytes]] = []
        self.keep = False
        self.stream = Connection()
        self.number = 0
        self.transport: asyncio.Transport

    @classmethod
    async def dial(cls, address: AmsAddress) -> "Client":
        loop = asyncio.get_running_loop()
        _, client = await loop.create_connection(lambda: cls(address), HOST, 48898)
        return client

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport  # type: ignore[assignment]

    def connection_lost(self, failure: Exception | None) -> None:
        for answer in self.answers.values():
            if not answer.done():
                answer.set_exception(ConnectionResetError())
                answer.exception()

    def data_received(self, data: bytes) -> None:
        with contextlib.suppress(DecodeError):
            for event in self.stream.receive(data):
                if not isinstance(event, Frame):
                    continue
                if event.command == Command.NOTIFICATION:
                    if self.keep:
                        for stamp, samples in NotificationStream.decode(event.data).stamps:
                            self.samples += [(stamp, value) for _, value in samples]
                elif (answer := self.answers.pop(event.invoke_id, None)) and not answer.done():
                    answer.set_result(event.data)

    async def ask(
        self, target: AmsAddress, command: Command, data: bytes, patience: float = 2.0
    ) -> bytes:
        self.number += 1
        answer = self.answers[self.number] = asyncio.get_running_loop().create_future()
        frame = Frame(target, self.address, command, 4, 0, self.number, data)
        self.transport.write(frame.encode_tcp())
        return await asyncio.wait_for(answer, patience)

    async def subscribe(self, offset: int, mode: int = 3) -> None:
        cycle = CYCLE_MS * 10_000
        body = ADD_NOTIFICATION_BODY.pack(0x4020, offset, 4, mode, 0, cycle)
        await self.ask(PLC, Command.ADD_NOTIFICATION, body)


class Churn:
    """All the clients that come and go."""

    def __init__(self, seed: int = 1) -> None:
        self.random = random.Random(seed)
        self.came = 0
        self.endings: dict[str, int] = {}

    async def live(self, number: int, end: float) -> None:
        """One place: client after client."""
        await asyncio.sleep(self.random.uniform(0, 5))
        while time.monotonic() < end:
            self.came += 1
            port = 30_000 + self.came % 30_000
            address = AmsAddress(f"10.{number >> 8 & 255}.{number & 255}.1.1.1:{port}")
            with contextlib.suppress(OSError, TimeoutError, asyncio.CancelledError):
                await self.stay(address, end)

    async def stay(self, address: AmsAddress, end: float) -> None:
        client = await Client.dial(address)
        ending = self.random.choice(("close", "abort", "silent", "garbage", "knock", "half"))
        self.endings[ending] = self.endings.get(ending, 0) + 1
        try:
            if ending == "knock":
                return
            for offset in range(0, 4 * SUBSCRIPTIONS, 4):
                with contextlib.suppress(TimeoutError):
                    await client.subscribe(offset, self.random.choice((3, 4)))
            if ending == "silent":
                client.transport.pause_reading()
            stay = self.random.expovariate(1 / STAY_S)
            await asyncio.sleep(min(stay, max(0.0, end - time.monotonic())))
            if ending == "garbage":
                client.transport.write(self.random.randbytes(200))
            elif ending == "half":
                frame = Frame(PLC, address, Command.READ_STATE).encode_tcp()
                client.transport.write(frame[:20])
        finally:
            client.transport.abort() if ending != "close" else client.transport.close()


async def fire(own: Client, end: float, churn: Churn, clients: int) -> int:
    """Add a fault every now and then; how many."""
    fired = 0
    while time.monotonic() < end - 1:
        await asyncio.sleep(FAULT_EVERY_S)
        number = churn.random.randrange(clients)
        victim = f"10.{number >> 8 & 255}.{number & 255}.1.1.1"
        fault = churn.random.choice(FAULTS_TO_FIRE) | {"client": victim, "lasting": 10.0}
        request = ReadWriteRequest(FAULTS, 0, 1000, json.dumps(fault).encode())
        answer = await own.ask(OWN, Command.READ_WRITE, request.encode(), 30)
        assert b'"number"' in answer, answer
        fired += 1
    return fired


def memory_mb(process_id: int) -> float:
    """Resident memory of a process."""
    for line in Path(f"/proc/{process_id}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return 0.0


def processor_s(process_id: int) -> tuple[float, float]:
    """Seconds that the main thread of a process was on a processor, and waited for one."""
    ran, waited, _ = Path(f"/proc/{process_id}/schedstat").read_text().split()
    return int(ran) / 1e9, int(waited) / 1e9


async def watch_memory(process_id: int, end: float) -> list[float]:
    figures = []
    while time.monotonic() < end:
        await asyncio.sleep(min(10.0, max(0.1, end - time.monotonic())))
        figures.append(memory_mb(process_id))
    return figures


def main(seconds: float, clients: int) -> None:
    arguments = ["run", "--host", HOST, "--net-id", f"{HOST}.1.1", "--log-format", "json"]
    with tempfile.TemporaryFile("w+") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "achse", *arguments],
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        )
        assert process.stdout is not None
        ready = process.stdout.readline()
        try:
            if not ready.startswith("achse ready"):
                raise SystemExit(f"the station does not start: {ready}{_read(log)}")
            asyncio.run(measure(process.pid, seconds, clients))
        finally:
            process.terminate()
            process.wait()
        records = [json.loads(line) for line in _read(log).splitlines()]
    kinds = Counter((record["level"], _kind(record["message"])) for record in records)
    for (level, kind), count in kinds.most_common():
        print(f"log: {count} × {level}: {kind}")
    print(f"exit code {process.returncode}")


def _kind(message: str) -> str:
    """A message without what is different each time."""
    _, _, reason = message.rpartition(": ")
    return re.sub(r"\b0x[0-9A-F]+|\b\d[\d.:]*", "…", reason)


def _read(log: IO[str]) -> str:
    log.seek(0)
    return log.read()


async def measure(process_id: int, seconds: float, clients: int) -> None:
    begin = time.monotonic()
    end = begin + seconds
    steady = await Client.dial(AmsAddress("192.0.2.77.1.1:40000"))
    own = await Client.dial(AmsAddress("192.0.2.78.1.1:40001"))
    steady.keep = True
    await steady.subscribe(100)
    churn = Churn()
    firing = asyncio.create_task(fire(own, end, churn, clients))
    memory = asyncio.create_task(watch_memory(process_id, end))
    await asyncio.gather(*(churn.live(number, end) for number in range(clients)))
    fired, figures = await firing, await memory
    await asyncio.sleep(0.5)
    answer = await own.ask(OWN, Command.READ, struct.pack("<III", STATISTICS, 0, 1 << 20), 30)
    statistics = json.loads(answer[8:])
    ran, waited = processor_s(process_id)
    stamps = [stamp for stamp, _ in steady.samples]
    step = CYCLE_MS * 10_000
    missed = sum(
        round((after - before) / step) - 1
        for before, after in pairwise(stamps[1:])  # the first one comes with the subscription
    )
    print(f"{churn.came} clients came in {seconds:g} s, {fired} faults fired; {churn.endings}")
    print(
        f"steady client: {len(stamps)} samples in {time.monotonic() - begin:.0f} s, {missed} missed"
    )
    print(f"station: {ran:.0f} s on a processor, {waited:.0f} s waiting for one")
    tenths = [figures[len(figures) * n // 10] for n in range(10)]
    print("memory: " + " ".join(f"{each:.0f}" for each in (*tenths, figures[-1])) + " MB")
    print("station: " + json.dumps({k: v for k, v in statistics.items() if k != "devices"}))
    for device in statistics["devices"]:
        if device["subscriptions"]:
            print(f"left on {device['ports']}: {device['subscriptions']} subscriptions")


if __name__ == "__main__":
    main(
        float(sys.argv[1]) if len(sys.argv) > 1 else 600.0,
        int(sys.argv[2]) if len(sys.argv) > 2 else 1000,
    )
