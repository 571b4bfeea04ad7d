"""[metrics]: figures of a running station for Prometheus, at a port of its own.

Needs the extra `metrics` (prometheus-client), imported when the port is opened.
"""

import asyncio
import logging
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from achse.extras import needs_extra
from achse.station.clocks.pacing import STEP_BOUNDS_NS, Pace
from achse.station.configuration.http import MetricsConfig
from achse.station.configuration.types import ConfigError

__all__ = ["MetricsPort"]

log = logging.getLogger("achse.station")

_WAIT = 2.0
"""Seconds that the station's loop has to give its figures."""


class _Figure(NamedTuple):
    """A number of the station's statistics."""

    name: str
    """Prometheus' name without `achse_`; counters get `_total` by themselves."""
    key: str
    """Key of the number in `Station.statistics()`."""
    meaning: str
    counts: bool = False
    """True if the number only grows."""


_FIGURES = (
    _Figure("station_seconds", "time", "Station time."),
    _Figure("tick_seconds", "tick", "Length of the station's cycle."),
    _Figure("late_ticks", "late_ticks", "Cycles begun more than one cycle late.", True),
    _Figure("lost_time", "rebases", "Dropped backlogs of more than a second.", True),
    _Figure("stamp_lag_seconds", "stamp_lag", "Wall clock minus the stamp of the present cycle."),
    _Figure("connections", "connections", "Open TCP connections."),
    _Figure("connections_refused", "connections_refused", "Connections not taken.", True),
    _Figure("connections_cut_off", "connections_cut_off", "Connections closed by a limit.", True),
    _Figure("held_bytes", "held_bytes", "Bytes that wait on all connections together."),
    _Figure("samples_late", "samples_late", "Samples of notifications that came late.", True),
    _Figure("registered_ports", "registered_ports", "AMS ports in use."),
    _Figure("lost_frames", "lost_frames", "Frames that nobody was there for.", True),
    _Figure("requests_denied", "requests_denied", "Requests without their right.", True),
    _Figure("faults", "faults", "Faults in force."),
    _Figure("axes", "axes", "Axes of the NC."),
    _Figure("axes_moving", "axes_moving", "Axes with a set velocity that is not 0."),
    _Figure("axes_in_error", "axes_in_error", "Axes with an error code."),
)

_OF_DEVICES = (
    _Figure("device_requests", "requests", "Requests that a device has answered.", True),
    _Figure("device_errors", "errors", "Of these, those answered with an error.", True),
    _Figure("device_clients", "clients", "Clients that hold something of a device."),
    _Figure("device_subscriptions", "subscriptions", "Subscriptions."),
    _Figure("device_handles", "handles", "Symbol handles."),
    _Figure("device_samples_dropped", "samples_dropped", "Samples dropped by a limit.", True),
)

_OF_BUSES = (
    _Figure("bus_slaves", "slaves", "Slaves that answer."),
    _Figure("bus_slaves_operational", "slaves_operational", "Of these, in Op with valid data."),
    _Figure("bus_frames", "frames", "Cyclic frames sent.", True),
    _Figure("bus_frames_lost", "frames_lost", "Cyclic frames that did not come back.", True),
    _Figure("bus_frames_wrong", "frames_wrong", "Frames with a wrong working counter.", True),
    _Figure("bus_round_trip_seconds", "round_trip_mean", "Mean round trip on the interface."),
    _Figure("bus_round_trip_largest_seconds", "round_trip_largest", "The longest round trip."),
)

Figures = Mapping[str, Any]


class MetricsPort:
    """Answers Prometheus from `open` to `close`, by a thread that asks the station's loop.

    `figures()` gives the statistics and is called in the loop; `pace()` the pace, or None.
    """

    def __init__(self, figures: Callable[[], Figures], pace: Callable[[], Pace | None]) -> None:
        self._figures = figures
        self._pace = pace
        self._server: Any = None
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop
        self.host, self.port = "", 0

    def open(self, config: MetricsConfig) -> None:
        """Listen if there is a port. Raises ConfigError without the extra, or if it is taken."""
        if config.port is None:
            return
        try:
            from prometheus_client import GC_COLLECTOR, CollectorRegistry, start_http_server
            from prometheus_client.process_collector import ProcessCollector
        except ImportError:
            raise ConfigError(needs_extra("metrics: the port", "metrics")) from None
        self._loop = asyncio.get_running_loop()
        registry = CollectorRegistry(auto_describe=False)
        ProcessCollector(registry=registry)
        registry.register(GC_COLLECTOR)
        registry.register(self)
        where = config.port, config.host
        try:
            self._server, self._thread = start_http_server(*where, registry=registry)
        except OSError as taken:
            told = f"metrics: {config.host}:{config.port}: {taken.strerror or taken}"
            raise ConfigError(told) from None
        self.port, self.host = self._server.server_port, config.host
        log.info("figures for Prometheus at http://%s:%d/metrics", self.host, self.port)

    async def close(self) -> None:
        """End; a question under way gets its answer."""
        server, self._server = self._server, None
        if server is None or self._thread is None:
            return
        thread = self._thread
        await self._loop.run_in_executor(None, server.shutdown)
        await self._loop.run_in_executor(None, thread.join)
        server.server_close()

    def describe(self) -> list[Any]:
        """Nothing beforehand: devices come and go."""
        return []

    def collect(self) -> Iterator[Any]:
        """Called by Prometheus' thread; the figures come from the loop."""
        asked = asyncio.run_coroutine_threadsafe(self._look(), self._loop)
        yield from asked.result(_WAIT)

    async def _look(self) -> list[Any]:
        from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

        figures = self._figures()
        families: list[Any] = []
        for figure in _FIGURES:
            kind = CounterMetricFamily if figure.counts else GaugeMetricFamily
            families.append(kind(f"achse_{figure.name}", figure.meaning, figures[figure.key]))
        for figure in _OF_DEVICES:
            kind = CounterMetricFamily if figure.counts else GaugeMetricFamily
            family = kind(f"achse_{figure.name}", figure.meaning, labels=("device", "port"))
            for device in figures["devices"]:
                ports = ",".join(map(str, device["ports"]))
                family.add_metric((device["name"], ports), device[figure.key])
            families.append(family)
        for figure in _OF_BUSES:
            kind = CounterMetricFamily if figure.counts else GaugeMetricFamily
            family = kind(f"achse_{figure.name}", figure.meaning, labels=("bus",))
            for bus in figures["buses"]:
                family.add_metric((bus["name"],), bus[figure.key])
            families.append(family)
        families.append(self._steps())
        return families

    def _steps(self) -> Any:
        from prometheus_client.core import HistogramMetricFamily

        pace = self._pace()
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
