"""Draw routers between clients and the station, and what happens to them."""

from dataclasses import replace

from achse.swarm.services.drawing import routes_of_routers
from achse.swarm.worlds.draws import Stream, moments
from achse.swarm.worlds.world import STATION, Act, DrawnRouter, World

ROUTER_ACTS = ("router_cut", "router_kill", "router_restart")
"""Acts of the station's surroundings: the connection of a router to its target breaks, its process
is killed, or it ends and starts again. Values: number of the router, time that it is away, ns."""

_LONGEST_BACK_NS = 3_000_000_000
"""Time within which a client has noticed that a router is back."""


def with_routers(world: World) -> World:
    """Add one or two routers to some worlds; where rights go by NetId, those of routers too."""
    draws, rights = Stream(world.seed, "routers"), Stream(world.seed, "rights of routers")
    has_rights = "route" in world.machine
    if not world.clients or (has_rights and rights.chance(0.5)) or not draws.chance(0.25):
        return world
    routers = [
        DrawnRouter(
            draws.choice((0, 100_000, 1_000_000, 20_000_000, 300_000_000)),
            draws.choice((0, 0, 0, 7, 100)),
            draws.chance(0.5),
            draws.randrange(-1, number),
        )
        for number in range(draws.choice((1, 1, 2)))
    ]
    clients = [
        replace(each, router=draws.randrange(-1, len(routers)) if draws.chance(0.9) else -1)
        for each in world.clients
    ]
    acts = [*world.acts]
    for moment in moments(draws, 0.3 * draws.decades(-1.0, 0.5), world.length_ns):
        number, away_ns = draws.randrange(len(routers)), round(draws.decades(5.0, 9.3))
        acts.append(Act(moment, STATION, draws.choice(ROUTER_ACTS), [number, away_ns]))
        for client, part in enumerate(clients):
            if part.router >= 0:
                back = moment + away_ns + draws.randrange(_LONGEST_BACK_NS)
                acts.append(Act(back, client, "dial"))
    acts.sort(key=lambda act: act.at_ns)
    routed = replace(world, routers=routers, clients=clients, acts=acts)
    if not has_rights:
        return routed
    routes = routes_of_routers(rights, routed)
    return replace(routed, machine={**world.machine, "route": [*world.machine["route"], *routes]})
