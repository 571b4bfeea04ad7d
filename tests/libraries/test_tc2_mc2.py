"""Tc2_MC2: outputs of each block call by call, over the NC of the same station."""

import math
from pathlib import Path
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import StateBit
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.mc2 import FORMS, Bench


@pytest.fixture(params=FORMS)
def bench(request: pytest.FixtureRequest, tmp_path: Path) -> Any:
    """`bench(move="MC_MoveAbsolute", …)`."""
    return lambda axis={}, **blocks: Bench(tmp_path, request.param, axis, **blocks)


MOVES = (
    ("MC_MoveAbsolute", {"Position": 50.0}, 50.0),
    ("MC_MoveRelative", {"Distance": -20.0}, -20.0),
    ("MC_MoveAdditive", {"Distance": 20.0}, 20.0),
    ("MC_MoveModulo", {"Position": 90.0, "Direction": 3}, -270.0),
    ("MC_MoveModulo", {"Position": 350.0, "Direction": 2}, -10.0),
    ("MC_MoveModulo", {"Position": 90.0, "Direction": 4}, 90.0),
)


@pytest.mark.parametrize(("block", "inputs", "end"), MOVES)
def test_a_move_held(bench: Any, block: str, inputs: dict[str, float], end: float) -> None:
    """Busy in the call of the edge, Active once the NC has it, Done until Execute falls."""
    on = bench(move=block)
    assert on.edge("move", 400, Velocity=200.0, **inputs) == ["B", "BA", "D"]
    assert on.axis.set_position == pytest.approx(end)
    on.set("move", Execute=False)
    assert on.outputs("move", 2) == [""]


def test_execute_dropped_early_shows_done_for_one_call(bench: Any) -> None:
    on = bench(move="MC_MoveAbsolute")
    assert on.edge("move", 1, Position=5.0, Velocity=200.0) == ["B"]
    on.set("move", Execute=False)
    seen = []
    for _ in range(200):
        on.call()
        seen.append(on.shown("move"))
    assert seen.count("D") == 1
    assert seen[-1] == ""


def test_a_move_to_where_it_is_ends_two_calls_after_its_edge(bench: Any) -> None:
    on = bench(move="MC_MoveAbsolute")
    on.edge("move", 1, Position=0.0, Velocity=200.0)
    assert on.outputs("move", 3)[-1] == "D"


def test_edges_while_busy_are_lost(bench: Any) -> None:
    on = bench(move="MC_MoveAbsolute")
    on.edge("move", 3, Position=50.0, Velocity=200.0)
    on.set("move", Execute=False, Position=999.0)
    on.call()
    on.set("move", Execute=True)
    assert on.outputs("move", 400) == ["BA", "D"]
    assert on.axis.set_position == 50.0
    number = on.axis.command_counter
    on.set("move", Execute=False)
    on.call()
    assert on.edge("move", 2, Position=60.0)[0] == "B"
    assert on.axis.command_counter == number + 1


def test_a_second_block_aborts_the_first(bench: Any) -> None:
    on = bench(first="MC_MoveAbsolute", second="MC_MoveRelative")
    on.edge("first", 3, Position=500.0, Velocity=100.0)
    on.set("second", Distance=10.0, Velocity=100.0, Execute=True)
    assert on.outputs("first", 5) == ["BA", "C"]
    assert on.outputs("second", 300)[-1] == "D"
    on.set("first", Execute=False)
    assert on.outputs("first", 1) == [""]


def test_a_buffered_block_waits_and_the_one_before_is_done(bench: Any) -> None:
    on = bench(first="MC_MoveAbsolute", second="MC_MoveAbsolute")
    on.edge("first", 3, Position=50.0, Velocity=100.0)
    on.set("second", Position=80.0, Velocity=100.0, BufferMode=1, Execute=True)
    assert on.outputs("second", 20) == ["B"]
    assert on.outputs("first", 400)[-1] == "D"
    assert on.outputs("second", 400)[-1] == "D"
    assert on.axis.set_position == 80.0


def test_an_aborting_block_kills_the_running_and_the_waiting_one(bench: Any) -> None:
    on = bench(first="MC_MoveAbsolute", second="MC_MoveAbsolute", third="MC_MoveAbsolute")
    on.edge("first", 3, Position=500.0, Velocity=100.0)
    on.edge("second", 3, Position=800.0, Velocity=100.0, BufferMode=1)
    on.edge("third", 3, Position=5.0, Velocity=100.0)
    assert (on.shown("first"), on.shown("second"), on.shown("third")) == ("C", "C", "BA")


def test_an_axis_error_while_busy_and_the_way_out(bench: Any) -> None:
    on = bench(move="MC_MoveAbsolute", reset="MC_Reset", error="MC_ReadAxisError")
    on.set("error", Enable=True)
    on.edge("move", 3, Position=500.0, Velocity=100.0)
    on.main["bOn"] = False
    on.call(3)
    assert on.shown("move") == "E"
    code = on.main["move"]["ErrorID"]
    assert code == on.axis.error_code == on.main["error"]["AxisErrorID"] != 0
    assert on.main["power"]["Error"]
    on.main["bOn"] = True
    on.call(3)
    assert on.edge("reset", 30)[-1] == "D"
    assert on.axis.error_code == 0


def test_refusals_of_the_nc_are_the_error(bench: Any) -> None:
    on = bench(move="MC_MoveAbsolute")
    assert on.edge("move", 5, Position=5.0, Velocity=0.0) == ["B", "E"]
    assert on.main["move"]["ErrorID"] == NcError.SET_VELOCITY_NOT_ALLOWED
    on.set("move", Execute=False)
    assert on.outputs("move", 1) == [""]
    assert on.main["move"]["ErrorID"] == 0


def test_a_stop_by_another_client_is_an_error_of_the_block(bench: Any) -> None:
    from achse.motion import commands

    on = bench(move="MC_MoveAbsolute")
    on.edge("move", 5, Position=500.0, Velocity=100.0)
    assert commands.stop(on.axis) == 0
    assert on.outputs("move", 100)[-1] == "E"
    assert on.main["move"]["ErrorID"] == NcError.of(0x4B00)


def test_velocity_takes_the_place_of_done(bench: Any) -> None:
    on = bench(run="MC_MoveVelocity", halt="MC_Halt")
    assert on.edge("run", 200, Velocity=100.0, Direction=3) == ["B", "BA", "D"]
    assert on.axis.set_velocity == -100.0
    on.set("halt", Execute=True)
    assert on.outputs("run", 5) == ["D", "C"]
    assert on.outputs("halt", 200) == ["BA", "D"]
    assert on.axis.set_velocity == 0.0
    on.set("run", Execute=False)
    on.call()
    assert on.edge("run", 2, Direction=128) == ["E"]
    assert on.main["run"]["ErrorID"] == 0x4B05


def test_a_stop_locks_the_axis_until_execute_falls(bench: Any) -> None:
    on = bench(move="MC_MoveAbsolute", stop="MC_Stop", status="MC_ReadStatus")
    on.set("status", Enable=True)
    on.edge("move", 20, Position=500.0, Velocity=100.0)
    assert on.edge("stop", 200) == ["B", "BA", "DBA"]
    assert on.main["status"]["Stopping"]
    on.set("move", Execute=False)
    on.call()
    assert on.edge("move", 5)[-1] == "E"
    on.set("stop", Execute=False)
    assert on.outputs("stop", 10) == ["BA", ""]
    assert on.main["status"]["StandStill"]


def test_jog_travels_while_its_input_is_true(bench: Any) -> None:
    on = bench(jog="MC_Jog")
    assert on.edge("jog", 50, "JogForward", Mode=2, Velocity=50.0) == ["B", "BA"]
    assert on.axis.set_velocity == 50.0
    on.set("jog", JogForward=False)
    assert on.outputs("jog", 100)[-2:] == ["D", ""]
    assert on.axis.set_velocity == 0.0
    here = on.axis.set_position
    assert on.edge("jog", 300, "JogBackwards", Mode=3, Position=5.0)[-1] == "D"
    assert on.axis.set_position == pytest.approx(here - 5.0)
    on.set("jog", JogBackwards=False)
    on.call()
    on.edge("jog", 300, "JogForward", Mode=4, Position=10.0)
    assert on.axis.set_position % 10.0 == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("mode", "position", "homed"), [(4, 12.5, True), (7, 1e307, True), (8, 1e307, False)]
)
def test_homing_without_motion(bench: Any, mode: int, position: float, homed: bool) -> None:
    on = bench(home="MC_Home")
    assert on.edge("home", 10, HomingMode=mode, Position=position) == ["B", "D"]
    assert on.axis.set_position == (12.5 if mode == 4 else 0.0)
    assert bool(on.axis.state_dword & StateBit.HOMED) is homed
    on.set("home", Execute=False)
    on.call()
    assert on.edge("home", 2, HomingMode=1) == ["E"]


def test_positions_and_parameters(bench: Any) -> None:
    on = bench(
        place="MC_SetPosition", read="MC_ReadParameter", write="MC_WriteParameter",
        flag="MC_ReadBoolParameter", wflag="MC_WriteBoolParameter", actual="MC_ReadActualPosition",
    )  # fmt: skip
    on.set("actual", Enable=True)
    assert on.edge("place", 4, Position=30.0)[-1] == "D"
    on.set("place", Execute=False)
    on.call()
    assert on.edge("place", 4, Position=-5.0, Mode=True)[-1] == "D"
    on.call(5)
    assert on.main["actual"]["Position"] == pytest.approx(25.0, abs=0.1)
    assert on.edge("write", 4, ParameterNumber=1017, Value=-77.5)[-1] == "D"
    on.set("read", ParameterNumber=1017, Enable=True)
    on.call(4)
    assert (on.main["read"]["Valid"], on.main["read"]["Value"]) == (True, -77.5)
    assert on.edge("wflag", 4, ParameterNumber=1016, Value=True)[-1] == "D"
    on.set("flag", ParameterNumber=1016, Enable=True)
    on.call(4)
    assert (on.main["flag"]["Valid"], on.main["flag"]["Value"]) == (True, True)
    on.set("read", Enable=False)
    on.call()
    on.set("read", ParameterNumber=1016, Enable=True)
    on.call(4)
    assert (on.main["read"]["Valid"], on.main["read"]["Value"]) == (True, 1.0)
    on.set("flag", Enable=False)
    on.call()
    on.set("flag", ParameterNumber=1017, Enable=True)
    on.call(2)
    assert (on.main["flag"]["Error"], on.main["flag"]["ErrorID"]) == (True, 0x4B05)


@pytest.mark.parametrize("step", [1e-300, 1e-9, math.inf, math.nan, 0.0, -1.0])
def test_jog_to_multiples_of_a_step_that_has_none(bench: Any, step: float) -> None:
    on = bench(set="MC_SetPosition", jog="MC_Jog")
    on.edge("set", 4, Position=100.0)
    assert on.edge("jog", 3, "JogForward", Mode=4, Position=step, Velocity=10.0) == ["E"]
    assert on.main["jog"]["ErrorID"] == 0x4B06


@pytest.mark.parametrize("ratio", [0.0, -0.7, 0.5])
@pytest.mark.parametrize("acceleration", [0.0, 300.0])
def test_a_gear_of_any_ratio_changes_within_its_acceleration(
    bench: Any, ratio: float, acceleration: float
) -> None:
    """At the largest velocity of the master; acceleration 0 is that of the slave."""
    on = bench(gear="MC_GearInDyn", run="MC_MoveVelocity")
    on.edge("gear", 10, "Enable", GearRatio=ratio, Acceleration=acceleration)
    assert on.shown("gear") == "DB"
    slave = on.axis_of(7)
    most = (acceleration or slave.default_acceleration) / on.axis.max_velocity
    assert slave.coupling.parameters[0] == pytest.approx(most)
    on.call(600)
    on.edge("run", 150, Velocity=20.0)
    assert slave.set_velocity == pytest.approx(20.0 * ratio)


@pytest.mark.parametrize("acceleration", [-1.0, math.nan, math.inf, 1e308])
def test_a_gear_refuses_an_acceleration_that_is_none(bench: Any, acceleration: float) -> None:
    on = bench(gear="MC_GearInDyn")
    assert on.edge("gear", 9, "Enable", GearRatio=1.0, Acceleration=acceleration) == ["E"]
    assert on.main["gear"]["ErrorID"] == 0x4B06


def test_gears(bench: Any) -> None:
    on = bench(gear="MC_GearIn", out="MC_GearOut", move="MC_MoveAbsolute")
    assert on.edge("gear", 10, RatioNumerator=3.0, RatioDenominator=2) == ["BA", "D"]
    on.edge("move", 300, Position=20.0, Velocity=100.0)
    assert on.station.nc is not None
    assert on.station.nc.axis(7).set_position == pytest.approx(30.0)
    assert on.edge("out", 10)[-1] == "D"
    assert on.outputs("gear", 1) == ["C"]
    on.set("gear", Execute=False)
    on.call()
    assert on.edge("gear", 1, RatioDenominator=0) == ["E"]


def test_power_and_override(bench: Any) -> None:
    on = bench(override="MC_SetOverride")
    on.edge("override", 2, "Enable", VelFactor=0.25)
    assert on.axis.velocity_override == 250_000
    on.set("override", Enable=False)
    on.set("power", Override=101.0)
    on.call(2)
    assert on.main["power"]["ErrorID"] == 0x4B06
    on.main["bOn"] = False
    on.call(3)
    assert on.axis.control_dword == 0
    assert on.shown("power") in ("", "E")


def test_the_mode_of_the_drive_is_written_and_read(bench: Any) -> None:
    on = bench(write="MC_WriteDriveOperationMode", read="MC_ReadDriveOperationMode")
    for mode in (0, 4, 2, 0):
        assert on.edge("write", 6, DriveOperationMode=mode)[-1] == "D"
        assert on.edge("read", 6)[-1] == "D"
        assert on.main["read"]["DriveOperationMode"] == mode
        for block in ("write", "read"):
            on.set(block, Execute=False)
        on.call(20)


def test_an_axis_that_no_link_leads_to(tmp_path: Path) -> None:
    text = (
        "PROGRAM MAIN VAR a : AXIS_REF; m : MC_MoveAbsolute; END_VAR"
        " m(Axis := a, Execute := TRUE); END_PROGRAM"
    )
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=tmp_path)
    station.advance(0.05)
    main: Any = station.plcs[851].instance("MAIN")
    assert (main["m"]["Error"], main["m"]["ErrorID"]) == (True, 0x4B06)


def test_sizes_and_places(tmp_path: Path) -> None:
    text = (
        "PROGRAM MAIN VAR a : AXIS_REF; n : ARRAY [0..9] OF UDINT; END_VAR n[0] := SIZEOF(a);"
        " n[1] := SIZEOF(a.NcToPlc); n[2] := SIZEOF(a.PlcToNc); n[3] := SIZEOF(a.Status);"
        " n[4] := SIZEOF(a.ADS); n[5] := SIZEOF(a.DriveAddress); n[6] := SIZEOF(a.Status.OpMode);"
        " END_PROGRAM"
    )
    (tmp_path / "a.st").write_text(text, encoding="utf-8")
    station = Station(parse({"plc": [{"sources": "a.st"}]}, "a.toml"), base=tmp_path)
    station.advance(0.02)
    main: Any = station.plcs[851].instance("MAIN")
    assert list(main["n"])[:7] == [1136, 256, 128, 96, 28, 84, 17]
