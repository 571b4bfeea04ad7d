"""A world: a station with its program, its clients, and all that happens to it, as plain data.

Everything is drawn before the world runs. Each act stands for itself: another world without it is
the same in all else, which is what makes worlds small (`achse.swarm.worlds.shrink`).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Self

STATION = -1
"""Actor of what happens to the station itself; others are the numbers of clients."""


class WorldError(ValueError):
    """A text is not a world: says what was expected and what came."""


@dataclass(frozen=True)
class DrawnAxis:
    """An axis: its name, unit and parameters, and the least part of its jerk that commands have."""

    name: str
    unit: str
    modulo: bool
    values: Mapping[str, float]
    gentlest: float = 1.0


@dataclass(frozen=True)
class DrawnChannel:
    """A channel with a 3D group: its axes X, Y, Z, and its part programs."""

    axes: Sequence[DrawnAxis]
    programs: Sequence[str]
    keep_jerk: bool = False
    segments_per_cycle: int = 1
    table_size: int = 128


@dataclass(frozen=True)
class Program:
    """A program of a PLC: variables beside its counter, their types, and statements."""

    variables: Mapping[str, str]
    statements: Sequence[str]


@dataclass(frozen=True)
class DrawnClient:
    """A client and its link to the station."""

    behaviour: str
    """A name of `achse.swarm.worlds.drawing.BEHAVIOURS`, for people: acts say what it does."""
    delay_ns: int
    """Delay of bytes on the link, one way."""
    piece: int
    """Bytes after which, and before the end of which, a packet is cut; 0: it is not."""
    registers: bool
    """True if the client has its port from the router."""
    router: int = -1
    """Number of the router to which it connects; -1: the station itself."""


@dataclass(frozen=True)
class DrawnRouter:
    """A router without devices between clients and the station, and its link to the station."""

    delay_ns: int
    piece: int
    """As of a client."""
    resubscribe: bool
    """True if it makes subscriptions and handles again behind a lost connection."""
    behind: int = -1
    """Number of the router to which it connects, less than its own; -1: the station itself."""


@dataclass(frozen=True)
class Act:
    """An act at a station time: of a client, or of `STATION`."""

    at_ns: int
    actor: int
    kind: str
    """A name of `achse.swarm.clients.CLIENT_ACTS` or `achse.swarm.life.STATION_ACTS`."""
    values: Sequence[Any] = ()


@dataclass(frozen=True)
class World:
    """Everything that is drawn from one seed."""

    seed: int
    length_ns: int
    cycle_ns: int
    axes: Sequence[DrawnAxis] = ()
    cams: Sequence[Sequence[Sequence[float]]] = ()
    """Points of tables 1, 2, …: master position, slave position."""
    programs: Sequence[Program] = ()
    """The first is loaded at the beginning, the others by online changes."""
    clients: Sequence[DrawnClient] = ()
    limits: Mapping[str, int] = field(default_factory=dict)
    acts: Sequence[Act] = ()
    project: str = ""
    """A station.toml of a user, which then says what the station is."""
    channel: DrawnChannel | None = None
    motion_only: bool = False
    """True for an NC without a station around it."""

    machine: Mapping[str, Any] = field(default_factory=dict)
    """Further tables of the station.toml: buses and drives, camshaft controllers, rights."""
    scope: bool = False
    """True if a scope records the first axis."""
    routers: Sequence[DrawnRouter] = ()

    @property
    def all_axes(self) -> Sequence[DrawnAxis]:
        """All axes in the order of their ids: those of the channel come last."""
        return [*self.axes, *(self.channel.axes if self.channel else ())]

    def encode(self) -> str:
        """Return the world as JSON."""
        return json.dumps(asdict(self), separators=(",", ":"))

    @classmethod
    def decode(cls, text: str) -> Self:
        """Return the world in a JSON text. Raises WorldError."""
        try:
            document = json.loads(text)
            return cls(
                **{
                    **document,
                    "axes": [DrawnAxis(**each) for each in document["axes"]],
                    "programs": [Program(**each) for each in document["programs"]],
                    "clients": [DrawnClient(**each) for each in document["clients"]],
                    "routers": [DrawnRouter(**each) for each in document.get("routers", ())],
                    "acts": [Act(**each) for each in document["acts"]],
                    "channel": _channel(document.get("channel")),
                }
            )
        except (ValueError, TypeError, KeyError) as fault:
            raise WorldError(f"expected a world as JSON, got {text!r:.60}: {fault}") from None


def _channel(document: Mapping[str, Any] | None) -> DrawnChannel | None:
    if document is None:
        return None
    return DrawnChannel(**{**document, "axes": [DrawnAxis(**each) for each in document["axes"]]})
