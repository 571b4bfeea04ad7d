"""Attackers: each floods a station in one way for a second, in a process of its own.

Usage: attacks.py NAME, with what there is to know as JSON on the first line of stdin: host, port
and NetId of the station. It prints "ready" when it is in place; then each further line is one
attack, answered by what the attacker saw, as JSON.
"""

import asyncio
import contextlib
import json
import random
import struct
import sys
import time
from collections.abc import Callable, Coroutine
from typing import Any

from achse.ams import AmsAddress, Command, Connection, Frame, NetId, TcpCommand
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.ams.discovery import ANYBODY, RouteRequest, info_request

SECONDS = 1.0

PLC, NC, LOGGER, EVENTS, SYSTEM, STATION = 851, 500, 100, 110, 10000, 26000
TAPS = 0xFA02
READ_ONE = struct.pack("<III", 0x4020, 0, 4)


class Attacker(asyncio.Protocol):
    """A bare connection: frames out as fast as one likes, answers counted, nothing else."""

    def __init__(self, net_id: str, source: str) -> None:
        self.net_id, self.source = net_id, AmsAddress(source)
        self.answers = self.samples = self.ports = 0
        self.results: dict[int, int] = {}
        """How often each code came, other than to Reads."""
        self.closed = False
        self.stream = Connection()
        self.last: bytes = b""
        self.number = 0
        self.transport: asyncio.Transport
        self.progress = asyncio.Event()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport  # type: ignore[assignment]

    def connection_lost(self, failure: Exception | None) -> None:
        self.closed = True
        self.progress.set()

    def data_received(self, data: bytes) -> None:
        for event in self.stream.receive(data):
            if not isinstance(event, Frame):
                self.ports += event.command == TcpCommand.PORT_CONNECT
            elif event.command == Command.NOTIFICATION:
                self.samples += 1
            else:
                self.answers += 1
                self.last = event.data
                if event.command == Command.READ:
                    continue
                result = event.error or int.from_bytes(event.data[:4], "little")
                self.results[result] = self.results.get(result, 0) + 1
        self.progress.set()

    def frame(self, port: int, command: Command, data: bytes) -> bytes:
        self.number += 1
        target = AmsAddress(f"{self.net_id}:{port}")
        return Frame(target, self.source, command, 4, 0, self.number, data).encode_tcp()

    def send(self, port: int, command: Command, data: bytes) -> None:
        self.transport.write(self.frame(port, command, data))

    async def ask(self, port: int, command: Command, data: bytes) -> bytes:
        """One request and its answer, ten seconds at most."""
        wanted = self.answers + 1
        self.send(port, command, data)
        await self.answered(wanted)
        return self.last

    async def registered(self, count: int, patience: float = 1.0) -> None:
        """Wait for the answers to so many port requests."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(patience):
                while self.ports < count and not self.closed:
                    self.progress.clear()
                    await self.progress.wait()

    async def answered(self, count: int, patience: float = 10.0) -> None:
        end = time.monotonic() + patience
        while self.answers < count and not self.closed and time.monotonic() < end:
            self.progress.clear()
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self.progress.wait(), 0.2)


class Place:
    """The station under attack."""

    def __init__(self, host: str, port: int, net_id: str, **more: Any) -> None:
        self.host, self.port, self.net_id, self.more = host, port, net_id, more
        self.dialled = 0
        self.seen: dict[str, Any] = {}

    async def dial(self, source: str = "") -> Attacker:
        """A connection with an AMS address of its own, from the attackers' host."""
        self.dialled += 1
        source = source or f"10.9.{self.dialled >> 8 & 255}.{self.dialled & 255}.1.1:40000"
        _, attacker = await asyncio.get_running_loop().create_connection(
            lambda: Attacker(self.net_id, source),
            *(self.host, self.port),
            local_addr=(self.more["attacker"], 0),
        )
        return attacker


def lasting(seconds: float = SECONDS) -> Callable[[], bool]:
    end = time.monotonic() + seconds
    return lambda: time.monotonic() < end


def write(group: int, offset: int, data: bytes) -> bytes:
    return struct.pack("<III", group, offset, len(data)) + data


def read_write(group: int, offset: int, length: int, data: bytes) -> bytes:
    return struct.pack("<IIII", group, offset, length, len(data)) + data


def subscription(group: int, offset: int, length: int, cycle_ms: float, mode: int = 3) -> bytes:
    return ADD_NOTIFICATION_BODY.pack(group, offset, length, mode, 0, round(cycle_ms * 1e4))


async def taps(place: Place) -> None:
    """One connection opens tap after tap, others talk and fetch."""
    opener, talker = await place.dial(), await place.dial()
    go_on = lasting()
    while go_on() and not opener.closed:
        opener.transport.write(
            b"".join(
                opener.frame(STATION, Command.READ_WRITE, read_write(TAPS, 0, 4, b""))
                for _ in range(50)
            )
        )
        talker.transport.write(
            b"".join(talker.frame(PLC, Command.READ, READ_ONE) for _ in range(200))
        )
        for tap in range(4):
            opener.send(STATION, Command.READ, struct.pack("<III", TAPS, tap, 1 << 20))
        await opener.answered(opener.number, 1.0)
        await talker.answered(talker.number, 1.0)
    place.seen["taps"] = opener.results.get(0, 0)
    opener.transport.abort()
    talker.transport.abort()


async def logging(place: Place) -> None:
    """Messages to the loggers, and things that make the station warn; nobody reads its stderr."""
    writer = await place.dial()
    text = b"x" * 1000 + b"\0"
    go_on = lasting()
    while go_on():
        for _ in range(100):
            writer.send(LOGGER, Command.WRITE, write(1, 4, text))
            writer.send(EVENTS, Command.WRITE, write(1, 0, text))
        garbage = await place.dial()
        garbage.transport.write(random.randbytes(64))
        garbage.transport.close()
        await writer.answered(writer.number, 2.0)
    writer.transport.abort()


async def routes(place: Place) -> None:
    """A stranger adds routes, removes those that are there and leads others to itself."""
    stranger = await place.dial()
    victim = AmsAddress(place.more["victim"])
    go_on = lasting()
    number = 0
    while go_on():
        for net_id in (bytes(victim.net_id), bytes([6, 6, number >> 8 & 255, number & 255, 1, 1])):
            number += 1
            name = b"evil%d\0" % number
            head = net_id + struct.pack("<HIII", 1, 0, 5000, 0)
            entry = head + struct.pack("<II", 11, len(name)) + b"127.0.0.99\0" + name
            stranger.send(SYSTEM, Command.WRITE, write(801, 0, entry))
        stranger.send(SYSTEM, Command.WRITE, write(802, 0, b"kept\0"))
        stranger.send(SYSTEM, Command.READ, struct.pack("<III", 803, 0, 1024))
        if number % 100 < 2:
            await stranger.answered(stranger.number, 60.0)
    place.seen["answers"] = stranger.answers
    place.seen["granted"] = stranger.results.get(0, 0)
    stranger.transport.abort()


async def buffered_bytes(place: Place) -> None:
    """Connections ask for much and read nothing, others send the beginning of long packets."""
    greedy = [await place.dial() for _ in range(20)]
    slow: list[Attacker] = []
    for each in greedy:
        each.transport.pause_reading()
    beginning = greedy[0].frame(PLC, Command.WRITE, write(0x4020, 0, bytes(32 << 20)))[:1_000_000]
    go_on = lasting()
    while go_on() and len(slow) < 200:
        slow.append(await place.dial())
        slow[-1].transport.write(beginning)
        for each in greedy:
            if not each.closed and each.transport.get_write_buffer_size() < 1 << 16:
                each.send(NC, Command.READ, struct.pack("<III", 0xF00B, 0, 1 << 20))
                each.send(PLC, Command.READ, struct.pack("<III", 0xF00E, 0, 1 << 20))
        await asyncio.sleep(0.002)
    await asyncio.sleep(0.2)
    for each in (*greedy, *slow):
        each.transport.abort()


async def subscriptions(place: Place) -> None:
    """Clients subscribe, vanish and come back at the same address."""
    go_on = lasting()
    foreign = rounds = 0
    while go_on():
        for number in range(8):
            client = await place.dial(f"10.77.0.{number}.1.1:40000")
            await asyncio.sleep(0)
            foreign += client.samples
            body = subscription(0x4020, 0, 4, 10)
            client.transport.write(
                b"".join(client.frame(PLC, Command.ADD_NOTIFICATION, body) for _ in range(250))
            )
            await client.answered(250, 3.0)
            client.transport.abort()
        rounds += 1
    place.seen["rounds"] = rounds


async def returning(place: Place) -> None:
    """Come back at the addresses of `subscriptions` and count what nobody asked for."""
    clients = [await place.dial(f"10.77.0.{number}.1.1:40000") for number in range(8)]
    for client in clients:
        await client.ask(PLC, Command.READ_STATE, b"")
    await asyncio.sleep(SECONDS)
    place.seen["foreign"] = sum(client.samples for client in clients)
    for client in clients:
        client.transport.abort()


async def samples(place: Place) -> None:
    """As many subscriptions at cycle 0 as one gets, from several addresses."""
    clients = [await place.dial() for _ in range(4)]
    go_on = lasting(2 * SECONDS)
    while go_on():
        for client in clients:
            if client.closed or client.number - client.answers > 500:
                continue
            body = subscription(0x4020, 4 * random.randrange(8), 4, 0, random.choice((3, 4)))
            client.transport.write(
                b"".join(client.frame(PLC, Command.ADD_NOTIFICATION, body) for _ in range(500))
            )
        await asyncio.sleep(0.005)
    place.seen["subscriptions"] = sum(client.results.get(0, 0) for client in clients)
    for client in clients:
        client.transport.abort()


async def connections(place: Place) -> None:
    """Connections from one host, as many as there are, kept open and idle."""
    attackers: list[Attacker] = place.more.setdefault("kept", [])
    before = len(attackers)
    while len(attackers) < before + 700:
        with contextlib.suppress(OSError):
            attackers += await asyncio.gather(*(place.dial() for _ in range(50)))
        await asyncio.sleep(0)
    await asyncio.sleep(0.2)
    place.seen["open"] = sum(not each.closed for each in attackers)


class Datagrams(asyncio.DatagramProtocol):
    """Sends without listening."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport: asyncio.DatagramTransport = transport  # type: ignore[assignment]


async def datagrams(place: Place) -> None:
    """Garbage, searches and guesses of a password at the UDP port."""
    loop = asyncio.get_running_loop()
    _, sender = await loop.create_datagram_endpoint(
        Datagrams,
        local_addr=(place.more["attacker"], 0),
        remote_addr=(place.host, place.more["udp_port"]),
    )
    search = info_request(ANYBODY).encode()
    wanted = RouteRequest("evil", NetId("6.6.6.6.1.1"), "127.0.0.99", "Administrator", "guess")
    guess = wanted.encode(ANYBODY).encode()
    go_on = lasting()
    sent = 0
    while go_on():
        for _ in range(50):
            sender.transport.sendto(random.randbytes(random.randrange(1, 200)))
            sender.transport.sendto(search)
            sender.transport.sendto(search[:4] + random.randbytes(40))
            sender.transport.sendto(guess)
            sent += 4
        await asyncio.sleep(0.001)
    place.seen["sent"] = sent
    sender.transport.close()


async def files(place: Place) -> None:
    """Searches through a folder of 30,000 files, each begun and hardly any ended."""
    clients = [await place.dial() for _ in range(4)]
    go_on = lasting()
    while go_on():
        for client in clients:
            client.send(SYSTEM, Command.READ_WRITE, read_write(133, 1 << 16, 400, b"many\\*.txt\0"))
            client.send(SYSTEM, Command.READ_WRITE, read_write(133, 1 << 16, 400, b"MANY\\*\0"))
            client.send(SYSTEM, Command.READ_WRITE, read_write(120, 0x10021, 4, b"Many\\X\0"))
        await asyncio.gather(*(client.answered(client.number, 60.0) for client in clients))
    place.seen["answers"] = sum(client.answers for client in clients)
    for client in clients:
        client.transport.abort()


async def ports(place: Place) -> None:
    """One host takes client ports of the router, as many as it gets, and keeps them."""
    attackers: list[Attacker] = place.more.setdefault("kept", [])
    connect = struct.pack("<HIH", TcpCommand.PORT_CONNECT, 2, 0)

    async def take(count: int) -> bool:
        attackers.append(await place.dial())
        attackers[-1].transport.write(connect * count)
        await attackers[-1].registered(count)
        return not attackers[-1].closed

    for _ in range(81):
        await take(400)
    refused = 0
    while refused < 3 and len(attackers) < 600:
        refused += not await take(1)
    place.seen["ports"] = sum(each.ports for each in attackers if not each.closed)


async def loops(place: Place) -> None:
    """Requests for a NetId that two stations each hold the other one for."""
    client = await place.dial()
    nowhere = AmsAddress(f"{place.more['nowhere']}:851")
    go_on = lasting()
    while go_on():
        for _ in range(100):
            client.number += 1
            request = Frame(
                nowhere, client.source, Command.READ, 4, 0, client.number, READ_ONE
            ).encode_tcp()
            client.transport.write(request)
        await client.answered(client.number, 0.05)
    place.seen["sent"] = client.number
    client.transport.abort()


ATTACKS: dict[str, Callable[[Place], Coroutine[Any, Any, None]]] = {
    attack.__name__: attack
    for attack in (
        taps, logging, routes, buffered_bytes, subscriptions, returning, samples, connections,
        datagrams, files, ports, loops,
    )
}  # fmt: skip


def main() -> None:
    """Attack when told to."""
    attack = ATTACKS[sys.argv[1]]
    place = Place(**json.loads(sys.stdin.readline()))
    with asyncio.Runner() as runner:
        print("ready", flush=True)
        for _ in sys.stdin:
            runner.run(attack(place))
            print(json.dumps(place.seen), flush=True)


if __name__ == "__main__":
    main()
