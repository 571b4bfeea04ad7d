"""Tc2_IoFunctions: devices and boxes of a station with a bus, and of one without."""

from pathlib import Path
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.io.device import IoDevice
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.plc.code.conftest import Ran

BUS: dict[str, Any] = {
    "bus": [{"name": "Line"}],
    "axis": [{"id": 1, "name": "X"}, {"id": 2, "name": "Y"}],
    "drive": [{"axis": "X"}, {"axis": "Y"}],
}
BLOCKS = (
    ("count : IOF_GetDeviceCount", ""),
    ("ids : IOF_GetDeviceIDs", "LEN := SIZEOF(words), DESTADDR := ADR(words)"),
    ("name : IOF_GetDeviceName", "DEVICEID := 1"),
    ("id : IOF_GetDeviceIDByName", "DEVICENAME := 'Line'"),
    ("netId : IOF_GetDeviceNetId", "DEVICEID := 1"),
    ("kind : IOF_GetDeviceType", "DEVICEID := 1"),
    ("info : IOF_GetDeviceInfoByName", "DEVICENAME := 'Line'"),
    ("boxes : IOF_GetBoxCount", "DEVICEID := 1"),
    ("boxName : IOF_GetBoxNameByAddr", "DEVICEID := 1, BOXADDR := 1002"),
    ("boxAddr : IOF_GetBoxAddrByName", "DEVICEID := 1, BOXNAME := boxName.BOXNAME"),
    ("boxAddrEx : IOF_GetBoxAddrByNameEx", "DEVICENAME := 'Line', BOXNAME := boxName.BOXNAME"),
    ("boxNetId : IOF_GetBoxNetId", "DEVICEID := 1, BOXADDR := 1001"),
    ("reset : IOF_DeviceReset", "DEVICEID := 1"),
    ("noDevice : IOF_GetDeviceName", "DEVICEID := 2"),
    ("device0 : IOF_GetDeviceName", "DEVICEID := 0"),
    ("device999 : IOF_GetDeviceName", "DEVICEID := 999"),
    ("otherName : IOF_GetDeviceInfoByName", "DEVICENAME := 'line'"),
    ("otherBox : IOF_GetBoxAddrByNameEx", "DEVICENAME := 'Line', BOXNAME := 'no'"),
    ("again : IOF_GetDeviceInfoByName", "DEVICENAME := 'Line'"),
)


def run(folder: Path, document: dict[str, Any]) -> tuple[Station, Any]:
    body = "IF go THEN CASE step OF\n"
    for number, (declared, inputs) in enumerate(BLOCKS):
        block = declared.partition(" ")[0]
        start = "RESET" if block == "reset" else "START"
        start_inputs = f"{inputs}, " if inputs else ""
        body += (
            f"{number}: {block}({start_inputs}{start} := TRUE);\n IF NOT {block}.BUSY THEN\n"
            f" errors[{number}] := {block}.ERRID; failed[{number}] := {block}.ERR;\n"
            f" {block}({start} := FALSE); step := step + 1; END_IF\n"
        )
    declared = "; ".join(each for each, _ in BLOCKS)
    text = (
        "PROGRAM MAIN VAR go : BOOL; step : INT; words : ARRAY [0..3] OF WORD;"
        f" errors : ARRAY [0..30] OF UDINT; failed : ARRAY [0..30] OF BOOL; {declared}; END_VAR\n"
        f"{body}END_CASE END_IF END_PROGRAM"
    )
    (folder / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}], **document}, "a.toml"), base=folder)
    station.advance(2.0)
    main: Any = station.plcs[851].instance("MAIN")
    main["go"] = True
    station.advance(3.0)
    assert station.plcs[851].failure == ""
    assert main["step"] == len(BLOCKS)
    return station, main


def test_devices_and_boxes_of_a_bus(tmp_path: Path) -> None:
    station, main = run(tmp_path, BUS)
    port = next(each for each in station.devices if isinstance(each, IoDevice))
    net_id = str(NetId(bytes(port.buses[0].net_id)))
    errors = list(main["errors"])[: len(BLOCKS)]
    assert errors[:13] == [0] * 13
    assert errors[13:] == [0x70C, 0x70C, 0x70C, 0x70C, 0x70C, 0]
    assert list(main["failed"])[: len(BLOCKS)] == [bool(each) for each in errors]
    assert main["count"]["DEVICECOUNT"] == 1
    assert list(main["words"]) == [1, 1, 0, 0]
    assert main["name"]["DEVICENAME"] == "Line"
    assert main["id"]["DEVICEID"] == 1
    assert main["netId"]["DeviceNetId"] == net_id
    assert int(main["kind"]["IODeviceType"]) == 111
    for block in ("info", "again"):
        assert (main[block]["DEVICEID"], main[block]["DEVICENETID"]) == (1, net_id)
    assert main["boxes"]["BOXCOUNT"] == 2
    assert main["boxName"]["BOXNAME"]
    assert main["boxAddr"]["BOXADDR"] == main["boxAddrEx"]["BOXADDR"] == 1002
    assert main["boxNetId"]["BoxNetId"] == net_id


def test_a_station_without_a_bus_has_no_devices(tmp_path: Path) -> None:
    _, main = run(tmp_path, {})
    assert set(list(main["errors"])[: len(BLOCKS)]) == {6}


@pytest.mark.parametrize("device", [0, 1, 254, 255, 70000])
def test_groups_of_devices(device: int) -> None:

    ran = Ran(f"PROGRAM MAIN VAR g : UDINT; END_VAR g := F_IofGroup({device}); END_PROGRAM").cycle()
    assert ran["g"] == (0x5000 + device if 0 < device <= 254 else 0x50FF)
