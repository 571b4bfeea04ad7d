"""1,000 clients with 10 subscriptions each come and go while faults fire; a steady one watches.

Clients stay for a while and leave as clients do: some say good-bye, some vanish, some stop reading,
some send garbage, some only knock. They take handles and files, and give back some of them; every
other one comes from an address that another client had before it. Beside them one client has a
cyclic subscription and must miss nothing. Printed at the end: memory of the station, samples
missed, connections, what was logged, and how long the station had to wait for a processor (Linux).

It ends with code 1 if the steady client missed a sample, if a client got one that it never asked
for, if anything of a client is left after the last has gone, if the station's memory goes on
growing, or if the station reports an error.

Usage: python benchmarks/churn.py [SECONDS] [CLIENTS] [SPEED]
(default: 600 s of station time, 1000 clients, as fast as the clock)
"""

import asyncio
import contextlib
import json
import os
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
from achse.codes import ReservedGroup
from achse.devices.station import FAULTS, STATISTICS
from achse.testing import free_host

HOST = free_host()
PLC = AmsAddress(f"{HOST}.1.1:851")
OWN = AmsAddress(f"{HOST}.1.1:26000")
SYSTEM = AmsAddress(f"{HOST}.1.1:10000")
SUBSCRIPTIONS = 10
NAMES = (b"GVL.nInt\0", b"GVL.fLreal\0", b"GVL.sString\0", b"MAIN.nCounter\0")
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


SETTLES_S = 20.0
"""Station time in which everything of clients that are gone must be gone too."""

GROWTH_MB = 40.0
"""What the station may grow by after its first fifth: what a crowd of that size holds, and what
the allocator keeps. A leak passes it sooner or later."""

CONFIG = """
[system]
root = "files"
[limits]
unreachable_time = "5s"
[[plc]]
globals = ["achse.station.demo:GVL"]
[[plc.task]]
cycle = "10ms"
programs = ["achse.station.demo:MAIN"]
"""


class Client(asyncio.Protocol):
    """A bare client: requests with an answer each, and samples that are handed on."""

    def __init__(self, address: AmsAddress) -> None:
        self.address = address
        self.answers: dict[int, asyncio.Future[bytes]] = {}
        self.samples: list[tuple[int, bytes]] = []
        self.keep = False
        self.asked_for_samples = False
        self.foreign = 0
        """Samples that came before any were asked for."""
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
                    self.foreign += not self.asked_for_samples
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
        self.asked_for_samples = True
        cycle = CYCLE_MS * 10_000
        body = ADD_NOTIFICATION_BODY.pack(0x4020, offset, 4, mode, 0, cycle)
        await self.ask(PLC, Command.ADD_NOTIFICATION, body)

    async def call(self, target: AmsAddress, group: int, offset: int, data: bytes) -> int:
        """A ReadWrite that answers four bytes: their number, 0 if it was refused."""
        request = ReadWriteRequest(group, offset, 4, data)
        answer = await self.ask(target, Command.READ_WRITE, request.encode())
        return int.from_bytes(answer[8:12], "little")

    async def take_handles(self, back: bool) -> None:
        """Handles of symbols; every other one is given back."""
        for number, name in enumerate(NAMES * 3):
            handle = await self.call(PLC, ReservedGroup.SYMBOL_HANDLE_BY_NAME, 0, name)
            if handle and back and number % 2:
                body = struct.pack("<IIII", ReservedGroup.RELEASE_SYMBOL_HANDLE, 0, 4, handle)
                await self.ask(PLC, Command.WRITE, body)

    async def use_files(self, number: int, back: bool) -> None:
        """Write a file, read it; close it or leave it open."""
        path = b"churn%d.txt\0" % (number % 50)
        for mode in (FILE_WRITE, FILE_READ):
            handle = await self.call(SYSTEM, FILE_OPEN, 1 << 16 | mode, path)
            if handle:
                if mode == FILE_WRITE:
                    await self.call(SYSTEM, FILE_WRITES, handle, b"x" * 1000)
                if back:
                    await self.call(SYSTEM, FILE_CLOSE, handle, b"")


FILE_OPEN, FILE_CLOSE, FILE_WRITES = 120, 121, 123
FILE_READ, FILE_WRITE = 0x11, 0x12


class Churn:
    """All the clients that come and go; times are of the station, which runs at `speed`."""

    def __init__(self, speed: float, seed: int = 1) -> None:
        self.random = random.Random(seed)
        self.speed = speed
        self.came = 0
        self.returned = 0
        self.foreign = 0
        self.endings: dict[str, int] = {}
        self.left: list[AmsAddress] = []
        """Addresses whose clients are gone."""

    async def live(self, number: int, end: float) -> None:
        """One place: client after client."""
        await asyncio.sleep(self.random.uniform(0, 5) / self.speed)
        while time.monotonic() < end:
            self.came += 1
            port = 30_000 + self.came % 30_000
            address = AmsAddress(f"10.{number >> 8 & 255}.{number & 255}.1.1.1:{port}")
            if self.left and self.random.random() < 0.5:
                address = self.left.pop(self.random.randrange(len(self.left)))
                self.returned += 1
            with contextlib.suppress(OSError, TimeoutError, asyncio.CancelledError):
                await self.stay(address, end)
            self.left.append(address)

    async def stay(self, address: AmsAddress, end: float) -> None:
        client = await Client.dial(address)
        try:
            with contextlib.suppress(TimeoutError):  # what it hears before it asks for samples
                await client.ask(PLC, Command.READ_STATE, b"")
                await asyncio.sleep(2.5 * CYCLE_MS / 1000 / self.speed)
            self.foreign += client.foreign
            await self.use(client, end)
        finally:
            client.transport.abort()

    async def use(self, client: Client, end: float) -> None:
        ending = self.random.choice(("close", "abort", "silent", "garbage", "knock", "half"))
        self.endings[ending] = self.endings.get(ending, 0) + 1
        back = self.random.random() < 0.5
        try:
            if ending == "knock":
                return
            with contextlib.suppress(TimeoutError):
                await client.take_handles(back)
                await client.use_files(self.came, back)
            for offset in range(0, 4 * SUBSCRIPTIONS, 4):
                with contextlib.suppress(TimeoutError):
                    await client.subscribe(offset, self.random.choice((3, 4)))
            if ending == "silent":
                client.transport.pause_reading()
            stay = self.random.expovariate(1 / STAY_S)
            await asyncio.sleep(min(stay / self.speed, max(0.0, end - time.monotonic())))
            if ending == "garbage":
                client.transport.write(self.random.randbytes(200))
            elif ending == "half":
                frame = Frame(PLC, client.address, Command.READ_STATE).encode_tcp()
                client.transport.write(frame[:20])
        finally:
            if ending == "close":
                client.transport.close()


async def fire(own: Client, end: float, churn: Churn, clients: int) -> int:
    """Add a fault every now and then; how many."""
    fired = 0
    while time.monotonic() < end - 1:
        await asyncio.sleep(FAULT_EVERY_S / churn.speed)
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


def open_files(process_id: int, folder: Path) -> int:
    """How many files below a folder a process has open."""
    count = 0
    for link in Path(f"/proc/{process_id}/fd").iterdir():
        with contextlib.suppress(OSError):
            count += Path(os.readlink(link)).is_relative_to(folder)
    return count


async def watch_memory(process_id: int, end: float) -> list[float]:
    figures = []
    while time.monotonic() < end:
        await asyncio.sleep(min(2.0, max(0.1, end - time.monotonic())))
        figures.append(memory_mb(process_id))
    return figures


def main(seconds: float = 600.0, clients: float = 1000, speed: float = 1.0) -> None:
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as log:
        (Path(folder) / "files").mkdir()
        config = Path(folder) / "churn.toml"
        config.write_text(CONFIG)
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", "achse", "run", str(config), "--speed", str(speed)),
                *("--host", HOST, "--net-id", f"{HOST}.1.1", "--log-format", "json"),
            ],
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        )
        assert process.stdout is not None
        ready = process.stdout.readline()
        try:
            if not ready.startswith("achse ready"):
                raise SystemExit(f"the station does not start: {ready}{_read(log)}")
            run = measure(process.pid, Path(folder).resolve(), seconds, int(clients), speed)
            faults = asyncio.run(run)
        finally:
            process.terminate()
            process.wait()
        records = [json.loads(line) for line in _read(log).splitlines()]
    kinds = Counter((record["level"], _kind(record["message"])) for record in records)
    for (level, kind), count in kinds.most_common():
        print(f"log: {count} × {level}: {kind}")
        if level in ("error", "critical"):
            faults.append(f"the station reports: {kind}")
    print(f"exit code {process.returncode}")
    if process.returncode:
        faults.append(f"the station ended with code {process.returncode}")
    if faults:
        raise SystemExit("FAILED: " + "; ".join(faults))


def _kind(message: str) -> str:
    """A message without what is different each time."""
    _, _, reason = message.rpartition(": ")
    return re.sub(r"\b0x[0-9A-F]+|\b\d[\d.:]*", "…", reason)


def _read(log: IO[str]) -> str:
    log.seek(0)
    return log.read()


async def settle(own: Client, process_id: int, folder: Path, speed: float) -> dict[str, int]:
    """What is left of clients that are gone, once it is nothing or the time for it is over."""
    end = time.monotonic() + max(SETTLES_S / speed, 5.0)
    while True:
        answer = await own.ask(OWN, Command.READ, struct.pack("<III", STATISTICS, 0, 1 << 20), 30)
        statistics = json.loads(answer[8:])
        devices = statistics["devices"]
        left = {
            "subscriptions": sum(device["subscriptions"] for device in devices) - 1,
            "handles": sum(device["handles"] for device in devices)
            - statistics["handles_abandoned"],  # any client may use them, they are bounded
            "connections": statistics["connections"] - 2,
            "queued bytes": sum(device["queued_bytes"] for device in devices),
            "open files": open_files(process_id, folder),
        }
        if not any(left.values()) or time.monotonic() > end:
            print("station: " + json.dumps({k: v for k, v in statistics.items() if k != "devices"}))
            return left
        await asyncio.sleep(0.1)


async def measure(
    process_id: int, folder: Path, seconds: float, clients: int, speed: float
) -> list[str]:
    """Let clients come and go; what is wrong then."""
    begin = time.monotonic()
    end = begin + seconds / speed
    steady = await Client.dial(AmsAddress("192.0.2.77.1.1:40000"))
    own = await Client.dial(AmsAddress("192.0.2.78.1.1:40001"))
    steady.keep = True
    await steady.subscribe(100)
    churn = Churn(speed)
    firing = asyncio.create_task(fire(own, end, churn, clients))
    memory = asyncio.create_task(watch_memory(process_id, end))
    await asyncio.gather(*(churn.live(number, end) for number in range(clients)))
    fired, figures = await firing, await memory
    left = await settle(own, process_id, folder, speed)
    ran, waited = processor_s(process_id)
    stamps = [stamp for stamp, _ in steady.samples]
    step = CYCLE_MS * 10_000
    missed = sum(
        round((after - before) / step) - 1
        for before, after in pairwise(stamps[1:])  # the first one comes with the subscription
    )
    print(
        f"{churn.came} clients came in {seconds:g} s, {churn.returned} of them again at an address,"
        f" {fired} faults fired; {churn.endings}"
    )
    print(
        f"steady client: {len(stamps)} samples in {time.monotonic() - begin:.0f} s, {missed} missed"
    )
    print(f"foreign samples: {churn.foreign}; left: {left}")
    print(f"station: {ran:.0f} s on a processor, {waited:.0f} s waiting for one")
    tenths = [figures[len(figures) * n // 10] for n in range(10)]
    print("memory: " + " ".join(f"{each:.0f}" for each in (*tenths, figures[-1])) + " MB")
    growth = max(figures) - max(figures[: len(figures) // 5 + 1])
    return [
        fault
        for wrong, fault in (
            (missed or not stamps, f"the steady client missed {missed} of {len(stamps)} samples"),
            (churn.foreign, f"{churn.foreign} samples came that nobody had asked for"),
            (any(left.values()), f"of clients that are gone is left: {left}"),
            (growth > GROWTH_MB, f"the station grew by {growth:.0f} MB"),
            (not churn.came, "no client came"),
        )
        if wrong
    ]


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
