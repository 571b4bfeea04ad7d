"""Faults on demand: begins each at its time, ends it at its time, and keeps the list.

A fault begins at a station time, so that the same test sees the same fault at the same cycle. Until
one is added nothing of this is in the way of a frame or a cycle.
"""

import logging
from collections.abc import Callable, Iterator
from typing import Any

from achse.ams import AdsState
from achse.faults.fault import (
    MOST_FAULTS,
    ActiveFault,
    FaultError,
    FaultState,
    LastingFault,
    Undo,
)
from achse.faults.kinds import STATION_FAULTS
from achse.faults.runtimes import Config
from achse.faults.site import Site, StationFault
from achse.faults.target import FaultyStation

log = logging.getLogger("achse.faults")


class Faults:
    """The faults of one station: `station.faults.add("drop", port=851, count=1)`."""

    def __init__(self, station: FaultyStation) -> None:
        self._station = station
        self._faults: dict[int, ActiveFault] = {}
        self._last = 0
        self._site = Site(station, self.later, self._finish)

    def __iter__(self) -> Iterator[ActiveFault]:
        """Iterate over the faults that are waiting or active."""
        return iter(tuple(self._faults.values()))

    def __len__(self) -> int:
        return len(self._faults)

    def add(self, fault: StationFault | str, /, **fields: Any) -> ActiveFault:
        """Add a fault, or one of this kind with these fields; raises FaultError.

        It begins before this returns unless `at` is later.
        """
        if isinstance(fault, str):
            fault = STATION_FAULTS.of({"kind": fault, **fields})
        now = self._station.time_ns
        begins = now if fault.at is None else round(fault.at * 1e9)
        fault.check(self._site)
        if len(self._faults) >= MOST_FAULTS:
            raise FaultError(f"{MOST_FAULTS} faults are there; clear some of them")
        self._last += 1
        active = ActiveFault(self._last, fault, begins)
        self._faults[active.number] = active
        if begins > now:
            self._plan(active, begins, lambda: self._begin(active))
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
            if active.state is FaultState.ACTIVE and not isinstance(active.fault, Config):
                if active.undo is not None:
                    active.undo()
                    active.undo = None
                try:
                    active.undo = self._hit(active)
                except FaultError as failure:
                    log.warning("fault %d hits nothing any more: %s", active.number, failure)
                    self._finish(active)

    def _begin(self, active: ActiveFault) -> None:
        if active.state is not FaultState.WAITING:
            return
        active.state = FaultState.ACTIVE
        log.info("fault %d begins: %s", active.number, active.fault)
        fault = active.fault
        lasts = isinstance(fault, LastingFault)
        try:
            active.undo = self._hit(active)
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

    def _hit(self, active: ActiveFault) -> Undo | None:
        assert isinstance(active.fault, StationFault)
        return active.fault.begin(self._site, active)

    def _end_in_time(self, active: ActiveFault) -> None:
        fault = active.fault
        if isinstance(fault, LastingFault) and fault.lasting is not None:
            end = self._station.time_ns + round(fault.lasting * 1e9)
            self._plan(active, end, lambda: self._finish(active))

    def _plan(self, active: ActiveFault, due_ns: int, action: Callable[[], None]) -> None:
        active.planned = action
        self._station.at(due_ns, action)

    def _finish(self, active: ActiveFault) -> None:
        if active.state is FaultState.OVER:
            return
        active.state = FaultState.OVER
        self._faults.pop(active.number, None)
        planned, active.planned = active.planned, None
        if planned is not None:
            self._station.forget(planned)
        undo, active.undo = active.undo, None
        if undo is not None:
            undo()
        log.info("fault %d is over after %d hits", active.number, active.hits)

    # station time ----------------------------------------------------------------------------

    def later(self, seconds: float, action: Callable[[], None]) -> None:
        """Call `action` in so many seconds of station time, between two cycles as frames are."""
        self._station.after(self._station.time_ns + round(seconds * 1e9), action)
