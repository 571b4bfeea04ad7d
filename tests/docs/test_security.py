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
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import AmsAddress, NetId
from achse.ams.discovery import (
    DiscoveryService,
    OsVersion,
    RouteRequest,
    RouterInfo,
    info_request,
)
from achse.cli import drive, monitor
from achse.cli.axis import ALL_ENABLES, FULL_OVERRIDE
from achse.cli.nc import CYCLIC, PARAMETERS, chosen
from achse.devices.system.device import _REFUSED
from achse.devices.system.routes import RouteEntry
from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Loopback, Segment, Slave
from achse.router.access import Users, hash_password
from achse.router.routes import Route, RouteTable
from achse.station import ConfigError, Station
from achse.station.config import parse
from achse.transport import udp
from achse.transport.udp import ANYBODY, DiscoveryEndpoint

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "explanation" / "security.md"

PROOFS: dict[str, list[str]] = {}
"""Sentence: tests, `path::name` or functions of this module."""


def sentences(text: str) -> list[str]:
    """The sentences of the page, without headings and line ends; the introduction is none."""
    body = text[text.index("\n## ") :]
    found = []
    for block in re.split(r"\n\n|\n(?=- )", body):
        line = " ".join(block.split()).removeprefix("- ")
        if line and not line.startswith("#"):
            found += re.split(r"(?<=\.) (?=[A-Z`])", line)
    return found


def proves(sentence: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The test proves the sentence."""

    def note(test: Callable[..., Any]) -> Callable[..., Any]:
        PROOFS.setdefault(sentence, []).append(test.__name__)
        return test

    return note


def elsewhere(sentence: str, *tests: str) -> None:
    """These tests, `path::name`, prove the sentence."""
    PROOFS.setdefault(sentence, []).extend(tests)


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


# what tests elsewhere prove

NETWORK = "tests/station/test_network.py"
FOLDER = "tests/devices/system/test_folder.py"
TCP = "tests/transport/test_tcp.py"
UDP = "tests/transport/test_udp.py"
QUEUE = "tests/transport/test_password_queue.py"
HOSTILE = "tests/interop/test_hostile_load.py"
STATE = "tests/station/test_state_file.py"
NESTING = "tests/fuzz/test_nesting.py"

elsewhere(
    "At an address that other computers reach it does not start without `strict = true` or"
    " `let_everybody_in = true` in `[router]`.",
    f"{NETWORK}::test_beyond_this_computer_a_station_listens_only_if_told_in_so_many_words",
    f"{NETWORK}::test_which_addresses_other_computers_reach",
)
elsewhere(
    "With `let_everybody_in` it says at the start what everybody may do.",
    f"{NETWORK}::test_a_station_says_what_everybody_may",
    "tests/cli/test_run.py::test_beyond_this_computer_it_listens_only_if_told_in_so_many_words",
)
elsewhere(
    "Only programs on this computer get AMS ports of their own.",
    f"{TCP}::test_peers_on_other_hosts_get_no_port_service_unless_let_in",
    f"{TCP}::test_loopback_hosts",
)
elsewhere(
    "Nobody changes its routes from outside.",
    f"{NETWORK}::test_who_may_change_routes",
    f"{NETWORK}::test_only_users_change_routes",
)
elsewhere(
    "It shows no files without `root` in `[system]`.",
    "tests/devices/system/test_files.py::test_without_a_folder_files_are_not_supported",
)
elsewhere(
    "Anyone who gets in may record the traffic of others, and cause faults, by port 26000.",
    "tests/devices/test_station.py::test_a_tap_shows_what_others_do",
    "tests/interop/test_faults.py::test_a_lost_answer_is_a_timeout",
)
elsewhere(
    "A client from another computer needs a route, to its NetId and with the address it comes"
    " from.",
    f"{NETWORK}::test_strict_closes_clients_without_a_route",
    f"{NETWORK}::test_who_may_change_routes",
    "tests/router/test_routes.py::test_senders_are_admitted_by_net_id_and_address",
    "tests/transport/test_uplinks.py"
    "::test_where_routes_are_required_a_stranger_is_told_how_to_get_one",
)
elsewhere(
    "A route by host name lets in who comes from an address of that name, looked up again every"
    " minute.",
    f"{NETWORK}::test_strict_lets_in_by_a_host_name_only_who_is_there",
    "tests/router/test_routes.py::test_by_a_host_name_only_its_addresses_are_admitted",
    "tests/transport/test_host_names.py::test_names_are_looked_up_again_every_minute",
)
elsewhere(
    "By a name that nobody knows, nobody gets in.",
    f"{NETWORK}::test_strict_lets_in_by_a_host_name_only_who_is_there",
    "tests/transport/test_host_names.py::test_an_unknown_name_is_told_and_lets_nobody_in",
)
elsewhere(
    "A computer has one connection, and a second one closes the first.",
    f"{TCP}::test_strict_a_second_connection_of_a_host_closes_one_without_port",
)
elsewhere(
    "From the far end of a one-way route requests are refused, in a station without `strict` too.",
    "tests/transport/test_uplinks.py::test_requests_from_the_far_end_of_a_one_way_route_are_refused",
    "tests/router/test_routes.py::test_a_one_way_route_refuses_also_before_its_host_is_known",
)
elsewhere(
    "A user in `[router.users]` changes routes by UDP requests with name and password.",
    f"{NETWORK}::test_only_users_change_routes",
    f"{UDP}::test_the_right_password_adds_and_deletes_a_route",
    "tests/interop/test_discovery.py::test_pyads_learns_the_net_id_and_adds_a_route",
)
elsewhere(
    "A user changes nothing but routes.",
    f"{UDP}::test_other_services_are_not_supported_and_answers_not_answered",
    f"{NETWORK}::test_who_may_change_routes",
)
elsewhere(
    "Only scrypt hashes of passwords are kept.",
    "tests/router/test_access.py::test_a_hash_survives_its_text_and_does_not_show_the_password",
    "tests/router/test_access.py::test_the_hash_is_scrypt_as_rfc_7914_has_it",
    "tests/router/test_access.py::test_what_is_no_hash_is_refused",
)
elsewhere(
    "After three wrong passwords a computer waits a second for the next check, then twice as long"
    " each time, up to a minute.",
    f"{QUEUE}::test_wrong_passwords_slow_a_host_down",
)
elsewhere(
    "Computers that have not known a password get five checks a second together.",
    f"{QUEUE}::test_all_strangers_together_get_five_checks_a_second",
)
elsewhere(
    "A flood of requests from one computer does not crowd out another.",
    f"{UDP}::test_a_flood_from_one_host_does_not_crowd_out_another",
    f"{HOSTILE}::test_datagrams",
)
elsewhere(
    "Routes of the configuration are neither replaced nor removed, by nobody.",
    f"{NETWORK}::test_a_route_of_the_configuration_stays",
    f"{NETWORK}::test_who_may_change_routes",
    "tests/router/test_routes.py::test_a_fixed_route_stays",
    f"{HOSTILE}::test_routes",
)
elsewhere(
    "Over ADS routes change with `routes_over_ads = true` only, and then everybody who gets in may"
    " change them.",
    f"{NETWORK}::test_who_may_change_routes",
    "tests/devices/system/test_routes.py::test_without_permission_routes_cannot_be_changed",
)
elsewhere(
    "A change that cannot be written to `static_routes` is refused.",
    f"{NETWORK}::test_a_route_is_refused_if_the_file_cannot_be_written",
    f"{UDP}::test_a_fixed_route_and_one_that_cannot_be_written_are_refused",
)
elsewhere(
    "No name of a file leads out of `root`: no `..`, no absolute path, no drive, no device, no"
    " link.",
    f"{FOLDER}::test_what_leads_out_names_nothing",
    f"{FOLDER}::test_nor_does_a_search_or_another_place",
    f"{FOLDER}::test_any_bytes_stay_inside_or_are_refused",
    "tests/devices/system/test_files.py::test_whatever_is_asked_stays_inside_and_is_answered",
)
elsewhere(
    "A station does not start with a `root` that shows its configuration, `static_routes` or"
    " `persistent_data` to clients.",
    "tests/station/test_assembly.py::test_clients_are_not_shown_what_the_station_reads_itself",
)
elsewhere(
    "Machine code is not loaded from a cache that others own or may write to.",
    "tests/native/backend/test_cache.py::test_a_folder_that_others_may_write_to_is_not_used",
    "tests/native/backend/test_cache.py::test_a_file_that_others_may_write_to_is_not_loaded",
    "tests/native/backend/test_cache.py::test_what_belongs_to_somebody_else_is_not_loaded",
)
elsewhere(
    "What a station writes is whole on the disk, the old or the new, when it is killed or the power"
    " fails.",
    f"{STATE}::test_killed_at_any_system_call_the_old_or_the_new_is_there",
    f"{STATE}::test_a_text_is_on_the_disk_before_its_name_and_the_name_before_the_answer",
)
elsewhere(
    "What a client holds has limits, for itself and for all together, in `[limits]`.",
    "tests/server/test_limits.py::test_notifications_per_client",
    "tests/server/test_limits.py::test_handles_of_one_client_and_of_all",
    "tests/server/test_limits.py::test_bytes_of_all_samples_of_all_clients",
    "tests/devices/test_station.py"
    "::test_taps_of_many_addresses_have_a_limit_together_and_harm_nobody",
)
elsewhere(
    "A client that does not read is cut off.",
    f"{TCP}::test_a_peer_that_does_not_read_is_cut_off",
    f"{TCP}::test_of_unfinished_packets_that_are_too_much_together_the_largest_goes",
)
elsewhere(
    "Bytes that are not AMS close the connection they come by, and no other.",
    f"{TCP}::test_garbage_closes_with_a_log_line_after_the_answers_before_it",
    f"{TCP}::test_an_exception_over_one_frame_is_told_and_closes_nothing",
)
elsewhere(
    "Text that nests too deep is refused with an error, wherever a parser reads it.",
    *(
        f"{NESTING}::test_{parser}"
        for parser in (
            *("expressions", "statements", "declarations_and_comments", "names_of_types", "paths"),
            *("types_that_rest_on_each_other", "values", "station_toml", "state_files", "xml"),
            "faults_that_a_client_wants",
        )
    ),
)
elsewhere(
    "File services and host names are looked after beside the loop, so that a slow disk or network"
    " holds up nobody else.",
    "tests/devices/system/test_files.py::test_no_file_service_holds_the_loop",
    "tests/transport/test_host_names.py::test_a_look_up_that_hangs_holds_nobody_up",
)
elsewhere(
    "During a restart nobody takes the ports of the configuration.",
    "tests/station/test_assembly.py::test_configured_ports_stay_the_stations_through_restarts",
)
elsewhere(
    "Beside an attack a good client is answered in time.",
    *(
        f"{HOSTILE}::test_{attack}"
        for attack in ("taps", "logging", "routes", "files", "loops_of_routes")
    ),
)
elsewhere(
    "Virtual drives give the processor back when a master asks without a pause.",
    "tests/station/test_fieldbus.py::test_with_priority_never_more_than_half_in_the_long_run",
)
elsewhere(
    "The link opens an EtherCAT segment that DL control has closed.",
    "tests/station/test_fieldbus.py::test_a_segment_closed_by_dl_control_opens_again_with_the_link",
    "tests/ethercat/test_segment.py::test_whatever_dl_control_does_the_link_opens_the_segment",
)


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
    assert {"start process", "registry HKLM", "send mail"} <= set(_REFUSED.values())
    client = client_of(station().router, 10_000)
    for group in _REFUSED:
        with refused(0x701):
            client.exchange(group, 0, 100, b"/bin/sh\0")
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
        "nc": {"kernel": "interpreted"},
        "plc": [{"globals": ["achse.station.demo:GVL"]}],
    }
    built = station(**document)
    async with built.running("127.0.0.1", 0, speed=0) as running:
        dial = functools.partial(achse.connect, f"127.0.0.1:{running.tcp_port}", source=STRANGER)
        async with dial(port=851) as plc:
            await plc.write("GVL.nInt", 66)
            assert await plc.read("GVL.nInt") == 66
        async with dial(port=501) as nc:
            [axis] = await chosen(nc, ["X"])
            await axis.write(PARAMETERS, "max_velocity", 66.0)
            assert await axis.read(PARAMETERS, "max_velocity") == 66.0
            await axis.write(CYCLIC, "velocity_override", FULL_OVERRIDE * 100)
            await axis.write(CYCLIC, "control_dword", ALL_ENABLES)
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


@proves("Rights of single clients do not exist.")
@proves("A NetId and an address are all that is compared, and a sender may lie about its NetId.")
@proves("When a route is removed, connections that are open stay.")
async def test_who_gets_in_past_strict_has_every_right() -> None:
    built = station(router={"strict": True})
    route = Route(name="me", net_id=AmsAddress(STRANGER).net_id, host="127.0.0.1")
    async with built.running("127.0.0.1", 0, speed=0) as running:
        dial = functools.partial(achse.connect, f"127.0.0.1:{running.tcp_port}", port=10_000)
        built.router.routes.add(route)
        async with dial(source=STRANGER, reconnect=False) as liar:
            assert (await liar.state()).ads_state == 5
            built.router.routes.remove("me")
            assert (await liar.state()).ads_state == 5
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
@proves("Sources and symbol files of a PLC are read and never run.")
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


@proves("Nothing is encrypted, neither values nor passwords.")
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
async def test_a_search_asks_for_no_password() -> None:
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
    kept: list[int] = []
    fsync = os.fsync

    def keep(number: int) -> None:
        kept.append(number)
        fsync(number)

    monkeypatch.setattr(os, "fsync", keep)
    built = station(tmp_path, router={"static_routes": "r.xml", "routes_over_ads": True})
    route = Route(name="me", net_id=NetId("5.8.8.8.1.1"), host="10.0.0.8")
    client_of(built.router, 10_000).write(801, 0, RouteEntry.of(route).encode())
    assert (len(kept), "10.0.0.8" in (tmp_path / "r.xml").read_text()) == (2, True)


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
