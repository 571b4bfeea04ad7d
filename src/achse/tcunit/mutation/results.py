"""Results of mutation testing: each mutant, and what the tests made of it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property

from achse.plc.coverage.results import percentage
from achse.st.lexis.source import Source
from achse.tcunit.mutation.edits import TextEdit
from achse.tcunit.mutation.operators import MutationOperator


class MutantOutcome(Enum):
    """Outcome of a mutant."""

    KILLED = "killed"
    """A test failed that passes without the fault, or the PLC stopped with an exception."""
    TIMEOUT = "timeout"
    """The tests did not end, or a cycle did not: noticed as well."""
    SURVIVED = "survived"
    NOT_COVERED = "not covered"
    """No test runs the statement."""
    EQUIVALENT = "equivalent"
    """Marked as equivalent by the user, and not tried."""


@dataclass(frozen=True, slots=True)
class MutantResult:
    """A mutant and its outcome."""

    path: str
    """File, as it can be opened from here."""
    source: Source
    routine: str
    line: int
    column: int
    place: str
    """Place in a drawing; empty in text."""
    fault: MutationOperator
    change: str
    edit: TextEdit | None
    outcome: MutantOutcome
    test: str = ""
    """The test that noticed, `PRG_TEST.fbMath: adds`; or what stopped the PLC."""
    tests: int = 0
    """Number of tests that were to run."""

    @property
    def location(self) -> str:
        """File and line, or place in a drawing."""
        return f"{self.path}:{self.place or self.line}"

    @property
    def lines(self) -> tuple[list[str], list[str]]:
        """Lines of the code before and after the change; none of a drawing."""
        if self.edit is None:
            return [], []
        text, (start, end, new) = self.source.text, self.edit
        first = text.rfind("\n", 0, start) + 1
        first = max([first, *(one.start for one in self.source.pieces if one.start <= start)])
        last = text.find("\n", end)
        later = [one.start for one in self.source.pieces if one.start >= max(end, start + 1)]
        last = min([len(text) if last < 0 else last, *later])
        old = text[first:last].split("\n")
        changed = (text[first:start] + new + text[end:last]).split("\n")
        return _shortened(old, changed)


def _shortened(old: list[str], new: list[str]) -> tuple[list[str], list[str]]:
    """Return both without equal lines at the end."""
    while len(old) > 1 and len(new) > 1 and old[-1] == new[-1]:
        old, new = old[:-1], new[:-1]
    return old, new


class MutationScore:
    """Numbers of mutants by outcome."""

    def __init__(self, outcomes: Iterator[MutantOutcome]) -> None:
        self.counts = dict.fromkeys(MutantOutcome, 0)
        for one in outcomes:
            self.counts[one] += 1

    @property
    def noticed(self) -> int:
        """Mutants that the tests noticed."""
        return self.counts[MutantOutcome.KILLED] + self.counts[MutantOutcome.TIMEOUT]

    @property
    def covered(self) -> int:
        """Mutants that some test runs."""
        return self.noticed + self.counts[MutantOutcome.SURVIVED]

    @property
    def percent(self) -> float:
        """Share of noticed mutants among all; 100 of none. Equivalent ones do not count."""
        return percentage(self.noticed, self.covered + self.counts[MutantOutcome.NOT_COVERED])

    @property
    def covered_percent(self) -> float:
        """Share of noticed mutants among those that are covered."""
        return percentage(self.noticed, self.covered)


@dataclass(frozen=True)
class MutationRun:
    """Results of all mutants, by file and place."""

    mutants: Sequence[MutantResult]
    planted: int
    """Number of mutants of the project; more than are here if only some were drawn."""
    failing: Sequence[str] = ()
    """Tests that do not pass without any fault: they notice nothing."""
    dependent: Sequence[str] = ()
    """Suites that give another result without the others: they run with all of them."""

    @cached_property
    def score(self) -> MutationScore:
        return MutationScore(one.outcome for one in self.mutants)

    def by_file(self) -> dict[str, list[MutantResult]]:
        """Mutants by path."""
        by_file: dict[str, list[MutantResult]] = {}
        for one in self.mutants:
            by_file.setdefault(one.path, []).append(one)
        return by_file
