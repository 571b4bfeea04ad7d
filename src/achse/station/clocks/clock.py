"""The clock of the station: the Unix time of its cycles, which all time stamps show.

Station time counts cycles and never leaves any out. `StationClock` maps it to Unix time: evenly
from `epoch_ns` on in virtual time, by the wall clock in a station that runs at its pace.
"""

import time
from bisect import bisect_right
from collections.abc import Callable

from achse.station.clocks.cycle import Cycle

_TOLERANCE_NS = 1_000_000
"""Moves of the mapping below this in all are not worth an entry of its history."""

_HISTORY = 1000
"""Entries of the history: of recordings that ended before them, the oldest entry is right."""


class StationClock:
    """Time stamps: calling it returns the Unix time of the present cycle, ns.

    A stamp is `epoch_ns` + station time. The time of day is read by `align` and `lag_ns` only;
    stamps of later cycles are always greater, whatever happens to the computer's clock.
    """

    def __init__(
        self, cycle: Cycle, epoch_ns: int, time_of_day: Callable[[], int] = time.time_ns
    ) -> None:
        self._cycle = cycle
        self.time_of_day = time_of_day
        """The computer's clock, Unix ns."""
        self.epoch_ns = epoch_ns
        """Unix time at station time 0, as the present mapping has it."""
        self._starts = [0]
        self._epochs = [epoch_ns]
        """The mappings so far, each with the station time it counts from."""

    def __call__(self) -> int:
        return self.epoch_ns + self._cycle.now_ns

    @property
    def time_ns(self) -> int:
        """Station time."""
        return self._cycle.now_ns

    @property
    def lag_ns(self) -> int:
        """Time of day minus the stamp of the present cycle; below 0 if the former was set back."""
        return self.time_of_day() - self()

    def align(self) -> None:
        """Let the present station time be the time of day, unless stamps would go back."""
        self.shift(max(self.lag_ns, 0))

    def shift(self, by_ns: int) -> None:
        """Move the stamps of the cycles to come; by more than minus one cycle."""
        self.epoch_ns += by_ns
        if abs(self.epoch_ns - self._epochs[-1]) < _TOLERANCE_NS:
            return
        start = self._cycle.now_ns + 1
        if self._starts[-1] == start:
            self._epochs[-1] = self.epoch_ns
            return
        self._starts.append(start)
        self._epochs.append(self.epoch_ns)
        if len(self._starts) > _HISTORY:
            del self._starts[0], self._epochs[0]

    def epoch_at(self, time_ns: int) -> int:
        """Return the `epoch_ns` that counted at a station time, to 1 ms."""
        if time_ns >= self._starts[-1]:
            return self.epoch_ns
        return self._epochs[max(bisect_right(self._starts, time_ns) - 1, 0)]
