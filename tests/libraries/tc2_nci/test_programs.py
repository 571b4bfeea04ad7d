"""Part programs that a PLC runs: M functions, stops, single blocks, errors, block search."""

from pathlib import Path
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion.channels.program_channel import ProgramChannel
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.tc2_nci.conftest import NciBench

PART = "N10 G1 X5 F6000\nN20 M8\nN30 X20 Y2 M7\nN40 Z3\nM30\n"
IDLE, READY, SINGLE, ABORTED, WAITING = 1, 2, 10, 12, 16


@pytest.fixture
def mill(nci: NciBench) -> NciBench:
    """The 3D group has its axes; `part.nc` is there."""
    nci.write("part.nc", PART)
    axes = {"nXAxisId": 1, "nYAxisId": 2, "nZAxisId": 3}
    assert nci.fire("CfgBuild3DGroup", nGroupId=11, **axes) == 0
    return nci


def _load(mill: NciBench, name: str = "part.nc") -> int:
    return mill.fire("ItpLoadProgEx", sPrg=name, nLength=len(name))


def _at(mill: NciBench) -> list[float]:
    return [round(mill.nc.axis(n).set_position, 6) for n in (1, 2, 3)]


def _wait_for_request(mill: NciBench) -> None:
    """Until an M function asks for a confirmation."""
    for _ in range(500):
        if mill.main["fromNci"]["HskMFuncReq"]:
            return
        mill.call()
    raise AssertionError("no M function asks")


def test_a_part_is_cut(mill: NciBench) -> None:
    assert _load(mill) == 0
    assert mill.channel.state == READY
    assert mill.fire("ItpStartStopEx", "bStart") == 0
    _wait_for_request(mill)
    assert mill.main["fromNci"]["ItpState"] == WAITING
    assert mill.main["fromNci"]["HskMFuncNo"] == 8
    assert _at(mill) == [5.0, 0.0, 0.0]
    confirm = mill.main["aItpConfirmHsk"]
    confirm["bExecute"] = True
    mill.call()
    assert (confirm["bBusy"], mill.main["toNci"]["MFuncGranted"]) == (True, 1)
    for _ in range(10):
        if not confirm["bBusy"]:
            break
        mill.call()
    assert (confirm["bBusy"], mill.main["toNci"]["MFuncGranted"]) == (False, 0)
    mill.until(READY)
    assert _at(mill) == [20.0, 2.0, 3.0]
    assert mill.fire("ItpConfirmHsk") == NcError.PLC_NO_M_FUNCTION


def test_a_handshake_is_confirmed_once_for_each_m_function(mill: NciBench) -> None:
    """The confirmation of one does not count for the next."""
    mill.write("two.nc", "N10 M8\nN20 M8\nM30\n")
    assert _load(mill, "two.nc") == 0
    assert mill.fire("ItpStartStopEx", "bStart") == 0
    for _ in range(2):
        _wait_for_request(mill)
        mill.call(20)
        assert mill.main["fromNci"]["HskMFuncReq"] == 1
        assert mill.fire("ItpConfirmHsk") == 0
    mill.until(READY)


def test_stop_reset_and_again(mill: NciBench) -> None:
    mill.write("far.nc", "N10 G1 X100 F6000\nM30\n")
    assert mill.fire("ItpStartStopEx", "bStart") == NcError.CHANNEL_NOT_READY
    assert _load(mill, "far.nc") == 0
    assert mill.fire("ItpStartStopEx", "bStart") == 0
    mill.call(5)
    assert _load(mill) == NcError.CHANNEL_COMMAND_NOT_NOW
    assert mill.fire("ItpStartStopEx", "bStop") == 0
    mill.until(IDLE)
    assert 0.0 < _at(mill)[0] < 100.0
    assert mill.fire("ItpStartStopEx", "bStart") == NcError.NCI_RESET_NEEDED
    assert mill.fire("ItpResetEx2") == 0
    mill.until(IDLE)
    assert _load(mill) == 0
    assert mill.fire("ItpStartStop", "bStart", nChnId=1) == 0
    _wait_for_request(mill)
    assert mill.fire("ItpResetEx", nChnId=1, nGrpId=11) == 0
    mill.until(IDLE)
    assert not mill.main["fromNci"]["HskMFuncReq"]


@pytest.mark.parametrize(("end", "own"), [("Ex", {}), ("", {"nGrpId": 11})])
def test_an_emergency_stop_goes_on(mill: NciBench, end: str, own: dict[str, int]) -> None:
    mill.write("far.nc", "N10 G1 X100 F6000\nM30\n")
    assert _load(mill, "far.nc") == 0
    assert mill.fire("ItpStartStopEx", "bStart") == 0
    mill.call(30)
    state = mill.main["fromNci"]["ChnState"]
    assert not state["bIsEStopRequested"]
    assert mill.fire(f"ItpEStop{end}", fDec=5000.0, fJerk=50000.0, **own) == 0
    mill.call(100)
    assert state["bIsEStopRequested"]
    assert mill.fire("ItpIsEStop", nGrpId=11) == 0
    assert mill.main["aItpIsEStop"]["bEStop"]
    stands = _at(mill)[0]
    mill.call(50)
    assert 0.0 < stands < 100.0
    assert _at(mill)[0] == stands
    assert mill.fire("ItpGetBlocksearchData") == 0
    block = mill.main["aItpGetBlocksearchData"]["sBlockSearchData"]
    assert block["nBlockNo"] == 10
    assert block["fLength"] == pytest.approx(100.0 - stands, abs=1e-6)
    assert mill.fire(f"ItpEStop{end}", fDec=-1.0, **own) == NcError.EMERGENCY_STOP_DATA
    assert mill.fire(f"ItpStepOnAfterEStop{end}", **own) == 0
    mill.until(READY)
    assert _at(mill)[0] == 100.0
    assert not state["bIsEStopRequested"]


def test_single_blocks_one_by_one(mill: NciBench) -> None:
    mill.write("three.nc", "N10 G1 X1 F6000\nN20 X2\nN30 X3\nM30\n")
    assert _load(mill, "three.nc") == 0
    assert mill.fire("ItpSingleBlock", "bExecuteModeChange", nMode=1) == 0
    assert mill.fire("ItpSingleBlock", "bTriggerNext") == 0
    for x in (1.0, 2.0):
        mill.until(SINGLE)
        mill.call(10)
        assert _at(mill)[0] == x
        assert mill.fire("ItpSingleBlock", "bTriggerNext") == 0
        mill.call(5)
    mill.until(READY)
    assert _at(mill)[0] == 3.0


def test_go_ahead_and_distance_to_go(mill: NciBench) -> None:
    mill.write("stop.nc", "N10 G1 X1 F6000\nN20 @717\nN30 DelDTG G1 X50 F600\nM30\n")
    assert _load(mill, "stop.nc") == 0
    assert mill.fire("ItpGoAheadEx") == NcError.CHANNEL_NO_DECODER_STOP
    assert mill.fire("ItpDelDtgEx") == NcError.DELETE_DISTANCE_TO_GO
    assert mill.fire("ItpStartStopEx", "bStart") == 0
    mill.until(WAITING)
    mill.call(100)
    assert _at(mill)[0] == 1.0
    assert mill.fire("ItpGoAhead", nChnId=1) == 0
    mill.call(50)
    assert mill.fire("ItpDelDtg", nChnId=1) == 0
    mill.until(READY)
    assert 1.0 < _at(mill)[0] < 50.0


def test_an_error_of_the_program_is_shown(mill: NciBench) -> None:
    mill.write("bad.nc", "N10 G1 X1 F6000\nN20 G33 X5\nM30\n")
    assert _load(mill, "none.nc") == NcError.PROGRAM_OPEN
    assert _load(mill, "bad.nc") == 0
    assert mill.fire("ItpStartStopEx", "bStart") == 0
    mill.until(ABORTED)
    mill.call()
    assert mill.main["fromNci"]["ErrorCode"] == mill.channel.error_code != 0
    assert mill.fire("ItpReset", nChnId=1) == 0
    mill.call(5)
    assert mill.main["fromNci"]["ErrorCode"] == 0


SEARCHED = "N10 G1 X10 F6000\nN20 X20 Y10\nN30 X30 Y0\nM30\n"


def _search(mill: NciBench, **inputs: Any) -> int:
    defaults = {"sPrgName": "far.nc", "nPrgLength": 6, "eBlockSearchMode": 1, "nBlockId": 20}
    return mill.fire("ItpBlocksearch", **{**defaults, "eDryRunMode": 1, "fLength": 0.0, **inputs})


def test_a_block_search(mill: NciBench) -> None:
    mill.write("far.nc", SEARCHED)
    assert _search(mill, fLength=50.0) == 0
    block = mill.main["aItpBlocksearch"]
    assert block["bDone"]
    assert list(block["sStartPosition"]["fStartPosition"])[:3] == [15.0, 5.0, 0.0]
    assert mill.fire("ItpGetBlocksearchData") == 0
    search = mill.main["aItpGetBlocksearchData"]["sBlockSearchData"]
    assert (search["nBlockNo"], search["fLength"]) == (20, 50.0)
    assert mill.fire("ItpStepOnAfterBlocksearch") == NcError.START_NOT_ON_CONTOUR


def test_a_found_block_goes_on(mill: NciBench) -> None:
    mill.write("far.nc", "N10 G1 X0 F6000\nN20 X20\nM30\n")
    assert _search(mill) == 0
    assert _at(mill) == [0.0, 0.0, 0.0]
    assert mill.fire("ItpStepOnAfterBlocksearch") == 0
    mill.until(READY)
    assert _at(mill)[0] == 20.0


FAILING: tuple[tuple[dict[str, Any], NcError], ...] = (
    ({"eBlockSearchMode": 0}, NcError.PLC_BLOCK_SEARCH_PARAMETER),
    ({"eBlockSearchMode": 3}, NcError.PLC_BLOCK_SEARCH_PARAMETER),
    ({"eDryRunMode": 4}, NcError.PLC_BLOCK_SEARCH_PARAMETER),
    ({"eDryRunMode": -1}, NcError.PLC_BLOCK_SEARCH_PARAMETER),
    ({"fLength": 100.1}, NcError.PLC_BLOCK_SEARCH_PARAMETER),
    ({"fLength": float("nan")}, NcError.PLC_BLOCK_SEARCH_PARAMETER),
    ({"sPrgName": "none.n"}, NcError.PROGRAM_OPEN),
    ({"nBlockId": 25}, NcError.PLC_BLOCK_SEARCH),
)


def test_searches_that_fail(mill: NciBench) -> None:
    """The last is told by the NC, whose own error the channel shows."""
    mill.write("far.nc", SEARCHED)
    for wrong, number in FAILING:
        assert _search(mill, **wrong) == number, wrong
        assert not mill.main["aItpBlocksearch"]["bDone"]
    assert mill.channel.error_code == mill.main["fromNci"]["ErrorCode"] != 0


def test_a_search_back_is_refused(mill: NciBench) -> None:
    for option in ("bIsRetrace", "bRetraceBackward"):
        mill.main["aItpBlocksearch"]["sOptions"][option] = True
        assert _search(mill) == NcError.PLC_NOT_IMPLEMENTED
        mill.main["aItpBlocksearch"]["sOptions"][option] = False


def test_back_on_the_path_and_forward_again(mill: NciBench) -> None:
    """As the page on ItpRetraceMoveBackward says: emergency stop, back, emergency stop, forward."""
    mill.write("far.nc", "N10 G1 X100 F6000\nM30\n")
    assert mill.fire("ItpEnableFeederBackup", bEnable=True) == 0
    assert _load(mill, "far.nc") == 0
    assert mill.fire("ItpStartStopEx", "bStart") == 0
    mill.call(60)
    assert mill.fire("ItpEStopEx", fDec=5000.0, fJerk=50000.0) == 0
    mill.call(100)
    far = _at(mill)[0]
    state = mill.main["fromNci"]["ChnState"]
    assert mill.fire("ItpRetraceMoveBackward") == 0
    mill.call(10)
    assert state["bIsMovingBackward"]
    assert state["bIsFeedFromBackupList"]
    mill.call(300)
    assert state["bRetraceStartPosReached"]
    assert _at(mill)[0] == pytest.approx(0.0)
    assert far > 1.0
    assert mill.fire("ItpRetraceMoveForward") == 0
    mill.until(READY)
    assert _at(mill)[0] == 100.0
    assert not state["bIsFeedFromBackupList"]


PREVIEW = """PROGRAM MAIN
VAR
    fromNci AT %I* : NCTOPLC_NCICHANNEL_REF;
    ahead : ItpGetGeoInfoAndHParamEx;
    older : ItpGetGeoInfoAndHParam;
END_VAR
ahead(sNciToPlc := fromNci);
older(sNciToPlc := fromNci);
END_PROGRAM
"""


def test_what_is_ahead_comes_without_an_edge(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(PREVIEW, encoding="utf-8")
    (tmp_path / "a.nc").write_text("N10 G1 X100 F6000 H7\nN20 Y5\nM30\n")
    document = {
        "plc": [{"sources": "a.st", "code": "plain"}],
        "axis": [{"id": n, "name": f"A{n}"} for n in (1, 2)],
        "channel": [{"id": 1, "programs": ".", "plc": ["MAIN.fromNci"]}],
        "group": [{"id": 11, "channel": 1, "axes": [1, 2]}],
    }
    station = Station(parse(document, "a.toml"), base=tmp_path)
    assert station.nc is not None
    channel = station.nc.channels.channel(1)
    assert isinstance(channel, ProgramChannel)
    for axis in station.nc:
        axis.control_dword, axis.velocity_override = 7, 1_000_000
    station.advance(0.1)
    assert (channel.load("a.nc"), channel.start()) == (0, 0)
    station.advance(0.5)
    main: Any = station.plcs[851].instance("MAIN")
    for name in ("ahead", "older"):
        lines = main[name]["stTab"]["arrLines"]
        assert main[name]["nErrId"] == 0
        assert 0.0 < lines[1]["fLength"] < 90.0
        assert [lines[1][each] for each in ("nBlockNo", "nHParam", "nEntryID")] == [10, 7, 1]
        assert [lines[2][each] for each in ("fLength", "nBlockNo", "nEntryID")] == [5.0, 20, 2]
        assert lines[3]["nBlockNo"] == 0
