"""Figures about a running station: its clients, their resources, its lag behind the clock."""

from collections.abc import Mapping, Sequence, Sized
from typing import TYPE_CHECKING, Any, Protocol

from achse.motion import Nc
from achse.router import Router
from achse.router.clients import LISTED_CLIENTS
from achse.server import Device, Usage
from achse.station.clocks.clock import StationClock
from achse.station.clocks.pacing import Pace
from achse.transport.tcp.listener import TcpListener

if TYPE_CHECKING:
    from achse.station.buses.ethercat_bus import EthercatBus
    from achse.station.buses.interface_bus import InterfaceBus


class CountedStation(Protocol):
    """Interface of the station to its statistics."""

    clock: StationClock
    usage: Usage

    @property
    def devices(self) -> Sequence[Device]: ...
    @property
    def listeners(self) -> Sequence[TcpListener]: ...
    @property
    def pace(self) -> Pace | None: ...
    @property
    def nc(self) -> Nc | None: ...
    @property
    def fieldbuses(self) -> "Mapping[str, EthercatBus | InterfaceBus]": ...
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
                "handles": 0 if symbols is None else len(symbols.handles),
                "requests": device.request_count,
                "errors": device.error_count,
                "refused": notifications.refused
                + (0 if symbols is None else symbols.handles.refused),
                "queued_bytes": notifications.queued,
                "samples_dropped": notifications.dropped,
            }
        )
    connections = [
        connection for listener in station.listeners for connection in listener.connections
    ]
    pace, nc = station.pace, station.nc
    axes = [] if nc is None else list(nc)
    client_figures, others = station.router.client_figures, _silent_clients(station)
    return {
        "time": station.time_ns / 1e9,
        "tick": station.tick_ns / 1e9,
        "speed": 0.0 if pace is None else pace.speed,
        "computed": 0.0 if pace is None else pace.computed_ns / 1e9,
        "late_ticks": 0 if pace is None else pace.late_ticks,
        "rebases": 0 if pace is None else pace.rebases,
        "stamp_lag": station.clock.lag_ns / 1e9 if pace is not None and pace.speed == 1 else 0.0,
        "connections": len(connections),
        "connections_refused": sum(listener.refused for listener in station.listeners),
        "connections_cut_off": sum(listener.cut_off for listener in station.listeners),
        "queued_bytes": sum(connection.backlog for connection in connections),
        "buffered_bytes": sum(
            budget.total for budget in {listener.send_budget for listener in station.listeners}
        ),
        "samples_late": station.usage.budget.late,
        "handles_abandoned": station.usage.abandoned_handles,
        "registered_ports": len(station.router.ports),
        "lost_frames": station.router.lost_frames,
        "requests_denied": station.router.denied,
        "faults": len(station.faults),
        "axes": len(axes),
        "axes_moving": sum(axis.set_velocity != 0.0 for axis in axes),
        "axes_in_error": sum(axis.error_code != 0 for axis in axes),
        "clients_known": len(client_figures) + len(others),
        "clients": [
            {
                **station.router.client_row(each),
                "subscriptions": sum(
                    d.notifications.subscriptions_of(each) for d in station.devices
                ),
            }
            for each in [*client_figures.busiest(), *others][:LISTED_CLIENTS]
        ],
        "devices": devices,
        "buses": [_of_bus(name, bus) for name, bus in station.fieldbuses.items()],
    }


def _silent_clients(station: CountedStation) -> list[bytes]:
    """Return the clients that have subscribed and send no requests."""
    client_figures = station.router.client_figures
    subscribed = {
        client: None for device in station.devices for client in device.notifications.clients
    }
    return [client for client in subscribed if client and client not in client_figures]


def _of_bus(name: str, bus: "EthercatBus | InterfaceBus") -> dict[str, Any]:
    """Frames of a bus since their last reset; round trips in seconds."""
    master, trips = bus.master, bus.round_trips
    frames = master.cyclic.counters
    return {
        "name": name,
        "interface": bus.interface,
        "second_interface": bus.second_interface,
        "trouble": bus.trouble,
        "ring_open": bus.master.supervision.opening,
        "slaves": sum(slave.present for slave in master.slaves),
        "slaves_operational": sum(slave.operational for slave in master.slaves),
        "frames": frames.sent,
        "frames_lost": frames.lost,
        "frames_wrong": frames.wrong,
        "round_trips": trips.count,
        "round_trip_mean": trips.mean_ns / 1e9,
        "round_trip_99": trips.within_ns(0.99) / 1e9,
        "round_trip_largest": trips.largest_ns / 1e9,
    }
