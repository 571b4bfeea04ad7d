"""pyads operates the scope server over TCP as its manual says, while others flood it and vanish."""

import asyncio
import contextlib
import json
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.client import blocking
from achse.scope.service import ScopeGroup
from achse.station import Station
from achse.station.configuration.station_file import parse

PLC = [{"globals": ["achse.station.demo:GVL"], "task": [{"programs": ["achse.station.demo:MAIN"]}]}]
VIEW = {"name": "press", "record_length": "500ms", "channels": ["MAIN.nCounter"]}


@pytest.fixture
def served(tmp_path: Path, free_host: Callable[[], str]) -> Iterator[tuple[Station, str, int]]:
    """A station with a folder for recordings, ten times as fast as the clock."""
    (tmp_path / "recordings").mkdir()
    host = free_host()
    document = {
        "router": {"net_id": f"{host}.1.1"},
        "plc": PLC,
        "scope": {"folder": "recordings", "view": [VIEW]},
    }
    station = Station(parse(document, "station.toml"), base=tmp_path)
    ready, loop, leave, port = threading.Event(), asyncio.new_event_loop(), asyncio.Event(), [0]

    async def serve() -> None:
        async with station.running(host, 48898, udp_port=None, speed=10) as running:
            port[0] = running.tcp_port
            ready.set()
            await leave.wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(serve()))
    thread.start()
    assert ready.wait(60)
    yield station, host, port[0]
    loop.call_soon_threadsafe(leave.set)
    thread.join()
    loop.close()


def test_pyads_goes_online_triggers_and_exports(
    served: tuple[Station, str, int], witness: Callable[[str], None], tmp_path: Path
) -> None:
    witness("pyads")
    witness("pytcs")
    import pyads
    import pytcs

    _, host, port = served
    with pyads.Connection(f"{host}.1.1", 14000, host) as scope:
        scope.write(0x3000, 0x201, 0.3, pyads.PLCTYPE_LREAL)
        assert scope.read(0x1000, 1, pyads.PLCTYPE_BYTE) == 0
        _write(scope, 0x1000, 1)
        assert scope.read(0x1000, 1, pyads.PLCTYPE_BYTE) == 1
        _write(scope, 0x3000, 0x101)
        with blocking.connect(f"{host}:{port}", port=14000) as client:
            while json.loads(client.read_raw(ScopeGroup.SCOPES, 1, 1 << 20))["state"] != "done":
                pass
        _write(scope, 0x3000, 0x1001, "D:\\TwinCAT\\Scope\\Data\\Test.csv")
    [file] = (tmp_path / "recordings").rglob("Test.csv")
    read = pytcs.ScopeFile(file)
    read.load()
    counts = read["MAIN.nCounter"].values
    assert len(counts) == 30
    assert (counts[1:] - counts[:-1] == 1).all()


def _write(scope: Any, group: int, offset: int, text: str = "") -> None:
    import pyads

    if text:
        scope.write(group, offset, text, pyads.PLCTYPE_STRING)
    else:
        scope.write(group, offset, [], pyads.PLCTYPE_BYTE * 0)


def test_a_client_beside_a_flood_gets_every_sample(served: tuple[Station, str, int]) -> None:
    station, host, port = served
    address = f"{host}:{port}"
    over = threading.Event()

    def flood() -> None:
        many = [{"name": f"c{n}", "symbol": "MAIN.nCounter"} for n in range(1000)]
        while not over.is_set():
            with blocking.connect(address) as bad:
                for _ in range(4):
                    with contextlib.suppress(DeviceError):
                        scope = bad.scope(many, length=3600)
                        scope.open()
                        scope.start()
                bad.at_port(14000).read_raw(ScopeGroup.SCOPES, 0, 1 << 20)

    thread = threading.Thread(target=flood)
    with blocking.connect(address) as good, good.scope("MAIN.nCounter", length=2.0) as scope:
        thread.start()
        try:
            scope.trigger()
            scope.wait(600)
            counts = scope.data()["MAIN.nCounter"].values
        finally:
            over.set()
            thread.join()
        assert len(counts) == 200
        assert counts == list(range(counts[0], counts[0] + 200))
    with blocking.connect(address) as last:
        listed = json.loads(last.at_port(14000).read_raw(ScopeGroup.SCOPES, 0, 1 << 20))
    assert len(listed) == 1
    assert station.state.name == "RUN"
