"""Topology: which slave is connected to which port, and how long frames travel between them.

Frames enter a slave at port 0 and leave it by ports 3, 1, 2 in this order; the slaves come in the
order in which frames pass them.

Source: ETG.1000.4 §6.1.4 (DL status), §6.8 (receive times).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

PORT_ORDER = (0, 3, 1, 2)
"""Order in which a frame passes the ports."""

_COMMUNICATION = 9
"""Bit of DL status for port 0; two bits for each port."""
_U32 = 0xFFFF_FFFF


@dataclass
class PlaceOnBus:
    """Position of a slave in the tree: its open ports, parent (None: the master) and parent's
    port."""

    open_ports: tuple[int, ...]
    parent: int | None = None
    parent_port: int = 0
    children: dict[int, int] = field(default_factory=dict)
    """Port → position of the slave there."""


def open_ports(dl_status: int) -> tuple[int, ...]:
    """Return the ports with communication, in the order in which frames pass them."""
    return tuple(port for port in PORT_ORDER if dl_status >> _COMMUNICATION + 2 * port & 1)


def build_tree(dl_statuses: Sequence[int]) -> list[PlaceOnBus]:
    """Return the places of slaves in processing order, from their DL status.

    A status that fits to nothing makes a line: faults of links are reported elsewhere.
    """
    places: list[PlaceOnBus] = []
    waiting: list[tuple[int, int]] = []
    """Open ports that nothing was found at yet, the next last."""
    for position, status in enumerate(dl_statuses):
        place = PlaceOnBus(open_ports(status))
        if position:
            place.parent, place.parent_port = waiting.pop() if waiting else (position - 1, 1)
            places[place.parent].children[place.parent_port] = position
        places.append(place)
        downstream = [port for port in place.open_ports if port != 0]
        waiting += [(position, port) for port in reversed(downstream)]
    return places


def propagation_delays(
    places: Sequence[PlaceOnBus], times: Sequence[Sequence[int] | None]
) -> list[int]:
    """Delay of each slave from the first with a clock, in ns.

    `times` are the receive times of ports 0 to 3 of each slave (32 bit, they wrap), None for a
    slave without them. A loop is what a slave sees between sending a frame on and getting it
    back; half of what is left of it without the loops behind is the way to the next slave.
    """
    delays = [0] * len(places)
    for position, place in enumerate(places):
        own = times[position]
        upstream = _clock_above(places, times, position)
        if own is None or upstream is None:
            continue
        parent, port = upstream
        above = times[parent]
        assert above is not None
        before = _port_before(places[parent].open_ports, port)
        loop = above[port] - above[before] & _U32
        last = place.open_ports[-1] if place.open_ports else 0
        behind = own[last] - own[0] & _U32
        to_port = above[before] - above[0] & _U32
        hop = max(loop - behind, 0) // 2
        delays[position] = delays[parent] + to_port + hop
    return delays


def _clock_above(
    places: Sequence[PlaceOnBus], times: Sequence[Sequence[int] | None], position: int
) -> tuple[int, int] | None:
    """Return the nearest slave with a clock towards the master, and its port on the way here."""
    while (parent := places[position].parent) is not None:
        if times[parent] is not None:
            return parent, places[position].parent_port
        position = parent
    return None


def _port_before(ports: Sequence[int], port: int) -> int:
    """Return the port that frames passed before this one."""
    if port not in ports:
        return 0
    at = ports.index(port)
    return ports[at - 1] if at else 0
