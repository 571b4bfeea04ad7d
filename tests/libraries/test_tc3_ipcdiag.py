"""Tc3_IPCDiag: what a station says of its computer, and what it does not know."""

import platform
from pathlib import Path
from typing import Any

from achse.devices.system.device import VERSION
from achse.station import Station
from achse.station.configuration.station_file import parse

READS = (
    *("IPCDeviceName", "TC_Version", "TC_VersionBuild", "TC_AmsNetID", "TC_Status", "TC_NoRoutes"),
    *("TC_RouteList_Name", "TC_RouteList_AmsAddress", "OS_Name", "CPU_Name", "NIC_ModuleCnt"),
    *("Time_SecondsSince1970UTC", "CPU_Temp", "NIC_IPv4Address", "Disk_FreeSpaceOfVolumeC"),
    *("TC_LogFilePath", "Unselected"),
)
MAIN = """
PROGRAM MAIN
VAR
    register : FB_IPCDiag_Register; read : FB_IPCDiag_ReadParameter; n : INT;
    write : FB_IPCDiag_WriteParameter; periodic : FB_IPCDiag_ReadParameterPeriodic;
    keys : ARRAY [0..20] OF E_IPCDiag_ParameterKey := [{keys}];
    texts : ARRAY [0..20] OF STRING(40); numbers : ARRAY [0..20] OF UDINT;
    counts : ARRAY [0..20] OF USINT; results, gets, shorts : ARRAY [0..20] OF HRESULT;
    lists : ARRAY [0..20] OF ARRAY [1..3] OF STRING(15); name : STRING(3); tiny : BYTE;
    seconds : UDINT; byIdx : STRING(20); outside : HRESULT;
END_VAR
register(bExecute := TRUE);
IF NOT register.bValid THEN RETURN; END_IF
periodic(bEnable := TRUE, eParameterKey := E_IPCDiag_ParameterKey.Time_SecondsSince1970UTC,
         tPeriod := T#500MS, fbRegister := register);
IF periodic.bValid THEN periodic.GetParameter(ADR(seconds), SIZEOF(seconds)); END_IF
write(bExecute := TRUE, eParameterKey := E_IPCDiag_ParameterKey.IPCDeviceName,
      pBuffer := ADR(name), nBufferSize := 4, fbRegister := register);
IF n < {count} THEN
    read(bExecute := TRUE, eParameterKey := keys[n], fbRegister := register);
    IF NOT read.bBusy THEN
        results[n] := read.hrErrorCode;
        counts[n] := read.nReadParameterValues;
        gets[n] := read.GetParameter(ADR(texts[n]), SIZEOF(texts[n]));
        read.GetParameter(ADR(numbers[n]), SIZEOF(numbers[n]));
        shorts[n] := read.GetParameter(ADR(tiny), 1);
        IF n = 0 THEN read.GetParameter(ADR(name), SIZEOF(name)); END_IF
        read.GetParameterStrings(ADR(lists[n]), SIZEOF(lists[n]), 3);
        IF n = 6 THEN
            read.GetParameterByIdx(ADR(byIdx), SIZEOF(byIdx), 2);
            outside := read.GetParameterByIdx(ADR(byIdx), SIZEOF(byIdx), 3);
        END_IF
        read(bExecute := FALSE, fbRegister := register);
        n := n + 1;
    END_IF
END_IF
END_PROGRAM
"""


def code(value: int) -> int:
    return value & 0xFFFF_FFFF


def test_parameters_of_a_station(tmp_path: Path) -> None:
    keys = ", ".join(f"E_IPCDiag_ParameterKey.{name}" for name in READS)
    (tmp_path / "a.st").write_text(MAIN.replace("{keys}", keys).replace("{count}", str(len(READS))))
    document = {
        "name": "Press 7",
        "router": {"net_id": "5.6.7.8.1.1"},
        "plc": [{"sources": "a.st"}],
        "route": [
            {"name": "north", "net_id": "1.2.3.4.1.1", "host": "10.0.0.1"},
            {"name": "south", "net_id": "1.2.3.5.1.1", "host": "10.0.0.2"},
        ],
    }
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(3.2)
    assert station.plcs[851].failure == ""
    main: Any = station.plcs[851].instance("MAIN")
    assert main["n"] == len(READS)
    modules = main["register"]["stModuleList"]
    assert modules["nModules"] == 4
    assert (modules["aModules"][0]["nModIdx"], modules["aModules"][0]["nModCnt"]) == (1, 1)
    at = {name: number for number, name in enumerate(READS)}
    texts = {name: main["texts"][number] for name, number in at.items()}
    version = ".".join(map(str, (*VERSION, 0)))
    assert texts["IPCDeviceName"] == "Press 7"
    assert main["name"] == "Pre"
    assert texts["TC_Version"] == version
    assert texts["TC_AmsNetID"] == "5.6.7.8.1.1"
    assert texts["OS_Name"] == platform.system()
    assert texts["CPU_Name"] == (platform.processor() or platform.machine())[:40]
    for name, value in (
        ("TC_VersionBuild", VERSION[2]),
        ("TC_Status", 5),
        ("TC_NoRoutes", 2),
        ("NIC_ModuleCnt", 0),
    ):
        assert main["numbers"][at[name]] == value
    assert main["counts"][at["TC_RouteList_Name"]] == 2
    assert list(main["lists"][at["TC_RouteList_Name"]]) == ["north", "south", ""]
    assert list(main["lists"][at["TC_RouteList_AmsAddress"]])[1] == "1.2.3.5.1.1"
    assert (main["byIdx"], code(main["outside"])) == ("south", 0x9811_070B)
    started = station.epoch_ns // 1_000_000_000
    assert started <= main["numbers"][at["Time_SecondsSince1970UTC"]] <= started + 1
    assert main["seconds"] >= started + 2  # it is read again and again
    results = {name: code(main["results"][number]) for name, number in at.items()}
    unknown = {
        **dict.fromkeys(("CPU_Temp", "TC_LogFilePath"), 0x9811_0703),
        **dict.fromkeys(
            ("NIC_IPv4Address", "Disk_FreeSpaceOfVolumeC", "Unselected"),
            0x9811_070C,
        ),
    }
    assert results == {name: unknown.get(name, 0) for name in READS}
    assert code(main["gets"][at["CPU_Temp"]]) == 0x9811_070B
    assert code(main["shorts"][at["TC_NoRoutes"]]) == 0x9811_0705
    assert (main["write"]["bError"], code(main["write"]["hrErrorCode"])) == (True, 0x9811_0704)
