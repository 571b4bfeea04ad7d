"""Figures about a running station: who is connected, what they hold, whether it keeps up."""

from collections.abc import Sequence, Sized
from typing import Any, Protocol

from achse.router import Router
from achse.server import Device, Usage
from achse.station.pacing import Pace
from achse.transport.tcp import TcpListener

__all__ = ["CountedStation", "statistics"]


class CountedStation(Protocol):
    """What the figures are about."""

    devices: Sequence[Device]
    listeners: Sequence[TcpListener]
    pace: Pace | None
    usage: Usage

    @property
    def router(self) -> Router: ...
    @property
    def faults(self) -> Sized: ...
    @property
    def time_ns(self) -> int: ...
    @property
    def tick_ns(self) -> int: ...


def statistics(station: CountedStation) -> dict[str, Any]:
    """Present figures as numbers and texts; times in seconds of station time."""
    devices = []
    for device in station.devices:
        notifications, symbols = device.notifications, device.symbols
        devices.append(
            {
                "name": device.name,
                "ports": [address.port for address in device.addresses],
                "state": device.ads_state.name,
                "clients": len(set(notifications.clients)),
                "subscriptions": len(notifications),
                "handles": 0 if symbols is None else symbols.count,
                "refused": notifications.refused + (0 if symbols is None else symbols.refused),
                "queued_bytes": notifications.queued,
                "samples_dropped": notifications.dropped,
            }
        )
    connections = [
        connection for listener in station.listeners for connection in listener.connections
    ]
    pace = station.pace
    return {
        "time": station.time_ns / 1e9,
        "tick": station.tick_ns / 1e9,
        "late_ticks": 0 if pace is None else pace.late_ticks,
        "rebases": 0 if pace is None else pace.rebases,
        "connections": len(connections),
        "connections_refused": sum(listener.refused for listener in station.listeners),
        "connections_cut_off": sum(listener.cut_off for listener in station.listeners),
        "queued_bytes": sum(connection.backlog for connection in connections),
        "held_bytes": sum(listener.held.total for listener in station.listeners),
        "samples_late": station.usage.budget.late,
        "registered_ports": len(station.router.ports),
        "lost_frames": station.router.lost_frames,
        "faults": len(station.faults),
        "devices": devices,
    }
