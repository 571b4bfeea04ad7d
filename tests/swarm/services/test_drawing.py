"""Services in worlds: which worlds have them, and that a station takes what is drawn."""

from collections import Counter

from achse.swarm.life import configuration
from achse.swarm.services.drawing import NET_ID, net_id_of
from achse.swarm.worlds.drawing import draw_world


def test_services_are_drawn_and_are_a_configuration() -> None:
    seen: Counter[str] = Counter()
    for seed in range(120):
        world = draw_world(seed)
        seen.update(list(world.machine))
        seen["scope"] += world.scope
        if not {"camshaft", "route"} & set(world.machine) or seen["checked"] > 12:
            continue
        seen["checked"] += 1
        config = configuration(world, "auto")
        assert str(config.router.net_id) == NET_ID
        for shaft in world.machine.get("camshaft", ()):
            part = next(each for each in world.axes if each.name == shaft["axis"])
            step = part.values["max_velocity"] * world.cycle_ns / 1e9
            assert step <= 0.11 * shaft["units_per_turn"]
    assert all(seen[name] > 12 for name in ("camshaft", "route", "scope"))


def test_each_client_has_a_net_id_of_its_own() -> None:
    assert len({net_id_of(number) for number in range(600)}) == 600
