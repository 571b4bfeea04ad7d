"""Commands of operators: each is one that a service of an axis takes."""

import pytest

from achse.swarm.clients import encode_service
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.operators import draw_motion


@pytest.mark.parametrize("seed", range(6))
def test_commands_have_a_layout_and_an_axis(seed: int) -> None:
    world = draw_world(seed)
    draws = Stream(seed, "test")
    for _ in range(100):
        acts = draw_motion(draws, 5, 0, world.axes, len(world.cams))
        for act in acts:
            group, name, axis, numbers = act.values
            assert 1 <= axis <= len(world.axes)
            assert encode_service(group, name, numbers) is not None
