"""Small worlds: what is not needed for a failure is left out."""

import random

import pytest

from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.shrink import shrink
from achse.swarm.worlds.world import World


@pytest.mark.parametrize("seed", range(4))
def test_needed_acts_remain_alone(seed: int) -> None:
    world = draw_world(seed)
    dice = random.Random(seed)
    needed = [world.acts[n] for n in sorted(dice.sample(range(len(world.acts)), 2))]
    wanted = [(act.kind, act.values) for act in needed]

    def fails(smaller: World) -> bool:
        left = [(act.kind, act.values) for act in smaller.acts]
        return all(left.count(each) >= wanted.count(each) for each in wanted)

    small = shrink(world, fails, clock=lambda: 0.0)
    assert sorted(map(repr, ((act.kind, act.values) for act in small.acts))) == sorted(
        map(repr, wanted)
    )
    assert len(small.clients) <= 2
    assert len(small.axes) == 1
    assert small.length_ns < world.length_ns


def test_world_stays_when_the_budget_is_used_up() -> None:
    world = draw_world(3)
    assert shrink(world, lambda smaller: True, budget_s=0.0, clock=lambda: 1.0) == world
