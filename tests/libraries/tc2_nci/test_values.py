"""What blocks read and write: settings, tools, zero shifts, groups; and which of it they refuse."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.gcode.state.offsets import ZeroShift
from tests.libraries.tc2_nci.conftest import NciBench

OWN: tuple[tuple[str, dict[str, int]], ...] = (("Ex", {}), ("", {"nChnId": 1}))


@pytest.mark.parametrize(("end", "own"), OWN)
def test_tools(nci: NciBench, end: str, own: dict[str, int]) -> None:
    read, write = f"ItpReadToolDesc{end}", f"ItpWriteToolDesc{end}"
    tool = nci.main["tool"]
    tool["nToolNumber"], tool["nToolType"] = 77, 20
    for n in range(2, 16):
        tool["fParam"][n] = n + 0.25
    for place in (1, 50):
        assert nci.fire(write, nDNo=place, **own) == 0
        stored = nci.channel.data.tools[place]
        assert stored.values == [77.0, 20.0, *(n + 0.25 for n in range(2, 15))]
    stored[4] = 3.5
    for n in range(2, 16):
        tool["fParam"][n] = -1.0
    tool["nToolNumber"] = 0
    assert nci.fire(read, nDNo=50, **own) == 0
    assert (tool["nToolNumber"], tool["nToolType"], tool["fParam"][4]) == (77, 20, 3.5)
    assert (tool["fParam"][14], tool["fParam"][15]) == (14.25, 0.0)
    for place in (0, 51, 2**31):
        assert nci.fire(read, nDNo=place, **own) == NcError.PLC_TOOL_INDEX
        assert nci.fire(write, nDNo=place, **own) == NcError.PLC_TOOL_INDEX
    tool["nToolType"] = 65536
    assert nci.fire(write, nDNo=1, **own) == NcError.PLC_TOOL_INDEX
    assert nci.fire(f"ItpSetToolDescNull{end}", **own) == 0
    assert 50 not in nci.channel.data.tools


def test_a_row_that_is_refused_is_the_error_of_the_block(nci: NciBench) -> None:
    nci.main["tool"]["fParam"][4] = float("inf")
    assert nci.fire("ItpWriteToolDescEx", nDNo=1) == 0x706


@pytest.mark.parametrize(("end", "own"), OWN)
def test_zero_shifts(nci: NciBench, end: str, own: dict[str, int]) -> None:
    read, write = f"ItpReadZeroShift{end}", f"ItpWriteZeroShift{end}"
    shift, shifts = nci.main["shift"], nci.channel.data.shifts
    rows = list(ZeroShift)
    for axis in range(3):
        for n, row in enumerate(rows):
            shifts[row, axis] = 10.0 * (n + 1) + axis
    for number in range(54, 60):
        assert nci.fire(read, nZsNo=number, **own) == 0
        first = 2 * (number - 54)
        wanted = [
            sum(shifts[row, axis] for row in rows[first : first + 2])
            if number < 58
            else shifts[rows[number - 50], axis]
            for axis in range(3)
        ]
        assert [shift["fShiftX"], shift["fShiftY"], shift["fShiftZ"]] == wanted
    for number in range(54, 60):
        shift["fShiftX"], shift["fShiftY"], shift["fShiftZ"] = number, number + 0.5, -number
        assert nci.fire(write, nZsNo=number, **own) == 0
    for axis, expected in enumerate(([54, 0, 55, 0], [54.5, 0, 55.5, 0], [-54, 0, -55, 0])):
        assert [shifts[row, axis] for row in rows[:4]] == expected
    assert [shifts[rows[n], 0] for n in (8, 9)] == [58, 59]
    for number in (0, 53, 60, 2**31):
        assert nci.fire(read, nZsNo=number, **own) == NcError.PLC_ZERO_SHIFT_INDEX
        assert nci.fire(write, nZsNo=number, **own) == NcError.PLC_ZERO_SHIFT_INDEX
    assert nci.fire(f"ItpSetZeroShiftNull{end}", **own) == 0
    assert shifts[rows[0], 0] == 0.0


@pytest.mark.parametrize(("end", "own"), OWN)
def test_bottlenecks(nci: NciBench, end: str, own: dict[str, int]) -> None:
    for mode in (1, 2, 0):
        assert nci.fire(f"ItpSetBottleNeckMode{end}", eBottleNeckMode=mode, **own) == 0
        assert nci.fire(f"ItpGetBottleNeckMode{end}", **own) == 0
        assert nci.main[f"aItpGetBottleNeckMode{end}"]["eBottleNeckMode"] == mode
    assert nci.fire(f"ItpSetBottleNeckMode{end}", eBottleNeckMode=3, **own) != 0
    for number in (1, 24):
        assert nci.fire(f"ItpSetBottleNeckLookAhead{end}", nLookAhead=number, **own) == 0
        assert nci.fire(f"ItpGetBottleNeckLookAhead{end}", **own) == 0
        assert nci.main[f"aItpGetBottleNeckLookAhead{end}"]["nLookAhead"] == number
    assert nci.fire(f"ItpSetBottleNeckLookAhead{end}", nLookAhead=25, **own) != 0


def test_values_that_the_structure_shows(nci: NciBench) -> None:
    for kind, field in (("UDint", "whole_offsets"), ("Lreal", "real_offsets")):
        offsets = {f"nIndexOffsetParam{n}": 0x500 + n for n in (1, 2, 3, 4)}
        assert nci.fire(f"ItpSetCyclic{kind}Offsets", **offsets) == 0
        assert getattr(nci.channel, field) == (0x501, 0x502, 0x503, 0x504)
        assert nci.fire(f"ItpGetCyclic{kind}Offsets") == 0
        block = nci.main[f"aItpGetCyclic{kind}Offsets"]
        assert {key: block[key] for key in offsets} == offsets


def test_default_g_code_and_subroutines(nci: NciBench) -> None:
    for use in (True, False):
        assert nci.fire("ItpEnableDefaultGCode", bUseDefaultGCode=use) == 0
        assert nci.channel.default_g_code == int(use)
    (nci.programs / "parts").mkdir()
    for end, own in OWN:
        name = f"ItpSetSubroutinePath{end}"
        assert nci.fire(name, sPath="parts", nLength=5, **own) == 0
        assert nci.fire(name, sPath="none", nLength=4, **own) == NcError.PROGRAM_OPEN
        assert nci.fire(name, sPath="", nLength=0, **own) == 0


def test_fast_m_functions_are_cleared(nci: NciBench) -> None:
    for end, own in OWN:
        nci.channel.outputs.set_fast(7)
        assert nci.fire(f"ItpResetFastMFunc{end}", nMFuncNo=7, **own) == 0
        assert not nci.channel.outputs.is_fast(7)
        refused = nci.fire(f"ItpResetFastMFunc{end}", nMFuncNo=160, **own)
        assert refused == NcError.CHANNEL_M_FUNCTION_INDEX


def _places(nci: NciBench) -> list[int]:
    group: Any = nci.nc.groups.group(11)
    return list(group.ids)


def test_groups(nci: NciBench) -> None:
    axes = {"nXAxisId": 1, "nYAxisId": 2, "nZAxisId": 3}
    assert nci.fire("CfgBuild3DGroup", nGroupId=11, **axes) == 0
    assert _places(nci)[:4] == [1, 2, 3, 0]
    assert nci.fire("CfgRead3DAxisIds", nGroupId=11) == 0
    assert nci.fire("CfgAddAxisToGroup", nGroupId=11, nAxisId=5, nIndex=3) == 0
    assert nci.fire("CfgReadExt3DAxisIds", nGroupId=11) == 0
    places = nci.main["places"]
    names = ("X", "Y", "Z", "Q1", "Q2", "Q3", "Q4", "Q5")
    assert [places[f"n{name}AxisId"] for name in names] == [1, 2, 3, 5, 0, 0, 0, 0]
    assert nci.fire("CfgReconfigAxis", nAxisId=5) == 0
    assert _places(nci)[:4] == [1, 2, 3, 0]
    assert nci.fire("CfgReconfigGroup", nGroupId=11) == 0
    assert _places(nci) == [0] * 8
    every = {f"n{name}AxisId": n for n, name in enumerate(names[:6], 1)}
    assert nci.fire("CfgBuildExt3DGroup", nGroupId=11, **every) == 0
    assert _places(nci) == [1, 2, 3, 4, 5, 6, 0, 0]
    assert nci.fire("CfgReconfigGroup", nGroupId=11) == 0
    for wrong in ({"nXAxisId": 99}, {"nXAxisId": 1, "nYAxisId": 1}):
        assert nci.fire("CfgBuild3DGroup", nGroupId=11, **{**axes, **wrong}) != 0
        assert _places(nci) == [0] * 8
    assert nci.fire("CfgBuild3DGroup", nGroupId=99, **axes) == NcError.GROUP_ID


def test_the_way_back_is_kept_where_it_is_requested(nci: NciBench) -> None:
    for wanted in (True, False):
        assert nci.fire("ItpEnableFeederBackup", bEnable=wanted) == 0
        assert nci.fire("ItpIsFeederBackupEnabled") == 0
        assert nci.main["aItpIsFeederBackupEnabled"]["bEnabled"] == wanted
    for name in ("ItpRetraceMoveBackward", "ItpRetraceMoveForward"):
        assert nci.fire(name) == NcError.CHANNEL_COMMAND_NOT_NOW
