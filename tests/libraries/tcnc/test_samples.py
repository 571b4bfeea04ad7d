"""The programs that the manual prints (004 §3 … §6), as printed, on the demo station.

`tests/data/tcnc_misprints.tsv` lists where print and meaning differ, and what is done here.
"""

import tomllib
from importlib.resources import files
from itertools import pairwise
from math import cos, pi
from pathlib import Path
from typing import Any

import pytest

from achse.codes.axis import ControlBit, StateBit
from achse.station import Station
from achse.station.configuration.station_file import parse

STRUCTURES = """
    PlcToNc1 AT %QB1000 : PLCTONC_AXLESTRUCT;
    NcToPlc1 AT %IB1000 : NCTOPLC_AXLESTRUCT;
"""
ENABLES = "PlcToNc1.nDeCtrlDWord := 7; PlcToNc1.nOverride := AxisSetOverridePercent(100);"


def _demo(folder: Path, program: str, cycle: str = "10ms", **axis: Any) -> Station:
    """The demo station with this program in place of its own."""
    text = files("achse.station").joinpath("demo.toml").read_text(encoding="utf-8")
    document = tomllib.loads(text)
    (folder / "sample.st").write_text(program, encoding="utf-8")
    document["plc"] = [
        {"sources": "sample.st", "task": [{"name": "T", "cycle": cycle, "programs": ["MAIN"]}]}
    ]
    document["axis"][0] |= {"plc": ["%IB1000", "%QB1000"]} | axis
    for key in ("camshaft", "signal"):
        document.pop(key, None)
    return Station(parse(document, "demo.toml"), base=folder)


def _started(station: Station) -> tuple[Any, Any]:
    """Variables of MAIN and the axis X, once both have met."""
    station.advance(0.1)
    assert station.plcs[851].failure == ""
    assert station.nc is not None
    return station.plcs[851].instance("MAIN"), station.nc.axis(1)


STATUS: dict[str, tuple[str, int]] = {
    "AxisIsReady": ("Ready", StateBit.OPERATIONAL),
    "AxisControlLoopClosed": ("CamDataQueued", StateBit.CONTROL_LOOP_CLOSED),
    "AxisIsCalibrated": ("Calibrated", StateBit.HOMED),
    "AxisIsNotMoving": ("Standstill", StateBit.NOT_MOVING),
    "AxisInPositionWindow": ("NearTarget", StateBit.IN_POSITION_AREA),
    "AxisIsAtTargetPosition": ("AtTarget", StateBit.IN_TARGET_POSITION),
    "AxisInProtectedMode": ("Protected", StateBit.PROTECTED),
    "AxisHasBeenStopped": ("Stopped", StateBit.HAS_BEEN_STOPPED),
    "AxisHasJob": ("HasJob", StateBit.HAS_JOB),
    "AxisIsMoving": ("Moving", StateBit.POSITIVE_DIRECTION | StateBit.NEGATIVE_DIRECTION),
    "AxisIsMovingForward": ("Forward", StateBit.POSITIVE_DIRECTION),
    "AxisIsMovingBackwards": ("Backwards", StateBit.NEGATIVE_DIRECTION),
    "AxisIsMovingEndless": ("Moving", StateBit.CONTINUOUS_MOTION),
    "AxisIsCalibrating": ("Calibrating", StateBit.HOMING_BUSY),
    "AxisExternalLatchValid": ("LatchValid", StateBit.EXTERNAL_LATCH_VALID),
    "AxisReachedConstantVelocity": ("ConstVelocity", StateBit.CONSTANT_VELOCITY),
    "AxisIsCompensating": ("IsCompensating", StateBit.COMPENSATING),
    "AxisHasExtSetPointGen": (
        "HasExtSetPointGen", StateBit.EXTERNAL_SETPOINT_ENABLED,
    ),
    "AxisInErrorState": ("Error", StateBit.ERROR),
    "AxisGotNewTargetPosition": ("NewTarget", StateBit.NEW_TARGET_POSITION),
    "AxisCamDataQueued": ("CamDataQueued", StateBit.CAM_DATA_QUEUED),
    "AxisCamTableQueued": ("CamTableQueued", StateBit.CAM_TABLE_QUEUED),
    "AxisCamScalingPending": (
        "CamScalingPending", StateBit.CAM_SCALING_PENDING,
    ),
}  # fmt: skip
"""Per function the variable that its sample declares, and the bits. AxisGotNewTargetPosition has no
sample and is here in the form of the others."""

OTHER_NAMES = {
    "AxisControlLoopClosed": "ControlLoopClosed",
    "AxisIsMovingEndless": "MovingEndless",
    "AxisCamTableQueued": "AxisCamTableQueued",
}
"""Samples that assign to another name than they declare: misprints."""


@pytest.mark.parametrize("name", STATUS)
def test_a_program_of_one_status(name: str, tmp_path: Path) -> None:
    """As the NC shows it, then with each of the 32 bits alone."""
    declared, mask = STATUS[name]
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} {declared} : BOOL; word : DWORD; alone : BOOL; END_VAR"
        f" {declared} := {name}( NcToPlc1.nStateDWord );"
        f" alone := {name}(nStateDWord := word); END_PROGRAM",
    )
    main, axis = _started(station)
    assert main["NcToPlc1"]["nStateDWord"] == axis.state_dword
    assert main[declared] is bool(axis.state_dword & mask)
    for bit in range(32):
        main["word"] = 1 << bit
        station.advance(0.01)
        assert main["alone"] is bool(mask >> bit & 1), bit
    main["word"] = 0xFFFF_FFFF ^ mask
    station.advance(0.01)
    assert main["alone"] is False


@pytest.mark.parametrize("name", OTHER_NAMES)
def test_programs_that_assign_to_what_is_not_there_are_reported(
    name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    table = Path(__file__).parents[2] / "data/tcnc_misprints.tsv"
    assert f"{OTHER_NAMES[name]} := {name}(…), {STATUS[name][0]} declared" in table.read_text(
        "utf-8"
    )
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} {STATUS[name][0]} : BOOL; END_VAR"
        f" {OTHER_NAMES[name]} := {name}( NcToPlc1.nStateDWord ); END_PROGRAM",
    )
    station.advance(0.05)
    assert OTHER_NAMES[name] in caplog.text
    assert station.plcs[851].instance("MAIN")[STATUS[name][0]] is False


def test_the_program_of_the_coupling_state(tmp_path: Path) -> None:
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} Coupled, alone : BOOL; word : DWORD; END_VAR"
        " Coupled := AxisIsCoupled( NcToPlc1.nCoupleState ); alone := AxisIsCoupled(word);"
        " END_PROGRAM",
    )
    main, axis = _started(station)
    assert (main["Coupled"], main["NcToPlc1"]["nCoupleState"]) == (False, axis.coupling_state)
    for state, coupled in ((0, False), (1, False), (2, True), (3, True)):
        main["word"] = state
        station.advance(0.01)
        assert main["alone"] is coupled


CONTROLS = {
    "AxisSetControllerEnable": ControlBit.ENABLE,
    "AxisSetFeedEnableMinus": ControlBit.FEED_ENABLE_MINUS,
    "AxisSetFeedEnablePlus": ControlBit.FEED_ENABLE_PLUS,
    "AxisSetReferencingCamSignal": ControlBit.HOMING_SENSOR,
    "AxisSetAcceptBlockedDriveSignal": ControlBit.ACCEPT_BLOCKED_DRIVE,
}


@pytest.mark.parametrize("name", CONTROLS)
def test_a_program_of_one_enable(name: str, tmp_path: Path) -> None:
    """It reaches the axis; other bits stay, and FALSE takes it away."""
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} ReferencingCamInput AT %IX0.0 : BOOL; END_VAR VAR"
        " word, cleared : DWORD; END_VAR"
        f" PlcToNc1.nDeCtrlDWord := {name}( PlcToNc1.nDeCtrlDWord, TRUE );"
        f" word := {name}(16#5555_5555, FALSE); cleared := {name}(16#FFFF_FFFF, FALSE);"
        " END_PROGRAM",
    )
    main, axis = _started(station)
    assert axis.control_dword == CONTROLS[name]
    assert main["word"] == 0x5555_5555 & ~CONTROLS[name]
    assert main["cleared"] == 0xFFFF_FFFF & ~CONTROLS[name]


def test_the_program_of_the_homing_cam_takes_an_input(tmp_path: Path) -> None:
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} ReferencingCamInput AT %IX0.0 : BOOL; END_VAR"
        " PlcToNc1.nDeCtrlDWord := AxisSetReferencingCamSignal("
        "PlcToNc1.nDeCtrlDWord, ReferencingCamInput ); END_PROGRAM",
    )
    main, axis = _started(station)
    for on in (True, False):
        main["ReferencingCamInput"] = on
        station.advance(0.03)
        assert axis.control_dword == (ControlBit.HOMING_SENSOR if on else 0)


@pytest.mark.parametrize(
    ("percent", "number"),
    [(100.0, 1_000_000), (50.0, 500_000), (33.333, 333_330), (0.00005, 1), (0.0, 0), (-7.0, 0),
     (1e9, 1_000_000), (float("nan"), 0), (float("inf"), 1_000_000)],
)  # fmt: skip
def test_the_programs_of_the_override(percent: float, number: int, tmp_path: Path) -> None:
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} fOverride, percent : LREAL; END_VAR"
        " PlcToNc1.nOverride := AxisSetOverridePercent(percent);"
        " fOverride := AxisGetOverridePercent ( PlcToNc1.nOverride ); END_PROGRAM",
    )
    main, axis = _started(station)
    main["percent"] = percent
    station.advance(0.03)
    assert axis.velocity_override == main["PlcToNc1"]["nOverride"] == number
    assert main["fOverride"] == pytest.approx(number / 10_000)


def test_versions(tmp_path: Path) -> None:
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} n : ARRAY [-1..4] OF UINT; i : INT; s, none : STRING(20);"
        " END_VAR FOR i := -1 TO 4 DO n[i] := F_GetVersionTcNC(i); END_FOR"
        " s := Get_TcNcUtilities_Version(TRUE); none := Get_TcNcUtilities_Version(FALSE);"
        " END_PROGRAM",
    )
    main, _ = _started(station)
    assert [main["n"][i] for i in range(-1, 5)] == [0, 0, 1, 0, 42, 0]
    assert (main["s"], main["none"]) == ("1.0.42", "")


def test_axactex_moves_to_10000_mm(tmp_path: Path) -> None:
    """004 §3.1.3: 2000 mm/s, 3000 mm/s², 15000 mm/s³, the deceleration as configured."""
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} AXACTEX_1 : AXACTEX; bStart, bStop, bBusy, bErr : BOOL;"
        f" nErrId : UDINT; END_VAR {ENABLES}"
        " AXACTEX_1(AXID := 1, START := bStart, STOP := bStop, MODE := 1, VELOCITY := 2000,"
        " ACCEL := 3000, DECEL := -1, JERK := 15000, TARGPOS := 10000.0, TMOUT := T#1s,"
        " BUSY => bBusy, ERR => bErr, ERRID => nErrId); END_PROGRAM",
    )
    main, axis = _started(station)
    main["bStart"] = True
    station.advance(0.02)
    assert (main["bBusy"], main["bErr"], main["nErrId"]) == (False, False, 0)
    assert main["NcToPlc1"]["nStateDWord"] >> 8 & 1
    speeds, accelerations = [], []
    for _ in range(5000):
        station.advance(0.002)
        speeds.append(axis.set_velocity)
        accelerations.append(axis.set_acceleration)
        if not axis.state_dword & StateBit.HAS_JOB:
            break
    assert axis.set_position == 10_000.0
    assert max(speeds) == pytest.approx(2000.0)
    assert max(accelerations) == pytest.approx(3000.0)
    assert min(accelerations) == pytest.approx(-axis.default_deceleration) == -1500.0
    jerks = [(after - before) / 0.002 for before, after in pairwise(accelerations)]
    assert max(map(abs, jerks)) <= 15_000.0 * (1 + 1e-6)
    assert max(jerks) == pytest.approx(15_000.0)


def test_a_stop_on_the_way_to_10000_mm(tmp_path: Path) -> None:
    station = _demo(
        tmp_path,
        f"PROGRAM MAIN VAR {STRUCTURES} AXACTEX_1 : AXACTEX; bStart, bStop : BOOL; END_VAR"
        f" {ENABLES} AXACTEX_1(AXID := 1, START := bStart, STOP := bStop, MODE := 1,"
        " VELOCITY := 2000, ACCEL := 3000, DECEL := -1, JERK := 15000, TARGPOS := 10000.0,"
        " TMOUT := T#1s); END_PROGRAM",
    )
    main, axis = _started(station)
    main["bStart"] = True
    station.advance(2.0)
    main["bStop"] = True
    station.advance(0.05)
    assert axis.state_dword & StateBit.HAS_BEEN_STOPPED
    station.advance(4.0)
    assert axis.set_velocity == 0.0
    assert 2000.0 < axis.set_position < 9000.0
    assert not axis.state_dword & StateBit.HAS_JOB


PRINTED_ROWS = {
    0: 0.0, 1: 0.10783, 2: 0.43114, 76: 277.99809, 77: 278.75055, 78: 279.28886, 79: 279.61217,
    80: 279.72,
}  # fmt: skip
ROWS = [round(279.72 / 2 * (1 - cos(pi * n / 80)), 5) for n in range(81)]
"""The rows between the printed ones lie on the cosine that these are of."""


def test_axcpltab_follows_the_table_of_81_rows(tmp_path: Path) -> None:
    """004 §3.1.5: slave 3, master 1, the table as an ASCII file."""
    assert {n: ROWS[n] for n in PRINTED_ROWS} == PRINTED_ROWS
    lines = ["81\t2", *(f"{n:+.5f}\t{slave:+.5f}" for n, slave in enumerate(ROWS))]
    (tmp_path / "table.txt").write_text("\n".join(lines) + "\n", encoding="ascii")
    program = (
        f"PROGRAM MAIN VAR {STRUCTURES} PlcToNc3 AT %QB1128 : PLCTONC_AXLESTRUCT;"
        " AXCPLTAB_1 : AXCPLTAB; act : AXACT; bCouple, bDiscouple, bStart, bErr : BOOL; END_VAR"
        f" {ENABLES} PlcToNc3.nDeCtrlDWord := 7; PlcToNc3.nOverride := 1000000;"
        " AXCPLTAB_1(AXID := 3, MASTERID := 1, SLAVEOFFSET := 0.0, MASTEROFFSET := 0.0,"
        " SLAVEABSOLUT := 0, MASTERABSOLUT := 0, TABID := 1, CPLON := bCouple,"
        " CPLOFF := bDiscouple, TMOUT := T#1s, ERR => bErr);"
        " act(AXID := 1, START := bStart, MODE := 1, TARGPOS := 80, VELOCITY := 40); END_PROGRAM"
    )
    text = files("achse.station").joinpath("demo.toml").read_text(encoding="utf-8")
    document = tomllib.loads(text)
    del document["camshaft"]
    (tmp_path / "sample.st").write_text(program, encoding="utf-8")
    document["plc"] = [{"sources": "sample.st"}]
    document["axis"][0]["plc"] = ["%IB1000", "%QB1000"]
    document["axis"][2]["plc"] = "%QB1128"
    document["table"] = [
        {"id": 1, "kind": "cam", "type": "equidistant_linear", "file": "table.txt"}
    ]
    station = Station(parse(document, "demo.toml"), base=tmp_path)
    main, master = _started(station)
    assert station.nc is not None
    slave = station.nc.axis(3)
    main["bCouple"] = True
    station.advance(0.03)
    assert (main["bErr"], slave.coupling_state) == (False, 3)
    main["bStart"] = True
    seen = 0
    for _ in range(3000):
        station.advance(0.002)
        n = min(int(master.set_position), 79)
        share = master.set_position - n
        assert slave.set_position == pytest.approx(
            ROWS[n] + share * (ROWS[n + 1] - ROWS[n]), abs=1e-9
        )
        seen += 1
        if master.set_position == 80.0:
            break
    assert (master.set_position, slave.set_position) == (80.0, pytest.approx(279.72))
    assert seen > 1000
    main["bCouple"] = False
    main["bDiscouple"] = True
    station.advance(0.5)
    assert (main["bErr"], slave.coupling_state) == (False, 0)


PITCH = """PROGRAM MAIN
VAR
  in_stXNcToPlc AT %IB1000 : NCTOPLC_AXLESTRUCT;
  out_stXPlcToNc AT %QB1000 : PLCTONC_AXLESTRUCT;
  fbPitchCompensation      :FB_PositionCompensation;
  fbWritePosCorrection     :FB_WritePositionCorrection;
  bAxisIsHomed             : BOOL;
  bEnablePitchCompensation : BOOL := FALSE;
  fCompensationValue       : LREAL;
  bError, bActive, bLimiting : BOOL;
  nErrorId                 : UDINT;
END_VAR
VAR CONSTANT
  stXDescPitch: ST_CompensationDesc :=
  (fPosMin:=0.0, fPosMax:=100.0, nTableElements:=11);
  stXPitchTable: ARRAY[0..10] OF ST_CompensationElement
  :={rows};
END_VAR
out_stXPlcToNc.nDeCtrlDWord := 7;
out_stXPlcToNc.nOverride := 1000000;
bEnablePitchCompensation := bAxisIsHomed;
fbPitchCompensation(
  Enable:= bEnablePitchCompensation ,
  pTable:= ADR(stXPitchTable),
  cbSize:= SIZEOF(stXPitchTable),
  ReferenceAxis:= in_stXNcToPlc,
  Desc:= stXDescPitch,
  Compensation=>fCompensationValue,
  Error=>bError,
  ErrorId=>nErrorId,
  Active=>bActive);
fbWritePosCorrection(
  Enable:=TRUE,
  PositionCorrectionValue:=fCompensationValue,
  CorrectionMode:= POSITIONCORRECTIONMODE_FAST,
  Acceleration:= 500,
  CorrectionLength:= ,
  AxisRefIn:= in_stXNcToPlc,
  AxisRefOut:= out_stXPlcToNc,
  Busy=> bLimiting,
  Error=> ,
  ErrorID=> ,
  Limiting=> );
END_PROGRAM
"""
PITCH_ROWS = ",\n  ".join(f"(fPos:={10 * n}.0, fCompensation:={n / 10})" for n in range(11))


def test_pitch_compensation_of_a_spindle(tmp_path: Path) -> None:
    """004 §6.4: at 25 mm it is 0.25 mm, which FAST reaches in 125 calls of 2 ms."""
    station = _demo(
        tmp_path,
        PITCH.format(rows=PITCH_ROWS),
        "2ms",
        encoder_actual_position_correction_enable=1,
    )
    main, axis = _started(station)
    from achse.motion import commands

    assert commands.start(axis, 1, 25.0, 100.0) == 0
    station.advance(2.0)
    assert axis.set_position == 25.0
    before = axis.actual_position
    assert (main["fCompensationValue"], main["bActive"]) == (0.0, False)
    main["bAxisIsHomed"] = True
    out, block = main["out_stXPlcToNc"], main["fbWritePosCorrection"]
    for call in range(1, 126):
        station.advance(0.002)
        assert main["fCompensationValue"] == pytest.approx(0.25)
        assert main["bActive"]
        assert block["Limiting"] is (call < 125)
        assert out["fActPosCorrection"] == pytest.approx(0.002 * call)
    assert out["fActPosCorrection"] == main["fCompensationValue"]
    assert main["bLimiting"] is True  # the sample gives Busy to a variable of this name
    assert (main["bError"], block["Error"]) == (False, False)
    station.advance(1.0)
    assert axis.actual_position_correction == 0.25
    assert axis.actual_position_uncorrected == pytest.approx(before - 0.25, abs=0.02)
