"""Tc2_SUPS: what blocks for a 1-second UPS do when the simulated power fails."""

from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse

BLOCKS = ("", "_CX51x0", "_CX9020_U900", "_CB3011", "_BAPI")
STATES = ("OK", "failure", "write", "shutdown", "recover", "off")
MODES = ("write and shutdown", "write", "shutdown", "check")

PROGRAM = (
    "PROGRAM MAIN VAR fail : BOOL; mode : E_S_UPS_Mode; recover : TIME := T#100MS;"
    + "".join(f" f{block} : FB_S_UPS{block};" for block in BLOCKS)
    + " port : UINT; state : E_S_UPS_State; trace : ARRAY [0..199] OF E_S_UPS_State; n : INT;"
    " END_VAR SimulatedPower.bPowerFail := fail;"
    + "".join(
        f" f{block}(eUpsMode := mode, tRecoverTime := recover, iPLCPort := port);"
        for block in BLOCKS
    )
    + " state := eGlobalSUpsState; IF n < 200 THEN trace[n] := f.eState; n := n + 1; END_IF"
    " END_PROGRAM"
)


def station(folder: Path) -> Station:
    (folder / "a.st").write_text(PROGRAM, encoding="utf-8")
    document: dict[str, Any] = {"plc": [{"sources": "a.st"}]}
    return Station(parse(document, "a.toml"), base=folder)


@pytest.fixture(scope="module")
def main(tmp_path_factory: pytest.TempPathFactory) -> tuple[Station, Any]:
    here = station(tmp_path_factory.mktemp("ups"))
    here.advance(0.02)
    plc = here.plcs[851]
    assert plc.failure == ""
    return here, plc.instance("MAIN")


@settings(max_examples=8, deadline=None)
@given(mode=st.sampled_from([1, 3]), off=st.integers(1, 20), recover=st.integers(1, 20))
def test_power_that_comes_back(
    main: tuple[Station, Any], mode: int, off: int, recover: int
) -> None:
    here, values = main
    values["mode"], values["n"], values["fail"] = mode, 0, True
    values["recover"] = timedelta(seconds=recover / 100)
    here.advance(off / 100)
    for block in BLOCKS:
        assert bool(values[f"f{block}"]["bPowerFailDetect"])
    assert int(values["f_BAPI"]["nCapacity"]) == 0
    values["fail"] = False
    here.advance(1)
    seen = [STATES[int(values["trace"][k])] for k in range(int(values["n"]))]
    order = list(dict.fromkeys(seen))
    expected = ["failure", "write", "recover", "OK"] if mode == 1 else ["failure", "recover", "OK"]
    assert order == expected
    assert seen.count("failure") == 1
    began = max(off, seen.index("recover"))
    assert abs(seen.index("OK") - began - recover) <= 2
    assert STATES[int(values["state"])] == "OK"
    assert {int(values[f"f{block}"]["eState"]) for block in BLOCKS} == {0}
    assert int(values["f_BAPI"]["nCapacity"]) == 100
    assert not bool(values["f_BAPI"]["bError"])


@pytest.mark.parametrize("mode", [0, 2])
def test_shutdown_ends_the_station(tmp_path: Path, mode: int) -> None:
    here = station(tmp_path)
    here.advance(0.02)
    values: Any = here.plcs[851].instance("MAIN")
    values["mode"], values["n"], values["fail"] = mode, 0, True
    here.advance(1)
    seen = [STATES[int(values["trace"][k])] for k in range(int(values["n"]))]
    write = ["write"] if mode == 0 else []
    assert list(dict.fromkeys(seen)) == ["failure", *write, "shutdown"]
    assert len(seen) < 100  # the PLC has ended


def test_port_that_does_not_exist(tmp_path: Path) -> None:
    here = station(tmp_path)
    here.advance(0.02)
    values: Any = here.plcs[851].instance("MAIN")
    values["mode"], values["fail"], values["port"] = 1, True, 999
    here.advance(0.5)
    assert int(values["f_BAPI"]["nErrID"]) == 6
    assert STATES[int(values["state"])] == "recover"
