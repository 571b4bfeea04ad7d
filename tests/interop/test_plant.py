"""A plant declared in .TcDUT, .TcGVL and .TcPOU files: every client sees it as on a real PLC."""

import asyncio
import ctypes
import json
import struct
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from datetime import datetime, timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import achse
from achse.ams import DeviceError
from achse.iec import plain

PLANT = Path(__file__).parent / "plant" / "station.toml"
NPM = Path(__file__).parent / "npm"

FIRST = {
    "nId": 1,
    "sName": "first",
    "wsTitle": "Größe",
    "eMode": 10,
    "tWait": timedelta(milliseconds=1500),
    "dtLast": datetime(2026, 1, 2, 3, 4, 5),
    "aPoints": [{"fX": 0.0, "fY": 1.5}, {"fX": 0.0, "fY": 1.5}],
    "bReady": False,
}
"""The first station as declared."""

NAMES = {"GVL.aStations", "GVL.nShift", "GVL.cMost", "MAIN.nCycles", "MAIN.fbFeeder"}


class Point(ctypes.Structure):
    _fields_ = (("fX", ctypes.c_double), ("fY", ctypes.c_double))


class Station(ctypes.Structure):
    """ST_Station by hand: each member at its natural alignment, 8 at most."""

    _fields_ = (
        ("nId", ctypes.c_int16),
        ("sName", ctypes.c_char * 21),
        ("_gap", ctypes.c_byte),
        ("wsTitle", ctypes.c_uint16 * 13),
        ("eMode", ctypes.c_uint16),
        ("tWait", ctypes.c_uint32),
        ("dtLast", ctypes.c_uint32),
        ("aPoints", Point * 2),
        ("bReady", ctypes.c_bool),
    )


@pytest.fixture(scope="module")
def station(start_station: Callable[..., AbstractContextManager[Any]]) -> Iterator[Any]:
    with start_station(str(PLANT)) as running:
        yield running


@pytest.fixture
def restartable(
    start_station: Callable[..., AbstractContextManager[Any]], free_host: Callable[[], str]
) -> Callable[[], AbstractContextManager[Any]]:
    """`with restartable() as station:` always starts the plant at the same address."""
    host = free_host()
    return lambda: start_station(str(PLANT), "--host", host, "--net-id", f"{host}.1.1")


# achse -------------------------------------------------------------------------------------------


def test_achse(station: Any) -> None:
    async def main() -> None:
        async with achse.connect(station.host) as plc:
            assert {entry.name for entry in await plc.symbols()} >= NAMES
            first, second, _ = await plc.read("GVL.aStations")
            assert plain(first) == FIRST
            second.sName, second.eMode, second.wsTitle = "von achse", "Fault", "Maß µ"
            second.tWait = timedelta(seconds=3)
            await plc.write("GVL.aStations[1]", second)
            assert plain(await plc.read("GVL.aStations[1]")) == plain(second)
            assert (await plc.read("GVL.aStations[1].eMode")).name == "Fault"
            async with plc.subscribe("GVL.aStations[1]", cycle_time=0.01) as samples:
                assert plain((await anext(samples)).value) == plain(second)
                await plc.write("GVL.aStations[1].aPoints[2].fX", 7.5)
                assert (await anext(samples)).value.aPoints[2].fX == 7.5
            weight = await plc.call("MAIN.fbFeeder", "Feed", nParts=3, fWeight=0.5, sWhat="Nägel")
            assert weight == 1.5
            result = await plc.call("MAIN.fbFeeder", "Last")
            assert (result.value, result.outputs["sWhat"]) == (True, "Nägel")
            assert plain(result.outputs["stLast"]) == {"fX": 3.0, "fY": 0.5}
            assert await plc.read("MAIN.fbFeeder.fMean") == 0.5
            with pytest.raises(DeviceError, match="0x704"):
                await plc.write("MAIN.fbFeeder.fMean", 1.0)
            shift = await plc.read("GVL.nShift")
            result = await plc.call("MAIN", "Shift", nTo=2)
            assert (result.value, result.outputs) == (2, {"nFrom": shift})

    asyncio.run(main())


def test_achse_survives_a_restart(restartable: Callable[..., Any]) -> None:
    async def main() -> None:
        with restartable() as first:
            plc = await achse.connect(first.host)
            samples = await plc.subscribe("GVL.aStations[0].sName", cycle_time=0.01).__aenter__()
            assert (await anext(samples)).value == "first"
            await plc.write("GVL.aStations[0].sName", "before")
            assert (await anext(samples)).value == "before"
        with restartable():
            sample = await anext(samples)
            assert (sample.value, sample.gap) == ("first", True)
            await plc.write("GVL.aStations[0].sName", "after")
            assert (await anext(samples)).value == "after"
            assert plain((await plc.read("GVL.aStations"))[0])["sName"] == "after"
            await plc.close()

    asyncio.run(main())


# pyads -------------------------------------------------------------------------------------------


def _use_with_pyads(plc: Any, name: str, until: Callable[..., None]) -> None:
    import pyads

    symbols = {symbol.name: symbol for symbol in plc.get_all_symbols()}
    assert set(symbols) >= NAMES
    assert symbols["GVL.aStations"].symbol_type == "ARRAY [0..2] OF ST_Station"
    stations = plc.read_by_name("GVL.aStations", Station * 3)
    one = stations[2]
    assert (one.nId, one.sName, one.eMode, one.tWait) == (3, b"new", 10, 1500)
    assert "".join(map(chr, one.wsTitle)).rstrip("\0") == "Größe"
    assert [point.fY for point in one.aPoints] == [1.5, 1.5]
    one.sName, one.aPoints[1].fX = name.encode(), 2.25
    plc.write_by_name("GVL.aStations[2]", one, Station)
    assert plc.read_by_name("GVL.aStations[2].sName", pyads.PLCTYPE_STRING) == name
    assert plc.read_by_name("GVL.aStations[2].aPoints[2].fX", pyads.PLCTYPE_LREAL) == 2.25
    assert plc.read_by_name("GVL.aStations[2].wsTitle", pyads.PLCTYPE_WSTRING) == "Größe"
    assert plc.read_by_name("MAIN.fbFeeder.fMean", pyads.PLCTYPE_LREAL) == 0

    seen: list[tuple[bytes, int]] = []

    @plc.notification(Station)
    def note(handle: int, name: str, stamp: datetime, value: Station) -> None:
        seen.append((bytes(value.sName), value.nId))

    attributes = pyads.NotificationAttrib(ctypes.sizeof(Station), cycle_time=10)
    handles = plc.add_device_notification("GVL.aStations[2]", attributes, note)
    until(lambda: seen)
    plc.write_by_name("GVL.aStations[2].nId", 33, pyads.PLCTYPE_INT)
    until(lambda: len(seen) > 1)
    assert seen[:2] == [(name.encode(), 3), (name.encode(), 33)]
    plc.del_device_notification(*handles)


def test_pyads_with_a_restart_between(
    restartable: Callable[..., Any],
    pyads_connection: Callable[..., Any],
    until: Callable[..., None],
) -> None:
    with restartable() as first:
        plc = pyads_connection(first, 851)
        _use_with_pyads(plc, "von pyads", until)
        plc.close()
    with restartable():
        plc.open()
        _use_with_pyads(plc, "wieder da", until)


# ads-client --------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["router", "direct"])
def test_ads_client(
    start_station: Callable[..., AbstractContextManager[Any]],
    node: Callable[..., Any],
    mode: str,
) -> None:
    with start_station(str(PLANT)) as station:
        report = node("plant.mjs", station, mode)
    assert set(report["symbols"]) >= NAMES
    first = report["before"][0]
    assert (first["nId"], first["sName"], first["wsTitle"]) == (1, "first", "Größe")
    mode_now = first["eMode"]
    assert (mode_now["name"], mode_now["value"], first["tWait"]) == ("Auto", 10, 1500)
    assert first["dtLast"].startswith("2026-01-02T03:04:05")
    assert first["aPoints"] == [{"fX": 0, "fY": 1.5}, {"fX": 0, "fY": 1.5}]
    after = report["after"]
    assert (after["sName"], after["wsTitle"], after["tWait"]) == ("zweite", "Maß µ", 250)
    assert (after["eMode"]["name"], after["bReady"]) == ("Fault", True)
    assert after["aPoints"] == [{"fX": 1.25, "fY": -2.5}, {"fX": 3, "fY": 4}]
    assert (report["member"], report["total"]) == (22, 4)
    assert report["fed"] == {"returnValue": 10, "outputs": {}}
    assert report["last"] == {
        "returnValue": True,
        "outputs": {"stLast": {"fX": 4, "fY": 2.5}, "sWhat": "Schrauben"},
    }
    assert report["shifted"]["returnValue"] == 3
    assert report["samples"] == [["new", 1.5], ["dritte", 1.5]]


def test_ads_client_survives_a_restart(
    restartable: Callable[..., Any], witness: Callable[[str], None]
) -> None:
    witness("ads-client")
    lines: list[str] = []
    with restartable() as first:
        settings = {
            "routerAddress": first.host,
            "routerTcpPort": first.port,
            "targetAmsNetId": first.net_id,
            "targetAdsPort": 851,
        }
        client = subprocess.Popen(
            ["node", "plant-restart.mjs", json.dumps(settings)],
            cwd=NPM,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert client.stdin is not None
        assert client.stdout is not None
        overdue = threading.Timer(600, client.kill)
        overdue.start()
        lines.append(client.stdout.readline())
        client.stdin.write("x\n")
        client.stdin.flush()
        lines.append(client.stdout.readline())
    assert lines == ["sample first\n", "sample changed 1\n"]
    with restartable():
        lines = [client.stdout.readline(), client.stdout.readline()]
        assert sorted(lines) == ["reconnected\n", "sample first\n"]
        client.stdin.write("x\n")
        client.stdin.flush()
        assert client.stdout.readline() == "sample changed 2\n"
        client.stdin.close()
        assert client.wait() == 0
        client.stdout.close()
    overdue.cancel()


# ads-async ---------------------------------------------------------------------------------------


def test_ads_async_with_a_restart_between(
    restartable: Callable[..., Any],
    witness: Callable[[str], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    witness("ads-async")
    monkeypatch.setattr("ads_async.asyncio.client.asyncio", _asyncio_as_before_3_11())
    with restartable() as first:
        asyncio.run(_use_with_ads_async(first, b"von ads-async"))
    with restartable() as second:
        asyncio.run(_use_with_ads_async(second, b"wieder da"))


def _asyncio_as_before_3_11() -> Any:
    """ads-async 0.3.1 hands coroutines to `asyncio.wait`, which Python 3.11 no longer takes."""

    async def wait(waiting: Any, **options: Any) -> Any:
        return await asyncio.wait([asyncio.ensure_future(item) for item in waiting], **options)

    return SimpleNamespace(**{**vars(asyncio), "wait": wait})


async def _use_with_ads_async(station: Any, name: bytes) -> None:
    from ads_async import constants, structs
    from ads_async.asyncio.client import Client

    async with Client(
        (station.host, station.port), our_net_id="192.0.2.9.1.1", reconnect_rate=None
    ) as client:
        circuit = client.get_circuit(station.net_id)
        info = await circuit.get_symbol_info_by_name("GVL.aStations[1]")
        assert info.size == ctypes.sizeof(Station)

        def read(group: int, offset: int, length: int) -> Any:
            return structs.AdsReadRequest(group, offset, length)

        sizes = await circuit.write_and_read(read(0xF00C, 0, 8))
        count, length = struct.unpack("<II", bytes(sizes.data)[:8])
        table = await circuit.write_and_read(read(0xF00B, 0, length))
        assert len(bytes(table.data)) == length
        assert all(one.encode() in bytes(table.data) for one in NAMES)
        assert count >= len(NAMES)

        symbol = circuit.get_symbol_by_name("GVL.aStations[1]")
        await symbol.initialize()
        answer = await circuit.get_value_by_handle(symbol.handle, info.size)
        one = Station.from_buffer_copy(bytes(answer.data))
        assert (one.nId, one.sName, one.eMode, one.tWait) == (2, b"new", 10, 1500)
        assert await circuit.get_symbol_by_name("GVL.aStations[0].sName").read() == "first"

        notification = await symbol.add_notification(
            length=info.size,
            mode=constants.AdsTransmissionMode.SERVERONCHA,
            max_delay=0,
            cycle_time=100_000,
        )
        async with notification:
            samples = notification.__aiter__()
            _, _, sample = await anext(samples)
            assert Station.from_buffer_copy(bytes(sample.data)).sName == b"new"
            one.sName = name
            await circuit.write_and_read(
                structs.AdsWriteRequest(0xF005, symbol.handle, data=bytes(one))
            )
            _, _, sample = await anext(samples)
            assert Station.from_buffer_copy(bytes(sample.data)).sName == name
            await samples.aclose()
