"""The npm package ads-client reads, writes, subscribes and moves, by the router and directly."""

from collections.abc import Callable
from typing import Any

import pytest

both_modes = pytest.mark.parametrize("mode", ["router", "direct"])


@both_modes
def test_variables(station: Any, node: Callable[..., Any], mode: str) -> None:
    report = node("variables.mjs", station, mode)
    local, symbols = report.pop("local"), report.pop("symbols")
    assert local.startswith("192.0.2.7.1.1:" if mode == "direct" else f"{station.net_id}:")
    assert {"MAIN.nCounter", "GVL.fLreal", "GVL.stPoint"} <= set(symbols)
    assert report == {
        "device": "Plc30 App",
        "state": "Run",
        "DINT": -123456,
        "LREAL": 0.125,
        "STRING": "Vorschub",
        "WSTRING": "Größe µ",
        "array": list(range(9, -1, -1)),
        "element": 0,
        "structure": {"fX": 1.5, "fY": -2.5, "sName": "corner", "bValid": True},
        "member": 4.5,
        "enumeration": {"name": "BLUE", "value": 2},
        "raw": (-123456).to_bytes(4, "little", signed=True).hex(),
        "samples": [-123456, 7],
        "unknown": 0x710,
    }


@both_modes
def test_an_axis_moves(station: Any, node: Callable[..., Any], mode: str) -> None:
    report = node("axis.mjs", station, mode)
    start, end = report["start"], report["end"]
    assert end["error"] == 0
    assert end["position"] == pytest.approx(start["position"] + 50.0, abs=1e-9)
    assert end["actual"] == pytest.approx(end["position"], abs=0.01)
    assert 0 < report["peak"] <= 100.0 * (1 + 1e-6)
