"""[metrics]: figures of a running process for Prometheus, at a port of its own.

Needs the extra `metrics` (prometheus-client), imported when the port is opened.
"""

import asyncio
import logging
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from achse.extras import needs_extra
from achse.station.configuration.http import MetricsConfig
from achse.station.configuration.types import ConfigError

log = logging.getLogger("achse.station")

_WAIT = 2.0
"""Seconds that the loop has to give its figures."""

Figures = Mapping[str, Any]


class Figure(NamedTuple):
    """A number of the statistics."""

    name: str
    """Prometheus' name without `achse_`; counters get `_total` by themselves."""
    key: str
    """Key of the number in the statistics."""
    meaning: str
    counts: bool = False
    """True if the number only grows."""


def families(rows: Iterable[Figure], figures: Figures) -> Iterator[Any]:
    """Yield a family of each row."""
    for row in rows:
        yield _kind(row)(f"achse_{row.name}", row.meaning, figures[row.key])


def labelled_families(
    rows: Iterable[Figure],
    all_figures: Iterable[Figures],
    labels: Sequence[str],
    values: Callable[[Figures], Sequence[str]],
) -> Iterator[Any]:
    """Yield a family of each row, with a metric for each of several things; `values` name it."""
    each_labelled = [(values(figures), figures) for figures in all_figures]
    for row in rows:
        family = _kind(row)(f"achse_{row.name}", row.meaning, labels=labels)
        for names, figures in each_labelled:
            family.add_metric(names, figures[row.key])
        yield family


def _kind(row: Figure) -> Any:
    from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

    return CounterMetricFamily if row.counts else GaugeMetricFamily


class MetricsPort:
    """Answers Prometheus from `open` to `close`, by a thread that asks the loop.

    `collected()` returns the families and is called in the loop.
    """

    def __init__(self, collected: Callable[[], Iterable[Any]]) -> None:
        self._collected = collected
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
            message = f"metrics: {config.host}:{config.port}: {taken.strerror or taken}"
            raise ConfigError(message) from None
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
        future = asyncio.run_coroutine_threadsafe(self._look(), self._loop)
        yield from future.result(_WAIT)

    async def _look(self) -> list[Any]:
        return list(self._collected())
