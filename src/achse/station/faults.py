"""Faults on demand: begins each at its time, ends it at its time, and keeps the list.

A fault begins at a station time, so that the same test sees the same fault at the same cycle. Until
one is added nothing of this is in the way of a frame or a cycle.
"""

import heapq
import logging
import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from achse.ams import AdsState
from achse.station.cycle import Cycle, Phase, Place
from achse.station.disturbances import Disturbances
from achse.station.fault import FAULT_KINDS, ActiveFault, Fault, FaultError

if TYPE_CHECKING:
    from achse.station.station import Station

__all__ = ["Agenda", "Faults"]

log = logging.getLogger("achse.faults")


class Agenda(Phase):
    """What begins and ends at a station time; part of the cycle as long as something is due."""

    place, name = Place.FAULTS, "faults"
    due_ns = math.inf

    def __init__(self, cycle: Cycle) -> None:
        self._cycle = cycle
        self._actions: list[tuple[int, int, Callable[[], None]]] = []
        self._sequence = 0

    def add(self, due_ns: int, action: Callable[[], None]) -> None:
        """Call `action` at a station time; with the next cycle if it is over."""
        if not self._actions:
            self._cycle.add(self)
        self._sequence += 1
        heapq.heappush(self._actions, (due_ns, self._sequence, action))
        self.due_ns = self._actions[0][0]

    def step(self, now_ns: int) -> None:
        """Do what is due."""
        actions = self._actions
        while actions and actions[0][0] <= now_ns:
            heapq.heappop(actions)[2]()
        if actions:
            self.due_ns = actions[0][0]
        else:
            self.due_ns = math.inf
            self._cycle.remove(self)


class Faults:
    """The faults of one station: `station.faults.add("drop", port=851, count=1)`."""

    def __init__(self, station: "Station") -> None:
        self._station = station
        self._agenda = Agenda(station.cycle)
        self._faults: dict[int, ActiveFault] = {}
        self._last = 0
        self._disturbances = Disturbances(station, self.later, self._finish)

    def __iter__(self) -> Iterator[ActiveFault]:
        """Those that wait or are at work."""
        return iter(tuple(self._faults.values()))

    def __len__(self) -> int:
        return len(self._faults)

    def add(self, fault: Fault | str, /, **fields: Any) -> ActiveFault:
        """Add a fault, or one of this kind with these fields; raises FaultError.

        It begins before this returns unless `at` lies ahead.
        """
        if isinstance(fault, str):
            fault = Fault.of({"kind": fault, **fields})
        now = self._station.time_ns
        begins = now if fault.at is None else round(fault.at * 1e9)
        self._disturbances.check(fault)
        self._last += 1
        active = ActiveFault(self._last, fault, begins)
        self._faults[active.number] = active
        if begins > now:
            self._agenda.add(begins, lambda: self._begin(active))
        else:
            self._begin(active)
        return active

    def clear(self, number: int | None = None) -> None:
        """End one fault, or all. KeyError if there is none with this number."""
        ending = list(self._faults.values()) if number is None else [self._faults[number]]
        for active in ending:
            self._finish(active)

    def renew(self) -> None:
        """Hit what the station consists of now: devices after a restart, one more listener."""
        for active in self:
            if active.state == "active" and active.fault.kind != "config":
                if active.undo is not None:
                    active.undo()
                    active.undo = None
                try:
                    active.undo = self._disturbances.begin(active)
                except FaultError as failure:
                    log.warning("fault %d hits nothing any more: %s", active.number, failure)
                    self._finish(active)

    def _begin(self, active: ActiveFault) -> None:
        if active.state != "waiting":
            return
        active.state = "active"
        log.info("fault %d begins: %s", active.number, active.fault)
        fault = active.fault
        lasts = FAULT_KINDS[fault.kind].lasts
        try:
            active.undo = self._disturbances.begin(active)
        except Exception as failure:
            if isinstance(failure, FaultError) and lasts and self._station.state != AdsState.RUN:
                log.info("fault %d hits nothing until the station runs again", active.number)
                self._end_in_time(active)
                return
            log.error("fault %d could not begin: %s", active.number, failure)
            self._finish(active)
            if fault.at is None:
                raise
            return
        if lasts:
            self._end_in_time(active)
        else:
            active.hits += 1
            self._finish(active)

    def _end_in_time(self, active: ActiveFault) -> None:
        if active.fault.lasting is not None:
            self.later(active.fault.lasting, lambda: self._finish(active))

    def _finish(self, active: ActiveFault) -> None:
        if active.state == "over":
            return
        active.state = "over"
        self._faults.pop(active.number, None)
        undo, active.undo = active.undo, None
        if undo is not None:
            undo()
        log.info("fault %d is over after %d hits", active.number, active.hits)

    # station time ----------------------------------------------------------------------------

    def later(self, seconds: float, action: Callable[[], None]) -> None:
        """Call `action` in so many seconds of station time."""
        self._agenda.add(self._station.time_ns + round(seconds * 1e9), action)
