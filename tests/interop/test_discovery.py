"""Strangers find the station over UDP, make routes, and go through one station to another."""

import asyncio
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import NetId
from achse.router.access import hash_password
from achse.router.static_routes import parse_static_routes
from achse.transport.udp import scan

USER, PASSWORD = "Administrator", "1"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("press")


@pytest.fixture(scope="module")
def press(folder: Path, start_station: Callable[..., AbstractContextManager[Any]]) -> Iterator[Any]:
    """A station that lets Administrator change its routes."""
    (folder / "files").mkdir()
    (folder / "press.toml").write_text(
        f"""
        name = "press"
        [router]
        static_routes = "StaticRoutes.xml"
        [router.users]
        {USER} = "{hash_password(PASSWORD)}"
        [system]
        root = "files"
        [[plc]]
        globals = ["achse.station.demo:GVL"]
        [[plc.task]]
        programs = ["achse.station.demo:MAIN"]
        """
    )
    with start_station(str(folder / "press.toml")) as station:
        yield station


@pytest.fixture
def mill(
    press: Any, tmp_path: Path, start_station: Callable[..., AbstractContextManager[Any]]
) -> Iterator[Any]:
    """A station without a PLC that has a route to the press, and one by way of NAT."""
    (tmp_path / "mill.toml").write_text(
        f"""
        name = "mill"
        [[route]]
        name = "press"
        net_id = "{press.net_id}"
        host = "{press.host}"
        [[route]]
        name = "press behind NAT"
        net_id = "6.6.6.6.1.1"
        host = "{press.host}"
        nat = "{press.net_id}"
        """
    )
    with start_station(str(tmp_path / "mill.toml")) as station:
        yield station


def _routes(folder: Path) -> dict[str, str]:
    path = folder / "StaticRoutes.xml"
    text = path.read_text() if path.exists() else "<TcConfig/>"
    return {route.name: str(route.net_id) for route in parse_static_routes(text)}


def test_our_scan_finds_both_stations(press: Any, mill: Any) -> None:
    stations: set[tuple[str, str, str]] = set()
    for _ in range(20):  # a datagram has no guarantee
        answers = asyncio.run(scan([press.host, mill.host], seconds=0.5))
        stations |= {(info.host_name, str(info.net_id), address) for info, address in answers}
        if len(stations) == 2:
            break
    assert stations == {
        ("press", press.net_id, press.host),
        ("mill", mill.net_id, mill.host),
    }


def test_pyads_learns_the_net_id_and_adds_a_route(
    witness: Callable[[str], None], press: Any, folder: Path
) -> None:
    witness("pyads")
    from pyads.pyads_ex import adsAddRouteToPLC, adsGetNetIdForPLC

    assert adsGetNetIdForPLC(press.host) == press.net_id
    added = adsAddRouteToPLC("192.0.2.7.1.1", "192.0.2.7", press.host, USER, PASSWORD, "by pyads")
    assert added
    assert _routes(folder)["by pyads"] == "192.0.2.7.1.1"
    with pytest.raises(RuntimeError, match="Unexpected response"):
        adsAddRouteToPLC("192.0.2.8.1.1", "192.0.2.8", press.host, USER, "wrong", "intruder")
    assert "intruder" not in _routes(folder)


def _ads_async(*arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "ads_async", *arguments],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_ads_async_reports_facts_of_the_station(witness: Callable[[str], None], press: Any) -> None:
    witness("ads-async")
    output = _ads_async("info", press.host)
    assert f'"source_net_id": "{press.net_id}"' in output
    assert '"plc_name": "press"' in output


def test_ads_async_adds_a_route(witness: Callable[[str], None], press: Any, folder: Path) -> None:
    witness("ads-async")
    output = _ads_async(
        *("route", press.host, "192.0.2.9.1.1", "192.0.2.9"),
        *("--username", USER, "--password", PASSWORD, "--route-name", "by ads-async"),
    )
    assert '"password_correct": true' in output
    assert _routes(folder)["by ads-async"] == "192.0.2.9.1.1"


@pytest.mark.parametrize("behind_nat", [False, True])
def test_one_station_forwards_to_the_other(press: Any, mill: Any, behind_nat: bool) -> None:
    async def read() -> tuple[Any, Any]:
        there = NetId("6.6.6.6.1.1" if behind_nat else press.net_id)
        async with achse.connect(mill.host, net_id=there) as plc:
            first = await plc.read("GVL.sString")
            async with plc.subscribe("MAIN.nCounter", cycle_time=0.01) as samples:
                counts = [(await anext(samples)).value for _ in range(5)]
            return first, counts

    text, counts = asyncio.run(read())
    assert text == "axis"
    assert counts == sorted(set(counts))


def test_pyads_goes_through_one_station_to_the_other(
    witness: Callable[[str], None], press: Any, mill: Any
) -> None:
    witness("pyads")
    import pyads

    with pyads.Connection(press.net_id, 851, mill.host) as plc:
        assert plc.read_device_info()[0] == "Plc30 App"
        plc.write_by_name("GVL.nInt", 1234, pyads.PLCTYPE_INT)
        assert plc.read_by_name("GVL.nInt", pyads.PLCTYPE_INT) == 1234


def test_pyads_writes_a_file_and_cannot_leave_the_folder(
    witness: Callable[[str], None], press: Any, folder: Path
) -> None:
    witness("pyads")
    import pyads

    number, text = pyads.PLCTYPE_UDINT, pyads.PLCTYPE_STRING
    fopen, fclose, fwrite, write_mode = 120, 121, 123, 2 | 1 << 16
    with pyads.Connection(press.net_id, 10_000, press.host) as system:
        handle = system.read_write(fopen, write_mode, number, "a.txt", text)
        system.read_write(fwrite, handle, None, [*b"hallo"], pyads.PLCTYPE_BYTE * 5)
        system.read_write(fclose, handle, None, None, None)
        assert (folder / "files" / "a.txt").read_text() == "hallo"
        with pytest.raises(pyads.ADSError) as refusal:
            system.read_write(fopen, write_mode, number, "../press.toml", text)
        assert refusal.value.err_code == 0x70C


def test_ads_client_follows_a_restart(node: Callable[..., Any], press: Any) -> None:
    """A state request each second tells it: RUN, not RUN, RUN; see npm/restart.mjs."""
    report = node("restart.mjs", press, "router")
    assert report["before"] == 5
    assert report["index"] == report["indexBefore"] + 1
    assert report["after"] == 5
    assert report["value"] == "axis"


BY_A_TOOL = (
    bytes([192, 0, 2, 7, 1, 1, 1, 0, 0x20])
    + bytes(23)
    + bytes([10, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0])
    + b"192.0.2.7\0mill\0"
)
"""How a C# tool writes a route to group 801."""


@pytest.mark.parametrize("permitted", [False, True])
def test_routes_over_ads_change_where_the_user_permits_it(
    witness: Callable[[str], None],
    tmp_path: Path,
    start_station: Callable[..., AbstractContextManager[Any]],
    permitted: bool,
) -> None:
    """With a password for UDP in the configuration, which opened ADS as well before."""
    witness("pyads")
    import pyads

    (tmp_path / "a.toml").write_text(
        f'[router]\nroutes_over_ads = {str(permitted).lower()}\nstatic_routes = "r.xml"\n'
        f'[router.users]\n{USER} = "{hash_password(PASSWORD)}"\n'
    )
    with (
        start_station(str(tmp_path / "a.toml")) as station,
        pyads.Connection(station.net_id, 10_000, station.host) as system,
    ):

        def write(group: int, data: bytes) -> int:
            try:
                system.write(group, 0, [*data], pyads.PLCTYPE_BYTE * len(data))
            except pyads.ADSError as refusal:
                return int(refusal.err_code)
            return 0

        def stored_routes() -> list[str]:
            file = tmp_path / "r.xml"
            return [route.name for route in parse_static_routes(file.read_text())]

        assert write(801, BY_A_TOOL) == (0 if permitted else 0x723)
        if permitted:
            assert stored_routes() == ["mill"]
        assert write(802, b"mill\0") == (0 if permitted else 0x723)
        if permitted:
            assert stored_routes() == []
        assert (tmp_path / "r.xml").exists() is permitted


STRICT_CLIENT = """
import sys
import pyads
from pyads.pyads_ex import adsAddRouteToPLC

host, net_id = sys.argv[1:]
pyads.open_port()
pyads.set_local_address("192.0.2.7.1.1")
pyads.set_timeout(500)
with pyads.Connection(net_id, 10_000, host) as stranger:
    try:
        stranger.read_state()
    except pyads.ADSError as error:
        print(hex(error.err_code))
adsAddRouteToPLC("192.0.2.7.1.1", "127.0.0.1", host, "Administrator", "1", "me")
pyads.set_timeout(600_000)
with pyads.Connection(net_id, 10_000, host) as known:
    print(known.read_state())
"""


def test_a_strict_station_lets_pyads_in_once_it_has_a_route(
    witness: Callable[[str], None],
    tmp_path: Path,
    start_station: Callable[..., AbstractContextManager[Any]],
) -> None:
    witness("pyads")
    (tmp_path / "strict.toml").write_text(
        f'[router]\nstrict = true\n[router.users]\n{USER} = "{hash_password(PASSWORD)}"\n'
    )
    with start_station(str(tmp_path / "strict.toml")) as station:
        done = subprocess.run(
            [sys.executable, "-c", STRICT_CLIENT, station.host, station.net_id],
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines() == ["0x745", "(5, 1)"]
