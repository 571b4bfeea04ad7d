"""Rights hold for every row of every device, by every transport, whatever is drawn.

What a request needs is said here once more, from the rows and not from the code that decides; then
a hostile client with few rights tries all rows of a whole station, and what it had no right to
change is as it was.
"""

import random
import struct
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, DeviceError, Frame, NetId
from achse.ams.connection import Connection
from achse.ams.mqtt import RouterNote
from achse.codes import ReservedGroup
from achse.codes.groups import NAMED, SUMS
from achse.devices.system.files import Files
from achse.router import Router
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right
from achse.router.routes import Route, RouteTls
from achse.server import READ, RowFacts
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.transport.connections.peer import Peer
from achse.transport.mqtt.network import MqttSettings
from achse.transport.mqtt.routes import MqttRoutes
from achse.transport.secure.listener import SecureListener, _Proof, _SecurePeer
from achse.transport.secure.tls import ServerTls
from achse.transport.tcp.listener import TcpListener
from achse.transport.uplinks.uplink import Uplink
from tests.transport.certificates import identity
from tests.transport.connections.peers import Loop

OURS = NetId("5.1.2.3.1.1")
HOST = "10.0.0.1"
SYSTEM, STATION = 10_000, 26_000
EVERY_SELECTION = [Right(bits) for bits in range(32)]

DOCUMENT: dict[str, Any] = {
    "bus": [{}],
    "axis": [{"id": 1, "name": "X"}, {"id": 2, "name": "Y"}],
    "drive": [{"axis": 1}, {"axis": 2}],
    "nc": {"code": "plain"},
    "plc": [{"globals": ["achse.station.demo:GVL"]}],
    "camshaft": [{}],
    "channel": [{"id": 1, "name": "C"}],
    "system": {"root": "files"},
    "router": {"routes_over_ads": True},
}


class RequestCase(NamedTuple):
    """A request, and what its sender needs."""

    port: int
    command: int
    data: bytes
    needs: Right
    what: str

    def frame(self, source: AmsAddress) -> Frame:
        target = AmsAddress.of(OURS, self.port)
        return Frame(bytes(target), bytes(source), self.command, data=self.data)


# what is asked -------------------------------------------------------------------------------


def needed(port: int, group: int, command: int) -> Right:
    """What the pages of the documentation say of a request about one row."""
    changes = command in (Command.WRITE, Command.READ_WRITE)
    looks_up = command == Command.READ_WRITE and group in NAMED
    if port == SYSTEM and (group in file_groups() or 100 <= group < 140):  # 003: all of them
        return Right.FILES
    if looks_up or not changes:
        return Right.READ
    if command == Command.WRITE and group == ReservedGroup.RELEASE_SYMBOL_HANDLE:
        return ALL_RIGHTS if port == STATION else Right.READ
    if port == STATION or (port == SYSTEM and group in (500, 801, 802)):
        return ALL_RIGHTS
    if command == Command.READ_WRITE and group == ReservedGroup.SYMBOL_VALUE_BY_HANDLE:
        return Right.METHODS
    return Right.WRITE if command == Command.WRITE else Right.READ | Right.WRITE


@cache
def file_groups() -> set[int]:
    return {each for of in Files(None, int).groups() for each in of.index_groups()}


def body(command: int, group: int, offset: int, length: int, data: bytes) -> bytes:
    if command == Command.READ_WRITE:
        return struct.pack("<4I", group, offset, length, len(data)) + data
    if command == Command.WRITE:
        return struct.pack("<3I", group, offset, len(data)) + data
    more = b"" if command == Command.READ else struct.pack("<3I16x", 3, 0, 0)
    return struct.pack("<3I", group, offset, length) + more


COMMANDS = (Command.READ, Command.WRITE, Command.READ_WRITE, Command.ADD_NOTIFICATION)


def one(port: int, row: RowFacts, by: random.Random) -> RequestCase:
    command = by.choice(COMMANDS)
    group = by.choice((row.index_group, row.last_index_group))
    offset = by.choice((row.index_offset, row.last_index_offset))
    size = by.choice((0, 1, 2, 4, 8, 64))
    data = by.choice((bytes(size), by.randbytes(size), struct.pack("<d", 5.0), b"GVL.nInt\0"))
    needs = needed(port, group, command)
    if group in SUMS and command in (Command.WRITE, Command.READ_WRITE):
        return a_sum(port, group, [], by)
    text = f"{command.name} {row.name} at {port}"
    return RequestCase(port, command, body(command, group, offset, size, data), needs, text)


def a_sum(
    port: int, group: int, rows: list[tuple[int, RowFacts]], by: random.Random
) -> RequestCase:
    """A sum of requests about some rows of one device: it needs what its parts need."""
    parts, needs, written = b"", NO_RIGHTS, b""
    for _, row in rows:
        place = (row.index_group, row.index_offset)
        size = by.choice((1, 4, 8))
        if group == ReservedGroup.SUM_WRITE:
            parts += struct.pack("<3I", *place, size)
            needs |= needed(port, row.index_group, Command.WRITE)
        elif group == ReservedGroup.SUM_READ_WRITE:
            parts += struct.pack("<4I", *place, 8, size)
            needs |= needed(port, row.index_group, Command.READ_WRITE)
        elif group == ReservedGroup.SUM_ADD_NOTIFICATION:
            parts += body(Command.ADD_NOTIFICATION, *place, size, b"")
        elif group == ReservedGroup.SUM_DELETE_NOTIFICATION:
            parts += struct.pack("<I", by.randrange(100))
        else:
            parts += struct.pack("<3I", *place, size)
        written += bytes(size)
    reads = group not in (ReservedGroup.SUM_WRITE, ReservedGroup.SUM_READ_WRITE)
    if reads:
        needs = Right.READ | Right.FILES if port == SYSTEM else Right.READ
    elif port in (SYSTEM, STATION):
        needs = ALL_RIGHTS
    elif not rows:
        needs = Right.WRITE if group == ReservedGroup.SUM_WRITE else Right.READ | Right.WRITE
    data = body(Command.READ_WRITE, group, len(rows), 4096, parts + written)
    return RequestCase(
        port, Command.READ_WRITE, data, needs, f"0x{group:X} of {len(rows)} at {port}"
    )


def others(port: int) -> Iterator[RequestCase]:
    """Commands that are about no row."""
    for command, data, needs in (
        (Command.READ_DEVICE_INFO, b"", Right.READ),
        (Command.READ_STATE, b"", Right.READ),
        (Command.DELETE_NOTIFICATION, bytes(4), Right.READ),
        (Command.WRITE_CONTROL, struct.pack("<HHI", 5, 0, 0), Right.STATE),
        (77, bytes(16), ALL_RIGHTS),
    ):
        yield RequestCase(port, command, data, needs, f"command {command} at {port}")


@cache
def rows_of_all() -> list[tuple[int, RowFacts]]:
    document = {**DOCUMENT, "system": {}}
    devices = Station(parse(document, "a.toml")).devices
    return [(each.address.port, row) for each in devices for row in each.services.describe()]


def drawn(by: random.Random, count: int) -> Iterator[RequestCase]:
    rows = rows_of_all()
    ports = sorted({port for port, _ in rows})
    for port, row in by.sample(rows, min(count, len(rows))):
        yield one(port, row, by)
    for _ in range(count // 10):
        port = by.choice(ports)
        mine = [each for each in rows if each[0] == port and each[1].index_group not in SUMS]
        yield a_sum(port, by.choice(SUMS), by.choices(mine, k=by.randrange(6)), by)
    for port in by.sample(ports, 4):
        yield from others(port)


# by which transport -------------------------------------------------------------------------------


class Line:
    """Keeps what is sent to a peer."""

    def __init__(self) -> None:
        self.sent = b""

    def write(self, data: Any) -> None:
        self.sent += bytes(data)

    def get_write_buffer_size(self) -> int:
        return 0

    def close(self) -> None:
        """It stays: nobody listens."""

    abort = pause_reading = resume_reading = close


class Echo:
    """Answers every request."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        self.router.deliver(frame.reply(frame.data))
        return True


def source(rights: Right) -> AmsAddress:
    return AmsAddress(f"192.0.2.{rights.value + 1}.1.1:30000")


class Transports:
    """A router with somebody at every port, and clients with every selection of rights."""

    def __init__(self) -> None:
        self.loop = Loop()
        self.router = Router(OURS)
        for port in {port for port, _ in rows_of_all()}:
            self.router.register(port, Echo(self.router))
        self._peers: dict[tuple[str, Right], tuple[Peer, Line]] = {}
        self._plain = TcpListener(self.router, routes_required=True)
        self._secure = SecureListener(self.router, ServerTls(identity("press")))
        settings = MqttSettings(host="broker", topic="plant")
        note = RouterNote(online=True, name="press")
        self._mqtt = MqttRoutes(self.router, settings, note, session=lambda **_: None)  # type: ignore[arg-type]
        self._plain.begin(self.loop)
        self._secure.begin(self.loop)
        self._mqtt.loop = self.loop  # type: ignore[assignment]
        self.published: list[bytes] = []
        self._mqtt.network.send = self._publish  # type: ignore[method-assign]

    def _publish(self, net_id: NetId, message: bytes, *, back: bool) -> bool:
        assert back
        self.published.append(message)
        return True

    def route(self, rights: Right, tls: RouteTls | None = None) -> Route:
        net_id = source(rights).net_id
        route = Route(name=f"r{rights.value}", net_id=net_id, host=HOST, rights=rights, tls=tls)
        self.router.routes.add(route)
        return route

    def answer(self, transport: str, rights: Right, request: RequestCase) -> int:
        """The AMS error that a client with these rights gets."""
        frame = request.frame(source(rights))
        if transport == "mqtt":
            self.published.clear()
            self._mqtt.received(frame.encode_tcp()[6:])
            self.loop.run()
            (message,) = self.published
            return int.from_bytes(message[24:28], "little")
        peer, line = self._peers[transport, rights]
        line.sent = b""
        peer.receive(frame.encode_tcp())
        self.loop.run()
        (back,) = Connection().receive(line.sent)
        assert isinstance(back, Frame)
        return back.error

    def use(self, transport: str) -> None:
        """All clients come by this transport."""
        for rights in EVERY_SELECTION:
            tls = (
                RouteTls(fingerprint=identity("panel").fingerprint)
                if transport == "secure"
                else None
            )
            route = self.route(rights, tls)
            if transport == "mqtt":
                continue
            peer: Peer
            if transport == "secure":
                secure = peer = _SecurePeer(self._secure)
                secure.know(route.net_id, _Proof(identity("panel").fingerprint))
            elif transport == "dialled":
                uplink = Uplink(self.router, route, self.loop, lambda _: None)
                peer = uplink.make_peer()
            else:
                peer = Peer(self._plain)
            line = Line()
            self._peers[transport, rights] = peer, line
            peer.begin(line, HOST, 40_000)


ROADS = ("plain", "secure", "dialled", "mqtt")


@given(st.integers(0, 2**32), st.sampled_from(ROADS))
@settings(max_examples=5, phases=(Phase.generate,))
def test_rights_hold_for_every_row_by_every_transport(seed: int, transport: str) -> None:
    by = random.Random(seed)
    transports = Transports()
    transports.use(transport)
    for request in drawn(by, 400):
        lacking = request.needs & ~by.choice([each for each in Right if each & request.needs])
        for rights in (request.needs, lacking, by.choice(EVERY_SELECTION)):
            error = transports.answer(transport, rights, request)
            refused = bool(request.needs & ~rights)
            assert error == (0x723 if refused else 0), (transport, request, rights)


def test_every_row_once_with_one_right_too_few() -> None:
    transports, by = Transports(), random.Random(1)
    transports.use("plain")
    for port, row in rows_of_all():
        for _ in range(3):
            request = one(port, row, by)
            assert transports.answer("plain", request.needs, request) == 0, request
            for right in Right:
                if right & request.needs:
                    assert transports.answer("plain", ALL_RIGHTS & ~right, request) == 0x723, (
                        request
                    )


# a whole station -----------------------------------------------------------------------------


class Client:
    """Sends with some rights, as a peer lets it."""

    def __init__(self, station: Station, rights: Right) -> None:
        station.router.routes.add(
            Route(name="hostile", net_id=source(rights).net_id, host=HOST, rights=rights),
            fixed=True,
        )
        owner = TcpListener(station.router, routes_required=True)
        owner.begin(Loop())
        self.peer, self.line = Peer(owner), Line()
        self.peer.begin(self.line, HOST, 40_000)
        self.source = source(rights)
        self.net_id = bytes(station.router.net_id)

    def send(self, request: RequestCase) -> None:
        frame = request.frame(self.source)
        frame.target = self.net_id + frame.target[6:]
        self.peer.receive(frame.encode_tcp())
        self.line.sent = b""


def values(station: Station, *, but: tuple[str, ...] = ()) -> dict[Any, Any]:
    """What every row of the station shows, counters of requests left out."""
    values: dict[Any, Any] = {}
    for device in station.devices:
        for row in device.services.describe():
            if not row.access & READ or row.name in ("clients", "statistics", "open file", *but):
                continue
            for place in (
                (row.index_group, row.index_offset),
                (row.last_index_group, row.last_index_offset),
            ):
                try:
                    values[device.address.port, *place, row.name] = device.read(*place, 0xFFFF)
                except DeviceError as refusal:
                    values[device.address.port, *place, row.name] = refusal.code
    return values


def whole(base: Path) -> Station:
    files = base / "files"
    files.mkdir(parents=True)
    (files / "a.txt").write_text("as it was")
    station = Station(parse(DOCUMENT, "a.toml"), base=base)
    station.advance(0.05)
    return station


def attack(station: Station, client: Client, by: random.Random) -> None:
    """All rows with all commands, sums of them, states, names of files."""
    rows = [
        (each.address.port, row) for each in station.devices for row in each.services.describe()
    ]
    by.shuffle(rows)
    for port, row in rows:
        for command in COMMANDS:
            size = by.choice((0, 1, 2, 4, 8, 16, 255))
            data = by.choice(
                (by.randbytes(size), b"a.txt\0", b"GVL.nInt\0", b'{"kind": "restart"}')
            )
            group = by.choice((row.index_group, row.last_index_group))
            offset = by.choice((row.index_offset, row.last_index_offset, by.randrange(1 << 18)))
            client.send(
                RequestCase(port, command, body(command, group, offset, size, data), ALL_RIGHTS, "")
            )
    for port in {port for port, _ in rows}:
        mine = [each for each in rows if each[0] == port]
        for group in SUMS:
            client.send(a_sum(port, group, by.choices(mine, k=20), by))
        for state in range(20):
            client.send(
                RequestCase(
                    port, Command.WRITE_CONTROL, struct.pack("<HHI", state, 0, 0), ALL_RIGHTS, ""
                )
            )


def other_state(station: Station, base: Path) -> list[Any]:
    """What only other rights change: states, routes, faults, files."""
    states = {each.address.port: (each.ads_state, each.device_state) for each in station.devices}
    folder = base / "files"
    files = {each.name: each.read_text() for each in folder.iterdir()}
    return [states, list(station.router.routes), list(station.faults), files, station.ended]


@given(st.integers(0, 2**32))
@settings(max_examples=2, phases=(Phase.generate,))
def test_who_only_reads_changes_nothing(tmp_path_factory: Any, seed: int) -> None:
    base = tmp_path_factory.mktemp("reads")
    station = whole(base)
    client = Client(station, Right.READ)
    before, kept_before = values(station), other_state(station, base)
    attack(station, client, random.Random(seed))
    assert client.peer.connected
    assert station.router.denied > 2000
    client.peer.abort()
    after = values(station)
    assert {key: (before[key], after[key]) for key in before if before[key] != after[key]} == {}
    assert other_state(station, base) == kept_before
    station.advance(0.02)
    assert other_state(station, base) == kept_before


@pytest.mark.parametrize(
    "rights", [Right.READ | Right.WRITE, ALL_RIGHTS & ~Right.FILES & ~Right.STATE]
)
@given(seed=st.integers(0, 2**32))
@settings(max_examples=2, phases=(Phase.generate,))
def test_who_writes_changes_no_states_routes_or_files(
    tmp_path_factory: Any, rights: Right, seed: int
) -> None:
    base = tmp_path_factory.mktemp("writes")
    station = whole(base)
    client = Client(station, rights)
    before = other_state(station, base)
    attack(station, client, random.Random(seed))
    assert client.peer.connected
    assert station.router.denied > 300
    assert other_state(station, base) == before
    station.advance(0.02)
    assert other_state(station, base) == before
