"""Invariants of motion: plain steps pass, each kind of wrong step is named."""

import random
from math import nan

import pytest

from achse.codes.nc.choices import MotionPhase
from achse.swarm.motion.checks import CHECKS, NAMES, describe
from achse.swarm.motion.step import STEP, MotionStep, set_limits

DT = 0.002


def fresh() -> MotionStep:
    fresh: MotionStep = STEP.plain()
    set_limits(fresh, 100.0, 500.0, 700.0, 9000.0, 1.0)
    return fresh


def drawn_step(seed: int) -> MotionStep:
    """A step of a move, within all limits."""
    dice = random.Random(seed)
    step = fresh()
    step.dt, step.speed, step.smooth = DT, 110.0, True
    step.phase = step.phase0 = MotionPhase.POSITIONING
    jerk = dice.uniform(-9000.0, 9000.0)
    step.p0, step.v0, step.a0 = (
        dice.uniform(-9.0, 9.0),
        dice.uniform(-50.0, 50.0),
        dice.uniform(-400.0, 400.0),
    )
    step.a1 = step.a0 + jerk * DT
    step.v1 = step.v0 + step.a0 * DT + 0.5 * jerk * DT**2
    step.p1 = step.p0 + step.v0 * DT + 0.5 * step.a0 * DT**2 + jerk * DT**3 / 6.0
    return step


def broken(step: MotionStep) -> set[str]:
    return {name for name, check in zip(NAMES, CHECKS, strict=True) if check(step)}


@pytest.mark.parametrize("seed", range(20))
def test_step_of_a_move_is_within_all(seed: int) -> None:
    assert broken(drawn_step(seed)) == set()


@pytest.mark.parametrize("seed", range(20))
def test_each_kind_of_wrong_step_is_named(seed: int) -> None:
    step = drawn_step(seed)
    step.p1 += 0.01
    assert "position" in broken(step)
    step = drawn_step(seed)
    step.v1 = 101.0
    assert "velocity" in broken(step)
    step = drawn_step(seed)
    step.a1 = 1000.0
    assert {"acceleration", "jerk"} & broken(step) == {"acceleration", "jerk"}
    step = drawn_step(seed)
    step.v1 = nan
    assert "finite" in broken(step)


@pytest.mark.parametrize("part", [0.0, 0.17, 0.83, 1.0])
@pytest.mark.parametrize("change", [-0.577, 0.3])
@pytest.mark.parametrize("coupled", [True, False])
def test_slave_of_a_gear_changes_its_velocity_anywhere_in_the_cycle(
    part: float, change: float, coupled: bool
) -> None:
    """Its master needs only a part of the cycle to accelerate."""
    step = drawn_step(1)
    step.coupled, step.law, step.a0, step.a1 = coupled, 1, 0.0, 0.0
    step.p0, step.v0, step.v1 = 0.003, 0.0, change
    step.p1 = step.p0 + part * change * DT
    assert ("position" in broken(step)) is not coupled
    step.p1 = step.p0 + 1.1 * change * DT
    assert "position" in broken(step)


def test_stop_that_accelerates_is_named() -> None:
    step = drawn_step(1)
    step.phase = step.phase0 = MotionPhase.STOPPING
    step.v0, step.v1, step.a0, step.a1 = 10.0, 10.1, 0.0, 5.0
    assert "stop" in broken(step)
    step.smooth = False
    assert "stop" not in broken(step)


def test_axis_at_rest_that_moves_is_named() -> None:
    step = fresh()
    step.dt, step.smooth, step.p1 = DT, True, 1e-6
    assert "rest" in broken(step)
    step.commanded = True
    assert "rest" not in broken(step)


def test_slaves_are_held_to_their_law() -> None:
    step = drawn_step(2)
    step.coupled = step.abrupt = True
    step.law, step.gear, step.gear0 = 1, 2.0, 2.0
    step.master, step.leading_speed = (step.p1 - step.p0) / 2.0, step.v1 / 2.0
    assert "gear-law" not in broken(step)
    step.leading_speed *= 1.01
    assert "gear-law" in broken(step)
    step.leading_speed, step.master = step.v1 / 2.0, 1.01 * step.master
    assert "gear-law" in broken(step)
    step.gear0 = nan  # the first cycle of the coupling
    assert "gear-law" not in broken(step)
    step.law, step.p1 = 10, step.p0 + 2 * 110.0 * DT
    assert "slave-step" in broken(step)


def test_new_ratio_counts_from_its_cycle() -> None:
    step = drawn_step(2)
    step.coupled = step.abrupt = True
    step.law, step.gear0, step.gear = 1, 2.0, 3.0
    step.master, step.leading_speed = (step.p1 - step.p0) / 3.0, step.v1 / 3.0
    assert "gear-law" not in broken(step)
    step.master = (step.p1 - step.p0) / 2.0
    assert "gear-law" in broken(step)


@pytest.mark.parametrize("law", [0, 1])
def test_step_is_described_with_what_it_is_judged_by(law: int) -> None:
    step = drawn_step(3)
    step.coupled, step.law, step.gear = int(law > 0), law, 2.5
    text = describe(step)
    assert f"velocity {step.v0} -> {step.v1}, " in text
    assert ("2.5 times master" in text) is (law == 1)
