"""Draw a camshaft controller, a scope and rights of clients into worlds."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from achse.swarm.worlds.draws import Stream
from achse.swarm.worlds.world import DrawnAxis, World

NET_ID = "10.200.1.1.1.1"
"""NetId of the station of a world."""

HOST = "127.0.0.1"
"""Address of all clients."""

_SOME_RIGHTS = (
    (),
    ("read",),
    ("read",),
    ("read", "methods"),
    ("read", "state"),
    ("write",),
    ("read", "write"),
    ("read", "write", "state", "files", "methods"),
)


def net_id_of(client: int) -> str:
    """Return the NetId of a client."""
    return f"10.1.{client // 256}.{client % 256}.1.1"


def net_id_of_router(number: int) -> str:
    """Return the NetId of a router, which the station sees of all clients behind it."""
    return f"10.2.0.{number}.1.1"


def with_services(world: World) -> World:
    """Add services to some worlds; each world has those of its seed."""
    machine = dict(world.machine)
    draws = Stream(world.seed, "camshaft")
    if draws.chance(0.3):
        machine["camshaft"] = [_camshaft(draws, draws.choice(world.axes), world.cycle_ns)]
    draws = Stream(world.seed, "rights")
    if draws.chance(0.3):
        machine.update(_rights(draws, world))
    scope = Stream(world.seed, "scope").chance(0.3)
    return replace(world, machine=machine, scope=scope)


def _camshaft(draws: Stream, part: DrawnAxis, cycle_ns: int) -> Mapping[str, Any]:
    """Draw a controller whose shaft turns less than a tenth of a turn in a cycle."""
    slowest = 10.0 * part.values["max_velocity"] * cycle_ns / 1e9
    cams = [
        {
            "type": "way",
            "start": draws.randrange(360),
            "end": draws.randrange(360),
            "track": draws.randrange(6),
        }
        for _ in range(draws.randrange(1, 24))
    ]
    return {
        "name": "Press",
        "axis": part.name,
        "units_per_turn": draws.rounded(slowest * draws.decades(0.0, 2.0)),
        "increments": draws.choice((4096, 3600, 100_000)),
        "zero_point": draws.choice((0, draws.randrange(-3599, 3600))),
        "reversed": draws.chance(0.3),
        "or_mask": draws.choice((0, 0, 1 << draws.randrange(32))),
        "cam": cams,
    }


def _rights(draws: Stream, world: World) -> Mapping[str, Any]:
    """Draw what each client may: by a route of its own, or as all that have none.

    In some of these worlds no client may write.
    """
    rights = _some_rights(may_write=not draws.chance(0.4))
    routes = [
        {
            "name": f"client {number}",
            "net_id": net_id_of(number),
            "host": HOST,
            "rights": list(draws.choice(rights)),
        }
        for number in range(len(world.clients))
        if draws.chance(0.6)
    ]
    return {
        "router": {"net_id": NET_ID, "rights": list(draws.choice(rights))},
        "route": routes,
    }


def routes_of_routers(draws: Stream, world: World) -> list[Mapping[str, Any]]:
    """Draw what the clients behind each router of a world may, for some routers.

    In a world in which no client may write, none behind a router may.
    """
    declared = [*world.machine["route"], world.machine["router"]]
    rights = _some_rights(may_write=any("write" in each["rights"] for each in declared))
    return [
        {
            "name": f"router {number}",
            "net_id": net_id_of_router(number),
            "host": HOST,
            "rights": list(draws.choice(rights)),
        }
        for number in range(len(world.routers))
        if draws.chance(0.6)
    ]


def _some_rights(*, may_write: bool) -> Sequence[Sequence[str]]:
    return [each for each in _SOME_RIGHTS if may_write or "write" not in each]
