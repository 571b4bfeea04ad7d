"""Reach of test suites: which of them run which statements, from the counters of coverage."""

from collections import Counter
from collections.abc import Callable, Mapping, MutableSequence
from dataclasses import dataclass, field
from itertools import compress
from typing import Any

from achse.plc.coverage.counters import CoverageCounters
from achse.plc.lowering.counters import Tally
from achse.tcunit.bench import PlcTests
from achse.tcunit.mutation.operators import Mutant

AT_START = -1
"""Owner of what runs before the first cycle: FB_init, start values."""

ELSEWHERE = 0
"""Owner of what runs in cycles outside of all suites: programs, other tasks."""


@dataclass(frozen=True, slots=True)
class Reached:
    """Suites that run a statement."""

    suites: frozenset[int]
    """Numbers in TcUnit's list, from 1."""
    at_start: bool
    """True if it runs before the first cycle."""
    elsewhere: bool
    """True if it runs outside of suites, too: any test may depend on it."""

    @property
    def is_empty(self) -> bool:
        """True if nothing runs it."""
        return not (self.suites or self.at_start or self.elsewhere)


@dataclass(frozen=True, slots=True)
class SuiteReach:
    """Counts of one PLC by owner: a number of a suite, `AT_START` or `ELSEWHERE`."""

    counts: dict[int, dict[int, int]] = field(default_factory=dict)
    """Counts that are not 0, by owner and number of the counter."""
    _values: dict[str, dict[int, Mapping[int, int]]] = field(default_factory=dict)
    """Values of a routine's counters, by the routine and the owner."""

    def of(self, mutant: Mutant, counters: CoverageCounters) -> Reached:
        """Return the suites that run the statement of a mutant; none if it has no counters."""
        covered = counters.routines.get(mutant.routine.key)
        tallies: list[Tally] = []
        if covered is not None:
            points = covered.counters
            at = mutant.statement
            if mutant.branch is not None:
                tallies = [one.tally for one in points.branches if one.at == mutant.branch]
            tallies = tallies or [one.tally for one in points.statements if one.at == at]
            if mutant.routine.key not in self._values:
                self._values[mutant.routine.key] = {
                    owner: points.values(Counter(counts)) for owner, counts in self.counts.items()
                }
        values = self._values.get(mutant.routine.key, {})
        suites = {
            owner for owner, of in values.items() if any(tally.of(of) > 0 for tally in tallies)
        }
        return Reached(
            frozenset(suites - {AT_START, ELSEWHERE}), AT_START in suites, ELSEWHERE in suites
        )


class _Ledger:
    """Counts of one PLC, moved from the row that code adds to, to the present owner."""

    def __init__(self, counts: MutableSequence[int]) -> None:
        self._row = counts
        self._zeros = [0] * len(counts)
        self._numbers = range(len(counts))
        self.owned: dict[int, dict[int, int]] = {}
        self._owner = AT_START

    def move_to(self, owner: int) -> int:
        """Let another own what is counted from now on; return the owner so far."""
        before, row = self._owner, self._row
        of = self.owned.setdefault(before, {})
        for number in compress(self._numbers, row):
            of[number] = of.get(number, 0) + row[number]
        row[:] = self._zeros
        self._owner = owner
        return before


def reach_of_suites(tests: PlcTests) -> Callable[[], SuiteReach]:
    """Attribute what runs from now on; return what gives the reach so far."""
    counters = tests.counters
    if counters is None:
        return SuiteReach
    ledger = _Ledger(counters.counts)
    ledger.move_to(ELSEWHERE)
    numbers = tests.suite_numbers

    def attributed(function: Callable[..., Any]) -> Callable[..., Any]:
        def run(this: int, *arguments: Any, **named: Any) -> Any:
            before = ledger.move_to(numbers.get(this, ELSEWHERE))
            try:
                return function(this, *arguments, **named)
            finally:
                ledger.move_to(before)

        return run

    tests.wrap_suites(attributed)

    def reach() -> SuiteReach:
        ledger.move_to(ELSEWHERE)
        return SuiteReach(ledger.owned)

    return reach
