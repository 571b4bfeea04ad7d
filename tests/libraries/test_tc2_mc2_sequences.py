"""Commands of Tc2_MC2 one after the other: taken over, buffered, cleared, overtaken by the NC.

Outputs are written as in `test_tc2_mc2_conformance.py`.
"""

from pathlib import Path

import pytest

from achse.motion import commands
from tests.libraries.mc2 import Bench

FORM = "plain"
"""Machine code does the same: `test_tc2_mc2.py` runs in both forms."""

RUN = {"run": "MC_MoveVelocity"}


def test_a_move_takes_over_from_jog(tmp_path: Path) -> None:
    on = Bench(tmp_path, FORM, {}, it="MC_Jog", move="MC_MoveAbsolute")
    on.edge("it", 40, "JogForward", Mode=2, Velocity=30.0)
    on.set("move", Execute=True, Position=0.0, Velocity=50.0)
    assert on.outputs("it", 10)[-1] == "C"
    assert on.outputs("move", 300)[-1] == "D"


def test_a_block_that_is_not_called_meanwhile_says_so(tmp_path: Path) -> None:
    """0x4B66: the NC is at a later command already, and nobody knows how the first one ended."""
    on = Bench(tmp_path, FORM, {}, it="MC_MoveAbsolute")
    on.edge("it", 4, Position=20.0, Velocity=200.0)
    on.main["bCalls"] = False
    commands.universal_start(on.axis, 1, 5.0, 100.0)
    on.call(30)
    on.main["bCalls"] = True
    assert on.outputs("it", 3)[-1] == "E"
    assert on.main["it"]["ErrorID"] == 0x4B66


def test_a_waiting_command_that_is_taken_away(tmp_path: Path) -> None:
    """0x4B63; 0x4B62 if the one before it ends in an axis error."""
    for cleared, code in ((True, 0x4B63), (False, 0x4B62)):
        on = Bench(tmp_path, FORM, {}, it="MC_MoveAbsolute", next="MC_MoveAbsolute")
        on.edge("it", 4, Position=500.0, Velocity=50.0)
        assert on.edge("next", 4, Position=900.0, Velocity=50.0, BufferMode=1)[-1] == "B"
        if cleared:
            assert commands.clear(on.axis) == 0
        else:
            commands.set_external_error(on.axis, 0x4FF0)
        assert on.outputs("next", 10)[-1] == "E"
        assert on.main["next"]["ErrorID"] == code


def test_waiting_commands_follow_one_after_the_other(tmp_path: Path) -> None:
    on = Bench(tmp_path, FORM, {}, it="MC_MoveAbsolute", b="MC_MoveAbsolute", c="MC_MoveAbsolute")
    on.edge("it", 4, Position=20.0, Velocity=50.0)
    on.edge("b", 4, Position=40.0, Velocity=50.0, BufferMode=1)
    on.edge("c", 4, Position=60.0, Velocity=50.0, BufferMode=1)
    assert on.outputs("c", 400)[-1] == "D"
    assert (on.shown("it"), on.shown("b")) == ("D", "D")


@pytest.mark.parametrize("block", ["MC_GearOut", "MC_CamOut"])
def test_leaving_no_master_is_done(block: str, tmp_path: Path) -> None:
    """Projects begin so; there is nothing to ask the NC for."""
    on = Bench(tmp_path, FORM, {}, it=block)
    assert on.edge("it", 4) == ["B", "D"]
    assert not on.requests


@pytest.mark.parametrize("block", ["MC_Halt", "MC_Stop"])
def test_stops_with_dynamics_zero_take_those_of_the_move(block: str, tmp_path: Path) -> None:
    on = Bench(tmp_path, FORM, {}, it=block, **RUN)
    on.edge("run", 100, Velocity=50.0, Acceleration=200.0, Deceleration=100.0, Jerk=1e6)
    on.set("it", Execute=True)
    on.call(20)
    assert on.axis.set_acceleration == pytest.approx(-100.0)


@pytest.mark.parametrize("order", [("it", "b"), ("b", "it")])
def test_a_second_stop_takes_the_lock_over(order: tuple[str, str], tmp_path: Path) -> None:
    """In whichever order they are called: what the first one releases is not the other's lock."""
    on = Bench(tmp_path, FORM, {}, **dict.fromkeys(order, "MC_Stop"), move="MC_MoveAbsolute")
    assert on.edge("it", 5)[-1] == "DBA"
    on.set("it", Execute=False)
    assert on.edge("b", 5)[-1] == "DBA"
    assert on.shown("it") == ""
    assert on.axis.motion_locked
    assert on.edge("move", 5, Position=5.0, Velocity=50.0)[-1] == "E"
    on.set("b", Execute=False)
    assert on.outputs("b", 5)[-1] == ""
    assert not on.axis.motion_locked


def test_a_stop_that_another_one_replaces_says_so(tmp_path: Path) -> None:
    on = Bench(tmp_path, FORM, {}, it="MC_Stop", b="MC_Stop")
    assert on.edge("it", 5)[-1] == "DBA"
    assert on.edge("b", 5)[-1] == "DBA"
    assert on.shown("it") == "C"
    on.set("it", Execute=False)
    assert on.outputs("it", 5) == [""]
    assert on.axis.motion_locked


def test_a_stop_whose_lock_a_reset_took_does_not_hold_the_axis(tmp_path: Path) -> None:
    on = Bench(tmp_path, FORM, {}, it="MC_Stop", reset="MC_Reset", move="MC_MoveAbsolute")
    assert on.edge("it", 5)[-1] == "DBA"
    assert on.edge("reset", 5)[-1] == "D"
    assert on.shown("it") == "D"
    assert on.edge("move", 5, Position=5.0, Velocity=50.0)[-1] == "BA"
    on.set("it", Execute=False)
    assert on.outputs("it", 3) == [""]
    assert on.outputs("move", 100)[-1] == "D"


def test_a_homing_that_is_replaced_is_not_active_while_it_restores(tmp_path: Path) -> None:
    on = Bench(tmp_path, FORM, {}, it="MC_Home", move="MC_MoveRelative")
    on.edge("it", 10, Position=7.0, bCalibrationCam=True)
    assert on.shown("it") == "BA"
    on.set("move", Execute=True, Distance=5.0, Velocity=50.0)
    for _ in range(6):
        on.call()
        assert not ("A" in on.shown("it") and "A" in on.shown("move"))
    assert on.shown("it") == "C"
