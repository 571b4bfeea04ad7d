"""What is seen of an axis: two set points, and what excuses a jump between them."""

import random

import pytest

from achse.motion import AxisParameters, Nc, commands
from achse.swarm.motion.checks import NAMES
from achse.swarm.motion.step import STEP, set_limits
from achse.swarm.motion.watch import axes_under_watch


@pytest.mark.parametrize("seed", range(5))
def test_weaker_jerk_takes_an_acceleration_away_over_more_velocity(seed: int) -> None:
    dice = random.Random(seed)
    rise, fall, jerk = (dice.uniform(1.0, 1e4) for _ in range(3))
    swings = []
    for gentlest in (1.0, dice.uniform(0.5, 0.9), 0.1):
        step = STEP.plain()
        set_limits(step, 1.0, rise, fall, jerk, gentlest)
        swings.append(step.swing)
    assert swings[0] == 0.0
    assert swings == sorted(swings)


def test_new_actual_position_moves_the_zero_point_and_is_not_smooth() -> None:
    nc = Nc(2_000_000, [AxisParameters(1, values={"control_dword": 7})])
    nc.cycle(5)
    axes = axes_under_watch(nc, {}, NAMES, False)
    for _ in range(3):
        nc.cycle()
        assert axes.look() == 0
    assert axes.steps[0].smooth
    assert commands.set_actual_position(nc.axis(1), 1, 3.5) == 0
    nc.cycle()
    axes.look()
    assert (axes.steps[0].shift, axes.steps[0].smooth) == (3.5, 0)


def test_external_set_point_that_contradicts_its_velocity_is_not_smooth() -> None:
    """Its position stands still and it names a velocity: no axis can follow both."""
    values = {"control_dword": 7, "allow_motion_commands_with_external_setpoint": 1}
    nc = Nc(2_000_000, [AxisParameters(1, values=values)])
    nc.cycle(5)
    axis = nc.axis(1)
    axes = axes_under_watch(nc, {}, NAMES, False)
    assert commands.start_external_setpoint(axis, 2, 0.0) == 0
    assert commands.universal_start(axis, 2, 5.0, 1.0) == 0
    smooth = []
    for velocity in (0.0, 0.0, 0.0, -0.5, 0.0, 0.0):
        axis.external_set_velocity = velocity
        nc.cycle()
        axes.look()
        smooth.append(axes.steps[0].smooth)
    assert smooth[2:] == [1, 0, 0, 1]
