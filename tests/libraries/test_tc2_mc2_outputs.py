"""Blocks of Tc2_MC2 on one axis, at random: what PLCopen says of their outputs holds in each call.

At most one of Done, CommandAborted and Error; Active only while Busy; an ErrorID only with Error;
no edge, result or command is lost; at most one block has the axis. MC_Stop has Busy, Active and
Done while it holds the axis. Letters are those of `tests/libraries/mc2.py`.
"""

import random
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from achse.motion import commands
from tests.libraries.mc2 import Bench

MOVES = {
    "a": "MC_MoveAbsolute", "b": "MC_MoveAbsolute", "relative": "MC_MoveRelative",
    "additive": "MC_MoveAdditive", "modulo": "MC_MoveModulo", "run": "MC_MoveVelocity",
    "on": "MC_MoveContinuousAbsolute", "onward": "MC_MoveContinuousRelative", "halt": "MC_Halt",
    "stop": "MC_Stop", "stop2": "MC_Stop", "home": "MC_Home", "torque": "MC_TorqueControl",
}  # fmt: skip
"""Commands of which at most one has the axis."""

OTHERS = {
    "reset": "MC_Reset", "place": "MC_SetPosition", "more": "MC_MoveSuperImposed",
    "less": "MC_AbortSuperposition", "gear": "MC_GearIn", "leave": "MC_GearOut",
    "phase": "MC_PhasingAbsolute",
}  # fmt: skip
ENDLESS = {"run", "on", "onward", "torque", "gear"}
"""Their result is a state that may end while Execute stays."""

MODES = (0, 0, 0, 1, 1, 18, 19, 20, 21)


def drawn_inputs(dice: random.Random, name: str) -> Mapping[str, Any]:
    """Return inputs for a rising edge of a block, good ones and bad ones."""
    inputs: dict[str, Any] = {
        "Position": dice.choice((0.0, dice.uniform(-50.0, 50.0), dice.uniform(0.0, 359.0))),
        "Distance": dice.choice((0.0, dice.uniform(-50.0, 50.0), dice.uniform(-2.0, 2.0))),
        "Velocity": dice.choice((10.0, dice.uniform(5.0, 200.0), 0.0)),
        "EndVelocity": dice.choice((0.0, dice.uniform(0.0, 60.0))),
        "Deceleration": dice.choice((0.0, 0.0, dice.uniform(50.0, 2000.0))),
        "Jerk": dice.choice((0.0, 0.0, dice.uniform(500.0, 20_000.0))),
        "BufferMode": dice.choice(MODES) if name != "home" else 0,
        "Direction": dice.choice((1, 1, 3, 4, 2)),
        "Mode": dice.randrange(1, 5) if name == "more" else dice.random() < 0.5,
        "HomingMode": dice.choice((0, 0, 4, 7, 8)),
        "bCalibrationCam": dice.random() < 0.5,
        "VelocityDiff": dice.uniform(1.0, 50.0),
        "VelocityProcess": dice.choice((50.0, 100.0)),
        "Length": dice.uniform(10.0, 50.0),
        "RatioNumerator": dice.choice((1.0, -1.0, 0.5)),
        "RatioDenominator": dice.choice((1, 1, 2, 0)),
        "PhaseShift": dice.uniform(-10.0, 10.0),
        "Torque": dice.uniform(-100.0, 100.0),
        "TorqueRamp": 1000.0,
        "VelocityLimitHigh": 100.0,
        "VelocityLimitLow": -100.0,
    }
    if name == "more":
        inputs |= {
            "Distance": dice.uniform(-5.0, 5.0),
            "Acceleration": 500.0,
            "Deceleration": 500.0,
        }
    return inputs


def act(on: Bench, dice: random.Random, levels: dict[str, bool]) -> None:
    """Give an edge to a block, or change what is around the blocks."""
    if dice.random() < 0.95:
        name = dice.choice(list(levels))
        levels[name] = not levels[name]
        inputs = drawn_inputs(dice, name) if levels[name] else {}
        names = dir(on.main[name])
        on.set(name, Execute=levels[name], **{k: v for k, v in inputs.items() if k in names})
        return
    match dice.randrange(4):
        case 0:
            on.main["bOn"] = not on.main["bOn"]
        case 1:
            commands.set_external_error(on.axis, 0x4FFF)
        case _:
            on.main["power"]["Override"] = dice.choice((0.0, 50.0, 100.0, 100.0))


def wrong_outputs(on: Bench, name: str, before: str, level: bool, rises: bool) -> str:
    """Return what is wrong with the outputs of a block behind those of its last call."""
    now, error = on.shown(name), on.main[name]["ErrorID"]
    result, last = set(now) & set("DCE"), set(before) & set("DCE")
    holds = name in ("stop", "stop2")
    if len(result) > 1 or (result and "B" in now and not (holds and now == "DBA")):
        return "two results"
    if ("A" in now and "B" not in now) or (error != 0) != ("E" in now):
        return "Active without Busy, or ErrorID without Error"
    if "B" in before:
        return "no result" if not now and not holds else ""
    if last and level and not rises and now != before:
        return "" if name in ENDLESS and result <= set("CE") and result else "result changes"
    if not level and now:
        return "result without Execute"
    return "edge is lost" if rises and not now else ""


@pytest.mark.parametrize("seed", range(3))
def test_outputs_of_drawn_blocks(seed: int, tmp_path: Path, many: Callable[[int], int]) -> None:
    dice = random.Random(seed)
    on = Bench(tmp_path, "plain", {}, **MOVES, **OTHERS)
    levels = dict.fromkeys(dice.sample([*MOVES, *OTHERS], 10), False)
    levels |= dict.fromkeys(("stop", "stop2"), False)
    free = 0
    seen, was = dict.fromkeys(levels, ""), dict(levels)
    for call in range(many(300)):
        if dice.random() < 0.3:
            act(on, dice, levels)
        on.call()
        for name, level in levels.items():
            wrong = wrong_outputs(on, name, seen[name], level, level and not was[name])
            assert not wrong, (call, name, seen[name], on.shown(name), wrong)
            seen[name] = on.shown(name)
        was = dict(levels)
        active = [name for name in MOVES if "A" in on.shown(name)]
        assert len(active) < 2, (call, active)
        if any(on.shown(name) == "DBA" for name in ("stop", "stop2")) > on.axis.motion_locked:
            free += 1  # it sees a reset in its next call
        else:
            free = 0
        assert free < 2, call
