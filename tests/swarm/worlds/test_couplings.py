"""Rare commands of worlds: each is a service of an axis, with values that it has room for."""

import pytest

from achse.swarm.clients import encode_service
from achse.swarm.worlds.couplings import draw_rare_motion
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.draws import Stream

SEEDS = [seed for seed in range(12) if len(draw_world(seed).axes) > 1]


@pytest.mark.parametrize("seed", SEEDS[:6])
def test_rare_commands_are_services_of_an_axis(seed: int) -> None:
    axes = draw_world(seed).axes
    acts = draw_rare_motion(Stream(seed, "rare"), axes, 3, range(0, 100_000, 1000))
    assert acts == draw_rare_motion(Stream(seed, "rare"), axes, 3, range(0, 100_000, 1000))
    for act in acts:
        group, name, axis, numbers = act.values
        assert act.actor in range(3)
        assert axis in range(1, len(axes) + 1)
        encode_service(group, name, numbers)
    names = {act.values[1] for act in acts}
    assert {"couple", "couple_universal_flying_saw", "oriented_stop", "start_special"} <= names
