"""Requests through `achse router`: instructions beside a bare forwarder, throughput beside direct.

Instructions: requests from a client and their answers from the target, without sockets: 64 reads
in one portion, 64 reads, writes and sums of different lengths in one portion, one read in a
portion. The bare forwarder in Python knows no limits, rights, ledger or routes: it gives each
connection and address a port, rewrites the two addresses and writes what came in one piece, at
once. What the router writes at the end of a turn of its loop counts with that turn. Callgrind
counts (valgrind).
Throughput: reads of 4 bytes, 64 under way, from a station directly and through a router process,
and the processor time of each process, which does not depend on what else the machine does.
Time: the same works by the clock of the processor, the best of some rounds.
Usage: python benchmarks/forwarding.py instructions [SHAPE …] | time [ROUNDS] | throughput [SECONDS]
"""

import asyncio
import os
import re
import statistics
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from processes import running, station

import achse
from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import DataResponse, ReadRequest, ReadWriteRequest, WriteRequest
from achse.router import Router
from achse.router.routes import Route
from achse.transport.connections.connection import TcpConnection
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener
from achse.transport.uplinks.uplink import Uplink

PORTION = 64
TARGET, CLIENT = AmsAddress("5.0.0.9.1.1:851"), AmsAddress("192.168.0.9.1.1:30000")
OWN = NetId("5.0.0.1.1.1")
FRAME = struct.Struct("<HI8s8s")

Work = Callable[[], object]


class Sink(asyncio.Transport):
    """Keeps what was written."""

    def __init__(self) -> None:
        super().__init__({"peername": ("127.0.0.1", 1)})
        self.written = b""

    def write(self, data: Any) -> None:
        self.written += data

    def get_write_buffer_size(self) -> int:
        return 0

    def set_write_buffer_limits(self, high: Any = None, low: Any = None) -> None:
        pass

    def abort(self) -> None:
        pass


class BareForwarder:
    """Rewrites addresses between connections of clients and one target."""

    def __init__(self, target: Sink) -> None:
        self.target = target
        self.ports: dict[tuple[Sink, bytes], bytes] = {}
        self.clients: dict[bytes, tuple[Sink, bytes]] = {}

    def from_client(self, client: Sink, data: bytes) -> None:
        out: list[bytes] = []
        position = 0
        while position < len(data):
            _, length, _, source = FRAME.unpack_from(data, position)
            alias = self.ports.get((client, source))
            if alias is None:
                alias = OWN + (32768 + len(self.ports)).to_bytes(2, "little")
                self.ports[client, source] = alias
                self.clients[alias] = client, source
            end = position + 6 + length
            out += data[position : position + 14], alias, data[position + 22 : end]
            position = end
        self.target.write(b"".join(out))

    def from_target(self, data: bytes) -> None:
        out: dict[Sink, list[bytes]] = {}
        position = 0
        while position < len(data):
            _, length, alias, _ = FRAME.unpack_from(data, position)
            client, source = self.clients[alias]
            end = position + 6 + length
            parts = out.setdefault(client, [])
            parts += data[position : position + 6], source, data[position + 14 : end]
            position = end
        for client, parts in out.items():
            client.write(b"".join(parts))


def reads_of_one_length() -> list[Frame]:
    data = ReadRequest(0x4020, 0, 4).encode()
    return [Frame(TARGET, CLIENT, Command.READ, 4, 0, n, data) for n in range(PORTION)]


def one_read() -> list[Frame]:
    return reads_of_one_length()[:1]


def mixed() -> list[Frame]:
    """Reads, writes and sums, each of another length than the one before it."""
    frames = []
    for n in range(PORTION):
        command, data = (
            (Command.READ, ReadRequest(0x4020, n, n % 7 + 1).encode()),
            (Command.WRITE, WriteRequest(0x4020, n, bytes(n % 5 + 1)).encode()),
            (Command.READ_WRITE, ReadWriteRequest(0xF080, 2, 16, bytes(24)).encode()),
        )[n % 3]
        frames.append(Frame(TARGET, CLIENT, command, 4, 0, n, data))
    return frames


SHAPES: dict[str, Callable[[], list[Frame]]] = {
    "reads": reads_of_one_length,
    "mixed": mixed,
    "single": one_read,
}


def answers(forwarded: bytes, requests: list[Frame]) -> bytes:
    """The answers of the target to requests that it got."""
    _, _, _, alias = FRAME.unpack_from(forwarded)
    parts = []
    for each in requests:
        length = 0 if each.command == Command.WRITE else int.from_bytes(each.data[8:12], "little")
        data = (
            bytes(4) if each.command == Command.WRITE else DataResponse(0, bytes(length)).encode()
        )
        answer = Frame(alias, TARGET, each.command, 5, 0, each.invoke_id, data)
        parts.append(answer.encode_tcp())
    return b"".join(parts)


def bare(requests: list[Frame]) -> Work:
    client, target = Sink(), Sink()
    forwarder = BareForwarder(target)
    portion = b"".join(each.encode_tcp() for each in requests)
    forwarder.from_client(client, portion)
    back = answers(target.written, requests)

    def work() -> None:
        target.written = client.written = b""
        forwarder.from_client(client, portion)
        forwarder.from_target(back)

    work()
    assert len(client.written) == len(back)
    return work


def routed(requests: list[Frame]) -> Work:
    loop = asyncio.new_event_loop()

    async def connected() -> tuple[TcpConnection, TcpConnection, Sink, Sink]:
        router = Router(OWN, source_nat=True)
        listener = TcpListener(router)
        await listener.open(port=0)
        client, target = Sink(), Sink()
        near = TcpConnection(Peer(listener))
        near.connection_made(client)
        route = Route(name="press", net_id=TARGET.net_id, host="127.0.0.1")
        uplink = Uplink(router, route, loop, lambda _: None)
        router.add_route(TARGET.net_id, uplink)
        far = TcpConnection(uplink.make_peer())
        far.connection_made(target)
        return near, far, client, target

    near, far, client, target = loop.run_until_complete(connected())

    ready: Any = vars(loop)["_ready"]

    def turn() -> None:
        """A turn of the loop, if something waits for it."""
        if ready:
            loop.call_soon(loop.stop)
            loop.run_forever()

    portion = b"".join(each.encode_tcp() for each in requests)
    near.data_received(portion)
    turn()
    back = answers(target.written, requests)
    far.data_received(back)
    turn()

    def work() -> None:
        target.written = client.written = b""
        near.data_received(portion)
        turn()
        far.data_received(back)
        turn()

    work()
    assert len(client.written) == len(back), (len(client.written), len(back))
    return work


WORKS: dict[str, Callable[[list[Frame]], Work]] = {"bare": bare, "routed": routed}


def instructions(work: str, shape: str, repetitions: int) -> int:
    """Instructions of a process that does a work so often."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", sys.executable]
    command += [__file__, "run", work, shape, str(repetitions)]
    same = {**os.environ, "PYTHONHASHSEED": "0"}  # each start does the same
    output = subprocess.run(command, capture_output=True, text=True, check=True, env=same).stderr
    return int(re.findall(r"Collected : (\d+)", output)[0])


def microseconds(work: Work, requests: int, rounds: int) -> float:
    """Processor time of one request and its answer in the best round, µs."""
    best = float("inf")
    for _ in range(rounds):
        begin = time.process_time()
        for _ in range(20):
            work()
        best = min(best, time.process_time() - begin)
    return best / 20 / requests * 1e6


async def reads(host: str, port: int, net_id: str, seconds: float) -> float:
    """Answers per second, and none is an error."""
    async with achse.connect(f"{host}:{port}", net_id=net_id, port=10_000) as client:
        end = time.monotonic() + seconds
        count, begin = 0, time.monotonic()

        async def ask() -> None:
            nonlocal count
            while time.monotonic() < end:
                await client.read_raw(0xF0, 0, 16)
                count += 1

        await asyncio.gather(*(ask() for _ in range(PORTION)))
        return count / (time.monotonic() - begin)


def processor_times() -> list[float]:
    """Processor time of this process and its children, the oldest first, s; 0 without /proc."""
    listed = Path(f"/proc/self/task/{os.getpid()}/children")
    if not listed.exists():
        return [0.0] * 3
    processes = [str(os.getpid()), *listed.read_text().split()]
    fields = (
        Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split() for each in processes
    )
    ticks = os.sysconf("SC_CLK_TCK")
    return [(int(each[11]) + int(each[12])) / ticks for each in fields]


def throughput(seconds: float) -> None:
    with station("127.0.0.81", "--log-level", "error") as port:
        words = ["-m", "achse", "router", "--to", f"127.0.0.81:{port}=127.0.0.81.1.1"]
        words += ["--host", "127.0.0.82", "--net-id", "127.0.0.82.1.1"]
        with running(*words, ready="achse ready"):
            places = {"direct": "127.0.0.81", "through the router": "127.0.0.82"}
            rates: dict[str, list[float]] = {name: [] for name in places}
            times = {name: [0.0, 0.0, 0.0] for name in places}
            for _ in range(5):
                for name, host in places.items():
                    before = processor_times()
                    rate = asyncio.run(reads(host, 48898, "127.0.0.81.1.1", seconds))
                    rates[name].append(rate)
                    spent = zip(times[name], processor_times(), before, strict=True)
                    times[name] = [
                        total + (now - then) / rate / seconds / 5 for total, now, then in spent
                    ]
    for name, (client, server, router) in times.items():
        print(f"{name:20} client {client * 1e6:5.1f} µs, station {server * 1e6:5.1f} µs,", end=" ")
        print(f"router {router * 1e6:5.1f} µs of a processor a read")
    medians = {name: statistics.median(each) for name, each in rates.items()}
    for name, rate in medians.items():
        print(f"{name:20} {rate:8.0f} reads/s")
    direct, through = medians.values()
    print(f"share {through / direct:.2f}")


def main(what: str = "instructions", *words: str) -> None:
    if what == "run":
        work = WORKS[words[0]](SHAPES[words[1]]())
        for _ in range(int(words[2])):
            work()
    elif what == "time":
        for shape, make in SHAPES.items():
            requests = make()
            for name, work_of in WORKS.items():
                rounds = int(words[0]) if words else 20
                duration = microseconds(work_of(requests), len(requests), rounds)
                print(f"{shape:8} {name:8} {duration:6.2f} µs per request and answer")
    elif what == "throughput":
        throughput(float(words[0]) if words else 1.0)
    else:
        for shape in words or SHAPES:
            count = len(SHAPES[shape]())
            each = {}
            for name in WORKS:
                more, less = (instructions(name, shape, n * PORTION // count) for n in (250, 50))
                each[name] = (more - less) / (200 * PORTION)
                print(f"{shape:8} {name:8} {each[name]:8.0f} instructions per request and answer")
            print(f"{shape:8} ratio {each['routed'] / each['bare']:.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
