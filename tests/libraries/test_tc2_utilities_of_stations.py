"""Tc2_Utilities where it asks the station: control, clocks, zones, files, what is refused."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse


def test_who_and_where(steps: Callable[..., Any]) -> None:
    ran = steps(
        "own : FB_GetLocalAmsNetId; zone : FB_GetTimeZoneInformation; host : FB_GetHostName;"
        " set : FB_SetTimeZoneInformation; e1, e2 : UDINT;",
        ("own", "", ""),
        ("zone", "", ""),
        ("host", "", "e1 := host.nErrId;"),
        ("set", "tzInfo := zone.tzInfo", "e2 := set.nErrId;"),
    )
    net_id = str(ran.station.router.net_id)
    assert ran["own.AddrString"] == net_id
    assert list(ran["own.AddrBytes"]) == [int(part) for part in net_id.split(".")]
    assert (int(ran["zone.tzID"]), ran["zone.bError"]) == (0, False)
    assert (ran["zone.tzInfo.bias"], ran["zone.tzInfo.standardName"]) == (0, "UTC")
    assert (ran["e1"], ran["e2"]) == (0x701, 0x701)


CONTROL = """
PROGRAM MAIN
VAR
    step : INT;
    start : PLC_Start; stop : PLC_Stop; reset : PLC_Reset; process : NT_StartProcess;
    load : TC_CpuUsage; write : WritePersistentData; adapters : FB_GetAdaptersInfo;
    value : FB_RegQueryValue; data : DWORD; time : NT_SetTimeToRTCTime;
    errors : ARRAY [0..9] OF UDINT;
END_VAR
CASE step OF
0: stop(PORT := 852, STOP := TRUE); IF NOT stop.BUSY THEN errors[0] := stop.ERRID; step := 1; END_IF
1: start(PORT := 852, START := TRUE);
   IF NOT start.BUSY THEN errors[1] := start.ERRID; step := 2; END_IF
2: reset(PORT := 852, RESET := TRUE);
   IF NOT reset.BUSY THEN errors[2] := reset.ERRID; step := 3; END_IF
3: process(PATHSTR := 'C:\\x.exe', START := TRUE);
   IF NOT process.BUSY THEN errors[3] := process.ERRID; step := 4; END_IF
4: load(START := TRUE); IF NOT load.BUSY THEN errors[4] := load.ERRID; step := 5; END_IF
5: adapters(bExecute := TRUE);
   IF NOT adapters.bBusy THEN errors[5] := adapters.nErrId; step := 6; END_IF
6: value(sSubKey := 'a', sValName := 'b', cbData := 4, pData := ADR(data), bExecute := TRUE);
   IF NOT value.bBusy THEN errors[6] := value.nErrId; step := 7; END_IF
7: time(SET := TRUE); IF NOT time.BUSY THEN errors[7] := time.ERRID; step := 8; END_IF
8: start(PORT := 999, START := FALSE); start(PORT := 999, START := TRUE); step := 9;
9: start(); IF NOT start.BUSY THEN errors[8] := start.ERRID; step := 10; END_IF
END_CASE
END_PROGRAM
"""


def test_control_of_another_plc_and_what_a_station_refuses(tmp_path: Path) -> None:
    from achse.plc import PlcState
    from achse.station import Station
    from achse.station.configuration.station_file import parse

    (tmp_path / "a.st").write_text(CONTROL, encoding="utf-8")
    (tmp_path / "b.st").write_text("PROGRAM MAIN VAR n : INT; END_VAR n := n + 1; END_PROGRAM")
    document = {"plc": [{"sources": "a.st"}, {"sources": "b.st", "port": 852}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(1)
    main: Any = station.plcs[851].instance("MAIN")
    assert station.plcs[851].failure == ""
    assert main["step"] == 10
    errors = list(main["errors"])
    assert errors[:3] == [0, 0, 0]
    assert errors[3] == errors[5] == errors[7] == 0x701
    assert errors[6] == 0x70C  # the registry is empty
    assert errors[4] == 0x703  # no load among the real-time settings
    assert errors[8] == 6  # nobody is at the port
    assert station.plcs[852].state is PlcState.STOP


def test_registry_value_is_read_as_it_was_written(steps: Callable[..., Any]) -> None:
    where = "sSubKey := 'Software\\A', sValName := 'speed', "
    ran = steps(
        "set : FB_RegSetValue; get : FB_RegQueryValue; sent : DWORD := 16#12345678; got : DWORD;"
        " big : ARRAY [0..4999] OF BYTE; e1, e2 : UDINT;",
        ("set", f"{where} eValType := 4, cbData := 4, pData := ADR(sent)", "e1 := set.nErrId;"),
        ("get", f"{where} cbData := 4, pData := ADR(got)", ""),
        ("set", f"{where} eValType := 3, cbData := 5000, pData := ADR(big)", "e2 := set.nErrId;"),
    )
    assert (ran["e1"], ran["set.cbWrite"], ran["e2"]) == (0, 0, 0x705)
    assert (ran["get.nErrId"], ran["get.cbRead"], ran["got"]) == (0, 4, 0x1234_5678)


def test_files_of_a_folder(steps: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "shown/logs").mkdir(parents=True)
    for name, size in (("a.txt", 3), ("b.txt", 70_000), ("c.dat", 1)):
        (tmp_path / "shown/logs" / name).write_bytes(bytes(size))
    keep = "names[step] := find.stFindFile.sFileName; ends[step] := find.bEOE; errors[step] :="
    keep += " find.nErrId; sizes[step] := find.stFindFile.fileSize.dwLowPart;"
    keep += " folders[step] := find.stFindFile.fileAttributes.bDirectory;"
    first = "sPathName := 'logs/*.txt', eCmd := E_EnumCmdType.eEnumCmd_First"
    ran = steps(
        "find : FB_EnumFindFileEntry; names : ARRAY [0..5] OF T_MaxString; ends, folders :"
        " ARRAY [0..5] OF BOOL; sizes, errors : ARRAY [0..5] OF UDINT;",
        ("find", first, keep),
        ("find", "eCmd := E_EnumCmdType.eEnumCmd_Next", keep),
        ("find", "eCmd := E_EnumCmdType.eEnumCmd_Next", keep),
        ("find", "sPathName := 'lo*', eCmd := E_EnumCmdType.eEnumCmd_First", keep),
        ("find", "eCmd := E_EnumCmdType.eEnumCmd_Abort", keep),
        ("find", "sPathName := 'none*', eCmd := E_EnumCmdType.eEnumCmd_First", keep),
        root="shown",
    )
    assert list(ran["names"])[:4] == ["a.txt", "b.txt", "", "logs"]
    assert list(ran["ends"]) == [False, False, True, False, False, True]
    assert list(ran["folders"])[3]
    assert list(ran["sizes"])[:2] == [3, 70_000]
    assert list(ran["errors"]) == [0] * 6


def test_no_watchdog_and_guids_that_differ(steps: Callable[..., Any]) -> None:
    ran = steps(
        "dog : FB_PcWatchdog; guid : FB_CreateGuid; a, b : GUID; e : UDINT; s : STRING(40);",
        ("guid", "pGuidBuffer := ADR(a), nGuidBufferSize := SIZEOF(a)",
         "dog(bEnable := TRUE); e := dog.nErrId; s := GUID_TO_STRING(a);"),
        ("guid", "pGuidBuffer := ADR(b), nGuidBufferSize := SIZEOF(b)", ""),
    )  # fmt: skip
    assert ran["e"] == 0x701
    assert bytes(ran["a.Data4"]) != bytes(ran["b.Data4"])
    assert ran["s"][14] == "4"


LIST = (
    "PROGRAM MAIN VAR find : FB_EnumFindFileList; list : ARRAY [0..2] OF ST_FindFileEntry;"
    " router : FB_GetRouterStatusInfo; ups : FB_GetUPSStatus; names : ARRAY [0..19] OF T_MaxString;"
    " n, runs : INT; step : INT; i : UDINT; END_VAR"
    " router(bExecute := TRUE); ups(bEnable := TRUE); find(bExecute := FALSE);"
    " CASE step OF 0: find(sPathName := 'f*.txt', pFindList := ADR(list),"
    " cbFindList := SIZEOF(list), bExecute := TRUE, eCmd := SEL(runs = 0,"
    " E_EnumCmdType.eEnumCmd_Next, E_EnumCmdType.eEnumCmd_First)); runs := runs + 1; step := 1;"
    " 1: IF NOT find.bBusy THEN i := 0; WHILE i < find.nFindFiles DO"
    " names[n] := list[i].sFileName; n := n + 1; i := i + 1; END_WHILE"
    " step := SEL(find.bEOE OR find.bError, 0, 2); END_IF END_CASE END_PROGRAM"
)


@given(count=st.integers(0, 8))
@settings(max_examples=4, deadline=None)
def test_files_of_a_folder_come_in_lists(
    tmp_path_factory: pytest.TempPathFactory, count: int
) -> None:
    folder = tmp_path_factory.mktemp("found")
    (folder / "shown").mkdir()
    for number in range(count):
        (folder / f"shown/f{number}.txt").write_text("x")
    (folder / "a.st").write_text(LIST)
    document: dict[str, Any] = {
        "system": {"root": "shown"},
        "plc": [{"sources": "a.st"}],
    }
    station = Station(parse(document, "a.toml"), base=folder)
    station.advance(2)
    main: Any = station.plcs[851].instance("MAIN")
    assert station.plcs[851].failure == ""
    assert (main["step"], main["runs"]) == (2, count // 3 + 1)
    assert sorted(list(main["names"])[:count]) == [f"f{number}.txt" for number in range(count)]
    assert (main["find"].bError, main["n"]) == (False, count)
    assert (main["router"].nErrId, main["ups"].nErrId) == (0x701, 6)
