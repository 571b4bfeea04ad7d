"""Tc2_MDP: values of a station's computer by their addresses."""

import platform
from pathlib import Path
from typing import Any

from achse.station import Station
from achse.station.configuration.station_file import parse

MAIN = """
PROGRAM MAIN
VAR
    address : ST_MDP_Addr; step : INT; name, processor : STRING(80); other, number : UDINT;
    general : FB_MDP_Read; element, fan, missing : FB_MDP_ReadElement; nic : FB_MDP_NIC_Read;
    split : FB_MDP_SplitErrorID; scan : FB_MDP_ScanModules;
END_VAR
CASE step OF
0: address.nArea := INT_TO_BYTE(eMDP_Area_GeneralArea); address.nTableId := 8;
   general(bExecute := TRUE, stMDP_DynAddr := address, pDstBuf := ADR(name), cbDstBufLen := 81);
   IF NOT general.bBusy THEN step := 1; END_IF
1: address.nArea := INT_TO_BYTE(eMDP_Area_ConfigArea); address.nTableId := 0; address.nSubIdx := 3;
   element(bExecute := TRUE, stMDP_Addr := address, eModuleType := eMDP_ModT_CPU,
           pDstBuf := ADR(processor), cbDstBufLen := 81);
   IF NOT element.bBusy THEN step := 2; END_IF
2: fan(bExecute := TRUE, stMDP_Addr := address, eModuleType := eMDP_ModT_Fan,
       pDstBuf := ADR(other), cbDstBufLen := 4);
   IF NOT fan.bBusy THEN step := 3; END_IF
3: address.nSubIdx := 99;
   missing(bExecute := TRUE, stMDP_Addr := address, eModuleType := eMDP_ModT_CPU,
           pDstBuf := ADR(other), cbDstBufLen := 4);
   IF NOT missing.bBusy THEN step := 4; END_IF
4: nic(bExecute := TRUE); IF NOT nic.bBusy THEN step := 5; END_IF
5: scan(bExecute := TRUE, nModuleType := eMDP_ModT_OS); IF NOT scan.bBusy THEN step := 6; END_IF
END_CASE
split(nErrID := missing.nErrID);
END_PROGRAM
"""


def test_values_of_the_computer(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(MAIN, encoding="utf-8")
    document = {"name": "Press 7", "plc": [{"sources": "a.st"}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(3.0)
    plc = station.plcs[851]
    main: Any = plc.instance("MAIN")
    assert (plc.failure, main["step"]) == ("", 6)
    assert main["name"] == "Press 7"
    assert (main["general"]["bError"], main["general"]["nCount"]) == (False, 8)
    assert main["processor"] == (platform.processor() or platform.machine())
    assert (main["element"]["iModuleTypeCount"], main["element"]["iModuleCount"]) == (1, 4)
    for block in ("fan", "nic"):  # such modules are not there
        assert (main[block]["bError"], main[block]["nErrID"]) == (True, 0xEC80_0002)
    assert (main["missing"]["bError"], main["missing"]["nErrID"]) == (True, 0xECA8_0703)
    assert main["split"]["eErrGroup"].name == "eMDP_Err_ADS"
    assert main["split"]["nErrCode"] == 0x703
    assert main["scan"]["nDynModuleId"] == main["scan"]["iModuleCount"] - 1 == 3
