"""`achse monitor --via`: what foreign clients do at a target is told with names and types."""

import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest

from achse.testing import LiveStation
from tests.warm_commands import WarmCommands

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

POINT = "(fX := 1.0, fY := 2.0, sName := 'home', bValid := TRUE)"


@contextmanager
def tap(
    commands: WarmCommands, station: LiveStation, host: str, *options: str
) -> Iterator[Callable[[str], str]]:
    """A tap in front of a station; `expect(text)` reads on to the line that contains it."""
    process = commands.popen(
        *("monitor", "--via", station.host, "--host", host, "--for", "100", *options),
        stdout=subprocess.PIPE,
    )
    assert process.stdout is not None
    lines = process.stdout

    def expect(text: str) -> str:
        for line in lines:
            if text in line:
                return line.split("  ")[2].strip()
        raise AssertionError(f"nothing with {text!r}")

    try:
        assert process.stdout.readline().startswith("achse ready tap=")
        yield expect
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def behind(free_host: Callable[[], str]) -> Iterator[Callable[[LiveStation, str], Any]]:
    """`behind(station, host)` is pyads that takes the tap at `host` for the station."""
    plcs = []

    def connect(station: LiveStation, host: str) -> Any:
        plc = pyads.Connection(station.net_id, 851, host)
        plc.open()
        plcs.append(plc)
        return plc

    yield connect
    for each in plcs:
        each.close()


def test_pyads_requests_bytes_and_the_tap_that_queries_reports_values(
    free_host: Callable[[], str], behind: Callable[..., Any], warm_commands: WarmCommands
) -> None:
    host = free_host()
    with (
        LiveStation() as station,
        tap(warm_commands, station, host, "--ask", station.net_id) as expect,
    ):
        plc = behind(station, host)
        assert plc.read_by_name("GVL.nInt", pyads.PLCTYPE_INT) == -16
        assert expect(" read GVL.nInt") == "read GVL.nInt = -16"
        plc.write_by_name("GVL.stPoint.fX", 2.5, pyads.PLCTYPE_LREAL)
        assert expect(" write GVL.stPoint") == "write GVL.stPoint.fX = 2.5"
        info = plc.get_symbol("GVL.nInt")
        plc.read(info.index_group, info.index_offset, pyads.PLCTYPE_INT)
        assert expect(" read GVL.nInt") == "read GVL.nInt = -16"
        assert plc.read_list_by_name(["GVL.stPoint.fY", "GVL.nInt"])["GVL.nInt"] == -16
        assert expect("read GVL.stPoint.fY = ").endswith("2 at once: read GVL.stPoint.fY = 2.0")
        attributes = pyads.NotificationAttrib(4)
        handles = plc.add_device_notification("MAIN.nCounter", attributes, lambda *_: None)
        assert expect("sample MAIN.nCounter").startswith("sample MAIN.nCounter = ")
        plc.del_device_notification(*handles)


def test_requests_of_ads_client_are_enough_for_a_tap_that_queries_nothing(
    free_host: Callable[[], str], node: Callable[..., Any], warm_commands: WarmCommands
) -> None:
    host = free_host()
    with LiveStation() as station, tap(warm_commands, station, host) as expect:
        place = SimpleNamespace(host=host, port=station.tcp_port, net_id=station.net_id)
        node("point.mjs", place, "direct")
        assert expect(" read GVL.stPoint") == f"read GVL.stPoint = {POINT}"
        assert expect("write GVL.stPoint").endswith(POINT.replace("1.0", "4.5"))
