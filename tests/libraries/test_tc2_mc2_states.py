"""PLCopen's state diagram, walked whole: each transition, and what each state refuses."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import commands
from tests.libraries.mc2 import Bench
from tests.plc.code.conftest import Ran

UNDEFINED, DISABLED, STANDSTILL, ERRORSTOP, STOPPING = range(5)
HOMING, DISCRETE, CONTINUOUS, SYNCHRONIZED = range(5, 9)

NAMES = (
    "undefined", "disabled", "standstill", "errorstop", "stopping",
    "homing", "discrete", "continuous", "synchronized",
)  # fmt: skip

BLOCKS = {
    "move": "MC_MoveAbsolute", "run": "MC_MoveVelocity", "halt": "MC_Halt", "stop": "MC_Stop",
    "stop2": "MC_Stop", "home2": "MC_Home",
    "home": "MC_Home", "reset": "MC_Reset", "gear": "MC_GearIn", "out": "MC_GearOut",
    "place": "MC_SetPosition", "more": "MC_MoveSuperImposed", "jog": "MC_Jog",
    "status": "MC_ReadStatus",
}  # fmt: skip

Step = Callable[[Bench], object]


class Walk:
    """X is watched; the master of its gear is Z, so that X is the slave."""

    def __init__(self, folder: Path) -> None:
        self.on = Bench(folder, "plain", {}, **BLOCKS)
        self.on.set("status", Enable=True)
        self.on.call()

    @property
    def state(self) -> str:
        for key, name in {
            "Disabled": "disabled", "StandStill": "standstill", "ErrorStop": "errorstop",
            "Stopping": "stopping", "Homing": "homing", "DiscreteMotion": "discrete",
            "ContinuousMotion": "continuous", "SynchronizedMotion": "synchronized",
        }.items():  # fmt: skip
            if self.on.main["status"][key]:
                assert NAMES[self.on.main["status"]["Status"]["MotionState"]] == name
                return name
        return "undefined"

    def do(self, *steps: Step) -> str:
        for step in steps:
            step(self.on)
        return self.state


def start(name: str, calls: int = 5, key: str = "Execute", **inputs: Any) -> Step:
    def step(on: Bench) -> None:
        on.set(name, **{key: False})
        on.call()
        on.edge(name, calls, key, **inputs)

    return step


def drop(name: str, calls: int = 5) -> Step:
    def step(on: Bench) -> None:
        on.set(name, Execute=False)
        on.call(calls)

    return step


def wait(calls: int) -> Step:
    return lambda on: on.call(calls)


def power(on_: bool) -> Step:
    def step(on: Bench) -> None:
        on.main["bOn"] = on_
        on.call(5)

    return step


def fail(on: Bench) -> None:
    assert commands.set_external_error(on.axis, 0x4FF0) == 0
    on.call(200)


def couple(on: Bench) -> None:
    """X follows Z: by the same service that MC_GearIn sends, as the bench's gear has Y."""
    assert commands.couple(on.axis, 1, 9, 0, 0, 1.0, 0.0, 0.0, 0.0) == 0
    on.call(3)


def lead(on: Bench) -> None:
    commands.universal_start(on.axis_of(9), 3, 0.0, 50.0)
    on.call(100)


def decouple(on: Bench) -> None:
    assert commands.decouple(on.axis) == 0
    on.call(3)


def may_leave(on: Bench) -> None:
    on.axis.allow_slave_motion_commands = 1
    on.call()


def leave_cam(on: Bench) -> None:
    on.set("home", bCalibrationCam=False)


MOVE = start("move", Position=300.0, Velocity=50.0)
RUN = start("run", Velocity=50.0)
HALT = start("halt", 200)
STOP = start("stop", 200)
HOME = start("home", 10, bCalibrationCam=True)
RESET = start("reset", 200)
GET: dict[str, tuple[Step, ...]] = {
    "standstill": (),
    "disabled": (power(False),),
    "errorstop": (fail,),
    "stopping": (RUN, STOP),
    "homing": (HOME,),
    "discrete": (MOVE,),
    "continuous": (RUN,),
    "synchronized": (couple,),
}
"""The way from standstill to each state."""

TRANSITIONS: tuple[tuple[str, str, tuple[Step, ...], str], ...] = (
    ("disabled", "power on", (power(True),), "standstill"),
    ("standstill", "power off", (power(False),), "disabled"),
    ("standstill", "MC_Home", (HOME,), "homing"),
    ("homing", "the end", (leave_cam, wait(800)), "standstill"),
    ("homing", "MC_Halt", (HALT,), "standstill"),
    ("homing", "MC_Stop", (STOP,), "stopping"),
    ("standstill", "MC_MoveAbsolute", (MOVE,), "discrete"),
    ("discrete", "the end", (wait(800),), "standstill"),
    ("discrete", "MC_MoveAbsolute", (MOVE,), "discrete"),
    ("discrete", "MC_MoveVelocity", (RUN,), "continuous"),
    ("discrete", "MC_Halt at once", (start("halt", 3),), "discrete"),
    ("discrete", "MC_Halt", (HALT,), "standstill"),
    ("discrete", "MC_Stop", (STOP,), "stopping"),
    ("standstill", "MC_MoveVelocity", (RUN,), "continuous"),
    ("standstill", "MC_Jog", (start("jog", 5, "JogForward", Mode=2, Velocity=20.0),), "continuous"),
    ("continuous", "MC_MoveVelocity", (RUN,), "continuous"),
    ("continuous", "MC_MoveAbsolute", (MOVE,), "discrete"),
    ("continuous", "MC_Halt", (HALT,), "standstill"),
    ("continuous", "MC_Stop", (STOP,), "stopping"),
    ("stopping", "Execute falls", (drop("stop"),), "standstill"),
    ("stopping", "MC_Stop again", (start("stop2", 200),), "stopping"),
    ("standstill", "MC_Stop", (STOP,), "stopping"),
    ("standstill", "coupled", (couple,), "synchronized"),
    ("continuous", "coupled in motion", (RUN,), "continuous"),
    ("synchronized", "uncoupled at rest", (decouple,), "standstill"),
    ("synchronized", "uncoupled in motion", (lead, decouple), "continuous"),
    ("synchronized", "a move that leaves", (may_leave, MOVE), "discrete"),
    ("synchronized", "a run that leaves", (may_leave, RUN), "continuous"),
    ("synchronized", "MC_Stop", (may_leave, STOP), "stopping"),
    *((state, "an axis error", (fail,), "errorstop") for state in GET if state != "errorstop"),
    ("errorstop", "MC_Reset", (RESET,), "standstill"),
    ("errorstop", "MC_Reset without power", (power(False), RESET), "disabled"),
    ("disabled", "an axis error, then MC_Reset", (fail, RESET), "disabled"),
    *((state, "power off", (power(False), wait(100), RESET), "disabled") for state in GET),
    ("standstill", "MC_SetPosition", (start("place", Position=7.0),), "standstill"),
    ("continuous", "MC_MoveSuperImposed", (
        wait(60), start("more", Distance=5.0, VelocityDiff=20.0, VelocityProcess=50.0, Length=50.0),
    ), "continuous"),
)  # fmt: skip

FORBIDDEN: tuple[tuple[str, str, int], ...] = (
    *(("disabled", block, 0x4260) for block in ("move", "run", "home")),
    *(("errorstop", block, 0x4FF0) for block in ("move", "run", "halt", "stop", "home")),
    *(
        ("stopping", block, NcError.AXIS_LOCKED_BY_STOP)
        for block in ("move", "run", "halt", "home")
    ),
    *(("synchronized", block, NcError.JOB_FOR_SLAVE) for block in ("move", "run", "halt")),
    ("homing", "home2", NcError.GROUP_BUSY),
    ("discrete", "home", NcError.GROUP_BUSY),
    ("continuous", "home", NcError.GROUP_BUSY),
    ("synchronized", "home", NcError.JOB_FOR_SLAVE),
)
"""State, block, ErrorID: the block shows Error, the axis stays in its state."""

INPUTS: dict[str, dict[str, Any]] = {
    "move": {"Position": 300.0, "Velocity": 50.0},
    "run": {"Velocity": 50.0},
    "home": {"bCalibrationCam": True},
}


@pytest.mark.parametrize(
    ("state", "what", "steps", "end"),
    TRANSITIONS,
    ids=[f"{row[0]}: {row[1]}" for row in TRANSITIONS],
)
def test_a_transition(
    state: str, what: str, steps: tuple[Step, ...], end: str, tmp_path: Path
) -> None:
    walk = Walk(tmp_path)
    assert walk.do(*GET[state]) == state
    assert walk.do(*steps) == end


@pytest.mark.parametrize(("state", "block", "code"), FORBIDDEN)
def test_what_a_state_refuses(state: str, block: str, code: int, tmp_path: Path) -> None:
    walk = Walk(tmp_path)
    assert walk.do(*GET[state]) == state
    if block in ("home", "run", "move") and walk.on.main[block]["Execute"]:
        walk.on.set(block, Execute=False)
        walk.on.call()
    walk.on.edge(block, 8, **INPUTS.get(block, {}))
    assert walk.on.shown(block) == "E"
    assert hex(walk.on.main[block]["ErrorID"]) == hex(code)
    assert walk.state == state


def test_every_state_has_transitions_in_and_out() -> None:
    assert {row[0] for row in TRANSITIONS} == {row[3] for row in TRANSITIONS} | {"homing"}
    assert set(GET) == set(NAMES[1:])


def test_an_axis_without_link_is_undefined(tmp_path: Path) -> None:
    on = Bench(tmp_path, "plain", {}, "unlinked", status="MC_ReadStatus")
    on.set("status", Enable=True)
    on.call()
    assert on.main["status"]["Error"]
    assert on.main["status"]["Status"]["MotionState"] == UNDEFINED


@settings(max_examples=5)
@given(value=st.integers(0, 2**32 - 1), bit=st.integers(0, 31))
def test_words_of_the_cyclic_structures_are_dwords_to_programs(value: int, bit: int) -> None:
    ran = Ran(
        "PROGRAM MAIN VAR a : AXIS_REF; d : DWORD; one, error, some : BOOL; END_VAR"
        f" a.NcToPlc.StateDWord := {value}; d := a.NcToPlc.StateDWord;"
        f" one := a.NcToPlc.StateDWord.{bit}; error := a.NcToPlc.StateDWord.Error;"
        f" a.PlcToNc.ControlDWord.{bit} := TRUE; some := a.PlcToNc.ControlDWord > 0; END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["d"], ran["one"], ran["error"]) == (value, bool(value >> bit & 1), value >> 31 == 1)
    assert ran["some"]
