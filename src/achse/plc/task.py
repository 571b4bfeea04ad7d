"""PLC tasks: programs called in order once per cycle, with counters about it."""

from collections.abc import Callable, Sequence

from achse.iec import Program

Stopwatch = Callable[[], int]
"""Reads a clock in nanoseconds; only differences of its values mean anything."""


class Task:
    """A cyclic task.

    `cycle_ns` > 0; `priority` 0..255, the lowest number runs first; `port` is the AMS port that
    `_TaskInfo` shows for the task, 0 for 350 and up in the order of the tasks. The programs run
    in the order given, once the PLC has made instances of them. A program with an annotation
    `task: Task` is given its task. `watchdog_cycles` is the task option of that name: after so many
    cycles in a row that took too long the log warns; 0 for never.
    """

    __slots__ = (
        "calls",
        "cycle_count",
        "cycle_ns",
        "due_ns",
        "exceed_count",
        "exceeds_in_a_row",
        "first_cycle",
        "last_exec_ns",
        "name",
        "port",
        "priority",
        "programs",
        "stretch",
        "time_ns",
        "watchdog_cycles",
    )

    def __init__(
        self,
        name: str = "PlcTask",
        cycle_ns: int = 10_000_000,
        programs: Sequence[type[Program]] = (),
        *,
        priority: int = 20,
        port: int = 0,
        watchdog_cycles: int = 0,
    ) -> None:
        if cycle_ns <= 0:
            raise ValueError(f"task {name}: the cycle is more than 0 ns, got {cycle_ns}")
        if not 0 <= priority <= 0xFF:
            raise ValueError(f"task {name}: the priority is 0..255, got {priority}")
        self.name = name
        self.cycle_ns = cycle_ns
        self.priority = priority
        self.programs = tuple(programs)
        self.port = port
        self.calls: list[Callable[[], object]] = []
        """Functions that a cycle calls: the `cycle` methods of the program instances."""
        self.due_ns = cycle_ns
        """Time at which the next cycle is due; always a multiple of the cycle."""
        self.time_ns = 0
        """The due time of the present or last cycle."""
        self.cycle_count = 0
        """Cycles begun since the last reset, modulo 2**32."""
        self.exceed_count = 0
        """Cycles since the last reset that took longer than the cycle time."""
        self.watchdog_cycles = watchdog_cycles
        self.exceeds_in_a_row = 0
        """Cycles up to the last one that took longer than the cycle time."""
        self.first_cycle = True
        """True until the first cycle after a start has ended."""
        self.last_exec_ns = 0
        """Duration of the last cycle; 0 without a stopwatch."""

        self.stretch = 1
        """Cycle times that a cycle takes; above 1 it exceeds, and those it covers are lost."""

    @property
    def exceeded(self) -> bool:
        """True if the last cycle took longer than the cycle time."""
        return self.last_exec_ns > self.cycle_ns

    def clear_counters(self) -> None:
        """Reset the counters."""
        self.cycle_count = self.exceed_count = self.last_exec_ns = 0
        self.exceeds_in_a_row = 0

    def skip(self, now_ns: int) -> None:
        """Pass over all cycles due up to `now_ns`; the next one stays on the grid."""
        if self.due_ns <= now_ns:
            self.due_ns = (now_ns // self.cycle_ns + 1) * self.cycle_ns

    def begin(self) -> None:
        """Take the next point of the grid as the present cycle."""
        self.time_ns = self.due_ns
        self.due_ns += self.cycle_ns
        self.cycle_count = self.cycle_count + 1 & 0xFFFF_FFFF

    def cycle(self, stopwatch: Stopwatch | None = None) -> None:
        """Call all programs once. What they raise comes through and ends the cycle."""
        if stopwatch is None:
            for call in self.calls:
                call()
        else:
            began = stopwatch()
            for call in self.calls:
                call()
            self.last_exec_ns = stopwatch() - began
            self.exceed_count += self.last_exec_ns > self.cycle_ns
        if self.stretch > 1:
            self.last_exec_ns = self.stretch * self.cycle_ns
            self.exceed_count += 1
            self.due_ns += self.last_exec_ns - self.cycle_ns
        self.exceeds_in_a_row = self.exceeds_in_a_row + 1 if self.exceeded else 0
        self.first_cycle = False
