"""Worlds as text."""

import json
import random

import pytest

from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.world import World, WorldError


@pytest.mark.parametrize("seed", [0, 1, (1 << 64) - 1])
def test_decoded_world_is_the_one_that_was_encoded(seed: int) -> None:
    text = draw_world(seed).encode()
    assert World.decode(text).encode() == text


@pytest.mark.parametrize("seed", range(10))
def test_any_text_raises_only_world_error(seed: int) -> None:
    dice = random.Random(seed)
    document = json.loads(draw_world(seed).encode())
    part = dice.choice(["axes", "clients", "acts", "programs"])
    document[part] = dice.choice([None, [1], [{"a": 1}], 5])
    with pytest.raises(WorldError, match="expected a world"):
        World.decode(json.dumps(document))
