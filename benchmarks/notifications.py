"""8,192 cyclic notifications at 100 ms to one client: how many samples arrive, how many are missed.

Counted by the frames of a bare client, after every subscription has had its first sample.
Usage: python benchmarks/notifications.py [SUBSCRIPTIONS] [SECONDS]
"""

import asyncio
import struct
import sys
import time

from processes import station

from achse.ams import AmsAddress, Command, Connection, Frame
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.ams.notification import NotificationStream

HOST = "127.0.0.79"
TARGET = AmsAddress(f"{HOST}.1.1:851")
SOURCE = AmsAddress("127.0.0.78.1.1:40000")
CYCLE_MS = 100


class Counter(asyncio.Protocol):
    """Collects answers by invoke id and counts samples per handle."""

    def __init__(self) -> None:
        self.stream = Connection()
        self.answers: dict[int, asyncio.Future[bytes]] = {}
        self.samples: dict[int, int] = {}
        self.counting = False
        self.frames = 0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        for event in self.stream.receive(data):
            assert isinstance(event, Frame)
            if event.command != Command.NOTIFICATION:
                self.answers.pop(event.invoke_id).set_result(event.data)
            elif self.counting:
                self.frames += 1
                for stamp in NotificationStream.decode(event.data).stamps:
                    for sample in stamp.samples:
                        self.samples[sample.handle] = self.samples.get(sample.handle, 0) + 1

    async def ask(self, invoke_id: int, command: Command, data: bytes) -> bytes:
        answer = asyncio.get_running_loop().create_future()
        self.answers[invoke_id] = answer
        frame = Frame(TARGET, SOURCE, command, invoke_id=invoke_id, data=data)
        self.transport.write(frame.encode_tcp())  # type: ignore[attr-defined]
        return await answer


async def count(subscriptions: int, seconds: float) -> None:
    loop = asyncio.get_running_loop()
    _, client = await loop.create_connection(Counter, HOST, 48898)
    (handle,) = struct.unpack(
        "<8xI",
        await client.ask(1, Command.READ_WRITE,
                         struct.pack("<IIII", 0xF003, 0, 4, 13) + b"MAIN.nCounter"),
    )  # fmt: skip
    body = ADD_NOTIFICATION_BODY.pack(0xF005, handle, 4, 3, 0, CYCLE_MS * 10_000)
    added = await asyncio.gather(
        *(client.ask(2 + n, Command.ADD_NOTIFICATION, body) for n in range(subscriptions))
    )
    handles = [struct.unpack("<II", answer)[1] for answer in added]
    await asyncio.sleep(0.5)
    client.counting = True
    start = time.perf_counter()
    await asyncio.sleep(seconds)
    client.counting = False
    elapsed = time.perf_counter() - start
    received = sum(client.samples.get(handle, 0) for handle in handles)
    expected = subscriptions * elapsed / (CYCLE_MS / 1e3)
    missed = max(0.0, 1 - received / expected)
    print(f"{subscriptions} notifications every {CYCLE_MS} ms for {elapsed:.1f} s")
    print(f"  {received} samples in {client.frames} frames, {received / elapsed:.0f} per second")
    print(f"  fewest of one subscription {min(client.samples.get(h, 0) for h in handles)}")
    print(f"  missed {missed:.3%}   (below 0.5 % is promised; one cycle of {seconds:g} s is"
          f" {CYCLE_MS / 10 / seconds:.2f} %)")  # fmt: skip


def main(subscriptions: int = 8192, seconds: float = 30) -> None:
    with station(HOST):
        asyncio.run(count(int(subscriptions), seconds))


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
