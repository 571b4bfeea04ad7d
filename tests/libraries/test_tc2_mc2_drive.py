"""Tc2_NcDrive, Tc2_MC2_Drive and references to drives: a virtual drive by CoE, a SERCOS drive by a
stub."""

import struct
from pathlib import Path
from typing import Any

from achse.ams import DeviceError
from achse.server import Device, RawGroup
from achse.station import Station
from achse.station.configuration.station_file import parse

DRIVE = {"bus": [{"name": "Line"}], "axis": [{"id": 1, "name": "X"}], "drive": [{"axis": "X"}]}
ALONE = {"axis": [{"id": 1, "name": "X"}]}


def run(
    folder: Path, document: dict[str, Any], variables: str, *steps: tuple[str, str]
) -> tuple[Station, Any]:
    """A station whose `MAIN` calls blocks of the axis, each until it is not busy."""
    body = "IF go THEN CASE step OF\n"
    for number, (block, inputs) in enumerate(steps):
        start = f"{inputs}, " if inputs else ""
        body += (
            f"{number}: {block}({start}Axis := X, Execute := TRUE);\n IF NOT {block}.Busy THEN\n"
            f" failed[{number}] := {block}.Error; {block}(Axis := X, Execute := FALSE);\n"
            " step := step + 1; END_IF\n"
        )
    text = (
        "PROGRAM MAIN VAR go : BOOL; step : INT; X : AXIS_REF; failed : ARRAY [0..20] OF BOOL;"
        f" {variables} END_VAR\n{body}END_CASE END_IF END_PROGRAM"
    )
    (folder / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}], **document}, "a.toml"), base=folder)
    station.advance(2.0)
    return station, station.plcs[851].instance("MAIN")


def finish(station: Station, main: Any, count: int) -> None:
    main["go"] = True
    station.advance(5.0)
    assert station.plcs[851].failure == ""
    assert main["step"] == count


OBJECTS = (
    ("vendor", "Index := 16#1018, SubIndex := 1, pDstBuf := ADR(id), BufLen := 4"),
    ("write", "Index := 16#6065, SubIndex := 0, pSrcBuf := ADR(window), BufLen := 4"),
    ("back", "Index := 16#6065, SubIndex := 0, pDstBuf := ADR(found), BufLen := 4"),
    ("whole", "Index := 16#1018, SubIndex := 0, pDstBuf := ADR(identity), BufLen := 18,"
     " CompleteAccess := TRUE"),
    ("none", "Index := 16#5FFF, SubIndex := 0, pDstBuf := ADR(id), BufLen := 4"),
    ("info", ""),
    ("sercos", "Idn := S_0_IDNs + 95, Element := 16#40, pDstBuf := ADR(id), BufLen := 4"),
    ("reset", ""),
)  # fmt: skip
BLOCKS = """vendor, back, whole, none : FB_CoERead; write : FB_CoEWrite; info : FB_ReadDriveInfo;
 sercos : FB_SoERead; reset : FB_SoEReset; id, found : UDINT := 7; window : UDINT := 123456;
 identity : ARRAY [0..17] OF BYTE;"""


def test_objects_of_a_virtual_drive(tmp_path: Path) -> None:
    station, main = run(tmp_path, DRIVE, BLOCKS, *OBJECTS)
    finish(station, main, len(OBJECTS))
    assert (main["info"]["ErrorID"], main["info"]["step"]) == (0, 2)
    assert list(main["failed"])[: len(OBJECTS)] == [False] * 4 + [True, False, True, True]
    slave = station.buses[0].bus.drives[0]
    assert main["id"] != 7
    assert main["found"] == main["window"] == 123456
    assert bytes(main["identity"])[2:6] == int(main["id"]).to_bytes(4, "little")
    assert main["none"]["AdsErrId"] == 0x703
    assert slave is not None
    net_id, port, _ = station.nc.axis(1).hardware_address if station.nc else (b"", 0, 0)
    info = main["info"]["DriveInfo"]
    assert main["info"]["Error"] is False
    assert info["NetId"] == ".".join(map(str, net_id))
    assert info["SlaveAddress"] == port != 0
    assert (info["Channel"], info["MDPProfile"], int(info["DeviceType"])) == (0, False, 0)
    assert info["DeviceName"] == ""  # the drive has no object 0x1008
    # A CANopen drive knows no SERCOS.
    assert (main["sercos"]["AdsErrId"], main["sercos"]["SercosErrId"]) == (0x701, 0)
    assert main["reset"]["AdsErrId"] == 0x701


def test_an_axis_without_a_drive(tmp_path: Path) -> None:
    station, main = run(tmp_path, ALONE, BLOCKS, *OBJECTS)
    finish(station, main, len(OBJECTS))
    assert all(list(main["failed"])[: len(OBJECTS)])
    for block in ("vendor", "write", "sercos", "reset"):
        assert main[block]["AdsErrId"] == 7
    assert main["info"]["ErrorID"] == 7


class Sercos(Device):
    """A drive with parameters; its reset takes a while."""

    def __init__(self) -> None:
        self.values = {(95, 0x40): struct.pack("<2H", 5, 80) + b"Ready", (390, 0x40): b"\1\2\3\4"}
        self.written: list[tuple[int, bytes]] = []
        self.looks = 0
        self.ends_with = 3
        group = RawGroup(0xF420, "SoE", read=self._read, write=self._write, last_offset=0xFFFF_FFFF)
        super().__init__("sercos", (1, 0, 0), (group,), clock=lambda: 0)

    def _read(self, offset: int, length: int, client: bytes) -> bytes:
        assert offset >> 24 == 2  # the number of the drive
        idn, element = offset & 0xFFFF, offset >> 16 & 0xFF
        if idn == 99 and element == 1:
            self.looks += 1
            return struct.pack("<H", 7 if self.looks < 4 else self.ends_with)
        if element == 4:
            return struct.pack("<I", 0x0001_0000 + idn)
        if (idn, element) not in self.values:
            raise DeviceError(0x1001, "no such IDN")
        return self.values[idn, element]

    def _write(self, offset: int, data: bytes, client: bytes) -> None:
        if offset & 0xFFFF == 1234:
            raise DeviceError(0x7004, "the value is not in its range")
        self.written.append((offset, data))


PARAMETERS = (
    ("message", ""),
    ("number", ""),
    ("read", "Idn := S_0_IDNs + 390, Element := 16#40, pDstBuf := ADR(value), BufLen := 4"),
    ("none", "Idn := P_0_IDNs + 1, Element := 16#40, pDstBuf := ADR(value), BufLen := 4"),
    ("write", "Idn := S_0_IDNs + 47, Element := 16#40, pSrcBuf := ADR(new), BufLen := 4"),
    ("refused", "Idn := 1234, Element := 16#40, pSrcBuf := ADR(new), BufLen := 4"),
    ("password", "Password := secret"),
    ("reset", ""),
)
SOE = """message : FB_SoEReadDiagMessage; number : FB_SoEReadDiagNumber; read, none : FB_SoERead;
 write, refused : FB_SoEWrite; password : FB_SoEWritePassword; reset : FB_SoEReset;
 value : UDINT; new : DINT := -2;
 secret : ST_SoE_String := (iActualSize := 3, iMaxSize := 16, strData := 'abc');"""


def sercos(folder: Path, ends_with: int = 3) -> tuple[Sercos, Any]:
    station, main = run(folder, ALONE, SOE, *PARAMETERS)
    drive = Sercos()
    drive.ends_with = ends_with
    drive.attach(station.router, 1007)
    assert station.nc is not None
    station.nc.axis(1).hardware_address = bytes(station.router.net_id), 1007, 2
    finish(station, main, len(PARAMETERS))
    return drive, main


def test_parameters_of_a_sercos_drive(tmp_path: Path) -> None:
    drive, main = sercos(tmp_path)
    assert list(main["failed"])[: len(PARAMETERS)] == [n in (3, 5) for n in range(len(PARAMETERS))]
    assert main["message"]["DiagMessage"]["strData"] == "Ready"
    assert main["message"]["DiagMessage"]["iActualSize"] == 5
    assert (main["message"]["Attribute"], main["number"]["Attribute"]) == (0x1005F, 0x10186)
    assert main["number"]["DiagNumber"] == main["value"] == 0x0403_0201
    assert (main["none"]["AdsErrId"], main["none"]["SercosErrId"]) == (0, 0x1001)
    assert (main["refused"]["AdsErrId"], main["refused"]["SercosErrId"]) == (0, 0x7004)
    value = 2 << 24 | 0x40 << 16
    assert drive.written == [
        (value | 47, struct.pack("<i", -2)),
        (value | 267, struct.pack("<2H", 3, 16) + b"abc"),
        (value | 99, b"\3\0"),
        (value | 99, b"\0\0"),
    ]
    assert drive.looks == 4
    assert (main["reset"]["Error"], main["reset"]["AdsErrId"]) == (False, 0)


def test_a_reset_that_fails_is_taken_back(tmp_path: Path) -> None:
    drive, main = sercos(tmp_path, 15)
    assert (main["reset"]["Error"], main["reset"]["AdsErrId"]) == (True, 0x700)
    assert drive.written[-1][1] == b"\0\0"


def test_references_to_drives(tmp_path: Path) -> None:
    text = """PROGRAM MAIN
VAR
    soe : FB_SoERead_ByDriveRef; put : FB_SoEWrite_ByDriveRef; ref : ST_DriveRef;
    linked : ST_PlcDriveRef; value : UDINT; step, done : INT;
END_VAR
ref.nSlaveAddr := 1007;
ref.nDriveNo := 2;
CASE step OF
0: soe(stDriveRef := ref, nIdn := 390, nElement := 16#40, pDstBuf := ADR(value), cbBufLen := 4,
       bExecute := TRUE);
   IF NOT soe.bBusy THEN step := 1; END_IF
1: put(stDriveRef := ref, nIdn := 5, nElement := 16#40, pSrcBuf := ADR(value), cbBufLen := 4,
       bExecute := TRUE);
   IF NOT put.bBusy THEN step := 2; END_IF
END_CASE
END_PROGRAM"""
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=tmp_path)
    drive = Sercos()
    drive.attach(station.router, 1007)
    station.advance(0.5)
    main: Any = station.plcs[851].instance("MAIN")
    assert (main["step"], main["value"]) == (2, 0x0403_0201)
    assert (main["soe"]["cbRead"], main["soe"]["dwAttribute"]) == (4, 0x10186)
    assert drive.written == [(0x0240_0005, b"\1\2\3\4")]


def test_parameters_of_a_sercos_drive_by_nctoplc_axis_ref(tmp_path: Path) -> None:
    text = """PROGRAM MAIN
VAR
    X : AXIS_REF; step : INT; value : UDINT; secret : ST_SoE_String := (iActualSize := 1);
    message : Tc2_NcDrive.FB_SoEReadDiagMessage; number : Tc2_NcDrive.FB_SoEReadDiagNumber;
    class : FB_SoEReadClassXDiag; read : Tc2_NcDrive.FB_SoERead; reset : Tc2_NcDrive.FB_SoEReset;
END_VAR
CASE step OF
0: message(Axis := X.NcToPlc, bExecute := TRUE); IF NOT message.bBusy THEN step := 1; END_IF
1: number(Axis := X.NcToPlc, bExecute := TRUE); IF NOT number.bBusy THEN step := 2; END_IF
2: class(Axis := X.NcToPlc, iDiagClass := 2, bExecute := TRUE);
   IF NOT class.bBusy THEN step := 3; END_IF
3: read(Axis := X.NcToPlc, nIdn := P_0_IDN + 1, nElement := 16#40, pDstBuf := ADR(value),
        cbBufLen := 4, bExecute := TRUE);
   IF NOT read.bBusy THEN step := 4; END_IF
4: reset(Axis := X.NcToPlc, bExecute := TRUE); IF NOT reset.bBusy THEN step := 5; END_IF
END_CASE
END_PROGRAM"""
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}], **ALONE}, "a.toml"), base=tmp_path)
    drive = Sercos()
    drive.values[12, 0x40] = b"\5\0"
    drive.attach(station.router, 1007)
    assert station.nc is not None
    station.nc.axis(1).hardware_address = bytes(station.router.net_id), 1007, 2
    station.advance(5.0)
    main: Any = station.plcs[851].instance("MAIN")
    assert station.plcs[851].failure == ""
    assert main["step"] == 5
    assert main["message"]["sDiagMessage"]["strData"] == "Ready"
    assert (main["number"]["iDiagNumber"], main["number"]["dwAttribute"]) == (0x0403_0201, 0x10186)
    assert main["class"]["wClassXDiag"] == 5
    assert (main["read"]["bError"], main["read"]["iSercosErrId"]) == (True, 0x1001)
    assert (main["reset"]["bError"], drive.looks) == (False, 4)


def test_power_of_a_stepper_motor(tmp_path: Path) -> None:
    text = """PROGRAM MAIN VAR X : AXIS_REF; power : MC_PowerStepper; bOn : BOOL; END_VAR
power(Axis := X, Enable := bOn, Enable_Positive := bOn, Enable_Negative := bOn);
END_PROGRAM"""
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}], **ALONE}, "a.toml"), base=tmp_path)
    main: Any = station.plcs[851].instance("MAIN")
    for on in (False, True, False):
        main["bOn"] = on
        station.advance(0.5)
        assert main["power"]["Status"] is on
    assert (main["power"]["Stalled"], main["power"]["Error"]) == (False, False)
