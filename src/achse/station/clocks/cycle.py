"""The station's cycle: named phases in a fixed order, each with its own next due moment.

The cycle goes from one due moment to the next and passes over the time between. It reads no clock:
virtual time lets it go on to an end, a running station lets it go on by a tick at a time.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from enum import IntEnum
from operator import attrgetter

IDLE_TICK_NS = 1_000_000
"""Tick of a station without any task."""


class PhasePlace(IntEnum):
    """Place of a phase in the cycle. Phases due at the same moment step in this order."""

    CHANGES = 0
    """Changes of the station's state: what the cycle consists of may be another afterwards."""
    FAULTS = 1
    INPUTS = 2
    """Inputs of the fieldbus."""
    NC = 3
    PLC = 4
    CAMSHAFT = 5
    OUTPUTS = 6
    """Outputs of the fieldbus."""
    NOTIFICATIONS = 7
    SCOPE = 8
    UPKEEP = 9
    """Looking after clients that are gone."""


class Phase(ABC):
    """One phase of the cycle: where it is, what it is called, when it is due, what it does."""

    place: PhasePlace
    name: str
    catches_up = False
    """True if a step does all cycles up to its moment at once. The cycle does not stop for such a
    phase: it brings it up to date before another phase steps. Of several, the first counts."""

    runs_ahead = False
    """True if `run_ahead` may do several steps at once. Of several, the first counts."""

    @property
    @abstractmethod
    def due_ns(self) -> float:
        """Station time of the next step, `math.inf` for never; between two ticks it waits for the
        second. An attribute serves as well as a property."""

    def begin(self, earliest_ns: int) -> None:  # noqa: B027  # not every phase counts
        """Join the cycle; no step can be before `earliest_ns`."""

    @abstractmethod
    def step(self, now_ns: int) -> None:
        """Do what is due at station time `now_ns`; `due_ns` is later afterwards."""

    def run_ahead(self, now_ns: int, latest_ns: int) -> int:
        """Do steps at moments after `now_ns`, up to `latest_ns`, with those of the phase that
        catches up: no other is due. Return the time of the last one, 0 if none was done.
        """
        return 0


class CyclicPhase(Phase):
    """A phase that calls `run(now_ns)` at each multiple of `cycle_ns`. Raises ValueError."""

    due_ns = 0

    def __init__(
        self, place: PhasePlace, name: str, cycle_ns: int, run: Callable[[int], None]
    ) -> None:
        if cycle_ns <= 0:
            raise ValueError(f"phase {name}: expected a cycle above 0 ns, got {cycle_ns}")
        self.place = place
        self.name = name
        self.cycle_ns = cycle_ns
        self._run = run

    def begin(self, earliest_ns: int) -> None:
        """Begin with the first multiple of the cycle from `earliest_ns` on."""
        self.due_ns = -(-earliest_ns // self.cycle_ns) * self.cycle_ns

    def step(self, now_ns: int) -> None:
        """Call `run`; cycles that were left out are not made up for."""
        self.due_ns = now_ns - now_ns % self.cycle_ns + self.cycle_ns
        self._run(now_ns)


class Cycle:
    """Phases, and the station time to which they have come.

    `tick_ns` is the grid of all steps: a station that is paced goes on by one tick at a time.
    """

    def __init__(self, tick_ns: int = IDLE_TICK_NS) -> None:
        self.tick_ns = tick_ns
        self.now_ns = 0
        self._done_ns = 0
        """Station time whose steps are all done; equal to `now_ns` after its steps."""
        self.phases: tuple[Phase, ...] = ()
        """In the order of their steps."""
        self._stops: tuple[Phase, ...] = ()
        """The other phases to whose due moments the cycle goes."""
        self._leader: Phase | None = None
        """The phase that runs ahead, which is not one of the stops."""
        self._follower: Phase | None = None
        """The phase that catches up."""
        self._first: tuple[Phase, ...] = ()
        """Phases before the follower, which need it up to date."""
        self._halted = False

    def add(self, phase: Phase) -> None:
        """Take in one more phase, behind the others of its place."""
        self.replace((), (phase,))

    def remove(self, phase: Phase) -> None:
        """Undo `add`. Unknown is not an error."""
        self.replace((phase,), ())

    def replace(self, old: Iterable[Phase], new: Iterable[Phase]) -> None:
        """Take out the phases `old`, take in `new`; a step of a place that is to come counts."""
        gone, added = list(old), list(new)
        remaining = [phase for phase in self.phases if not any(phase is each for each in gone)]
        earliest = self.now_ns + (self._done_ns == self.now_ns)
        for phase in added:
            phase.begin(earliest)
        phases = self.phases = tuple(sorted((*remaining, *added), key=attrgetter("place")))
        follower = next((phase for phase in phases if phase.catches_up), None)
        self._follower = follower
        leader = self._leader = next((phase for phase in phases if phase.runs_ahead), None)
        self._stops = tuple(each for each in phases if each is not follower and each is not leader)
        self._first = () if follower is None else phases[: phases.index(follower)]

    def halt(self) -> None:
        """Let `go_to` end after this moment."""
        self._halted = True

    def step(self) -> None:
        """Go on by one tick."""
        self._turn(self.now_ns + self.tick_ns)

    def go_to(self, end_ns: int) -> None:
        """Go from one due moment to the next until `end_ns`, or until `halt`."""
        self._halted = False
        while self.now_ns < end_ns and not self._halted:
            due: float = end_ns + 1
            for phase in self._stops:
                moment = phase.due_ns
                if moment < due:
                    due = moment
            leader = self._leader
            if leader is not None and (moment := leader.due_ns) < due:
                latest_ns = min(math.ceil(due) - 1, end_ns)
                reached = leader.run_ahead(self.now_ns, latest_ns)
                if reached:
                    self.now_ns = self._done_ns = reached
                    continue
                due = moment
            self._turn(self._tick_of(due, end_ns))

    def _tick_of(self, due: float, end_ns: int) -> int:
        """Return the next tick from `due` on, at most `end_ns`."""
        if due >= end_ns:
            return end_ns
        tick_ns, now = self.tick_ns, self.now_ns
        if due <= now:  # asked for after its turn
            due = now + 1
        return min(-(-int(due) // tick_ns) * tick_ns, end_ns)

    def _turn(self, now: int) -> None:
        """Take all steps that are due at `now`, in order."""
        self.now_ns = now
        for phase in self._first:
            if phase.due_ns <= now:
                self._catch_up(now)
                break
        phases = self.phases
        for phase in phases:
            if phase.due_ns <= now:
                phase.step(now)
                if self.phases is not phases and phase.place is PhasePlace.CHANGES:
                    self._turn_rest(now)
                    break
        self._done_ns = now

    def _catch_up(self, now: int) -> None:
        """Bring the follower to the tick before `now`."""
        follower = self._follower
        if follower is not None and follower.due_ns < now:
            follower.step(now - 1)

    def _turn_rest(self, now: int) -> None:
        """Take the steps of what the cycle consists of since a change of state."""
        for phase in self.phases:
            if phase.place is not PhasePlace.CHANGES and phase.due_ns <= now:
                phase.step(now)
