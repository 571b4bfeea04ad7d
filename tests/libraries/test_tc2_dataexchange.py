"""Tc2_DataExchange: values of another PLC by name, values that go there, and signs of life."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.station import Station
from achse.station.configuration.station_file import parse

TARGET = """PROGRAM THERE VAR
    n, m : DINT; b : BYTE; w : WORD; d : DWORD; r : REAL; l : LREAL; on : BOOL; alive : UDINT;
    place AT %MD0 : DWORD; other : LINT; text : STRING := 'far';
END_VAR
other := other + 1;
END_PROGRAM"""


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., tuple[Any, Any, Station]]:
    """Run a program at 851 beside THERE at 852; returns both, and the station."""

    def run(source: str, cycles: int = 60) -> tuple[Any, Any, Station]:
        (tmp_path / "a.st").write_text(source, encoding="utf-8")
        (tmp_path / "b.st").write_text(TARGET, encoding="utf-8")
        document = {"plc": [{"sources": "a.st"}, {"sources": "b.st", "port": 852}]}
        station = Station(parse(document, "a.toml"), base=tmp_path)
        station.advance(cycles * 0.01)
        assert [plc.failure for plc in station.plcs.values()] == ["", ""]
        here, there = station.plcs[851].instance("MAIN"), station.plcs[852].instance("THERE")
        return here, there, station

    return run


def handles(station: Station) -> int:
    """Handles that PLC 852 has given away."""
    [device] = [each for each in station.devices if 852 in {at.port for at in each.addresses}]
    return len(device.symbols.handles)  # type: ignore[union-attr]


READING = """PROGRAM MAIN VAR
    read : FB_ReadAdsSymByName; step, done : INT; got : ARRAY [0..9] OF LINT; value : LINT;
    text : STRING; failed : ARRAY [0..9] OF UDINT;
END_VAR
step := step + 1;
read(bRead := step MOD 2 = 1, nPort := 852, sVarName := NAME, nDestAddr := ADR(value),
    nLen := 8, eComMode := MODE);
IF NOT read.bBusy AND done < 10 THEN
    got[done] := value; failed[done] := read.nErrorId; done := done + 1;
END_IF
END_PROGRAM"""


@pytest.mark.parametrize(("mode", "left"), [("SecureCom", 0), ("FastCom", 1)])
def test_values_are_read_by_name(run: Callable[..., Any], mode: str, left: int) -> None:
    source = READING.replace("NAME", "'THERE.other'").replace("MODE", f"eAdsComMode{mode}")
    here, there, station = run(source, 90)
    got = [int(value) for value in here["got"]]
    assert here["done"] == 10
    assert got == sorted(got)
    assert 0 < got[-1] <= there["other"]
    assert list(here["failed"]) == [0] * 10
    assert handles(station) <= left + 1


def test_another_name_takes_another_handle(run: Callable[..., Any]) -> None:
    name = "SEL(done MOD 2 = 0, 'THERE.text', 'THERE.other')"
    here, _, station = run(READING.replace("NAME", name).replace("MODE", "eAdsComModeFastCom"), 200)
    assert here["done"] == 10
    far = int.from_bytes(b"far\0\0\0\0\0", "little")
    assert [value == far for value in here["got"]][1:] == [True, False] * 4 + [True]
    assert handles(station) <= 2


def test_a_name_that_is_not_there_is_an_error(run: Callable[..., Any]) -> None:
    source = READING.replace("NAME", "'THERE.nothing'").replace("MODE", "eAdsComModeFastCom")
    here, _, station = run(source)
    assert here["failed"][0] == 0x710
    assert handles(station) == 0


def test_values_are_written_by_name(run: Callable[..., Any]) -> None:
    source = """PROGRAM MAIN VAR
    write, wrong : FB_WriteAdsSymByName; go : BOOL; n : DINT := -5;
END_VAR
go := NOT go;
write(bWrite := go, nPort := 852, sVarName := 'THERE.n', nSrcAddr := ADR(n), nLen := 4);
wrong(bWrite := TRUE, nPort := 852, sVarName := 'THERE.n', nSrcAddr := ADR(n), nLen := 9);
END_PROGRAM"""
    here, there, station = run(source)
    assert there["n"] == -5
    assert (here["wrong"]["bError"], here["wrong"]["nErrorId"]) == (True, 0x705)
    assert handles(station) <= 1


DELTAS = """PROGRAM MAIN VAR
    b : FB_WriteByteOnDelta; w : FB_WriteWordOnDelta; d, bad : FB_WriteDWordOnDelta;
    r : FB_WriteRealOnDelta; l : FB_WriteLRealOnDelta; on : FB_WriteBoolOnDelta; step : INT;
END_VAR
step := step + 1;
b(bEnable := TRUE, nPort := 852, sVarName := 'THERE.b', nSignal := INT_TO_BYTE(step),
    nLowerLimit := 3, nUpperLimit := 20);
w(bEnable := TRUE, nPort := 852, sVarName := 'THERE.w', nSignal := 7, nLowerLimit := 3,
    nUpperLimit := 20, bSendNow := step > 10);
d(bEnable := step < 30, nPort := 852, nIdxGrp := 16#4020, nSignal := INT_TO_DWORD(step),
    nUpperLimit := 9);
bad(bEnable := TRUE, nPort := 853, sVarName := 'THERE.d', nSignal := 99);
r(bEnable := TRUE, nPort := 852, sVarName := 'THERE.r', fSignal := 2.5, fLowerLimit := 3,
    fUpperLimit := 4, bSwapLowHighWord := SWAP);
l(bEnable := TRUE, nPort := 852, sVarName := 'THERE.l', fSignal := -2.5, tCycleTime := T#50MS);
on(bEnable := TRUE, nPort := 852, sVarName := 'THERE.on', bSignal := step < 25,
    bRisingEdge := TRUE, bFallingEdge := FALLS);
END_PROGRAM"""


def test_values_outside_of_their_limits_go(run: Callable[..., Any]) -> None:
    here, there, station = run(DELTAS.replace("SWAP", "FALSE").replace("FALLS", "FALSE"))
    assert here["step"] - 8 < there["b"] <= here["step"]
    assert there["w"] == here["w"]["nLastSignal"] == 7
    assert 20 < there["place"] < 30
    assert (there["r"], there["l"], there["on"]) == (2.5, -2.5, True)
    assert here["bad"]["nErrorCnt"] > 3
    assert (here["bad"]["bError"], here["bad"]["nErrorId"]) == (True, 6)
    assert here["r"]["fLastSignal"] == 2.5
    assert handles(station) == 5


def test_words_are_swapped_and_falls_are_sent(run: Callable[..., Any]) -> None:
    _, there, _ = run(DELTAS.replace("SWAP", "TRUE").replace("FALLS", "TRUE"))
    assert there["r"] == pytest.approx(2.298e-41, rel=1e-3)  # 16#0000_4020
    assert there["on"] is False


def test_a_watchdog_sees_its_counter_stop(run: Callable[..., Any]) -> None:
    source = """PROGRAM MAIN VAR
    sign : FB_WriteWatchdog; look, never : FB_CheckWatchdog; read : FB_ReadAdsSymByName;
    count : UDINT; step : INT; barked : ARRAY [0..250] OF BOOL;
END_VAR
step := step + 1;
sign(bEnable := step < 100, nPort := 852, sVarName := 'THERE.alive', tWatchdogTime := T#100MS);
read(bRead := step MOD 4 = 0, nPort := 852, sVarName := 'THERE.alive', nDestAddr := ADR(count),
    nLen := 4, eComMode := eAdsComModeFastCom);
look(bEnable := step > 20, tWatchdogTime := T#500MS, nCnt := count);
never(bEnable := TRUE, nCnt := count);
barked[step] := look.bWatchdog;
END_PROGRAM"""
    here, there, _ = run(source, 200)
    assert 6 <= here["sign"]["nLastCnt"] == there["alive"] <= 10
    barked = list(here["barked"])
    assert not any(barked[:140])
    assert all(barked[170:200])
    assert here["never"]["bWatchdog"] is False
