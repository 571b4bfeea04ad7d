"""Faults begin and end at their station time, and leave nothing behind."""

from pathlib import Path
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.faults.fault import MOST_FAULTS, FaultError
from achse.station import ConfigError, Station

COUNTER = "MAIN.nCounter"


@pytest.fixture
def station() -> Station:
    return Station.demo()


@pytest.fixture
def plc(station: Station, client_of: Any) -> Any:
    return client_of(station.router, 851)


def _groups(station: Station) -> dict[int, Any]:
    """What answers for the index groups of the PLC."""
    return next(
        dict(device.services.by_index)
        for device in station.devices
        if device.addresses[0].port == 851
    )


def _refused(plc: Any) -> bool:
    try:
        plc.exchange(0xF004, 0, 4, b"MAIN.nCounter\0")
    except DeviceError as refusal:
        return refusal.code == 0x705
    return False


def test_a_fault_begins_and_ends_at_its_time(station: Station, plc: Any) -> None:
    station.faults.add("error", symbol=COUNTER, code=0x705, at=0.5, lasting=0.25)
    seen = []
    for _ in range(10):
        station.advance(0.1)
        seen.append(_refused(plc))
    assert seen == [False] * 4 + [True] * 3 + [False] * 3
    assert len(station.faults) == 0


def test_without_a_fault_no_gate_no_phase_and_no_group_is_in_the_way(
    station: Station, plc: Any
) -> None:
    served = next(device for device in station.devices if device.address.port == 851).services
    phases, groups = station.cycle.phases, dict(served.by_index)
    station.faults.add("delay", by=0.01, count=1)
    station.faults.add("error", symbol=COUNTER, code=0x705, lasting=0.1)
    assert station.cycle.phases != phases
    assert served.by_index != groups
    station.faults.clear()
    station.advance(1.0)
    assert station.cycle.phases == phases
    assert served.by_index == groups
    assert not _refused(plc)


def test_the_list_says_what_waits_and_what_is_at_work(station: Station, plc: Any) -> None:
    waiting = station.faults.add("drop", at=5.0)
    active = station.faults.add("error", symbol=COUNTER, code=0x705)
    assert _refused(plc)
    assert [each.facts() for each in station.faults] == [
        {"number": 1, "state": "waiting", "hits": 0, "fault": {"kind": "drop", "at": 5.0}},
        {
            "number": 2,
            "state": "active",
            "hits": 1,
            "fault": {"kind": "error", "symbol": COUNTER, "code": 0x705},
        },
    ]
    station.faults.clear(active.number)
    assert not _refused(plc)
    station.faults.clear()
    assert waiting.state == "over"
    station.advance(6.0)
    with pytest.raises(KeyError):
        station.faults.clear(1)


def test_equal_faults_give_equal_histories() -> None:
    def run() -> str:
        station = Station.demo()
        station.faults.add("slow_cycle", factor=3, at=0.2, lasting=0.5)
        station.faults.add("download", at=1.0)
        station.advance(2.0)
        return station.digest()

    assert run() == run() != Station.demo().digest()


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"kind": "error", "symbol": "MAIN.nowhere", "code": 1}, "symbol: no device"),
        ({"kind": "error", "group": 1, "code": 1, "port": 99}, "port: expected one of"),
        ({"kind": "download", "port": 501}, "port: expected that of a PLC"),
        ({"kind": "drop", "client": "nobody"}, "client: expected a NetId"),
    ],
)
def test_what_this_station_cannot_do_is_refused(
    station: Station, fields: dict[str, Any], message: str
) -> None:
    with pytest.raises(FaultError, match=message):
        station.faults.add(fields.pop("kind"), **fields)
    assert len(station.faults) == 0


def test_faults_are_scripted_in_the_configuration(tmp_path: Path, client_of: Any) -> None:
    file = tmp_path / "station.toml"
    file.write_text(
        '[[plc]]\n[[plc.task]]\nprograms = ["achse.station.demo:MAIN"]\n'
        '[[fault]]\nat = "20ms"\nlasting = "50ms"\n'
        'kind = "error"\nsymbol = "MAIN.nCounter"\ncode = 0x705\n'
    )
    station = Station.load(file)
    plc = client_of(station.router, 851)
    seen = []
    for _ in range(5):
        station.advance(0.02)
        seen.append(_refused(plc))
    assert seen == [True, True, True, False, False]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('kind = "melt"', r"fault\[1\]: kind: expected one of drop"),
        ('kind = "drop"\nat = "soon"', r"fault\[1\]\.at: expected a duration"),
        ('kind = "error"\ncode = 1\nsymbol = "X.y"', r"fault\[1\]\.symbol: no device"),
    ],
)
def test_a_wrong_script_names_file_and_key(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "station.toml"
    file.write_text(f"[[fault]]\n{text}\n")
    with pytest.raises(ConfigError, match=message):
        Station.load(file)


def test_what_begins_while_there_is_no_plc_hits_the_one_that_comes(
    station: Station, client_of: Any, caplog: pytest.LogCaptureFixture
) -> None:
    station.faults.add("slow_cycle", at=0.2, factor=3)
    station.faults.add("error", at=0.2, symbol=COUNTER, code=0x705, lasting=1.0)
    station.restart()
    station.advance(0.3)
    assert not station.plcs
    station.advance(0.5)
    assert station.plcs[851].tasks[0].stretch == 3
    assert _refused(client_of(station.router, 851))
    station.advance(0.5)
    assert [active.fault.kind for active in station.faults] == ["slow_cycle"]
    assert not caplog.records


def test_a_list_has_an_end_and_what_is_cleared_leaves_nothing_on_the_agenda(
    station: Station,
) -> None:
    for at in (None, 1e9):
        for _ in range(MOST_FAULTS):
            station.faults.add("drop", port=1, at=at, lasting=1e9)
        with pytest.raises(FaultError, match="256 faults are there"):
            station.faults.add("drop", port=1)
        station.faults.clear()
    assert not any(phase.name == "faults" for phase in station.cycle.phases)
    station.faults.add("drop", port=1)
