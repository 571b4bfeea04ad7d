"""64 requests under way at once: our station beside two bare responders, in turns.

A responder reads the header and answers 4 bytes; one is written with asyncio's streams, the other
as a protocol that answers all that came in one write: no server in Python can do less. Both run
in uvloop's loop where it is installed, as the station does. Two clients
ask each of them: achse's own, 64 tasks that await one read after the other, and a counting one
that keeps 64 Reads on the wire without looking at the answers, which shows the servers alone.
Usage: python benchmarks/outstanding.py [REQUESTS] [ROUNDS]
"""

import asyncio
import statistics
import struct
import sys
import time
from collections.abc import Coroutine

from processes import HERE, running, station

import achse
from achse.ams import AmsAddress, Command, Frame
from achse.ams.commands import DataResponse, ReadRequest
from achse.testing import free_host

OURS = free_host()
WINDOW = 64
ANSWER = DataResponse(0, bytes(4)).encode()


async def respond(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Read a header, answer 4 bytes, again and again."""
    while True:
        try:
            header = await reader.readexactly(38)
        except (asyncio.IncompleteReadError, ConnectionError):
            break
        (size,) = struct.unpack_from("<I", header, 26)
        await reader.readexactly(size)
        writer.write(
            struct.pack("<HI", 0, 32 + len(ANSWER)) + header[14:22] + header[6:14]
            + struct.pack("<HHII", 2, 5, len(ANSWER), 0) + header[34:38] + ANSWER
        )  # fmt: skip


class Responder(asyncio.Protocol):
    """The same for all frames that have come, in one write."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport
        self.pending = b""

    def data_received(self, data: bytes) -> None:
        data = self.pending + data
        position = 0
        answers = []
        while len(data) - position >= 6:
            (length,) = struct.unpack_from("<I", data, position + 2)
            end = position + 6 + length
            if end > len(data):
                break
            target = data[position + 6 : position + 14]
            source = data[position + 14 : position + 22]
            invoke_id = data[position + 34 : position + 38]
            answers.append(
                struct.pack("<HI8s8sHHII", 0, 32 + len(ANSWER), source, target, 2, 5,
                            len(ANSWER), 0) + invoke_id + ANSWER
            )  # fmt: skip
            position = end
        self.pending = data[position:]
        self.transport.write(b"".join(answers))  # type: ignore[attr-defined]


async def serve() -> None:
    loop = asyncio.get_running_loop()
    streams = await asyncio.start_server(respond, "127.0.0.1", 0)
    protocol = await loop.create_server(Responder, "127.0.0.1", 0)
    ports = (server.sockets[0].getsockname()[1] for server in (streams, protocol))
    print("peer ready", *ports, flush=True)
    await asyncio.gather(streams.serve_forever(), protocol.serve_forever())


async def serve_at(host: str) -> None:
    """The protocol alone, at the port of ADS."""
    loop = asyncio.get_running_loop()
    server = await loop.create_server(Responder, host, 48898)
    print("peer ready", flush=True)
    await server.serve_forever()


def run(work: Coroutine[None, None, None]) -> None:
    """In the loop that a station has: uvloop's where it is installed."""
    try:
        from uvloop import new_event_loop
    except ImportError:
        from asyncio import new_event_loop  # type: ignore[assignment]
    with asyncio.Runner(loop_factory=new_event_loop) as runner:
        runner.run(work)


class Asker(asyncio.Protocol):
    """Keeps `WINDOW` requests under way until `requests` are answered."""

    def __init__(self, request: bytes, answer_size: int, requests: int) -> None:
        self.request = request
        self.answer_size = answer_size
        self.left = requests
        self.to_send = requests
        self.received = 0
        self.done = asyncio.get_running_loop().create_future()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport
        self.send(WINDOW)

    def send(self, count: int) -> None:
        count = min(count, self.to_send)
        self.to_send -= count
        self.transport.write(self.request * count)  # type: ignore[attr-defined]

    def data_received(self, data: bytes) -> None:
        self.received += len(data)
        answered, self.received = divmod(self.received, self.answer_size)
        self.left -= answered
        self.send(answered)
        if self.left == 0 and not self.done.done():
            self.done.set_result(None)


async def rate_of_client(host: str, port: int, requests: int) -> float:
    """Answers per second to achse's client."""
    async with achse.connect(
        f"{host}:{port}", net_id=f"{OURS}.1.1", port=501, source="192.0.2.75.1.1:40000",
        watch_symbols=False, keep_alive=None,
    ) as nc:  # fmt: skip

        async def ask() -> None:
            for _ in range(requests // WINDOW):
                await nc.read_raw(0x4101, 1, 4)

        start = time.perf_counter()
        await asyncio.gather(*(ask() for _ in range(WINDOW)))
        return requests // WINDOW * WINDOW / (time.perf_counter() - start)


async def rate_of_counter(host: str, port: int, requests: int) -> float:
    """Answers per second to the counting client."""
    target = AmsAddress(f"{OURS}.1.1:501")
    request = Frame(
        target, AmsAddress("192.0.2.75.1.1:40000"), Command.READ, invoke_id=1,
        data=ReadRequest(0x4101, 1, 4).encode(),
    ).encode_tcp()  # fmt: skip
    size = len(Frame(target, target, Command.READ, data=ANSWER).encode_tcp())
    loop = asyncio.get_running_loop()
    start = time.perf_counter()
    transport, asker = await loop.create_connection(
        lambda: Asker(request, size, requests), host, port
    )
    await asker.done
    elapsed = time.perf_counter() - start
    transport.close()
    return requests / elapsed


async def compare(requests: int, rounds: int, streams: int, protocol: int) -> None:
    servers = {
        "achse station": (OURS, 48898),
        "bare, asyncio streams": ("127.0.0.1", streams),
        "bare, asyncio protocol": ("127.0.0.1", protocol),
    }
    print(f"{WINDOW} requests under way, {requests} in all, median of {rounds} rounds in turns")
    for client, rate in (("achse client", rate_of_client), ("counting client", rate_of_counter)):
        rates: dict[str, list[float]] = {name: [] for name in servers}
        for _ in range(rounds):
            for name, (host, port) in servers.items():
                rates[name].append(await rate(host, port, requests))
        print(f"  {client}")
        ours = rates["achse station"]
        for name, theirs in rates.items():
            ratio = statistics.median(a / b for a, b in zip(ours, theirs, strict=True))
            beside = "" if theirs is ours else f"   station/bare {ratio:5.2f}"
            print(f"    {name:24} {statistics.median(theirs):9.0f} answers/s{beside}")


def main(requests: int = 30_000, rounds: int = 7) -> None:
    with (
        station(OURS),
        running(str(HERE / "outstanding.py"), "--serve", ready="peer ready") as line,
    ):
        asyncio.run(compare(requests, rounds, *map(int, line.split()[2:])))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        run(serve())
    elif sys.argv[1:2] == ["--serve-at"]:
        run(serve_at(sys.argv[2]))
    else:
        main(*map(int, sys.argv[1:]))
