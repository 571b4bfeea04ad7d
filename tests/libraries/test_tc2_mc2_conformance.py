"""PLCopen's discipline of outputs: each block of the libraries Tc2_MC2 and kin in each situation.

A letter is an output that is TRUE: D Done (InVelocity, InGear, InSync …), B Busy, A Active,
C CommandAborted, E Error. "B BA D" are the outputs from the call of the edge on, repetitions left
out; a test that says how many calls counts each.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from achse.codes import NcError
from achse.libraries import sources
from achse.motion import commands
from tests.libraries.mc2 import Bench

FAST = {"Velocity": 200.0}
UNKNOWN_PORT = 999
TARGET_PORT_NOT_FOUND = 6
PARAMETER = 0x4B06

Step = Callable[[Bench], object]


def nothing(on: Bench) -> None:
    """No preparation."""


def runs(on: Bench) -> None:
    on.edge("run", 60, Velocity=50.0)


def gears(on: Bench) -> None:
    assert on.edge("gear", 5)[-1] == "D"


def turns(on: Bench) -> None:
    gears(on)
    on.edge("run", 60, Velocity=50.0)


def loads(on: Bench) -> None:
    assert on.edge("table", 9, CamTableID=3, Periodic=True)[-1] == "D"


def follows(on: Bench) -> None:
    loads(on)
    assert on.edge("cam", 5, CamTableID=3)[-1] == "D"


def follows_several(on: Bench) -> None:
    loads(on)
    assert on.edge("cam", 5, CamTableID=3)[-1] == "D"
    assert on.edge("second", 9, CamTableID=4, Periodic=True)[-1] == "D"


def follows_two(on: Bench) -> None:
    follows_several(on)
    on.set("more", Scaling__SlaveScalingMode=1)
    assert on.edge("more", 5, CamTableID=4)[-1] == "D"


def arms(on: Bench) -> None:
    on.main["trigger"]["TouchProbe"] = 1


def fails(on: Bench) -> None:
    commands.set_external_error(on.axis, 0x4001)
    on.call()


def corrects(on: Bench) -> None:
    on.axis.encoder.actual_position_correction_enable = 1
    on.call()


def edge(name: str, **inputs: Any) -> Step:
    return lambda on: on.set(name, Execute=True, **inputs)


@dataclass(frozen=True)
class Case:
    """What a block shows. `short`: it is over before a second edge could come."""

    block: str
    inputs: Mapping[str, Any] = field(default_factory=dict)
    bits: str = "B D"
    requests: int = 1
    key: str = "Execute"
    others: Mapping[str, str] = field(default_factory=dict)
    prepare: Step = nothing
    calls: int = 60
    axis: Mapping[str, Any] = field(default_factory=dict)
    refused: tuple[Mapping[str, Any], int] | None = None
    """Other inputs, and the ErrorID they get."""
    abort: tuple[Mapping[str, str], Step] | None = None
    """Further blocks, and what takes over."""
    aborted: str = "C"
    slave: bool = False
    """The axis that is commanded is Y."""

    @property
    def short(self) -> bool:
        return self.calls <= SHORT

    @property
    def lasts(self) -> bool:
        """Return True if it is busy in many calls until a motion ends or forever."""
        return not self.short and self.bits != "B D"

    def bench(self, folder: Path, form: str) -> Bench:
        """The block, and all further ones of its tests, so that these have the same program."""
        takes_over = self.abort[0] if self.abort else {}
        return Bench(folder, form, self.axis, **{"it": self.block, **self.others, **takes_over})


SHORT = 6
LONG = 400
HALT: Mapping[str, str] = {"halt": "MC_Halt"}
RUN: Mapping[str, str] = {"run": "MC_MoveVelocity"}
GEAR: Mapping[str, str] = {"gear": "MC_GearIn"}
TABLE: Mapping[str, str] = {"table": "MC_CamTableSelect"}
CAM: Mapping[str, str] = {**TABLE, "cam": "MC_CamIn"}
SEVERAL: Mapping[str, str] = {**TABLE, "cam": "MC_CamIn_V2", "second": "MC_CamTableSelect"}
HALTED = (HALT, edge("halt"))
ZERO_VELOCITY = ({"Velocity": 0.0}, int(NcError.SET_VELOCITY_NOT_ALLOWED))
NOT_MOVING = {"Velocity": 30.0}


def move(block: str, **inputs: Any) -> Case:
    return Case(
        block, {**FAST, **inputs}, "B BA D", calls=LONG, refused=ZERO_VELOCITY, abort=HALTED
    )


def gear(block: str, bits: str, **more: Any) -> Case:
    return Case(
        block, bits=bits, slave=True, calls=SHORT,
        abort=({"out": "MC_GearOut"}, edge("out")), **more,
    )  # fmt: skip


COMPENSATION = {
    "Distance": 5.0, "VelocityDiff": 20.0, "VelocityProcess": 50.0, "Length": 50.0,
    "Acceleration": 500.0, "Deceleration": 500.0,
}  # fmt: skip


def compensates(on: Bench) -> None:
    runs(on)
    on.set("more", **COMPENSATION)
    on.edge("more", 5)


SAW: Mapping[str, Any] = {"RatioNumerator": 1.0, "RatioDenominator": 1}


def synchronises(on: Bench) -> None:
    on.edge("saw_in", 5, **SAW)


def shifts(on: Bench) -> None:
    gears(on)
    on.edge("shift", 25, PhaseShift=50.0, Velocity=80.0)


_CASES = (
    move("MC_MoveAbsolute", Position=50.0),
    move("MC_MoveRelative", Distance=50.0),
    move("MC_MoveAdditive", Distance=50.0),
    move("MC_MoveModulo", Position=50.0, Direction=1),
    move("MC_MoveVelocity"),
    move("MC_MoveContinuousAbsolute", Position=20.0, EndVelocity=30.0),
    move("MC_MoveContinuousRelative", Distance=20.0, EndVelocity=30.0),
    Case("MC_Halt", bits="B BA D", calls=LONG, others=RUN, prepare=runs,
         abort=({"move": "MC_MoveAbsolute"}, edge("move", Position=5.0, **FAST))),
    Case("MC_Home", {"bCalibrationCam": True}, "B BA", calls=LONG, abort=HALTED,
         refused=({"HomingMode": 1}, 0x4B04)),
    Case("MC_Reset", calls=SHORT),
    Case("MC_SetPosition", {"Position": 30.0}, calls=SHORT,
         refused=({"Options__SelectEncoderIndex": True, "Options__EncoderIndex": 9}, 0x4013)),
    Case("MC_WriteParameter", {"ParameterNumber": 1017, "Value": -7.5}, calls=SHORT,
         refused=({"ParameterNumber": 1016}, 0x4B05)),
    Case("MC_WriteParameterPersistent", {"ParameterNumber": 1017, "Value": -7.5}, calls=SHORT,
         refused=({"ParameterNumber": 7777}, 0x4B45)),
    Case("MC_WriteBoolParameter", {"ParameterNumber": 1016, "Value": True}, calls=SHORT,
         refused=({"ParameterNumber": 1017}, 0x4B05)),
    Case("MC_WriteBoolParameterPersistent", {"ParameterNumber": 1016}, calls=SHORT,
         refused=({"ParameterNumber": 1017}, 0x4B05)),
    Case("MC_ReadParameterSet", calls=SHORT),
    Case("MC_ReadDriveAddress", calls=SHORT),
    Case("MC_ReadAxisComponents", calls=SHORT),
    Case("MC_ReadApplicationRequest", calls=SHORT),
    Case("MC_SetEncoderScalingFactor", {"ScalingFactor": 0.0002}, calls=SHORT,
         refused=({"Mode": 7}, 0x4250)),
    Case("MC_SelectControlLoop", calls=SHORT,
         refused=({"EncoderIndex": 4}, int(NcError.REQUEST_PARAMETER))),
    Case("MC_ReadDriveOperationMode", calls=SHORT),
    Case("MC_WriteDriveOperationMode", {"DriveOperationMode": 4}, calls=SHORT,
         refused=({"DriveOperationMode": 77}, int(NcError.DRIVE_MODE))),
    Case("MC_MoveSuperImposed", COMPENSATION, "B BA D", calls=300, others=RUN, prepare=runs,
         abort=({"end": "MC_AbortSuperposition"}, edge("end"))),
    Case("MC_AbortSuperposition", calls=SHORT, others={**RUN, "more": "MC_MoveSuperImposed"},
         prepare=compensates),
    Case("MC_TorqueControl", {"Torque": 500.0, "TorqueRamp": 1000.0, "VelocityLimitHigh": 50.0,
         "VelocityLimitLow": -50.0}, "B BA D", calls=100, abort=HALTED,
         refused=({"TorqueRamp": -1.0}, int(NcError.START_AXIS_DATA))),
    Case("MC_ExtSetPointGenEnable", calls=SHORT,
         refused=({"PositionType": 5}, int(NcError.START_TYPE))),
    Case("MC_ExtSetPointGenDisable", calls=SHORT, others={"on": "MC_ExtSetPointGenEnable"},
         prepare=lambda on: on.edge("on", 3)),
    Case("MC_TouchProbe", bits="B", requests=2, calls=60, prepare=arms,
         abort=({"end": "MC_AbortTrigger"}, edge("end"))),
    Case("MC_TouchProbe_V2", bits="B", requests=2, calls=60, prepare=arms,
         abort=({"end": "MC_AbortTrigger_V2"}, edge("end"))),
    Case("MC_AbortTrigger", requests=2, calls=SHORT, prepare=arms),
    Case("MC_AbortTrigger_V2", requests=2, calls=SHORT, prepare=arms),
    gear("MC_GearIn", "BA D", refused=({"RatioDenominator": 0}, PARAMETER)),
    gear("MC_GearInDyn", "BA DB", key="Enable", requests=3, refused=({"BufferMode": 1}, 0x4B64)),
    gear("MC_GearInMultiMaster", "BA DB", key="Enable", inputs={"Acceleration": 1000.0},
         refused=({"BufferMode": 1}, 0x4B64)),
    gear("MC_GearInVelo", "BA D", inputs=SAW, refused=({"RatioDenominator": 0}, PARAMETER)),
    Case("MC_GearInPos", {**SAW, "MasterSyncPosition": 100.0, "SlaveSyncPosition": 60.0},
         "BA D", slave=True, calls=LONG, others=RUN, prepare=runs,
         refused=({"RatioDenominator": 0}, PARAMETER),
         abort=({"out": "MC_GearOut"}, edge("out"))),
    Case("MC_ReadFlyingSawCharacteristics", slave=True, calls=SHORT,
         others={"saw_in": "MC_GearInVelo"}, prepare=synchronises),
    Case("MC_GearOut", slave=True, calls=SHORT, others=GEAR, prepare=gears),
    Case("MC_PhasingAbsolute", {"PhaseShift": 5.0, **NOT_MOVING}, "B BA D", slave=True, calls=100,
         others=GEAR, prepare=gears, refused=ZERO_VELOCITY,
         abort=({"end": "MC_HaltPhasing"}, edge("end"))),
    Case("MC_PhasingRelative", {"PhaseShift": 5.0, **NOT_MOVING}, "B BA D", slave=True, calls=100,
         others=GEAR, prepare=gears, refused=ZERO_VELOCITY,
         abort=({"end": "MC_HaltPhasing"}, edge("end"))),
    Case("MC_HaltPhasing", {}, "B BA D", slave=True, calls=60,
         others={**GEAR, "shift": "MC_PhasingAbsolute"},
         prepare=shifts,
         abort=({"again": "MC_PhasingRelative"}, edge("again", PhaseShift=5.0, Velocity=30.0))),
    Case("MC_CamTableSelect", {"CamTableID": 3}, "B D", requests=3, calls=9,
         refused=({"CamTableID": 0}, 0x4B32)),
    Case("MC_ReadCamTableSlaveDynamics", {"CamTableID": 3, "MasterPosition": 45.0}, calls=SHORT,
         others=TABLE, prepare=loads, refused=({"CamTableID": 9}, int(NcError.TABLE_ID))),
    Case("MC_CamIn", {"CamTableID": 3}, slave=True, calls=SHORT, others=TABLE, prepare=loads,
         refused=({"StartMode": 5}, PARAMETER), abort=({"out": "MC_CamOut"}, edge("out"))),
    Case("MC_CamIn_V2", {"CamTableID": 3}, slave=True, calls=SHORT, others=TABLE, prepare=loads,
         refused=({"CamTableID": 256}, 0x4B32), abort=({"out": "MC_CamOut"}, edge("out"))),
    Case("MC_CamAdd", {"CamTableID": 4, "Scaling__SlaveScalingMode": 1}, slave=True, calls=SHORT,
         others=SEVERAL, prepare=follows_several, refused=({"CamTableID": 0}, 0x4B32),
         abort=({"out": "MC_CamOut"}, edge("out"))),
    Case("MC_CamExchange", {"CamTableID": 4, "Options__ReferenceCamTableID": 3}, slave=True,
         calls=SHORT, others=SEVERAL, prepare=follows_several,
         refused=({"CamTableID": 0}, 0x4B32), abort=({"out": "MC_CamOut"}, edge("out"))),
    Case("MC_CamRemove", {"CamTableID": 4}, slave=True, calls=SHORT,
         others={**SEVERAL, "more": "MC_CamAdd"}, prepare=follows_two,
         refused=({"CamTableID": 0}, 0x4B32)),
    Case("MC_CamScaling", {"MasterScaling": 1.0}, slave=True, calls=SHORT, others=CAM,
         prepare=follows, refused=({"MasterScaling": 0.0}, 0x425B)),
    Case("MC_CamOut", slave=True, calls=SHORT, others=CAM, prepare=follows),
)  # fmt: skip

CASES = sorted(_CASES, key=lambda case: (case.abort is None, not case.lasts))
"""First those with further tests: pytest lets tests with the same number run one after the other,
and they share the code of their program."""

OWN_TESTS = {"MC_Power", "MC_PowerStepper", "MC_Stop", "MC_Jog"}
"""Blocks whose outputs differ from all others by the manual; see below, and test_tc2_mc2_drive."""

ids = [case.block for case in CASES]
ALL = pytest.mark.parametrize("case", CASES, ids=ids, scope="module")
"""All tests of a case run one after the other, and share the program."""


def expected(case: Case, *, dropped: bool = False) -> list[str]:
    """The outputs until nothing changes; after Execute fell the result is there for one call."""
    shown = case.bits.split()
    return [*shown, ""] if dropped and "D" in shown[-1] else shown


def test_the_table_has_every_block() -> None:
    listed = {case.block for case in CASES} | {row[0] for row in ENABLED} | OWN_TESTS
    text = "\n".join(text for path, text in sources() if path.startswith("tc2_mc2"))
    there = set(re.findall(r"^FUNCTION_BLOCK (MC_\w+)", text, re.MULTILINE))
    assert there - {"MC_OverrideFilter", "MC_CalcDynamicsByRampTime"} == listed


@ALL
def test_execute_held(case: Case, tmp_path: Path, form: str) -> None:
    """The result stays until Execute falls; the command sent its requests once.

    Before, it got no answer, and was refused: both leave the block and the axis as they were.
    """
    on = case.bench(tmp_path, form)
    case.prepare(on)
    if case.block != "MC_ReadCamTableSlaveDynamics":  # it has no axis that names another port
        _get_no_answer(on, case)
    if case.refused is not None:
        _be_refused(on, case, *case.refused)
    on.requests.clear()
    on.set("it", **case.inputs, **{case.key: True})
    assert on.outputs("it", case.calls) == expected(case)
    assert len(on.requests) == case.requests
    assert {frame.target[6:] for frame in on.requests} <= {b"\xf4\x01", b"\xf5\x01"}
    on.set("it", **{case.key: False})
    if "D" in case.bits:
        assert on.outputs("it", 2) == [""]
        assert len(on.requests) == case.requests


def _get_no_answer(on: Bench, case: Case) -> None:
    """Error with the ADS error, until Execute falls."""
    ports = {axis: on.main[axis]["ADS"]["Port"] for axis in "XY"}
    for axis in ports:
        on.main[axis]["ADS"]["Port"] = UNKNOWN_PORT
    assert on.edge("it", 8, case.key, **case.inputs)[-1] == "E"
    assert on.main["it"]["ErrorID"] == TARGET_PORT_NOT_FOUND
    on.set("it", **{case.key: False})
    assert on.outputs("it", 2) == [""]
    assert on.main["it"]["ErrorID"] == 0
    for axis, port in ports.items():
        on.main[axis]["ADS"]["Port"] = port


def _be_refused(on: Bench, case: Case, inputs: Mapping[str, Any], code: int) -> None:
    """Error with the code that these inputs get, until Execute falls."""
    before = {key: on.input("it", key) for key in inputs}
    seen = on.edge("it", 8, case.key, **{**case.inputs, **inputs})
    assert (seen[-1], hex(on.main["it"]["ErrorID"])) == ("E", hex(code))
    on.set("it", **{case.key: False})
    assert on.outputs("it", 2) == [""]
    on.set("it", **before)


@ALL
def test_execute_dropped_early(case: Case, tmp_path: Path, form: str) -> None:
    """The command goes on; its result is there for exactly one call."""
    on = case.bench(tmp_path, form)
    case.prepare(on)
    on.requests.clear()
    on.edge("it", 1, case.key, **case.inputs)
    on.set("it", **{case.key: False})
    each = []
    for _ in range(case.calls):
        on.call()
        each.append(on.shown("it"))
    seen = [shown for n, shown in enumerate(each) if n == 0 or each[n - 1] != shown]
    first = expected(case)[0]
    after = seen if seen[0] == first else [first, *seen]
    assert after == expected(case, dropped=True)
    if "D" in case.bits:
        assert sum("D" in shown for shown in each) == 1
    assert len(on.requests) == case.requests


@ALL
def test_an_edge_while_busy_is_lost(case: Case, tmp_path: Path, form: str) -> None:
    """A command that is over by then begins again instead."""
    on = case.bench(tmp_path, form)
    case.prepare(on)
    on.requests.clear()
    on.edge("it", 1, case.key, **case.inputs)
    on.set("it", **{case.key: False})
    on.call()
    busy = "B" in on.shown("it") and "D" not in on.shown("it")
    on.edge("it", case.calls, case.key)
    again = case.block not in REFUSE_A_SECOND
    if busy:
        assert len(on.requests) == case.requests
    elif again:
        assert len(on.requests) == 2 * case.requests
        assert on.shown("it") == expected(case)[-1]


REFUSE_A_SECOND = {
    *("MC_GearIn", "MC_GearInDyn", "MC_GearInMultiMaster", "MC_GearOut", "MC_CamOut"),
    *("MC_AbortSuperposition", "MC_ExtSetPointGenEnable", "MC_ExtSetPointGenDisable"),
    *("MC_CamAdd", "MC_CamExchange", "MC_CamRemove", "MC_CamIn_V2"),
}
"""The NC has done it already: a second one is an error."""


@pytest.fixture(scope="module")
def without_link(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """Every block on an axis without link, in one PLC: none of them reaches the NC."""
    blocks = [*(case.block for case in CASES), *(row[0] for row in ENABLED), *OWN_TESTS]
    named = {f"it_{block}": block for block in blocks}
    return Bench(tmp_path_factory.mktemp("unlinked"), "plain", {}, "unlinked", **named)


@ALL
def test_an_axis_without_link(case: Case, without_link: Bench) -> None:
    if case.block == "MC_ReadCamTableSlaveDynamics":
        pytest.skip("it has no axis")
    on, it = without_link, f"it_{case.block}"
    on.requests.clear()
    assert on.edge(it, 4, case.key, **case.inputs) == ["E"]
    assert on.main[it]["ErrorID"] == PARAMETER
    assert not on.requests


@pytest.mark.parametrize(
    "case", [case for case in CASES if case.abort], ids=lambda c: c.block, scope="module"
)
@pytest.mark.parametrize("dropped", [False, True])
def test_another_block_takes_over(case: Case, dropped: bool, tmp_path: Path, form: str) -> None:
    """CommandAborted while Execute is held, else for one call; the other one is done."""
    assert case.abort is not None
    others, take = case.abort
    on = case.bench(tmp_path, form)
    case.prepare(on)
    on.edge("it", 4 if case.short else 8, case.key, **case.inputs)
    if dropped and "B" not in on.shown("it").replace("DB", ""):
        pytest.skip("its result is shown no longer once Execute has fallen")
    if dropped:
        on.set("it", **{case.key: False})
        on.call()
    take(on)
    each = []
    for _ in range(10):
        on.call()
        each.append(on.shown("it"))
    if dropped:
        assert each.count("C") == 1
        assert each[-1] == ""
    else:
        assert each[-1] == "C"
        on.set("it", **{case.key: False})
        assert on.outputs("it", 2) == [""]
    (name,) = others
    on.call(200)
    assert on.shown(name) == "D"


LASTING = [case for case in CASES if case.lasts]


@pytest.mark.parametrize("case", LASTING, ids=lambda case: case.block, scope="module")
def test_an_axis_error_while_busy(case: Case, tmp_path: Path, form: str) -> None:
    """Error with the number of the axis error, and no later than two calls after it."""
    on = case.bench(tmp_path, form)
    case.prepare(on)
    on.edge("it", 3, case.key, **case.inputs)
    assert "B" in on.shown("it")
    axis = on.axis_of(7 if case.slave else 1)
    assert commands.set_external_error(axis, 0x4FF0) == 0
    assert on.outputs("it", 4)[-1] == "E"
    assert on.main["it"]["ErrorID"] == axis.error_code != 0


ENABLED: tuple[tuple[str, Mapping[str, Any], str], ...] = (
    ("MC_SetOverride", {"VelFactor": 0.5}, "Enabled"),
    ("MC_ReadStatus", {}, "Valid"),
    ("MC_ReadAxisError", {}, "Valid"),
    ("MC_ReadActualPosition", {}, "Valid"),
    ("MC_ReadActualVelocity", {}, "Valid"),
    ("MC_ReadParameter", {"ParameterNumber": 1004}, "Valid"),
    ("MC_ReadBoolParameter", {"ParameterNumber": 1016}, "Valid"),
    ("MC_BacklashCompensation", {"Backlash": 0.5}, "Enabled"),
    ("MC_PositionCorrectionLimiter", {"PositionCorrectionValue": 0.5}, "Busy"),
    ("MC_TableBasedPositionCompensation", {"TableSize": 0}, ""),
)
"""Blocks that act in each call while Enable is TRUE, and what they show then."""


@pytest.fixture(scope="module")
def with_enable(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """Every block with Enable in one PLC; each test leaves its own disabled."""
    named = {f"it_{row[0]}": row[0] for row in ENABLED}
    return Bench(tmp_path_factory.mktemp("enabled"), "plain", {}, **named)


@pytest.mark.parametrize(("block", "inputs", "valid"), ENABLED)
def test_enable(block: str, inputs: Mapping[str, Any], valid: str, with_enable: Bench) -> None:
    on, it = with_enable, f"it_{block}"
    corrects(on)
    on.set(it, **inputs, Enable=True)
    on.call(4)
    if valid:
        assert on.main[it][valid]
        assert not on.main[it]["Error"]
    else:
        assert (on.main[it]["Error"], on.main[it]["ErrorID"]) == (True, 0x4B43)
    on.set(it, Enable=False)
    on.call(2)
    assert not on.main[it][valid or "Enabled"]
    assert (on.main[it]["Error"], on.main[it]["ErrorID"]) == (False, 0)


@pytest.mark.parametrize(("block", "inputs", "valid"), ENABLED)
def test_enable_without_link(
    block: str, inputs: Mapping[str, Any], valid: str, without_link: Bench
) -> None:
    on, it = without_link, f"it_{block}"
    on.set(it, **inputs, Enable=True)
    on.call(4)
    if block == "MC_SetOverride":
        return  # it writes the cyclic interface, linked or not
    assert (on.main[it]["Error"], on.main[it]["ErrorID"]) == (True, PARAMETER)
    if valid:
        assert not on.main[it][valid]


def test_power_without_link(without_link: Bench) -> None:
    on, it = without_link, "it_MC_Power"
    on.edge(it, 3, "Enable")
    assert (on.main[it]["Error"], on.main[it]["ErrorID"]) == (True, PARAMETER)
    assert not on.main[it]["Status"]
    on.set(it, Enable=False)
    on.call()
    assert not on.main[it]["Error"]


def test_a_stop_whose_execute_drops_early(tmp_path: Path, form: str) -> None:
    """Done is there for one call, then the lock is released: two requests in all."""
    on = Bench(tmp_path, form, {}, it="MC_Stop", **RUN)
    runs(on)
    on.requests.clear()
    on.edge("it", 2)
    on.set("it", Execute=False)
    assert on.outputs("it", 100) == ["BA", "DBA", "BA", ""]
    assert len(on.requests) == 2
    assert not on.axis.motion_locked


def test_an_edge_of_a_stop_while_busy_is_lost(tmp_path: Path, form: str) -> None:
    on = Bench(tmp_path, form, {}, it="MC_Stop", **RUN)
    runs(on)
    on.requests.clear()
    on.edge("it", 2)
    on.set("it", Execute=False)
    on.call()
    assert on.edge("it", 100) == ["BA", "DBA"]
    assert len(on.requests) == 1


def test_a_reset_releases_the_lock_of_a_stop(tmp_path: Path, form: str) -> None:
    on = Bench(tmp_path, form, {}, it="MC_Stop", reset="MC_Reset", **RUN)
    runs(on)
    assert on.edge("it", 100)[-1] == "DBA"
    assert on.edge("reset", 5)[-1] == "D"
    assert not on.axis.motion_locked
    on.set("it", Execute=False)
    assert on.outputs("it", 5)[-1] in ("", "E")


@pytest.mark.parametrize("block", ["MC_Stop", "MC_Jog"])
def test_stop_and_jog_without_answer_or_link(
    block: str, tmp_path: Path, form: str, without_link: Bench
) -> None:
    key = "JogForward" if block == "MC_Jog" else "Execute"
    on = Bench(tmp_path, form, {}, it=block)
    on.main["X"]["ADS"]["Port"] = UNKNOWN_PORT
    assert on.edge("it", 8, key)[-1] == "E"
    assert on.main["it"]["ErrorID"] == TARGET_PORT_NOT_FOUND
    on.set("it", **{key: False})
    assert on.outputs("it", 2) == [""]
    on, it = without_link, f"it_{block}"
    assert on.edge(it, 4, key) == ["E"]
    assert on.main[it]["ErrorID"] == PARAMETER


@pytest.mark.parametrize(("mode", "speed"), [(0, "jog_velocity_slow"), (1, "jog_velocity_fast")])
@pytest.mark.parametrize("key", ["JogForward", "JogBackwards"])
def test_jog_slow_and_fast(mode: int, speed: str, key: str, tmp_path: Path, form: str) -> None:
    """By the velocities of the axis; a second direction beside the first one ends the travel."""
    on = Bench(tmp_path, form, {}, it="MC_Jog")
    sign = 1.0 if key == "JogForward" else -1.0
    assert on.edge("it", 150, key, Mode=mode) == ["B", "BA"]
    assert on.axis.set_velocity == sign * getattr(on.axis, speed)
    on.set("it", JogForward=True, JogBackwards=True)
    assert on.outputs("it", 200)[-1] in ("D", "")
    assert on.axis.set_velocity == 0.0


@pytest.fixture(params=("plain",))
def form(request: pytest.FixtureRequest) -> str:
    """Machine code does the same: `test_tc2_mc2.py` runs in both forms."""
    return str(request.param)
