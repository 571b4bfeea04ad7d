"""Overview of a target: devices, timing of the cycle, connections, failures."""

import asyncio
from typing import Any

from achse.ams import AdsError, AdsState
from achse.web.arguments import Arguments
from achse.web.faults import FaultHandlers
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import WatchedTarget

_PORTS = (100, 110, 300, 500, 501, 801, 811, 851, 852, 853, 10_000, 14_000)
"""AMS ports where devices of a controller usually are."""

_STATE_WITHIN = 1.0


class OverviewHandlers:
    """Handlers of page calls of the overview, the first page."""

    def __init__(self, watched: WatchedTarget, faults: FaultHandlers) -> None:
        self._watched = watched
        self._faults = faults

    async def watch_overview(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `overview`: figures of an achse station, device states of others."""
        every = arguments.number("every", 0.5, 0.1, 10.0)
        before: dict[str, Any] | None = None
        while True:
            try:
                figures = await self._watched.statistics()
            except AdsError:
                before = None
                subscription.show(await self._of_foreign())
            else:
                load = None if before is None else _load(before, figures)
                faults = await self._faults.active()
                subscription.show({**_of_station(figures, load), "faults": faults})
                before = figures
            await subscription.pause(every)

    async def _of_foreign(self) -> dict[str, Any]:
        rows = await asyncio.gather(*map(self._device, _PORTS))
        return {
            "devices": [row for row in rows if row is not None],
            "cycle": None,
            "clients": [],
            "faults": [],
            "axes": None,
        }

    async def _device(self, port: int) -> dict[str, Any] | None:
        target = self._watched.device(port).within(_STATE_WITHIN)
        try:
            state = (await target.state()).ads_state
            name = (await target.device_info()).name
        except AdsError:
            return None
        shown = state.name if isinstance(state, AdsState) else str(state)
        return {
            "name": name, "port": port, "state": shown,
            "requests": None, "errors": None, "clients": None,
        }  # fmt: skip


def _load(before: dict[str, Any], now: dict[str, Any]) -> float | None:
    """Share of the time in which cycles were computed; None if time stood or is not paced."""
    passed = now["time"] - before["time"]
    if passed <= 0 or not now["speed"]:
        return None
    return float((now["computed"] - before["computed"]) * now["speed"] / passed)


def _of_station(figures: dict[str, Any], load: float | None) -> dict[str, Any]:
    devices = [
        {
            "name": device["name"],
            "port": device["ports"][0] if device["ports"] else None,
            **{key: device[key] for key in ("state", "requests", "errors", "clients")},
        }
        for device in figures["devices"]
    ]
    return {
        "devices": sorted(devices, key=lambda each: each["port"] or 0),
        "time": figures["time"],
        "speed": figures["speed"] or None,
        "cycle": {
            "tick": figures["tick"],
            "load": load,
            "late": figures["late_ticks"],
            "lost": figures["rebases"],
        },
        "clients": figures.get("clients", []),
        "connections": figures["connections"],
        "faults": [],
        "axes": {
            "count": figures["axes"],
            "moving": figures["axes_moving"],
            "error": figures["axes_in_error"],
        },
    }
