"""Camshaft controllers in the cycle: encoders of three kinds, PLC variables, sleep, restarts."""

import math
from pathlib import Path
from typing import Any

import pytest

from achse.devices.camshaft import CamshaftDevice
from achse.motion import Nc
from achse.station import Station
from achse.station.building.camshaft import CamshaftPhase, make_camshafts
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError

SOURCE = """{attribute 'qualified_only'}
VAR_GLOBAL CONSTANT
    cFixed : UDINT := 3;
END_VAR
PROGRAM MAIN
VAR
    nEncoder : DINT;
    fEncoder : LREAL;
    nCams : DWORD;
    nByte : USINT;
    bAny : BOOL;
    nAngle : INT;
    bEngaged : BOOL := TRUE;
    nEnable : DWORD := 4;
    aInputs : ARRAY[0..17] OF UDINT;
    aOutputs : ARRAY[0..16] OF UDINT;
    nSeen : UDINT;
    sText : STRING;
    {more}
END_VAR
nEncoder := nEncoder + 40;
fEncoder := fEncoder + 40.5;
IF nCams.4 THEN nSeen := nSeen + 1; END_IF
END_PROGRAM
"""
WAY = {"type": "way", "start": 90, "end": 180, "track": 4}


def station_of(folder: Path, *camshafts: dict[str, Any], more: str = "", **keys: Any) -> Station:
    source = SOURCE.split("END_VAR\n", 1)[1].replace("{more}", more)
    (folder / "main.st").write_text(source, encoding="utf-8")
    document = {
        "plc": [{"sources": "main.st", "task": [{"cycle": "1ms", "programs": ["MAIN"]}]}],
        "camshaft": list(camshafts),
        **keys,
    }
    return Station(parse(document, "station.toml"), base=folder)


def device_of(station: Station) -> CamshaftDevice:
    [device] = [each for each in station.devices if isinstance(each, CamshaftDevice)]
    return device


def value(station: Station, name: str) -> int:
    symbols = device_of(station).symbols
    assert symbols is not None
    symbol = symbols.source.resolve(name)
    assert symbol is not None
    return int.from_bytes(symbol.read(), "little")


def plc(station: Station, name: str) -> Any:
    [device] = [each for each in station.devices if 851 in {at.port for at in each.addresses}]
    assert device.symbols is not None
    symbol = device.symbols.source.resolve(name)
    assert symbol is not None
    return int.from_bytes(symbol.read(), "little")


def test_an_axis_turns_the_shaft() -> None:
    """The demo: 360° per turn of axis C, one cam, to one cycle of 2 ms."""
    station = Station.demo()
    camshaft = device_of(station).camshafts[0]
    camshaft.controller.set_cam(1, {"type": 1, "start": 90, "end": 180, "track": 3})
    assert isinstance(station.nc, Nc)
    axis = station.nc.axis(3)
    for position in (0.0, 89.9, 90.0, 179.9, 180.0, 450.0, 810.0):
        axis.external.position = 0.0
        camshaft.controller.take_position(position * 4096 / 360)
        camshaft.controller.cycle()
        assert camshaft.controller.record.outputs == (8 if 90 <= position % 360 < 180 else 0)


@pytest.mark.parametrize("encoder", ["MAIN.nEncoder", "main.fEncoder"])
def test_a_variable_is_the_encoder_and_bits_come_back(tmp_path: Path, encoder: str) -> None:
    station = station_of(
        tmp_path,
        {
            "encoder": encoder,
            "cam": [WAY],
            "input": {"engaged": "MAIN.bEngaged", "brake_enable": "MAIN.nEnable"},
            "output": {
                "cams": "MAIN.nCams",
                "angle": "MAIN.nAngle",
                "configured_cams": "MAIN.bAny",
                "raw": "MAIN.nByte",
            },
        },
    )
    on = []
    for k in range(300):
        station.advance(0.001)
        position = (k + 1) * (40 if "n" in encoder[5] else 40.5)
        assert value(station, "Camshaft 1.Outputs.raw") == math.floor(position)
        expected = 90 <= position * 360 / 4096 % 360 < 180
        assert plc(station, "MAIN.nCams") == (0x10 if expected else 0)
        assert plc(station, "MAIN.nAngle") == int(position * 3600 / 4096 % 3600)
        assert plc(station, "MAIN.nByte") == math.floor(position) % 256
        on.append(expected)
    assert plc(station, "MAIN.bAny") == 1
    assert plc(station, "MAIN.nSeen") == sum(on[:-1])
    assert value(station, "Camshaft 1.Inputs.engaged") == 1
    assert value(station, "Camshaft 1.Cam1.brake_enabled") == 0
    assert value(station, "Camshaft 1.Tracks.4") == on[-1]


def test_process_data_are_the_encoder_without_another(tmp_path: Path) -> None:
    station = station_of(tmp_path, {"cam": [WAY], "increments": 3600})
    device = device_of(station)
    for angle, bits in ((899, 0), (900, 16), (1799, 16), (1800, 0), (4500, 16)):
        device.write(0xF020, 0, angle.to_bytes(4, "little"))
        station.advance(0.001)
        assert device.read(0xF030, 0x40, 4) == bits.to_bytes(4, "little")


def test_whole_images(tmp_path: Path) -> None:
    station = station_of(
        tmp_path,
        {
            "input_image": "MAIN.aInputs",
            "output_image": "MAIN.aOutputs",
            "cam": [{**WAY, "start": 0}],
            "or_mask": 1,
        },
    )
    station.advance(0.01)
    assert plc(station, "MAIN.aOutputs[16]") == 1  # the AND mask of the PLC is 0, and it counts
    plc_device = next(each for each in station.devices if 851 in {a.port for a in each.addresses})
    assert plc_device.symbols is not None
    mask = plc_device.symbols.source.resolve("MAIN.aInputs[16]")
    assert mask is not None
    mask.write(b"\xff\xff\xff\xff")
    station.advance(0.01)
    assert plc(station, "MAIN.aOutputs[16]") == 0x11


def test_a_controller_without_work_sleeps_until_someone_looks() -> None:
    station = Station.demo()
    [phase] = [each for each in station.cycle.phases if isinstance(each, CamshaftPhase)]
    assert phase.due_ns == math.inf
    station.advance(0.1)
    device = device_of(station)
    device.read(0xF100, 0, 4)
    assert phase.due_ns == math.inf
    device.read(0x1000, 0x33, 4)
    assert phase.due_ns == station.time_ns + 2_000_000
    station.advance(0.1)
    assert phase.due_ns == station.time_ns + 2_000_000


def test_four_controllers_have_their_own_cycles(tmp_path: Path) -> None:
    station = station_of(
        tmp_path,
        *({"encoder": "MAIN.nEncoder", "cycle": f"{n}ms", "cam": [WAY]} for n in (1, 2, 3, 4)),
    )
    station.advance(0.013)
    raw = [value(station, f"Camshaft {n}.Outputs.raw") for n in (1, 2, 3, 4)]
    assert raw == [13 * 40, 12 * 40, 12 * 40, 12 * 40]
    device = device_of(station)
    assert [device.read(n * 0x1000, 1, 4) for n in (1, 2, 3, 4)] == [b"\1\0\0\0"] * 4


def test_many_cams_are_machine_code_and_the_same(tmp_path: Path) -> None:
    cams = [{**WAY, "start": n, "track": n % 32} for n in range(40)]
    digests = set()
    for code in ("auto", "plain"):
        station = station_of(tmp_path, {"encoder": "MAIN.nEncoder", "cam": cams}, nc={"code": code})
        station.advance(0.2)
        digests.add(device_of(station).camshafts[0].controller.digest())
    assert len(digests) == 1


def test_equal_runs_have_equal_hashes(tmp_path: Path) -> None:
    hashes = set()
    for _ in range(2):
        station = station_of(tmp_path, {"encoder": "MAIN.nEncoder", "cam": [WAY]})
        station.advance(0.1)
        hashes.add(station.digest())
    assert len(hashes) == 1


def test_a_restart_brings_the_configured_cams_back(tmp_path: Path) -> None:
    station = station_of(tmp_path, {"encoder": "MAIN.nEncoder", "cam": [WAY]})
    device_of(station).camshafts[0].controller.set_cam(1, {"type": 0})
    station.restart()
    station.advance(1.0)
    assert value(station, "Camshaft 1.configured_cams") == 1


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"axis": "Z"}, "camshaft[1].axis: expected the name of an [[axis]], got 'Z'"),
        ({"encoder": "MAIN.nEncodr"}, "did you mean 'MAIN.nEncoder'"),
        ({"encoder": "MAIN.sText"}, "expected a number, MAIN.sText is a STRING"),
        ({"encoder": "MAIN.nEncoder", "plc": 852}, "plc: expected the port of a [[plc]] (851)"),
        ({"input": {"set_rate": "MAIN.fEncoder"}}, "expected a whole number or a BOOL"),
        ({"output": {"cams": "MAIN.fEncoder"}}, "expected a whole number or a BOOL"),
        ({"input_image": "MAIN.nEncoder"}, "expected 72 bytes, MAIN.nEncoder has 4"),
        ({"output_image": "MAIN.aInputs"}, "expected 68 bytes, MAIN.aInputs has 72"),
    ],
)
def test_what_is_not_there_is_reported(tmp_path: Path, keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as refusal:
        station_of(tmp_path, keys)
    assert message in str(refusal.value)


def test_names_are_there_once(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="each once"):
        station_of(tmp_path, {"name": "A"}, {"name": "a"})


def test_without_a_table_there_is_no_device() -> None:
    assert make_camshafts.__doc__
    station = Station(parse({}, "station.toml"))
    assert 900 not in station.router.ports
