"""Invariants of motion: plain steps pass, each kind of wrong step is named."""

import random
from math import nan

import pytest

from achse.codes.nc.choices import MotionPhase
from achse.swarm.motion.checks import CHECKS, NAMES, describe
from achse.swarm.motion.step import STEP, MotionStep, set_limits

DT = 0.002


def fresh() -> MotionStep:
    made: MotionStep = STEP.plain()
    set_limits(made, 100.0, 500.0, 700.0, 9000.0, 1.0)
    return made


def step(seed: int) -> MotionStep:
    """A step of a move, within all limits."""
    dice = random.Random(seed)
    made = fresh()
    made.dt, made.speed, made.smooth = DT, 110.0, True
    made.phase = made.phase0 = MotionPhase.POSITIONING
    jerk = dice.uniform(-9000.0, 9000.0)
    made.p0, made.v0, made.a0 = (
        dice.uniform(-9.0, 9.0),
        dice.uniform(-50.0, 50.0),
        dice.uniform(-400.0, 400.0),
    )
    made.a1 = made.a0 + jerk * DT
    made.v1 = made.v0 + made.a0 * DT + 0.5 * jerk * DT**2
    made.p1 = made.p0 + made.v0 * DT + 0.5 * made.a0 * DT**2 + jerk * DT**3 / 6.0
    return made


def broken(made: MotionStep) -> set[str]:
    return {name for name, check in zip(NAMES, CHECKS, strict=True) if check(made)}


@pytest.mark.parametrize("seed", range(20))
def test_step_of_a_move_is_within_all(seed: int) -> None:
    assert broken(step(seed)) == set()


@pytest.mark.parametrize("seed", range(20))
def test_each_kind_of_wrong_step_is_named(seed: int) -> None:
    made = step(seed)
    made.p1 += 0.01
    assert "position" in broken(made)
    made = step(seed)
    made.v1 = 101.0
    assert "velocity" in broken(made)
    made = step(seed)
    made.a1 = 1000.0
    assert {"acceleration", "jerk"} & broken(made) == {"acceleration", "jerk"}
    made = step(seed)
    made.v1 = nan
    assert "finite" in broken(made)


@pytest.mark.parametrize("part", [0.0, 0.17, 0.83, 1.0])
@pytest.mark.parametrize("change", [-0.577, 0.3])
@pytest.mark.parametrize("coupled", [True, False])
def test_slave_of_a_gear_changes_its_velocity_anywhere_in_the_cycle(
    part: float, change: float, coupled: bool
) -> None:
    """Its master needs only a part of the cycle to accelerate."""
    made = step(1)
    made.coupled, made.law, made.a0, made.a1 = coupled, 1, 0.0, 0.0
    made.p0, made.v0, made.v1 = 0.003, 0.0, change
    made.p1 = made.p0 + part * change * DT
    assert ("position" in broken(made)) is not coupled
    made.p1 = made.p0 + 1.1 * change * DT
    assert "position" in broken(made)


def test_stop_that_accelerates_is_named() -> None:
    made = step(1)
    made.phase = made.phase0 = MotionPhase.STOPPING
    made.v0, made.v1, made.a0, made.a1 = 10.0, 10.1, 0.0, 5.0
    assert "stop" in broken(made)
    made.smooth = False
    assert "stop" not in broken(made)


def test_axis_at_rest_that_moves_is_named() -> None:
    made = fresh()
    made.dt, made.smooth, made.p1 = DT, True, 1e-6
    assert "rest" in broken(made)
    made.commanded = True
    assert "rest" not in broken(made)


def test_slaves_are_held_to_their_law() -> None:
    made = step(2)
    made.coupled = made.abrupt = True
    made.law, made.gear, made.gear0 = 1, 2.0, 2.0
    made.master, made.leading_speed = (made.p1 - made.p0) / 2.0, made.v1 / 2.0
    assert "gear-law" not in broken(made)
    made.leading_speed *= 1.01
    assert "gear-law" in broken(made)
    made.leading_speed, made.master = made.v1 / 2.0, 1.01 * made.master
    assert "gear-law" in broken(made)
    made.gear0 = nan  # the first cycle of the coupling
    assert "gear-law" not in broken(made)
    made.law, made.p1 = 10, made.p0 + 2 * 110.0 * DT
    assert "slave-step" in broken(made)


def test_new_ratio_counts_from_its_cycle() -> None:
    made = step(2)
    made.coupled = made.abrupt = True
    made.law, made.gear0, made.gear = 1, 2.0, 3.0
    made.master, made.leading_speed = (made.p1 - made.p0) / 3.0, made.v1 / 3.0
    assert "gear-law" not in broken(made)
    made.master = (made.p1 - made.p0) / 2.0
    assert "gear-law" in broken(made)


@pytest.mark.parametrize("law", [0, 1])
def test_step_is_described_with_what_it_is_judged_by(law: int) -> None:
    made = step(3)
    made.coupled, made.law, made.gear = int(law > 0), law, 2.5
    told = describe(made)
    assert f"velocity {made.v0} -> {made.v1}, " in told
    assert ("2.5 times master" in told) is (law == 1)
