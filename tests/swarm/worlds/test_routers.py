"""Routers are drawn into some worlds, and worlds get smaller without them."""

from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.routers import ROUTER_ACTS, with_routers
from achse.swarm.worlds.shrink import shrink
from achse.swarm.worlds.world import STATION, World

WORLDS = [draw_world(seed) for seed in range(60)]


def test_routers_are_drawn_into_some_worlds() -> None:
    drawn = [world for world in WORLDS if world.routers]
    assert 5 < len(drawn) < 30
    for world in WORLDS:
        count = len(world.routers)
        assert all(each.behind < number for number, each in enumerate(world.routers))
        assert all(each.router < count for each in world.clients)
        for act in world.acts:
            if act.kind in ROUTER_ACTS:
                assert act.actor == STATION
                assert act.values[0] < count


def test_rights_of_routers_are_drawn_where_clients_have_some() -> None:
    worlds = [each for each in WORLDS if each.routers and "route" in each.machine]
    assert worlds
    routed = [
        route
        for world in worlds
        for route in world.machine["route"]
        if route["name"].startswith("router")
    ]
    assert routed
    assert {route["net_id"] for route in routed} <= {"10.2.0.0.1.1", "10.2.0.1.1.1"}


def test_kinds_of_worlds_are_all_drawn() -> None:
    routers = [each for world in WORLDS for each in world.routers]
    assert {each.resubscribe for each in routers} == {True, False}
    assert {each.behind for each in routers} == {-1, 0}
    acts = {act.kind for world in WORLDS for act in world.acts}
    assert set(ROUTER_ACTS) <= acts


def test_world_without_clients_has_no_router() -> None:
    assert with_routers(World(1, 1, 1)).routers == ()


def test_failure_without_routers_loses_them() -> None:
    world = next(each for each in WORLDS if each.routers)
    steps = iter(range(10**6))
    small = shrink(world, lambda _: True, budget_s=1e6, clock=lambda: float(next(steps)))
    assert (len(small.routers), len(small.clients)) == (0, 0)
