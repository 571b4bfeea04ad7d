"""docs/explanation/security.md: each of its sentences is proven, here or by the tests named here.

A sentence without a proof fails, and so does a proof without a sentence, or one that is not there.
"""

import ast
import asyncio
import functools
import hashlib
import inspect
import os
import re
import struct
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import AmsAddress, ConnectionLost, NetId
from achse.ams.discovery import (
    ANYBODY,
    DiscoveryService,
    OsVersion,
    RouteRequest,
    RouterInfo,
    info_request,
)
from achse.cli.fieldbus import drive
from achse.cli.record import monitor
from achse.client.nc import RemoteNc
from achse.client.nc.services import CYCLIC, named
from achse.devices.system.device import _REFUSED
from achse.devices.system.routes import RouteEntry
from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Loopback, Segment, Slave
from achse.router.access import Users, hash_password
from achse.router.routes import Route, RouteTable
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.transport import udp
from achse.transport.udp import DiscoveryEndpoint
from tests.docs.proofs import PROOFS, proves

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "explanation" / "security.md"


def sentences(text: str) -> list[str]:
    """The sentences of the page, without headings and line ends; the introduction is none."""
    body = text[text.index("\n## ") :]
    parts = []
    for block in re.split(r"\n\n|\n(?=- )", body):
        line = " ".join(block.split()).removeprefix("- ")
        if line and not line.startswith("#"):
            parts += re.split(r"(?<=\.) (?=[A-Z`])", line)
    return parts


@functools.cache
def functions_in(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    functions = ast.FunctionDef | ast.AsyncFunctionDef
    return {node.name for node in tree.body if isinstance(node, functions)}


def test_each_sentence_has_a_proof_and_each_proof_a_sentence() -> None:
    written = sentences(PAGE.read_text(encoding="utf-8"))
    assert len(written) > 40
    assert all(sentence.endswith(".") for sentence in written)
    assert sorted(set(written) - PROOFS.keys()) == [], "without a proof"
    assert sorted(PROOFS.keys() - set(written)) == [], "without a sentence"
    assert sorted({each for each in written if written.count(each) > 1}) == []


def test_each_proof_is_a_test_that_is_there() -> None:
    named = {name for names in PROOFS.values() for name in names}
    places = {name: name.partition("::") for name in named if "::" in name}
    assert all(test.startswith("test_") for _, _, test in places.values())
    missing = [
        name for name, (path, _, test) in places.items() if test not in functions_in(ROOT / path)
    ]
    assert missing == []
    here = functions_in(Path(__file__))
    assert [name for name in named if "::" not in name and name not in here] == []


def test_the_page_at_the_root_points_to_it() -> None:
    assert "](docs/explanation/security.md)" in (ROOT / "SECURITY.md").read_text()


# what is proven here


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


AXIS = {"id": 1, "name": "X"}
STRANGER = "192.0.2.66.1.1:30000"


@proves("A station listens at 127.0.0.1, where other computers do not get in.")
async def test_where_it_listens() -> None:
    async with station(router={"tcp_port": 0, "udp_port": 0}).running() as running:
        assert running.host == "127.0.0.1"
        discovery = running.network.discovery
        assert discovery is not None
        assert discovery.host == "127.0.0.1"


@proves("It runs no code and opens no file that a client names.")
def test_what_reaches_into_the_operating_system_is_refused(client_of: Any, refused: Any) -> None:
    assert {"create file", "device names", "send mail"} <= set(_REFUSED.values())
    client = client_of(station().router, 10_000)
    for group in _REFUSED:
        with refused(0x701):
            client.exchange(group, 0, 100, b"/bin/sh\0")
    for group in (*_REFUSED, 500):
        with refused(0x701):
            client.write(group, 0, b"/bin/sh\0")
    for group in (100, 101, 120, 133):
        with refused(0x701):
            client.exchange(group, 1 if group == 120 else 0, 100, b"/etc/passwd\0")


@proves("Anyone who gets in may read and write variables and parameters, and move axes.")
@proves("Anyone who gets in may restart and shut down the station.")
async def test_a_stranger_does_as_he_likes() -> None:
    document: dict[str, Any] = {
        "axis": [AXIS],
        "nc": {"code": "plain"},
        "plc": [{"globals": ["achse.station.demo:GVL"]}],
    }
    built = station(**document)
    async with built.running("127.0.0.1", 0, speed=0) as running:
        dial = functools.partial(achse.connect, f"127.0.0.1:{running.tcp_port}", source=STRANGER)
        async with dial(port=851) as plc:
            await plc.write("GVL.nInt", 66)
            assert await plc.read("GVL.nInt") == 66
        async with dial(port=501) as nc:
            axis = RemoteNc(nc).axis("X")
            await axis.parameters["max velocity"].write(66.0)
            assert await axis.parameters["max velocity"] == 66.0
            await axis.set_override(100)
            for bit in ("controller_enable", "feed_enable_plus", "feed_enable_minus"):
                service = named((CYCLIC,), bit)
                await nc.write_raw(*service.place(1), service.layout.encode(1))
            built.advance(0.1)
            await nc.write_raw(0x4201, 0x20, struct.pack("<I4xdd", 1, 5.0, 50.0))
            built.advance(2.0)
            assert await nc.read_raw(0x4101, 0x0A, 8) == struct.pack("<d", 5.0)
        async with dial(port=10_000) as system:
            await system.write_control(12)  # shutdown
        built.step()
        assert built.ended


@proves("Anyone who gets in may read, write and delete files below `root`.")
async def test_a_stranger_has_the_files(tmp_path: Path) -> None:
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / "a.txt").touch()
    built = station(tmp_path, system={"root": "files"})
    async with (
        built.running("127.0.0.1", 0) as running,
        achse.connect(f"127.0.0.1:{running.tcp_port}", source=STRANGER, port=10_000) as system,
    ):
        handle = await system.read_write_raw(120, 0x10002, 4, b"b.txt")
        await system.read_write_raw(123, int.from_bytes(handle, "little"), 0, b"hostile")
        await system.read_write_raw(131, 0x10000, 0, b"a.txt")
        names = [path.name for path in (tmp_path / "files").iterdir()]
        assert names == ["b.txt"]


@proves("A NetId and an address are all that is compared, and a sender may lie about its NetId.")
@proves("When a route is removed, connections that need it end.")
async def test_who_gets_in_past_strict_has_every_right() -> None:
    built = station(router={"strict": True})
    route = Route(name="me", net_id=AmsAddress(STRANGER).net_id, host="127.0.0.1")
    async with built.running("127.0.0.1", 0, speed=0) as running:
        dial = functools.partial(achse.connect, f"127.0.0.1:{running.tcp_port}", port=10_000)
        built.router.routes.add(route)
        async with dial(source=STRANGER, reconnect=False) as liar:
            assert (await liar.state()).ads_state == 5
            built.router.routes.remove("me")
            with pytest.raises(ConnectionLost):
                await liar.state()
        built.router.routes.add(route)
        async with dial(source=STRANGER, reconnect=False) as liar:
            await liar.write_control(12)
        built.step()
        assert built.ended


@proves("A program on this computer needs no route.")
async def test_a_program_here_gets_in_past_strict() -> None:
    async with station(router={"strict": True}).running("127.0.0.1", 0) as running:
        where = f"127.0.0.1:{running.tcp_port}"
        for source in (None, "127.0.0.1.1.1:30000"):
            async with achse.connect(where, port=10_000, source=source) as system:
                assert (await system.state()).ads_state == 5


@proves("A wrong name takes as long as a wrong password, and both are refused.")
def test_a_wrong_name_is_hashed_like_a_wrong_password(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[tuple[int, int, int]] = []
    scrypt = hashlib.scrypt

    def watched(password: bytes, *, n: int, r: int, p: int, **others: Any) -> bytes:
        done.append((n, r, p))
        return scrypt(password, n=n, r=r, p=p, **others)

    users = Users({"Administrator": hash_password("1")})
    monkeypatch.setattr(hashlib, "scrypt", watched)
    assert not users.check("Administrator", "2")
    assert not users.check("nobody", "1")
    assert not Users().check("", "")
    assert len(set(done)) == 1
    assert len(done) == 3


@proves("Names of Python programs in a station.toml are run with the rights of the station.")
@proves("Of the sources of a PLC its Structured Text alone is run, and of symbol files nothing.")
def test_python_is_run_only_if_the_configuration_names_it(tmp_path: Path) -> None:
    code = (
        "from pathlib import Path\nfrom achse.iec import GlobalVariables\n"
        "Path(__file__).with_name('ran').touch()\nclass GVL(GlobalVariables): pass\n"
    )
    (tmp_path / "code.py").write_text(code)
    (tmp_path / "sources").mkdir()
    (tmp_path / "sources" / "other.py").write_text(code)
    (tmp_path / "sources" / "a.st").write_text("VAR_GLOBAL a : INT; END_VAR")
    station(tmp_path, plc=[{"sources": "sources"}])
    assert list(tmp_path.rglob("ran")) == []
    (tmp_path / "a.tmc").write_text("__import__('pathlib').Path('ran').touch()")
    with pytest.raises(ConfigError):
        station(tmp_path, plc=[{"symbols": "a.tmc"}])
    station(tmp_path, plc=[{"globals": ["code.py:GVL"]}])
    assert list(tmp_path.rglob("ran")) == [tmp_path / "ran"]


@proves("A computer gets 200 answers to UDP datagrams at once and 50 a second after that.")
async def test_answers_to_datagrams() -> None:
    now = 0
    info = RouterInfo(NetId("5.1.2.3.1.1"), "press", (3, 1, 4024), OsVersion(6, 1, 0, 0, ""))
    endpoint = DiscoveryEndpoint(lambda: info, RouteTable())
    endpoint._clock = lambda: now
    sent: list[str] = []
    endpoint._send = lambda datagram, addr: sent.append(addr[0])  # type: ignore[method-assign]
    data = info_request(ANYBODY).encode()

    def ask(host: str, times: int) -> int:
        sent.clear()
        for _ in range(times):
            endpoint.datagram_received(data, (host, 9))
        return len(sent)

    assert ask("10.0.0.1", 1000) == 200
    assert ask("10.0.0.2", 1) == 1
    now = 1_000_000_000
    assert ask("10.0.0.1", 1000) == 50


@proves("By plain AMS/TCP and UDP nothing is encrypted, neither values nor passwords.")
async def test_who_listens_to_the_wire_reads_all() -> None:
    wanted = RouteRequest("me", NetId("192.0.2.7.1.1"), "192.0.2.7", "Administrator", "geheim")
    datagram = wanted.encode(NetId("192.0.2.7.1.1"), DiscoveryService.ADD_ROUTE)
    assert b"geheim\0" in datagram.encode()
    heard = bytearray()
    built = station(plc=[{"globals": ["achse.station.demo:GVL"]}])
    async with built.running("127.0.0.1", 0) as running:

        async def relay(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            there, out = await asyncio.open_connection("127.0.0.1", running.tcp_port)

            async def copy(source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
                while data := await source.read(4096):
                    heard.extend(data)
                    sink.write(data)
                sink.close()

            await asyncio.gather(copy(reader, out), copy(there, writer))

        server = await asyncio.start_server(relay, "127.0.0.1", 0)
        async with server:
            port = server.sockets[0].getsockname()[1]
            async with achse.connect(f"127.0.0.1:{port}", port=851) as plc:
                await plc.write("GVL.sString", "a secret recipe")
    assert b"a secret recipe\0" in bytes(heard)


@proves("A search is answered to anybody, with NetId, name, version and operating system.")
async def test_a_search_requests_no_password() -> None:
    built = station(name="press", router={"strict": True, "net_id": "5.6.7.8.1.1"})
    async with built.running("127.0.0.1", 0, udp_port=0) as running:
        assert running.udp_port is not None
        [(info, _)] = await udp.scan(["127.0.0.1"], port=running.udp_port, all_of_them=False)
        assert (str(info.net_id), info.host_name) == ("5.6.7.8.1.1", "press")
        assert info.version == (3, 1, 4024)
        assert info.os_version.build >= 0


@proves(
    "`achse drive serve` and `achse monitor` ask nobody for a password, and listen at 127.0.0.1"
    " unless told otherwise."
)
def test_where_drives_and_monitors_listen() -> None:
    serve = inspect.signature(drive.serve).parameters
    assert serve["control"].default.startswith("127.0.0.1:")
    assert (serve["udp"].default, serve["interface"].default) == (None, None)
    watch = inspect.signature(monitor.monitor).parameters
    assert watch["host"].default == "127.0.0.1"
    assert not [name for name in (*serve, *watch) if "password" in name or "user" in name]


@proves(
    "Anyone who may change routes holds the station up while the disk takes the file, so that the"
    " answer is true."
)
def test_a_change_of_routes_is_on_the_disk_when_it_is_answered(
    tmp_path: Path, client_of: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    numbers: list[int] = []
    fsync = os.fsync

    def keep(number: int) -> None:
        numbers.append(number)
        fsync(number)

    monkeypatch.setattr(os, "fsync", keep)
    built = station(tmp_path, router={"static_routes": "r.xml", "routes_over_ads": True})
    route = Route(name="me", net_id=NetId("5.8.8.8.1.1"), host="10.0.0.8")
    client_of(built.router, 10_000).write(801, 0, RouteEntry.of(route).encode())
    assert (len(numbers), "10.0.0.8" in (tmp_path / "r.xml").read_text()) == (2, True)


@proves(
    "EtherCAT has no senders to tell apart, and anyone who reaches the wire commands the drives."
)
def test_any_master_commands_a_slave() -> None:
    segment = Segment([Slave(Loopback())])
    write = EthercatFrame([Datagram.at(DatagramCommand.BWR, 0, 0x2000, b"\x66")]).encode()
    for sender in (b"\x02\0\0\0\0\x01", b"\x66\x66\x66\x66\x66\x66"):
        reply = segment.process(write[:6] + sender + write[12:])
        assert reply is not None
        assert EthercatFrame.decode(reply).datagrams[0].counter == 1
