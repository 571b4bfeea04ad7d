"""Counters of all routines that are covered, in one row that both forms of code add to."""

from bisect import bisect_right, insort
from collections.abc import Callable, Iterator, MutableSequence
from typing import NamedTuple

from achse.plc.lowering.counters import RoutineCounters
from achse.plc.lowering.placement import MissingPlaceError
from achse.plc.lowering.project import LoweredProject
from achse.plc.lowering.routines import lowered
from achse.st.typed.project import Routine, RoutineKind


class CoveredRoutine(NamedTuple):
    """A routine and its counters."""

    routine: Routine
    counters: RoutineCounters


def is_own(routine: Routine) -> bool:
    """Return True if a routine is of the project itself, not of a library."""
    return not routine.source.library


class CoverageCounters:
    """Counters of the routines of a project that are `wanted`.

    Lowering places them from then on. What the checker makes of declarations has none.
    """

    def __init__(self, project: LoweredProject, wanted: Callable[[Routine], bool]) -> None:
        self.routines: dict[str, CoveredRoutine] = {}
        self.size = 0
        for key, routine in project.typed.routines.items():
            if not routine.body or routine.kind is RoutineKind.LIFE or not wanted(routine):
                continue
            project.counted[key] = self.size
            try:
                counters = lowered(project, routine).counters
            except (MissingPlaceError, RecursionError):
                del project.counted[key]
                continue
            assert counters is not None
            self.routines[key] = CoveredRoutine(routine, counters)
            self.size += counters.size
        self.counts: MutableSequence[int] = [0] * self.size
        """Row that code adds to; machine code has one of its own."""

    def count(self, number: int) -> None:
        """Add one."""
        self.counts[number] += 1

    def clear(self) -> None:
        """Begin again from 0."""
        for number in range(self.size):
            self.counts[number] = 0

    def take_over(self, earlier: "CoverageCounters") -> None:
        """Keep the counts of routines that an online change leaves as they are."""
        texts = _Texts(earlier), _Texts(self)
        for key, (routine, counters) in self.routines.items():
            known = earlier.routines.get(key)
            if known is None or known.counters.size != counters.size:
                continue
            if texts[0].of(known.routine) != texts[1].of(routine):
                continue
            start, old = counters.first, known.counters.first
            for number in range(counters.size):
                self.counts[start + number] = earlier.counts[old + number]

    def __iter__(self) -> Iterator[CoveredRoutine]:
        return iter(self.routines.values())


class _Texts:
    """Texts of routines: from the name to the name of the next in the source."""

    def __init__(self, counters: CoverageCounters) -> None:
        self._begins: dict[int, list[int]] = {}
        for routine, _ in counters:
            insort(self._begins.setdefault(id(routine.source), []), routine.at)

    def of(self, routine: Routine) -> tuple[str, bytes]:
        """Return the text; of a source with drawings all of it."""
        source = routine.source
        if source.drawings:
            return "", source.digest
        begins = self._begins[id(source)]
        later = begins[bisect_right(begins, routine.at) :]
        return source.text[routine.at : later[0] if later else None], b""
