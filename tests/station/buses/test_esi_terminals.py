"""Terminals of ESI files on a station's bus: PLC addresses, names, behaviours, what cannot be."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.master.esi_reader import EsiError
from achse.ethercat.virtual import VirtualDevice
from achse.station import Station
from achse.station.buses.esi_terminals import make_esi_terminal
from achse.station.configuration.station_file import parse
from achse.station.configuration.terminal import TerminalConfig
from achse.station.configuration.types import ConfigError
from tests.ethercat.virtual.esi_text import ANALOG, COUPLER, DIGITAL_IN, DIGITAL_OUT, esi

PROGRAM = """
PROGRAM MAIN
VAR
    bSwitch AT %IX10.2 : BOOL;
    bLamp AT %QX20.5 : BOOL;
    nValue AT %IW32 : INT;
    nValve AT %QW40 : INT;
END_VAR
bLamp := bSwitch;
nValve := 2 * nValue;
END_PROGRAM
"""
FILE = {"esi": "boxes"}
TERMINALS: list[dict[str, Any]] = [
    {"name": "Coupler", **FILE, "type": "EK"},
    {"name": "Switches", **FILE, "type": "DI8", "input_address": 10},
    {"name": "Lamps", **FILE, "type": "DO8@0x10000", "output_address": 20},
    {"name": "Analog", **FILE, "type": "AIO", "input_address": 30, "output_address": 40},
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("station")
    (place / "boxes").mkdir()
    (place / "boxes" / "all.xml").write_text(esi(COUPLER, DIGITAL_IN, DIGITAL_OUT, ANALOG))
    (place / "main.st").write_text(PROGRAM, encoding="utf-8")
    return place


def station_of(folder: Path, *terminals: dict[str, Any]) -> Station:
    document = {
        "plc": [{"sources": "main.st"}],
        "bus": [{"name": "Terminals", "cycle": "2ms"}],
        "terminal": list(terminals),
    }
    return Station(parse(document, "a.toml"), base=folder)


def device_of(station: Station, name: str) -> VirtualDevice:
    device = station.terminals[name]
    assert isinstance(device, VirtualDevice)
    return device


def test_plc_sees_inputs_and_sets_outputs(folder: Path) -> None:
    station = station_of(folder, *TERMINALS)
    station.advance(1.0)
    device_of(station, "Switches").set_input("PDO 1A02.Input", True)
    device_of(station, "Analog").set_input("Value", -21)
    station.advance(0.05)
    assert device_of(station, "Lamps").output("Lamp 5") is True
    assert device_of(station, "Analog").output("Valve") == -42


@given(value=st.integers(-0x4000, 0x3FFF))
def test_loop_back_of_a_terminal_goes_round(folder: Path, value: int) -> None:
    config = TerminalConfig(name="A", esi="boxes", type="AIO", behaviour="loop-back")
    device = make_esi_terminal(config, folder)
    device.write_outputs(value.to_bytes(2, "little", signed=True))
    device.step(1)
    assert device.input("6000:01") == value & 0xFFFF


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"type": "DI9"}, "terminal 'T': no device 'DI9'"),
        ({"esi": "none.xml"}, "No such file"),
        ({"modules": ["M"]}, "DI8 has no slots"),
        ({"behaviour": "dance"}, "expected loop-back"),
        ({"type": None}, "type: expected the type"),
        ({"inputs": 8}, "inputs: expected none beside esi"),
        ({"kind": "digital"}, "kind: expected none beside esi"),
        ({"esi": None}, "type: expected beside esi"),
        ({"esi": None, "type": None, "behaviour": "x"}, "behaviour: expected beside esi"),
    ],
)
def test_terminal_that_cannot_be_is_reported(
    folder: Path, changes: dict[str, Any], message: str
) -> None:
    table = {"name": "T", "esi": "boxes", "type": "DI8", **changes}
    with pytest.raises(ConfigError, match=message):
        station_of(folder, {key: value for key, value in table.items() if value is not None})


def test_channel_of_a_recording_has_to_exist(folder: Path) -> None:
    (folder / "values.csv").write_text("time,Nothing\n0,1\n")
    config = TerminalConfig(name="A", esi="boxes", type="AIO", behaviour="values.csv")
    with pytest.raises(EsiError, match="terminal 'A': AIO has no channel 'Nothing'"):
        make_esi_terminal(config, folder)
