"""Worlds from seeds: all that they name is there."""

import pytest

from achse.swarm.clients import CLIENT_ACTS
from achse.swarm.life import STATION_ACTS
from achse.swarm.routers import ROUTER_ACTS
from achse.swarm.worlds.drawing import BEHAVIOURS, draw_world
from achse.swarm.worlds.world import STATION


@pytest.mark.parametrize("seed", range(12))
def test_acts_are_in_order_and_have_their_actors(seed: int) -> None:
    world = draw_world(seed)
    assert world == draw_world(seed)
    moments = [act.at_ns for act in world.acts]
    assert moments == sorted(moments)
    for act in world.acts:
        if act.actor == STATION:
            assert act.kind in STATION_ACTS or act.kind in (*ROUTER_ACTS, "save", "kill", "cut")
        else:
            assert act.kind in CLIENT_ACTS
            assert world.clients[act.actor].behaviour in BEHAVIOURS


def test_all_behaviours_and_acts_are_drawn() -> None:
    worlds = [draw_world(seed) for seed in range(60)]
    assert {part.behaviour for world in worlds for part in world.clients} == set(BEHAVIOURS)
    kinds = {act.kind for world in worlds for act in world.acts}
    assert kinds == {*CLIENT_ACTS, *STATION_ACTS, *ROUTER_ACTS, "save", "kill", "cut"}
