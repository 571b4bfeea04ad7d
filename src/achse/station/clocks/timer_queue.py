"""Timer queue: actions at station times, a phase of the cycle while any is pending."""

import heapq
import math
from collections.abc import Callable

from achse.station.clocks.cycle import Cycle, Phase, PhasePlace


class TimerQueue(Phase):
    """Queue of actions in station time, such as begins and ends of faults."""

    due_ns = math.inf

    def __init__(
        self, cycle: Cycle, place: PhasePlace = PhasePlace.FAULTS, name: str = "faults"
    ) -> None:
        self.place, self.name = place, name
        self._cycle = cycle
        self._actions: list[tuple[int, int, Callable[[], None]]] = []
        self._sequence = 0

    def add(self, due_ns: int, action: Callable[[], None]) -> None:
        """Call `action` at a station time; in the next cycle if that time has passed."""
        if not self._actions:
            self._cycle.add(self)
        self._sequence += 1
        heapq.heappush(self._actions, (due_ns, self._sequence, action))
        self.due_ns = self._actions[0][0]

    def forget(self, action: Callable[[], None]) -> None:
        """Remove this `action` from the queue, if it is there."""
        remaining = [entry for entry in self._actions if entry[2] is not action]
        if len(remaining) < len(self._actions):
            heapq.heapify(remaining)
            self._actions = remaining
            self._look()

    def step(self, now_ns: int) -> None:
        """Call the actions that are due."""
        while self._actions and self._actions[0][0] <= now_ns:
            heapq.heappop(self._actions)[2]()
        self._look()

    def _look(self) -> None:
        if self._actions:
            self.due_ns = self._actions[0][0]
        else:
            self.due_ns = math.inf
            self._cycle.remove(self)
