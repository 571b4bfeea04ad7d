"""Simulated signals of a station: written each PLC cycle, in virtual time, deterministic."""

import logging
from pathlib import Path
from typing import Any

import pytest

from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse

PLC = {
    "globals": ["achse.station.demo:GVL"],
    "task": [{"cycle": "10ms", "programs": ["achse.station.demo:MAIN"]}],
}


def _station(*signals: dict[str, Any], base: Path | None = None, plc: Any = PLC) -> Station:
    document = {"plc": [plc] if plc else [], "signal": list(signals)}
    return Station(parse(document, "station.toml"), base=base)


def _gvl(station: Station) -> Any:
    return station.plcs[851].instance("GVL")


SINE = {"symbol": "gvl.flreal", "kind": "sine", "period": "1s", "amplitude": 2, "offset": 1}


def test_a_signal_is_there_before_the_first_cycle_and_in_each() -> None:
    station = _station(SINE)
    assert _gvl(station)["fLreal"] == 1
    station.advance(0.25)
    assert _gvl(station)["fLreal"] == pytest.approx(3)
    _gvl(station)["fLreal"] = 99.0
    station.advance(0.009)
    assert _gvl(station)["fLreal"] == 99
    station.advance(0.001)
    assert _gvl(station)["fLreal"] != 99


def test_the_program_sees_the_value_of_its_cycle(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(
        "PROGRAM MAIN VAR nIn : UDINT; nSeen : UDINT; nCycle : UDINT; END_VAR\n"
        "nCycle := nCycle + 1; nSeen := nIn; END_PROGRAM"
    )
    count = {"symbol": "MAIN.nIn", "kind": "counter"}
    station = _station(count, base=tmp_path, plc={"sources": "MAIN.st"})
    station.advance(0.5)
    main = station.plcs[851].instance("MAIN")
    assert main["nSeen"] == main["nIn"] == 50


@pytest.mark.parametrize(
    ("symbol", "amplitude", "value"),
    [
        ("GVL.nSint", 1e9, 127),
        ("GVL.nSint", -1e9, -128),
        ("GVL.nUsint", -3.0, 0),
        ("GVL.nInt", 2.6, 3),
        ("GVL.nUlint", 1e30, 2**64 - 1),
        ("GVL.fReal", 1.5, 1.5),
        ("GVL.bBool", 0.1, True),
        ("GVL.bBool", -1.0, False),
        ("GVL.aInt[3]", 7.0, 7),
        ("GVL.aLreal[1,2]", 7.5, 7.5),
        ("GVL.stPoint.fX", 7.5, 7.5),
        ("GVL.nWord.3", 1.0, True),
        ("GVL.eColour", 2.0, 2),
    ],
)
def test_a_value_becomes_that_of_the_type(symbol: str, amplitude: float, value: Any) -> None:
    signal = {"symbol": symbol, "kind": "square", "period": "1s", "duty": 1.0}
    station = _station({**signal, "amplitude": amplitude})
    source = station.devices
    device = next(each for each in source if each.address.port == 851)
    assert device.symbols is not None
    place: Any = device.symbols.source.resolve(symbol)
    assert place.type.decode(place.read()) == value


def test_a_counter_goes_on_within_the_range_of_its_type() -> None:
    station = _station({"symbol": "GVL.nUsint", "kind": "counter", "first": 250})
    station.advance(0.07)
    assert _gvl(station)["nUsint"] == 1


def test_an_expression_sees_other_variables_and_earlier_signals() -> None:
    station = _station(
        SINE,
        {
            "symbol": "GVL.fReal",
            "kind": "expression",
            "expression": "if(GVL.bBool, GVL.fLreal, 0) + GVL.aInt[2] + 10 * t",
        },
    )
    station.advance(0.25)
    assert _gvl(station)["fReal"] == pytest.approx(3 + 2 + 2.5)
    _gvl(station)["bBool"] = False
    station.advance(0.01)
    assert _gvl(station)["fReal"] == pytest.approx(2 + 2.6)


def test_what_cannot_be_computed_leaves_the_variable_and_is_reported_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    signal = {"symbol": "GVL.fReal", "kind": "expression", "expression": "1 / GVL.nInt"}
    station = _station(signal)
    _gvl(station)["nInt"] = 4
    station.advance(0.01)
    _gvl(station)["nInt"] = 0
    station.advance(0.1)
    assert _gvl(station)["fReal"] == 0.25
    assert caplog.text.count("signal[1] (GVL.fReal) has no value at 0.02 s") == 1
    _gvl(station)["nInt"] = 2
    station.advance(0.01)
    assert _gvl(station)["fReal"] == 0.5


def test_equal_runs_are_equal_however_time_passes() -> None:
    signals = [SINE, {"symbol": "GVL.nInt", "kind": "noise", "amplitude": 1e4, "seed": 5}]
    one, other = _station(*signals), _station(*signals)
    one.advance(2.0)
    for _ in range(200):
        other.advance(0.01)
    assert one.digest() == other.digest()


def test_a_restart_and_a_stopped_plc_do_not_end_signals() -> None:
    station = _station({"symbol": "GVL.nUdint", "kind": "counter"})
    station.plcs[851].stop()
    station.advance(0.1)
    assert _gvl(station)["nUdint"] == 10
    station.restart()
    station.advance(1.0)
    assert _gvl(station)["nUdint"] == 110


def test_after_an_online_change_signals_find_their_variables(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    source = tmp_path / "MAIN.st"
    source.write_text("PROGRAM MAIN VAR a : UDINT; b : UDINT; END_VAR END_PROGRAM")
    signals = [{"symbol": f"MAIN.{name}", "kind": "counter"} for name in "ab"]
    station = _station(*signals, base=tmp_path, plc={"sources": "MAIN.st"})
    station.advance(0.1)
    source.write_text("PROGRAM MAIN VAR x : LREAL; b : UDINT; END_VAR END_PROGRAM")
    with caplog.at_level(logging.WARNING):
        station.online_change()
        station.advance(0.1)
    assert station.plcs[851].instance("MAIN")["b"] == 20
    assert "signal[1].symbol: expected a variable of the PLC, got 'MAIN.a'" in caplog.text


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        ({"symbol": "GVL.nIntt", "kind": "noise"}, r"signal\[1\]\.symbol: .*mean 'GVL.nInt'"),
        ({"symbol": "nCounter", "kind": "noise"}, "did you mean 'MAIN.nCounter'"),
        ({"symbol": "GVL.sString", "kind": "noise"}, "expected a number or a BOOL, got a STRING"),
        ({"symbol": "GVL.aInt", "kind": "noise"}, "expected a number or a BOOL"),
        ({"symbol": "GVL.aInt[77]", "kind": "noise"}, r"signal\[1\]\.symbol"),
        ({"symbol": "GVL.nInt", "kind": "noise", "plc": 852}, r"signal\[1\]\.plc: .*\(851\)"),
        (
            {"symbol": "GVL.nInt", "kind": "expression", "expression": "GVL.x + 1"},
            r"signal\[1\]\.expression: .*'GVL.x'",
        ),
        (
            {"symbol": "GVL.nInt", "kind": "expression", "expression": "GVL.sString + 1"},
            "GVL.sString: expected a number",
        ),
        (
            {"symbol": "GVL.nInt", "kind": "expression", "expression": "1 +"},
            r"signal\[1\]\.expression: column 4: expected a number",
        ),
        ({"symbol": "GVL.nInt", "kind": "csv", "file": "no.csv"}, r"signal\[1\]\.file: .*no.csv"),
    ],
)
def test_what_does_not_fit_is_reported(signal: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        _station(signal)


def test_two_signals_for_one_variable_are_refused() -> None:
    with pytest.raises(ConfigError, match="more than one signal"):
        _station(SINE, SINE)


def test_without_a_plc_there_is_nothing_to_write() -> None:
    with pytest.raises(ConfigError, match=r"signal\[1\]\.plc: .*none"):
        _station(SINE, plc=None)
