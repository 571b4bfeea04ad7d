"""Invariants of resources: what clients may hold, and that all of it is given back."""

import gc
import itertools
import sys
import weakref
from collections.abc import Callable
from typing import Any

from achse.station import Station

SETTLED_S = 70.0
"""Seconds after which the station holds nothing for clients that are gone."""

_ROUNDS = 6
"""Rounds of a conversation; the first fills caches."""

_NOISE = 2
"""Blocks by which a round may grow, the least of all rounds."""

Report = Callable[[str, str], None]


def check_bounds(station: Station, clients: int, report: Report) -> None:
    """Check what is held now against the limits for so many clients."""
    limits = station.config.limits.limits()
    figures = station.statistics()
    handles = sum(each["handles"] for each in figures["devices"])
    subscriptions = sum(each["subscriptions"] for each in figures["devices"])
    queued = sum(each["queued_bytes"] for each in figures["devices"])
    for what, value, most in (
        (
            "handles",
            handles,
            min(limits.all_handles, 2 * clients * limits.handles + limits.abandoned_handles),
        ),
        ("abandoned handles", figures["handles_abandoned"], limits.abandoned_handles),
        ("subscriptions", subscriptions, limits.all_notifications),
        ("queued bytes", queued, limits.all_queue_bytes + limits.frame_bytes),
    ):
        if not 0 <= value <= most:
            report("bounded", f"{what}: {value}, expected 0..{most} at {station.time_ns / 1e9:g} s")


def check_released(station: Station, report: Report) -> None:
    """Check that nothing is held, some time after the last client has left."""
    figures = station.statistics()
    limits = station.config.limits.limits()
    counts: dict[str, int] = {
        "connections": figures["connections"],
        "queued bytes of connections": figures["queued_bytes"],
        "buffered bytes": figures["buffered_bytes"],
        "known clients": station.router.clients,
        "subscriptions": sum(each["subscriptions"] for each in figures["devices"]),
        "queued bytes": sum(each["queued_bytes"] for each in figures["devices"]),
        "client ports": 0x8000 - station.router.free_ports,
        "handles beyond the abandoned ones": max(
            0, sum(each["handles"] for each in figures["devices"]) - limits.abandoned_handles
        ),
    }
    for what, value in counts.items():
        if value:
            report("released", f"{what}: {value} after all clients have left, expected 0")


def is_released(station: Station) -> bool:
    """Return True if nothing is held for clients now."""
    names: list[str] = []
    check_released(station, lambda name, what: names.append(what))
    return not names


def check_flat(converse: Callable[[], None], report: Report) -> None:
    """Check that the same conversation, again and again, leaves no memory behind."""
    blocks = []
    for _ in range(_ROUNDS):
        converse()
        gc.collect()
        blocks.append(sys.getallocatedblocks())
    growth = min(after - before for before, after in itertools.pairwise(blocks[1:]))
    if growth > _NOISE:
        report("flat", f"each round of the same conversation leaves {growth} blocks of memory")


class Replaced:
    """NCs and PLCs of a station, to see that those which a restart replaces are released."""

    def __init__(self) -> None:
        self._watched_parts: dict[int, tuple[str, weakref.ref[Any]]] = {}

    def look(self, station: Station) -> None:
        """Note what the station has now."""
        parts: list[tuple[str, Any]] = [("PLC", plc) for plc in station.plcs.values()]
        parts += [] if station.nc is None else [("NC", station.nc)]
        for what, part in parts:
            if (
                id(part) not in self._watched_parts
                or self._watched_parts[id(part)][1]() is not part
            ):
                self._watched_parts[id(part)] = what, weakref.ref(part)

    def check(self, station: Station, report: Report) -> None:
        """Report those that are alive and not the station's any more."""
        own = {id(plc) for plc in station.plcs.values()} | {id(station.nc)}
        if self._watched_parts.keys() <= own:
            return
        gc.collect()
        for number, (what, part) in list(self._watched_parts.items()):
            if part() is None:
                del self._watched_parts[number]
            elif number not in own:
                report("restart-released", f"{what} of before a restart is still there")
