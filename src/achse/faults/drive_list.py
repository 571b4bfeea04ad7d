"""The faults of the drives of one segment: begins each at its time, ends it, and keeps the list.

A fault begins and ends at times of the segment, so that a test in virtual time sees it at the same
cycle every time.
"""

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

from achse.ethercat import Disturbance, Segment, Slave
from achse.faults.drives import DRIVE_FAULTS, ENDLESS, CableFault, DriveFault, SlaveFault
from achse.faults.fault import MOST_FAULTS, FaultError, FaultState, Undo


@dataclasses.dataclass(slots=True)
class ActiveDriveFault:
    """A fault that waits for its time or is at work."""

    number: int
    fault: DriveFault
    begins_ns: int
    state: FaultState = FaultState.WAITING
    ends_ns: int = ENDLESS
    undos: dict[Slave | None, Callable[[], None]] = dataclasses.field(default_factory=dict)
    """Function that ends the fault, for each slave that it hits; None is the segment."""
    left: Callable[[], int] | None = None
    """Frames still to be hit."""

    def facts(self) -> dict[str, Any]:
        """As JSON has it."""
        hits = 0
        if self.left is not None and isinstance(self.fault, CableFault):
            hits = (self.fault.count or ENDLESS) - self.left()
        elif self.state is FaultState.ACTIVE:
            hits = 1
        fields = self.fault.fields()
        return {"number": self.number, "state": self.state, "hits": hits, "fault": fields}


class DriveFaults:
    """The faults of the drives of one segment: `faults.add("sto", drive=2, lasting=1.5)`.

    Times are those of the segment; `tick` begins and ends what is due.
    """

    def __init__(self, segment: Segment) -> None:
        self._segment = segment
        self._faults: dict[int, ActiveDriveFault] = {}
        self._last = 0

    def __iter__(self) -> Iterator[ActiveDriveFault]:
        """Iterate over the faults that are waiting or active."""
        self.tick()
        return iter(tuple(self._faults.values()))

    def __len__(self) -> int:
        return len(self._faults)

    def add(self, fault: DriveFault | str, /, **fields: Any) -> ActiveDriveFault:
        """Add a fault, or one of this kind with these fields; raises FaultError.

        It begins before this returns unless `at` is later.
        """
        if isinstance(fault, str):
            fault = DRIVE_FAULTS.of({"kind": fault, **fields})
        if isinstance(fault, SlaveFault):
            fault.targets(self._segment)
        if len(self._faults) >= MOST_FAULTS:
            raise FaultError(f"{MOST_FAULTS} faults are there; clear some of them")
        now = self._segment.time.now_ns
        begins = now if fault.at is None else round(fault.at * 1e9)
        self._last += 1
        active = self._faults[self._last] = ActiveDriveFault(self._last, fault, begins)
        self.tick()
        return active

    def clear(self, number: int | None = None) -> None:
        """End one fault, or all. KeyError if there is none with this number."""
        for active in list(self._faults.values()) if number is None else [self._faults[number]]:
            self._finish(active)

    def tick(self) -> None:
        """Begin and end what is due now."""
        now = self._segment.time.now_ns
        for active in tuple(self._faults.values()):
            if active.state is FaultState.WAITING and active.begins_ns <= now:
                active.state = FaultState.ACTIVE
                if active.fault.lasting is not None:
                    active.ends_ns = now + round(active.fault.lasting * 1e9)
                self._begin(active)
            if active.state is FaultState.ACTIVE and (
                now >= active.ends_ns or (active.left is not None and active.left() <= 0)
            ):
                self._finish(active)

    def _finish(self, active: ActiveDriveFault) -> None:
        active.state = FaultState.OVER
        self._faults.pop(active.number, None)
        undos, active.undos = active.undos, {}
        for slave, undo in undos.items():
            other = self._same(active, slave)
            if other is None:
                undo()
            elif slave is not None and other.fault.effect != active.fault.effect:
                undo()
                assert isinstance(other.fault, SlaveFault)
                other.fault.hit(slave, self._segment)

    def _same(self, active: ActiveDriveFault, slave: Slave | None) -> ActiveDriveFault | None:
        """Return the latest other fault at the same place of the slave."""
        match = None
        for each in self._faults.values():
            if (
                each is not active
                and slave in each.undos
                and each.fault.place == active.fault.place
            ):
                match = each
        return match

    def _begin(self, active: ActiveDriveFault) -> None:
        fault = active.fault
        if isinstance(fault, CableFault):
            self._disturb(active, fault)
        elif isinstance(fault, SlaveFault):
            for slave in fault.targets(self._segment):
                other = self._same(active, slave)
                shared = other is not None and other.fault.effect == fault.effect
                if other is not None and shared:
                    undo: Undo | None = other.undos[slave]
                else:
                    undo = fault.begin(slave, self._segment)
                if undo is not None:
                    active.undos[slave] = undo

    def _disturb(self, active: ActiveDriveFault, fault: CableFault) -> None:
        """Disturb frames; the segment counts them by itself."""
        segment = self._segment
        disturbance = segment.disturbance = segment.disturbance or Disturbance()
        fault.disturb(disturbance, fault.count or ENDLESS)
        active.left = lambda: fault.left(disturbance)

        def undo() -> None:
            fault.end(disturbance)
            if disturbance.lose <= 0 and disturbance.counter_frames <= 0:
                segment.disturbance = None

        active.undos[None] = undo
