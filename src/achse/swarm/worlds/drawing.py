"""Draw a world from its seed: axes, cams, programs, clients, and all their acts.

Each part has its own stream (`achse.swarm.worlds.draws`), so that worlds change little when a part
draws more than before.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from achse.codes.nc.choices import OverrideType
from achse.swarm.services.drawing import with_services
from achse.swarm.worlds.channels import draw_channel, draw_channel_acts
from achse.swarm.worlds.couplings import draw_rare_motion
from achse.swarm.worlds.draws import Stream, moments
from achse.swarm.worlds.layers import LEAST_PART, draw_layers
from achse.swarm.worlds.machine import with_drives
from achse.swarm.worlds.operators import draw_motion
from achse.swarm.worlds.program import draw_programs
from achse.swarm.worlds.routers import with_routers
from achse.swarm.worlds.world import STATION, Act, DrawnAxis, DrawnClient, Program, World

_SECOND = 1_000_000_000
_FULL = 1_000_000


@dataclass(frozen=True)
class Behaviour:
    """Acts of a kind of client: their rate, 1/s, and the weight of each kind."""

    rate: float
    weights: Mapping[str, float]


BEHAVIOURS: Mapping[str, Behaviour] = {
    "operate": Behaviour(3.0, {"motion": 20, "use": 2, "handle": 1, "subscribe_axis": 1}),
    "watch": Behaviour(
        2.0,
        {
            "handle": 4, "subscribe": 4, "subscribe_axis": 3, "unsubscribe": 3, "use": 3,
            "release": 2, "state": 1,
        },
    ),
    "hurry": Behaviour(
        30.0, {"motion": 4, "use": 10, "state": 5, "sum": 4, "handle": 2, "release": 2}
    ),
    "vanish": Behaviour(
        4.0,
        {
            "handle": 4, "subscribe": 4, "subscribe_axis": 3, "use": 4, "vanish": 2, "leave": 2,
            "dial": 6, "motion": 4,
        },
    ),
    "flood": Behaviour(
        2.0, {"flood": 8, "sum": 4, "deaf": 2, "listen": 4, "subscribe": 3, "handle": 3}
    ),
    "lie": Behaviour(4.0, {"lie": 10, "handle": 2, "use": 2, "dial": 3, "motion": 1}),
}  # fmt: skip
"""Kinds of clients by name."""

_LIES = (
    "group",
    "length",
    "port",
    "handle",
    "delete",
    "short",
    "command",
    "answer",
    "samples",
    "bytes",
)

_FAULTS = (
    "drop", "delay", "duplicate", "reorder", "cut", "truncate", "wrong_invoke_id", "error",
    "router_error", "drop_link", "refuse_links", "one_connection", "online_change", "download",
    "restart", "config", "slow_cycle",
)  # fmt: skip

_INJECTED = ("simulation_not_ready", "simulation_io_invalid", "simulation_fast_stop_signal")


def draw_world(seed: int) -> World:
    """Draw the world of a seed."""
    draws = Stream(seed, "world")
    axes = [draw_axis(Stream(seed, "axis", n), n) for n in range(draws.randrange(1, 5))]
    cams = [draw_cam(Stream(seed, "cam", n)) for n in range(draws.randrange(3))]
    world = draw_surroundings(seed, draws, axes, cams, draw_programs(Stream(seed, "programs")))
    world = with_services(with_drives(_with_layers(_with_rare_motion(_with_channel(world)))))
    return with_routers(world)


def _with_channel(world: World) -> World:
    """Add a channel to some worlds, and what clients want of it."""
    channel = draw_channel(Stream(world.seed, "channel"))
    if channel is None:
        return world
    draws = Stream(world.seed, "channel acts")
    times = list(moments(draws, draws.decades(-0.5, 0.5), world.length_ns))
    acts = draw_channel_acts(draws, channel, len(world.axes) + 1, len(world.clients), times)
    acts = sorted([*world.acts, *acts], key=lambda act: act.at_ns)
    return replace(world, channel=channel, acts=acts)


def _with_rare_motion(world: World) -> World:
    """Add rare commands to some worlds with two axes or more."""
    draws = Stream(world.seed, "rare motion")
    if len(world.axes) < 2 or not draws.chance(0.5):
        return world
    times = list(moments(draws, draws.decades(-1.0, 0.0), world.length_ns))
    acts = draw_rare_motion(draws, world.axes, len(world.clients), times)
    return replace(world, acts=sorted([*world.acts, *acts], key=lambda act: act.at_ns))


def _with_layers(world: World) -> World:
    """Add commands in layers to some worlds; their parameters weaken what an axis may do."""
    draws = Stream(world.seed, "layers")
    if not draws.chance(0.2):
        return world
    axes = [replace(part, gentlest=part.gentlest * LEAST_PART) for part in world.axes]
    times = list(moments(draws, draws.decades(-1.0, 0.0), world.length_ns))
    acts = draw_layers(draws, axes, len(world.cams), times)
    acts = sorted([*world.acts, *acts], key=lambda act: act.at_ns)
    return replace(world, axes=axes, acts=acts)


def draw_surroundings(
    seed: int,
    draws: Stream,
    axes: Sequence[DrawnAxis],
    cams: Sequence[Sequence[tuple[float, float]]],
    programs: Sequence[Program],
) -> World:
    """Draw a world around these parts of a station: its clients, and all that happens."""
    length_ns = round(draws.decades(0.5, 2.0) * _SECOND)
    clients = [_client(Stream(seed, "client", n)) for n in range(draws.randrange(1, 6))]
    calm = draws.chance(0.4)
    acts: list[Act] = []
    for number, part in enumerate(clients):
        acts += _acts(Stream(seed, "acts", number), number, part, axes, len(cams), length_ns)
    if not calm:
        acts += _trouble(Stream(seed, "trouble"), len(axes), len(programs), length_ns)
    acts.sort(key=lambda act: act.at_ns)
    return World(
        seed,
        length_ns,
        draws.choice((1, 2, 2, 4)) * 1_000_000,
        axes,
        cams,
        programs,
        clients,
        {"abandoned_handles": draws.choice((0, 3, 1000))},
        acts,
    )


def draw_axis(draws: Stream, number: int) -> DrawnAxis:
    """Draw an axis with dynamics over decades."""
    top = draws.decades(0.0, 3.3)
    acceleration = top * draws.decades(0.0, 2.0)
    deceleration = acceleration * draws.choice((1.0, draws.decades(-0.5, 0.5)))
    jerk = max(acceleration, deceleration) * draws.decades(0.0, 3.0)
    modulo = draws.chance(0.3)
    values: dict[str, float] = {
        "max_velocity": top,
        "jog_velocity_slow": 0.2 * top,
        "jog_velocity_fast": top,
        "rapid_traverse_velocity": top,
        "max_acceleration": acceleration,
        "max_deceleration": deceleration,
        "default_acceleration": acceleration,
        "default_deceleration": deceleration,
        "default_jerk": jerk,
        "homing_velocity_towards_cam": 0.3 * top,
        "homing_velocity_off_cam": 0.1 * top,
        "encoder_modulo_factor": top,
    }
    values = {name: draws.rounded(value) for name, value in values.items()}
    values |= {
        "override_type": int(draws.choice(list(OverrideType))),
        "controller_following_error_position_monitoring_enable": 0,
        "velocity_override": _FULL,
        "control_dword": 7,
    }
    if draws.chance(0.3):
        window = draws.rounded(top * draws.decades(-1.0, 1.0))
        values |= {
            "encoder_soft_limit_min": -window,
            "encoder_soft_limit_max": window,
            "encoder_soft_limit_min_enable": 1,
            "encoder_soft_limit_max_enable": 1,
        }
    gentlest = draws.choice((1.0, 1.0, 0.2))
    return DrawnAxis(
        f"A{number + 1}", draws.choice(("mm", "degree", "m")), modulo, values, gentlest
    )


def draw_cam(draws: Stream) -> list[tuple[float, float]]:
    """Draw the points of a cam."""
    place, points = 0.0, []
    size = draws.decades(0.0, 2.0)
    for _ in range(draws.randrange(4, 12)):
        points.append((draws.rounded(place), draws.rounded(size * draws.random())))
        place += size * draws.uniform(0.2, 2.0)
    return points


def _client(draws: Stream) -> DrawnClient:
    return DrawnClient(
        draws.choice(("operate", "operate", *BEHAVIOURS)),
        draws.choice((0, 100_000, 1_000_000, 20_000_000, 300_000_000)),
        draws.choice((0, 0, 0, 7, 100)),
        draws.chance(0.5),
    )


def _acts(
    draws: Stream,
    number: int,
    part: DrawnClient,
    axes: Sequence[DrawnAxis],
    cams: int,
    length_ns: int,
) -> list[Act]:
    behaviour = BEHAVIOURS[part.behaviour]
    kinds, weights = list(behaviour.weights), list(behaviour.weights.values())
    rate = behaviour.rate * draws.decades(-0.7, 0.5)
    acts = [Act(0, number, "dial")]
    for moment in moments(draws, rate, length_ns):
        (kind,) = draws.choices(kinds, weights)
        if kind == "motion":
            acts += draw_motion(draws, moment, number, axes, cams)
        elif kind == "deaf":
            acts.append(Act(moment, number, "listen", [False]))
        else:
            acts.append(Act(moment, number, kind, _VALUES[kind](draws, len(axes))))
        if draws.chance(0.02):
            acts.append(Act(moment, number, "dial"))
    return acts


def _cycle(draws: Stream) -> int:
    """Return a multiple of the cycles of tasks and NC: others are rounded up to one."""
    return draws.choice((20, 20, 40, 100, 1000)) * 1_000_000


def _delay(draws: Stream) -> int:
    return draws.choice((0, 0, 5, 100, 500)) * 1_000_000


_VALUES: Mapping[str, Callable[[Stream, int], list[object]]] = {
    "dial": lambda draws, axes: [],
    "leave": lambda draws, axes: [],
    "vanish": lambda draws, axes: [],
    "listen": lambda draws, axes: [True],
    "handle": lambda draws, axes: [draws.randrange(8)],
    "use": lambda draws, axes: [
        draws.randrange(8), draws.choice((None, None, draws.randrange(1 << 32)))
    ],
    "release": lambda draws, axes: [draws.randrange(8)],
    "subscribe": lambda draws, axes: [
        draws.randrange(8), draws.chance(0.7), _cycle(draws), _delay(draws)
    ],
    "subscribe_axis": lambda draws, axes: [
        draws.randrange(axes) + 1, draws.chance(0.7), _cycle(draws), _delay(draws)
    ],
    "unsubscribe": lambda draws, axes: [draws.randrange(8)],
    "state": lambda draws, axes: [draws.choice((851, 501, 10_000, 77))],
    "flood": lambda draws, axes: [draws.randrange(1, 200), draws.randrange(1, 5)],
    "sum": lambda draws, axes: [draws.randrange(1, 500)],
    "lie": lambda draws, axes: [draws.choice(_LIES), draws.randrange(1 << 31)],
}  # fmt: skip
"""Values of the acts of clients, by kind."""


def _trouble(draws: Stream, axes: int, programs: int, length_ns: int) -> list[Act]:
    """Draw the disturbances of the station."""
    acts: list[Act] = []
    for moment in moments(draws, 0.3 * draws.decades(-1.0, 0.5), length_ns):
        kind = draws.choice(
            (
                "fault",
                "fault",
                "inject",
                "inject",
                "online_change",
                "restart",
                "save",
                "kill",
                "cut",
                "full_disk",
            )
        )
        match kind:
            case "fault":
                acts.append(Act(moment, STATION, "fault", [_fault(draws)]))
            case "inject":
                axis, name = draws.randrange(axes) + 1, draws.choice(_INJECTED)
                acts.append(Act(moment, STATION, "inject", [axis, name, 1]))
                later = moment + round(draws.decades(-2.0, 0.5) * 1000) * 1_000_000
                acts.append(Act(later, STATION, "inject", [axis, name, 0]))
            case "online_change" if programs:
                acts.append(Act(moment, STATION, kind, [draws.randrange(programs)]))
            case "restart":
                if draws.chance(0.2):
                    acts.append(Act(moment, STATION, "configure"))
                acts.append(Act(moment + draws.randrange(3000) * 1_000_000, STATION, "restart"))
            case "cut":
                acts.append(Act(moment, STATION, "cut", [round(draws.decades(0.0, 4.3))]))
            case "full_disk":
                acts.append(Act(moment, STATION, kind, [draws.chance(0.5)]))
            case "save" | "kill":
                acts.append(Act(moment, STATION, kind))
    return acts


def _fault(draws: Stream) -> dict[str, object]:
    kind = draws.choice(_FAULTS)
    fields: dict[str, object] = {"kind": kind}
    lasting = draws.rounded(draws.decades(-1.5, 0.5))
    if kind in ("refuse_links", "one_connection", "config"):
        fields["lasting"] = lasting
    elif kind == "slow_cycle":
        fields |= {"lasting": lasting, "factor": draws.randrange(2, 6)}
    elif kind not in ("drop_link", "online_change", "download", "restart"):
        if draws.chance(0.5):
            fields["count"] = draws.randrange(1, 5)
        fields["lasting"] = lasting
        if draws.chance(0.5):
            fields["command"] = draws.choice(("read", "write", "notification", "read_write"))
        if kind in ("delay", "reorder"):
            fields["by"] = draws.rounded(draws.decades(-3.0, -0.4))
        if kind in ("error", "router_error"):
            fields["code"] = draws.choice((0x706, 0x701, 0x745))
            if fields.get("command") == "notification":
                del fields["command"]
    return fields
