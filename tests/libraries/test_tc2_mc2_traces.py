"""The same motion by blocks and by services of the NC, equal bit by bit; and what blocks read."""

import math
import struct
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from achse.ams import Frame
from achse.motion import Nc, StateBit, commands
from achse.motion.states import ProbeMode
from tests.libraries.mc2 import FORMS, Bench

NC_CYCLE = 0.002
START = "<II5dI4x3d"
"""Universal start, 0x16: 80 bytes."""
COUPLE = "<4I4d"

F_X, F_Y = 0x4201, 0x4207


def start(kind: int, place: float, velocity: float, *more: float) -> bytes:
    """Acceleration, deceleration, jerk, buffer mode, blending position, end velocity."""
    dynamics, (mode, blending, end) = more[:3], more[3:]
    return struct.pack(START, kind, 0, place, velocity, *dynamics, int(mode), blending, 0.0, end)


Row = tuple[float, ...]
Given = tuple[int, str, dict[str, Any]]
Sent = tuple[int, int, bytes]

MOTIONS: dict[str, tuple[Sequence[Given], Sequence[Sent]]] = {
    "absolute": (
        [(0, "move", {"Position": 50.0, "Velocity": 80.0, "Jerk": 9e3})],
        [(F_X, 0x16, start(1, 50.0, 80.0, 0, 0, 9e3, 0, 0, 0))],
    ),
    "relative, then absolute before it ends": (
        [
            (0, "way", {"Distance": -50.0, "Velocity": 80.0, "Acceleration": 300.0}),
            (30, "move", {"Position": 20.0, "Velocity": 120.0}),
        ],
        [
            (F_X, 0x16, start(2, -50.0, 80.0, 300.0, 0, 0, 0, 0, 0)),
            (F_X, 0x16, start(1, 20.0, 120.0, 0, 0, 0, 0, 0, 0)),
        ],
    ),
    "blended": (
        [
            (0, "move", {"Position": 50.0, "Velocity": 80.0}),
            (5, "way", {"Distance": 30.0, "Velocity": 40.0, "BufferMode": 20}),
        ],
        [
            (F_X, 0x16, start(1, 50.0, 80.0, 0, 0, 0, 0, 0, 0)),
            (F_X, 0x16, start(2, 30.0, 40.0, 0, 0, 0, 20, 0, 0)),
        ],
    ),
    "endless, then halt": (
        [
            (0, "run", {"Velocity": 60.0, "Direction": 3}),
            (60, "halt", {"Deceleration": 400.0}),
        ],
        [
            (F_X, 0x16, start(4, 0.0, 60.0, 0, 0, 0, 0, 0, 0)),
            (F_X, 0x16, start(8192, 0.0, 0.0, 0, 400.0, 0, 0, 0, 0)),
        ],
    ),
    "modulo": (
        [(0, "turn", {"Position": 90.0, "Velocity": 200.0, "Direction": 3})],
        [(F_X, 0x16, start(773, 90.0, 200.0, 0, 0, 0, 0, 0, 0))],
    ),
    "gear": (
        [
            (0, "gear", {"RatioNumerator": 3.0, "RatioDenominator": 2}),
            (5, "move", {"Position": 40.0, "Velocity": 80.0}),
        ],
        [
            (F_Y, 0x40, struct.pack(COUPLE, 1, 1, 0, 0, 1.5, 0.0, 0.0, 0.0)),
            (F_X, 0x16, start(1, 40.0, 80.0, 0, 0, 0, 0, 0, 0)),
        ],
    ),
}

BLOCKS = {
    "move": "MC_MoveAbsolute", "way": "MC_MoveRelative", "run": "MC_MoveVelocity",
    "halt": "MC_Halt", "turn": "MC_MoveModulo", "gear": "MC_GearIn",
}  # fmt: skip


def _values(on: Bench) -> Row:
    return tuple(
        value
        for axis in (on.axis, on.axis_of(7))
        for value in (
            axis.set_position,
            axis.set_velocity,
            axis.set_acceleration,
            axis.actual_position,
        )
    )


def _trace(on: Bench, cycles: int, step: Callable[[int], None]) -> list[Row]:
    rows = []
    for cycle in range(cycles):
        step(cycle)
        on.station.advance(NC_CYCLE)
        rows.append(_values(on))
    return rows


def _note(at: list[int], nc: Nc, frame: Frame) -> None:
    """The cycle in which a request passes."""
    if not frame.flags & 1:
        at.append(nc.cycle_count)


@pytest.mark.parametrize("name", MOTIONS)
def test_blocks_and_services_move_alike(name: str, tmp_path: Path, client_of: Any) -> None:
    calls, sent = MOTIONS[name]
    traces = []
    for form in FORMS:
        (tmp_path / form).mkdir()
        on = Bench(tmp_path / form, form, {}, **BLOCKS)
        nc = on.station.nc
        assert nc is not None
        at: list[int] = []
        on.station.router.put_watcher(partial(_note, at, nc))

        def press(cycle: int, on: Bench = on) -> None:
            for call, block, inputs in calls:
                if cycle == 5 * call:
                    on.set(block, Execute=True, **inputs)

        traces.append(_trace(on, 800, press))
        assert len(at) == len(sent)
    assert traces[0][-1] != traces[0][0]
    (tmp_path / "services").mkdir()
    on = Bench(tmp_path / "services", "plain", {})
    nc = on.station.nc
    assert nc is not None
    client = client_of(on.station.router, 501)
    waiting = list(zip(at, sent, strict=True))

    def send(cycle: int) -> None:
        while waiting and waiting[0][0] == nc.cycle_count:
            group, offset, data = waiting.pop(0)[1]
            if offset == 0x16:
                client.exchange(group, offset, 4, data)
            else:
                client.write(group, offset, data)

    assert _trace(on, 800, send) == traces[-1] == traces[0]


def test_the_parameter_set_and_the_address(tmp_path: Path) -> None:
    on = Bench(
        tmp_path, "plain", {}, all="MC_ReadParameterSet", drive="MC_ReadDriveAddress",
        parts="MC_ReadAxisComponents",
    )  # fmt: skip
    on.axis.default_jerk = 4321.0
    for block in ("all", "drive", "parts"):
        assert on.edge(block, 4)[-1] == "D"
    shown = on.main["parameters"]
    assert (shown["AxisId"], shown["sAxisName"], shown["fJerk"]) == (1, "X", 4321.0)
    assert shown["fVeloMaximum"] == on.axis.max_velocity
    assert shown["fEncScaleFactorNumerator"] == on.axis.encoder.scaling_numerator
    address = on.main["drive"]["DriveAddress"]
    assert (address["NetID"], address["NcAxisId"], address["NcDriveId"]) == ("0.0.0.0.0.0", 1, 1)
    assert on.main["X"]["DriveAddress"]["NcEncoderId"] == 1
    assert on.main["components"]["DriveId"] == 1


@pytest.mark.parametrize(
    ("number", "value"),
    [
        (1024, 0.75), (1104, 55.0), (1084, 0.1), (1092, 0.02), (1003, 700.0), (1066, None),
        (2003, None), (4000, None),
    ],
)  # fmt: skip
def test_parameters_by_number(number: int, value: float | None, tmp_path: Path) -> None:
    """Those that symbol files name without an offset, and those of the drive, are reached too."""
    on = Bench(tmp_path, "plain", {}, put="MC_WriteParameter", get="MC_ReadParameter")
    if value is not None:
        assert on.edge("put", 4, ParameterNumber=number, Value=value)[-1] == "D"
    on.set("get", ParameterNumber=number, Enable=True)
    on.call(4)
    assert on.main["get"]["Valid"], hex(on.main["get"]["ErrorID"])
    assert value is None or on.main["get"]["Value"] == value


def test_the_gear_ratio_is_a_parameter_of_the_slave(tmp_path: Path) -> None:
    on = Bench(tmp_path, "plain", {}, put="MC_WriteParameter", get="MC_ReadParameter")
    assert commands.couple(on.axis, 1, 7, 0, 0, 1.0, 0.0, 0.0, 0.0) == 0
    assert on.edge("put", 4, ParameterNumber=3000, Value=2.5)[-1] == "D"
    on.set("get", ParameterNumber=3000, Enable=True)
    on.call(4)
    assert on.main["get"]["Value"] == 2.5


def probe(on: Bench, number: int, high: bool) -> None:
    """The input of a touch probe."""
    bit = 1 << number - 1
    io = on.axis.drive.io
    io.state8 = io.state8 | bit if high else io.state8 & ~bit


def test_continuous_probes_count_edges(tmp_path: Path) -> None:
    """A PLC event: each edge is Done for one call, until the probe is aborted."""
    on = Bench(tmp_path, "plain", {}, it="MC_TouchProbe", end="MC_AbortTrigger")
    on.main["trigger"]["TouchProbe"] = 10
    on.main["trigger"]["Mode"] = ProbeMode.CONTINUOUS
    on.edge("it", 2)
    seen = []
    for n in range(8):
        on.main["trigger"]["PlcEvent"] = n % 2 == 0
        on.call()
        seen.append(on.shown("it"))
    assert seen.count("DB") == 4
    assert on.main["it"]["RecordedData"]["Counter"] == 4.0
    assert not on.requests
    on.set("end", Execute=True)
    assert on.outputs("it", 4)[-1] == "C"


@pytest.mark.parametrize("edge", [0, 1])
def test_a_plc_event_within_a_window(edge: int, tmp_path: Path) -> None:
    on = Bench(tmp_path, "plain", {}, it="MC_TouchProbe", run="MC_MoveVelocity")
    on.main["trigger"]["TouchProbe"] = 10
    on.main["trigger"]["Edge"] = edge
    on.main["trigger"]["Mode"] = ProbeMode.SINGLE
    on.edge("run", 60, Velocity=50.0)
    on.edge("it", 2, WindowOnly=True, FirstPosition=60.0, LastPosition=80.0)
    recorded = None
    for n in range(200):
        on.main["trigger"]["PlcEvent"] = n % 4 < 2
        on.call()
        if on.shown("it") == "D":
            recorded = on.main["it"]["RecordedPosition"]
            break
    assert recorded is not None
    assert 60.0 <= recorded <= 80.0


def test_the_position_correction_comes_by_steps(tmp_path: Path) -> None:
    """FAST: acceleration · T² per call; 0.25 by 500 · (0.01 s)² = 0.05 takes five calls."""
    on = Bench(tmp_path, "plain", {}, it="MC_PositionCorrectionLimiter")
    on.set("it", Enable=True, PositionCorrectionValue=0.25, CorrectionMode=1, Acceleration=500.0)
    on.call()
    assert (on.main["it"]["Error"], on.main["it"]["ErrorID"]) == (True, 0x4B04)
    on.axis.encoder.actual_position_correction_enable = 1
    on.call()
    limiting = []
    for _ in range(6):
        on.call()
        limiting.append(on.main["it"]["Limiting"])
    assert limiting[-2:] == [False, False]
    assert on.main["X"]["PlcToNc"]["PositionCorrection"] == 0.25
    on.call(2)
    assert on.axis.encoder.position_correction == pytest.approx(0.25)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    ("block", "key"),
    [
        ("MC_PositionCorrectionLimiter", "PositionCorrectionValue"),
        ("MC_BacklashCompensation", "Backlash"),
    ],
)
def test_a_correction_that_is_no_number_is_refused_and_forgotten(
    block: str, key: str, value: float, tmp_path: Path
) -> None:
    """The PLC runs on, and the next number acts. An infinite backlash is that of the axis."""
    on = Bench(tmp_path, "plain", {}, it=block)
    on.axis.encoder.actual_position_correction_enable = 1
    on.set("it", Enable=True, **{key: 0.0})
    on.call(4)
    on.set("it", **{key: value})
    on.call(3)
    if (block, value) != ("MC_BacklashCompensation", math.inf):
        assert (on.main["it"]["Error"], on.main["it"]["ErrorID"]) == (True, 0x4B06)
    assert on.main["X"]["PlcToNc"]["PositionCorrection"] == 0.0
    on.set("it", Enable=False)
    on.call()
    on.set("it", Enable=True, **{key: 0.25})
    on.call(3)
    assert not on.main["it"]["Error"]
    assert on.main["X"]["PlcToNc"]["PositionCorrection"] in (0.0, 0.25)


def test_backlash_follows_the_direction(tmp_path: Path) -> None:
    on = Bench(tmp_path, "plain", {}, it="MC_BacklashCompensation", run="MC_MoveVelocity")
    on.axis.encoder.actual_position_correction_enable = 1
    on.axis.backlash = 0.4
    on.call()
    on.set("it", Enable=True, CompensationInPositiveDirection=True, Ramp=10.0)
    on.call(4)
    assert on.main["it"]["Enabled"]
    on.edge("run", 20, Velocity=20.0)
    assert on.main["it"]["CurrentBacklash"] == pytest.approx(0.4)  # as configured
    on.set("run", Execute=False)
    on.call()
    on.edge("run", 80, Velocity=20.0, Direction=3)
    assert on.main["it"]["CurrentBacklash"] == 0.0
    on.set("it", Enable=False, DisableMode=1)
    on.call()
    assert not on.main["it"]["Busy"]


def test_external_set_points_move_the_axis(tmp_path: Path) -> None:
    on = Bench(tmp_path, "plain", {}, on="MC_ExtSetPointGenEnable", off="MC_ExtSetPointGenDisable")
    assert on.edge("on", 4)[-1] == "D"
    assert on.main["on"]["Enabled"]
    for n in range(100):
        on.main["X"]["PlcToNc"]["ExtSetPos"] = 0.01 * n * n / 100
        on.main["X"]["PlcToNc"]["ExtSetVelo"] = 0.02 * n
        on.main["X"]["PlcToNc"]["ExtSetDirection"] = 1
        on.call()
    on.main["X"]["PlcToNc"]["ExtSetVelo"] = 0.0
    on.call(2)
    assert on.axis.set_position == pytest.approx(0.9801)
    assert on.edge("off", 30)[-1] == "D"
    assert not on.main["off"]["Enabled"]


def test_homing_with_options_writes_parameters_and_restores_the_position(tmp_path: Path) -> None:
    on = Bench(tmp_path, "plain", {}, home="MC_Home")
    on.axis.encoder.reference_position = 3.0
    on.set("home", Options__SearchVelocity=20.0, Options__SyncVelocity=5.0)
    on.set("home", Options__SearchDirection=3, Options__SyncDirection=1, Position=12.0)
    on.edge("home", 40, bCalibrationCam=True)
    assert on.shown("home") == "BA"
    assert (on.axis.homing_velocity_towards_cam, on.axis.homing_velocity_off_cam) == (20.0, 5.0)
    assert (on.axis.encoder.homing_cam_search_inverse, on.axis.encoder.reference_position) == (
        1,
        12,
    )
    on.set("home", bCalibrationCam=False)
    assert on.outputs("home", 600)[-1] == "D"
    assert on.axis.encoder.reference_position == 3.0
    assert on.axis.set_position == pytest.approx(12.0, abs=1.0)


def test_cams_of_the_plc_lead_the_slave(tmp_path: Path) -> None:
    on = Bench(
        tmp_path, "plain", {}, table="MC_CamTableSelect", cam="MC_CamIn", move="MC_MoveAbsolute",
        look="MC_ReadCamTableSlaveDynamics",
    )  # fmt: skip
    assert on.edge("table", 9, CamTableID=3, Periodic=True)[-1] == "D"
    assert on.edge("look", 4, CamTableID=3, MasterPosition=45.0)[-1] == "D"
    assert on.main["look"]["SlavePosition"] == 15.0
    assert on.edge("cam", 4, CamTableID=3, SlaveScaling=2.0)[-1] == "D"
    assert on.edge("move", 300, Position=135.0, Velocity=100.0)[-1] == "D"
    assert on.axis_of(7).set_position == pytest.approx(80.0)


def test_several_masters_add_up(tmp_path: Path) -> None:
    on = Bench(tmp_path, "plain", {}, gear="MC_GearInMultiMaster", move="MC_MoveAbsolute")
    on.set("gear", GearRatio1=2.0, GearRatio2=-1.0, Acceleration=5000.0, Deceleration=5000.0)
    on.set("gear", Options__AdvancedSlaveDynamics=True)
    assert on.edge("gear", 4, "Enable")[-1] == "DB"
    commands.universal_start(on.axis_of(9), 1, 10.0, 20.0)
    assert on.edge("move", 400, Position=30.0, Velocity=20.0)[-1] == "D"
    assert on.axis_of(7).set_position == pytest.approx(50.0)


def test_homing_in_steps_to_a_switch(tmp_path: Path) -> None:
    """The place of the switch is SetPosition afterwards; the end of the sequence sets the flag."""
    declared = {"step": "MC_StepAbsoluteSwitch", "finish": "MC_FinishHoming"}
    on = Bench(tmp_path, "plain", {}, **declared)
    on.edge("step", 20, Velocity=20.0, Direction=3, SetPosition=7.0)
    assert on.shown("step") == "BA"
    on.main["step"]["ReferenceSignal"]["Level"] = True
    assert on.outputs("step", 100)[-1] == "D"
    assert on.axis.set_position < 7.0
    assert on.axis.set_position == pytest.approx(7.0, abs=3.0)
    assert not on.axis.state_dword & StateBit.HOMED
    assert on.edge("finish", 200, Distance=-3.0, Velocity=20.0)[-1] == "D"
    assert on.axis.state_dword & StateBit.HOMED
    on.set("step", Execute=False)
    on.call()
    on.main["step"]["ReferenceSignal"]["Level"] = False
    on.edge("step", 100, Velocity=20.0, Direction=1, DistanceLimit=5.0)
    assert (on.shown("step"), on.main["step"]["ErrorID"]) == ("E", 0x4B0A)


def test_places_of_masters_that_are_not_used(tmp_path: Path) -> None:
    """A project fills them with the slave itself or a master before, at ratio 0."""
    text = "{name}(Master1 := X, Master2 := Z, Master3 := Y, Master4 := X, Slave := Y);"
    on = Bench(tmp_path, "plain", {}, gear=f"MC_GearInMultiMaster @ {text}")
    on.set("gear", GearRatio3=0.0, GearRatio4=0.0, Acceleration=1000.0)
    assert on.edge("gear", 4, "Enable")[-1] == "DB"
