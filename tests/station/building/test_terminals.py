"""Terminals of a station: bits of PLC programs are inputs and outputs, through frames of a bus."""

from pathlib import Path
from typing import Any

import pytest

from achse.codes.axis import StartType
from achse.devices.io import IoDevice
from achse.ethercat.terminals import AnalogTerminal, DigitalTerminal
from achse.motion import commands
from achse.station import Station
from achse.station.building.terminals import TerminalBus
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError

PROGRAM = """
PROGRAM MAIN
VAR
    bStart AT %IX10.3 : BOOL;
    bLamp AT %QX21.7 : BOOL;
    nLevel AT %IW32 : INT;
    nValve AT %QW40 : INT;
END_VAR
bLamp := bStart;
nValve := -nLevel;
END_PROGRAM
"""

ANALOG = {"name": "Term 2", "kind": "analog", "inputs": 1, "outputs": 1}
TERMINALS = [
    {"name": "Term 1", "input_address": 10, "output_address": 20},
    {**ANALOG, "input_address": 30, "output_address": 40},
    {"name": "Term 3", "outputs": 0},
]


def station_of(folder: Path, **changes: Any) -> Station:
    (folder / "main.st").write_text(PROGRAM, encoding="utf-8")
    document = {
        "plc": [{"sources": "main.st"}],
        "bus": [{"name": "Terminals", "cycle": "2ms"}],
        "terminal": TERMINALS,
        **changes,
    }
    return Station(parse(document, "a.toml"), base=folder)


def terminals_of(station: Station) -> tuple[DigitalTerminal, AnalogTerminal]:
    digital, analog = station.terminals["Term 1"], station.terminals["Term 2"]
    assert isinstance(digital, DigitalTerminal)
    assert isinstance(analog, AnalogTerminal)
    return digital, analog


def test_bits_and_values_get_through(tmp_path: Path) -> None:
    station = station_of(tmp_path)
    digital, analog = terminals_of(station)
    station.advance(1.0)
    assert not digital.output(15)
    digital.set_input(3, True)
    analog.set_voltage(0, 5.0)
    station.advance(0.05)
    assert [digital.output(channel) for channel in (14, 15)] == [False, True]
    assert analog.voltage(0) == pytest.approx(-5.0, abs=1e-3)
    digital.set_input(3, False)
    station.advance(0.05)
    assert not digital.output(15)


def test_a_plc_that_does_not_run_has_its_outputs_off(tmp_path: Path) -> None:
    station = station_of(tmp_path)
    digital, _ = terminals_of(station)
    digital.set_input(3, True)
    station.advance(1.0)
    assert digital.output(15)
    station.plcs[851].stop()
    station.advance(0.05)
    assert not digital.output(15)


def test_two_runs_are_equal(tmp_path: Path) -> None:
    digests = []
    for _ in range(2):
        station = station_of(tmp_path)
        digital, _analog = terminals_of(station)
        station.advance(0.5)
        digital.set_input(3, True)
        station.advance(0.5)
        digests.append(station.digest())
    assert digests[0] == digests[1]


def test_the_bus_is_at_the_io_server(tmp_path: Path) -> None:
    station = station_of(tmp_path)
    station.advance(1.0)
    (io,) = (each for each in station.devices if isinstance(each, IoDevice))
    assert io.read(0x5000, 2, 4) == b"\1\0\0\0"
    assert io.read(0x5001, 1, 100) == b"Terminals\0"
    assert io.buses[0].dev_state == 0
    assert [each.name for each in io.buses[0].master.slaves] == ["Term 1", "Term 2", "Term 3"]
    station.restart()
    station.advance(2.0)
    assert station.terminals["Term 1"].state.name == "OP"
    assert TerminalBus.take is not None


def test_drives_and_terminals_have_buses_of_their_own(tmp_path: Path) -> None:
    station = station_of(
        tmp_path,
        bus=[{"name": "Terminals"}, {"name": "Drives"}],
        terminal=[{"name": "Term 1", "bus": "Terminals"}],
        axis=[{"id": 1, "name": "X"}],
        drive=[{"axis": "X", "bus": "Drives"}],
    )
    station.advance(1.0)
    (io,) = (each for each in station.devices if isinstance(each, IoDevice))
    assert sorted((bus.number, bus.name) for bus in io.buses) == [(1, "Terminals"), (2, "Drives")]


def test_drives_and_terminals_share_a_bus(tmp_path: Path) -> None:
    dynamics = {"max_velocity": 400.0, "default_acceleration": 2000.0,
                "default_deceleration": 2000.0, "default_jerk": 20_000.0}  # fmt: skip
    station = station_of(
        tmp_path,
        axis=[{"id": 1, "name": "X", **dynamics}],
        drive=[{"axis": "X"}],
        terminal=[{**TERMINALS[0], "position": 1}, *TERMINALS[1:]],
    )
    assert station.nc is not None
    axis = station.nc.axis(1)
    axis.control_dword, axis.velocity_override = 7, 1_000_000
    station.advance(1.5)
    (io,) = (each for each in station.devices if isinstance(each, IoDevice))
    (bus,) = io.buses
    assert [each.name for each in bus.master.slaves] == [
        "Term 1", "Drive 1 (axis X)", "Term 2", "Term 3",
    ]  # fmt: skip
    assert bus.dev_state == 0
    digital, _ = terminals_of(station)
    digital.set_input(3, True)
    assert commands.start(axis, StartType.ABSOLUTE, 20.0, 100.0) == 0
    station.advance(0.02)
    assert digital.output(15)
    station.advance(1.5)
    assert axis.actual_position == pytest.approx(20.0, abs=1e-2)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"bus": []}, r"terminal\[1\]: expected a table \[\[bus\]\]"),
        (
            {"terminal": [{"name": "a", "bus": "x"}]},
            r"terminal\[1\].bus: expected one of Terminals",
        ),
        ({"terminal": [{"name": "a"}, {"name": "a"}]}, r"terminal\[2\].name"),
        ({"terminal": [{"name": "a", "plc": 9, "input_address": 0}]}, r"terminal\[1\].plc"),
        ({"terminal": [{"name": "a", "input_address": 65535}]}, r"terminal\[1\].input_address"),
        (
            {"terminal": [{"name": "a", "position": 2}, {"name": "b", "position": 2}]},
            r"bus\[1\]: position 2: a is there, got b too",
        ),
    ],
)
def test_what_cannot_be_is_reported(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        station_of(tmp_path, **changes)
