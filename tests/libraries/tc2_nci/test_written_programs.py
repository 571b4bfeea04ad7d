"""Part programs that a PLC writes, block by block, and runs."""

from typing import Any

import pytest

from achse.ams import AmsAddress
from achse.codes import NcError
from tests.libraries.tc2_nci.conftest import NciBench


def _line(nci: NciBench, **inputs: Any) -> int:
    target = dict(zip(("fTargetXPos", "fTargetYPos", "fTargetZPos"), (1.0, 2.0, 3.0), strict=True))
    defaults = {"sPathName": "made.nc", "fPathVelo": 6000.0, "nBlockNo": 20, **target}
    return nci.fire("ItpPpgAppendGeoLine", **{**defaults, **inputs})


def test_a_program_is_written_and_runs(nci: NciBench) -> None:
    axes = {"nXAxisId": 1, "nYAxisId": 2, "nZAxisId": 3}
    assert nci.fire("CfgBuild3DGroup", nGroupId=11, **axes) == 0
    assert nci.fire("ItpPpgCreateMain", sPathName="made.nc") == 0
    assert [AmsAddress(frame.target).port for frame in nci.requested_frames] == [10000] * 3
    assert nci.fire("ItpPpgAppendGenericBlock", sPathName="made.nc", sBlock="N10 G17 G90") == 0
    assert _line(nci, fTargetXPos=10.0, fTargetYPos=0.0, fTargetZPos=-0.5) == 0
    arc = {"bClockWise": False, "fTargetXPos": 20.0, "fTargetYPos": 0.0, "fTargetZPos": -0.5}
    for number, clockwise in ((30, False), (40, True)):
        arc |= {"bClockWise": clockwise, "fRadius": 5.0, "fPathVelo": 6000.0, "nBlockNo": number}
        assert nci.fire("ItpPpgAppendGeoCircleByRadius", sPathName="made.nc", **arc) == 0
        arc["fTargetXPos"] = 30.0
    assert nci.fire("ItpPpgAppendGenericBlock", sPathName="made.nc", sBlock="N50 L7") == 0
    assert nci.fire("ItpPpgCloseMain", sPathName="made.nc") == 0
    assert nci.fire("ItpPpgCreateSubroutine", sPathName="L7.nc", nSubroutineId=7) == 0
    assert _line(nci, sPathName="L7.nc", fTargetXPos=30.0, fTargetYPos=4.0) == 0
    assert nci.fire("ItpPpgCloseSubroutine", sPathName="L7.nc") == 0
    assert (nci.programs / "made.nc").read_text().splitlines()[1:5] == [
        "N10 G17 G90",
        "N20 G01 X10.000000 Y0.000000 Z-0.500000 F6000.000000",
        "N30 G03 X20.000000 Y0.000000 Z-0.500000 U5.000000 F6000.000000",
        "N40 G02 X30.000000 Y0.000000 Z-0.500000 U5.000000 F6000.000000",
    ]
    assert (nci.programs / "L7.nc").read_text().splitlines()[::2] == ["L7", "M17"]
    assert nci.fire("ItpLoadProgEx", sPrg="made.nc", nLength=7) == 0
    assert nci.fire("ItpStartStopEx", "bStart") == 0
    nci.call(2)
    nci.until(2)
    assert [nci.nc.axis(n).set_position for n in (1, 2, 3)] == [30.0, 4.0, 3.0]


def test_a_new_program_replaces_an_old_one(nci: NciBench) -> None:
    for _ in range(2):
        assert nci.fire("ItpPpgCreateMain", sPathName="made.nc") == 0
        assert _line(nci) == 0
    assert len((nci.programs / "made.nc").read_text().splitlines()) == 2


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), -float("inf"), 1e15])
def test_numbers_that_no_program_has(nci: NciBench, wrong: float) -> None:
    for name in ("fTargetXPos", "fTargetYPos", "fTargetZPos", "fPathVelo"):
        assert _line(nci, **{name: wrong}) == NcError.PLC_PARAMETER
    arc = {"sPathName": "made.nc", "fRadius": wrong}
    assert nci.fire("ItpPpgAppendGeoCircleByRadius", **arc) == NcError.PLC_PARAMETER
    assert nci.requested_frames == []
    assert list(nci.programs.iterdir()) == []


def test_a_file_that_cannot_be_written(nci: NciBench) -> None:
    (nci.programs / "made.nc").mkdir()
    assert nci.fire("ItpPpgCreateMain", sPathName="made.nc") != 0
    assert nci.fire("ItpPpgCloseMain", sPathName="made.nc") != 0
