"""The watch over a scope: it has each sample of its channel once, in order, with its value."""

from collections import deque
from collections.abc import Callable

from achse.client.nc.services import services
from achse.motion import Nc
from achse.station import Station
from achse.station.building.scope import StationScope
from achse.station.clocks.cycle import Phase, PhasePlace

_PORT = 500
_RING_S = 0.5
_COMPARED_NS = 250_000_000
"""Time between two comparisons: less than the rings of the scope hold."""


class ScopeWatch(Phase):
    """Phase that notes the set position of an axis, and compares what a scope recorded of it."""

    place, name = PhasePlace.SCOPE, "swarm scope"
    due_ns: float = 0

    def __init__(self, station: Station, epoch_ns: int, report: Callable[[str, str], None]) -> None:
        """`epoch_ns` is the Unix time of the start of the station."""
        self._station = station
        self._epoch_ns = epoch_ns
        self._report = report
        self._nc: Nc | None = None
        self._scope: StationScope | None = None
        self._noted: deque[tuple[int, float]] = deque()
        self._compare_ns = 0
        self.compared = 0
        """Samples that were compared."""

    def begin(self, earliest_ns: int) -> None:
        """Look from the first cycle on."""
        self.due_ns = earliest_ns

    def step(self, now_ns: int) -> None:
        """Note the value of this cycle; compare from time to time."""
        nc = self._station.nc
        if nc is not self._nc:
            self._open(nc, now_ns)
        if nc is None:
            self.due_ns = now_ns + 1_000_000
            return
        self.due_ns = now_ns - now_ns % nc.cycle_ns + nc.cycle_ns
        if now_ns % nc.cycle_ns == 0:
            self._noted.append((now_ns, next(iter(nc)).set_position))
        if now_ns >= self._compare_ns:
            self._compare(now_ns)

    def _open(self, nc: Nc | None, now_ns: int) -> None:
        """Begin again with the NC of a restarted station."""
        self._nc, self._scope = nc, None
        self._noted.clear()
        if nc is None:
            return
        group, offset = services()[0x4100]["set_position"].place(1)
        channel = f"{_PORT}:{group:#x}:{offset:#x}"
        self._scope = self._station.scope(channel, length=_RING_S, name="swarm")
        self._scope.start()
        self._compare_ns = now_ns + _COMPARED_NS

    def _compare(self, now_ns: int) -> None:
        scope = self._scope
        if scope is None:
            return
        self._compare_ns = now_ns + _COMPARED_NS
        for track in scope.data().tracks:
            begin, step = track.block.begin_ns - self._epoch_ns, track.step_ns
            recorded = {begin + n * step: value for n, value in enumerate(track.values)}
            last = begin + (len(track) - 1) * step
            for moment, value in self._noted:
                if begin <= moment <= last:
                    self.compared += 1
                    if recorded.get(moment) != value:
                        self._report(
                            "scope-samples",
                            f"{track.channel.name} at {moment / 1e9:.6f} s: recorded"
                            f" {recorded.get(moment)}, it was {value}",
                        )
                        return
            if now_ns - last > step:
                self._report(
                    "scope-samples",
                    f"{track.channel.name} at {now_ns / 1e9:.6f} s: the last sample is of"
                    f" {last / 1e9:.6f} s",
                )
        self._noted.clear()
