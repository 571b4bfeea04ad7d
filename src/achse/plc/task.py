"""PLC tasks: programs called in order once per cycle, and the counters a task keeps about itself."""

from collections.abc import Callable, Sequence
from typing import Protocol

__all__ = ["Cyclic", "Stopwatch", "Task"]


class Cyclic(Protocol):
    """Anything with a cycle: a program."""

    def cycle(self) -> None: ...


Stopwatch = Callable[[], int]
"""Reads a clock in nanoseconds; only differences of its values mean anything."""


class Task:
    """A cyclic task.

    `cycle_ns` > 0; `priority` 0..255, the lowest number runs first; `port` is the AMS port that
    `_TaskInfo` shows for the task. The programs run in the order given.
    """

    __slots__ = (
        "cycle_count",
        "cycle_ns",
        "due_ns",
        "exceed_count",
        "first_cycle",
        "last_exec_ns",
        "name",
        "port",
        "priority",
        "programs",
        "time_ns",
    )

    def __init__(
        self,
        name: str = "PlcTask",
        cycle_ns: int = 10_000_000,
        priority: int = 20,
        programs: Sequence[Cyclic] = (),
        port: int = 350,
    ) -> None:
        if cycle_ns <= 0:
            raise ValueError(f"task {name}: the cycle is more than 0 ns, got {cycle_ns}")
        if not 0 <= priority <= 0xFF:
            raise ValueError(f"task {name}: the priority is 0..255, got {priority}")
        self.name = name
        self.cycle_ns = cycle_ns
        self.priority = priority
        self.programs = list(programs)
        self.port = port
        self.due_ns = cycle_ns
        """When the next cycle is due; always a multiple of the cycle."""
        self.time_ns = 0
        """The due time of the present or last cycle."""
        self.cycle_count = 0
        """Cycles begun since the last reset."""
        self.exceed_count = 0
        """Cycles since the last reset that took longer than the cycle time."""
        self.first_cycle = True
        """True until the first cycle after a start has ended."""
        self.last_exec_ns = 0
        """How long the last cycle took; 0 without a stopwatch."""

    @property
    def exceeded(self) -> bool:
        """Whether the last cycle took longer than the cycle time."""
        return self.last_exec_ns > self.cycle_ns

    def restart(self) -> None:
        """The next cycle is a first one; the counters begin anew."""
        self.cycle_count = self.exceed_count = self.last_exec_ns = 0
        self.first_cycle = True

    def skip(self, now_ns: int) -> None:
        """Pass over all cycles due up to `now_ns`; the next one stays on the grid."""
        if self.due_ns <= now_ns:
            self.due_ns = (now_ns // self.cycle_ns + 1) * self.cycle_ns

    def cycle(self, stopwatch: Stopwatch | None = None) -> None:
        """Call all programs once. What they raise comes through and ends the cycle."""
        self.time_ns = self.due_ns
        self.due_ns += self.cycle_ns
        self.cycle_count = self.cycle_count + 1 & 0xFFFF_FFFF
        if stopwatch is None:
            for program in self.programs:
                program.cycle()
        else:
            began = stopwatch()
            for program in self.programs:
                program.cycle()
            self.last_exec_ns = stopwatch() - began
            self.exceed_count += self.last_exec_ns > self.cycle_ns
        self.first_cycle = False
