"""Notification samples to one client, and how many are lost: by default 100,000 a second.

Every subscription carries the cycle counter of the PLC, a task of 10 ms; a sample that is missing
shows as a gap in its numbers. 1,000 subscriptions at 10 ms and 8,192 at 100 ms are what is promised
without loss, below 0.5 %.
Usage: python benchmarks/samples.py [SUBSCRIPTIONS] [CYCLE_MS] [SECONDS]
"""

import asyncio
import struct
import sys
import time

from processes import station

from achse.ams import AmsAddress, Command, Connection, Frame
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.testing import free_host

HOST = free_host()
TARGET = AmsAddress(f"{HOST}.1.1:851")
SOURCE = AmsAddress("192.0.2.83.1.1:40000")
TASK_MS = 10

STREAM = struct.Struct("<II")
STAMP = struct.Struct("<QI")
SAMPLE = struct.Struct("<III")


class Client(asyncio.Protocol):
    """Checks the counter in each sample against the one before, per handle."""

    def __init__(self, cycle_ms: int) -> None:
        self.step = cycle_ms // TASK_MS
        self.stream = Connection()
        self.answers: dict[int, asyncio.Future[bytes]] = {}
        self.last: dict[int, int] = {}
        self.samples = self.lost = self.frames = 0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        for event in self.stream.receive(data):
            assert isinstance(event, Frame)
            if event.command == Command.NOTIFICATION:
                self.take(event.data)
            else:
                self.answers.pop(event.invoke_id).set_result(event.data)

    def take(self, data: bytes) -> None:
        self.frames += 1
        last = self.last
        _, stamps = STREAM.unpack_from(data)
        position = STREAM.size
        for _ in range(stamps):
            _, count = STAMP.unpack_from(data, position)
            position += STAMP.size
            end = position + SAMPLE.size * count
            for handle, _, value in SAMPLE.iter_unpack(data[position:end]):
                before = last.get(handle)
                if before is not None:
                    self.lost += (value - before) // self.step - 1
                last[handle] = value
            self.samples += count
            position = end

    async def ask(self, invoke_id: int, command: Command, data: bytes) -> bytes:
        answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self.answers[invoke_id] = answer
        frame = Frame(TARGET, SOURCE, command, invoke_id=invoke_id, data=data)
        self.transport.write(frame.encode_tcp())  # type: ignore[attr-defined]
        return await answer


async def measure(subscriptions: int, cycle_ms: int, seconds: float) -> None:
    loop = asyncio.get_running_loop()
    _, client = await loop.create_connection(lambda: Client(cycle_ms), HOST, 48898)
    (handle,) = struct.unpack(
        "<8xI",
        await client.ask(1, Command.READ_WRITE,
                         struct.pack("<IIII", 0xF003, 0, 4, 13) + b"MAIN.nCounter"),
    )  # fmt: skip
    body = ADD_NOTIFICATION_BODY.pack(0xF005, handle, 4, 3, 0, cycle_ms * 10_000)
    await asyncio.gather(
        *(client.ask(2 + n, Command.ADD_NOTIFICATION, body) for n in range(subscriptions))
    )
    await asyncio.sleep(0.5)
    client.samples = client.lost = client.frames = 0
    start = time.perf_counter()
    await asyncio.sleep(seconds)
    elapsed = time.perf_counter() - start
    samples, lost, frames = client.samples, client.lost, client.frames
    print(f"{subscriptions} subscriptions every {cycle_ms} ms for {elapsed:.1f} s")
    print(f"  {samples} samples in {frames} frames, {samples / elapsed:.0f} per second")
    print(f"  {lost} lost, {lost / (samples + lost):.3%}")


def main(subscriptions: float = 1000, cycle_ms: float = 10, seconds: float = 10) -> None:
    with station(HOST):
        asyncio.run(measure(int(subscriptions), int(cycle_ms), seconds))


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
