"""Figures of a running station for Prometheus."""

from collections.abc import Iterator
from typing import Any

from achse.station.clocks.pacing import STEP_BOUNDS_NS, Pace
from achse.station.running.metrics_port import Figure, Figures, families, labelled_families

_FIGURES = (
    Figure("station_seconds", "time", "Station time."),
    Figure("tick_seconds", "tick", "Length of the station's cycle."),
    Figure("late_ticks", "late_ticks", "Cycles begun more than one cycle late.", True),
    Figure("lost_time", "rebases", "Dropped backlogs of more than a second.", True),
    Figure("stamp_lag_seconds", "stamp_lag", "Wall clock minus the stamp of the present cycle."),
    Figure("connections", "connections", "Open TCP connections."),
    Figure("connections_refused", "connections_refused", "Connections not taken.", True),
    Figure("connections_cut_off", "connections_cut_off", "Connections closed by a limit.", True),
    Figure("buffered_bytes", "buffered_bytes", "Bytes that wait on all connections together."),
    Figure("samples_late", "samples_late", "Samples of notifications that came late.", True),
    Figure("registered_ports", "registered_ports", "AMS ports in use."),
    Figure("lost_frames", "lost_frames", "Frames without a receiver.", True),
    Figure("requests_denied", "requests_denied", "Requests without their right.", True),
    Figure("faults", "faults", "Faults in force."),
    Figure("axes", "axes", "Axes of the NC."),
    Figure("axes_moving", "axes_moving", "Axes with a set velocity that is not 0."),
    Figure("axes_in_error", "axes_in_error", "Axes with an error code."),
)

_OF_DEVICES = (
    Figure("device_requests", "requests", "Requests that a device has answered.", True),
    Figure("device_errors", "errors", "Of these, those answered with an error.", True),
    Figure("device_clients", "clients", "Clients that hold something of a device."),
    Figure("device_subscriptions", "subscriptions", "Subscriptions."),
    Figure("device_handles", "handles", "Symbol handles."),
    Figure("device_samples_dropped", "samples_dropped", "Samples dropped by a limit.", True),
)

_OF_BUSES = (
    Figure("bus_slaves", "slaves", "Slaves that answer."),
    Figure("bus_slaves_operational", "slaves_operational", "Of these, in Op with valid data."),
    Figure("bus_frames", "frames", "Cyclic frames sent.", True),
    Figure("bus_frames_lost", "frames_lost", "Cyclic frames that did not come back.", True),
    Figure("bus_frames_wrong", "frames_wrong", "Frames with a wrong working counter.", True),
    Figure("bus_round_trip_seconds", "round_trip_mean", "Mean round trip on the interface."),
    Figure("bus_round_trip_largest_seconds", "round_trip_largest", "The longest round trip."),
)


def station_families(figures: Figures, pace: Pace | None) -> Iterator[Any]:
    """Yield the families of a station, from its statistics and its pace."""
    yield from families(_FIGURES, figures)
    yield from labelled_families(
        *(_OF_DEVICES, figures["devices"], ("device", "port")),
        lambda device: (device["name"], ",".join(map(str, device["ports"]))),
    )
    yield from labelled_families(_OF_BUSES, figures["buses"], ("bus",), lambda bus: (bus["name"],))
    yield _steps(pace)


def _steps(pace: Pace | None) -> Any:
    from prometheus_client.core import HistogramMetricFamily

    counts = [0] * (len(STEP_BOUNDS_NS) + 1) if pace is None else list(pace.steps)
    total, buckets = 0, []
    for bound, count in zip((*STEP_BOUNDS_NS, None), counts, strict=True):
        total += count
        buckets.append(("+Inf" if bound is None else f"{bound / 1e9:g}", total))
    return HistogramMetricFamily(
        "achse_step_seconds",
        "Computing time of one cycle of the station.",
        buckets=buckets,
        sum_value=0.0 if pace is None else pace.computed_ns / 1e9,
    )
