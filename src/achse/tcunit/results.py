"""Results of a run of unit tests."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from achse.plc.coverage.results import CoverageResult


class TestOutcome(Enum):
    """Outcome of a test."""

    __test__ = False

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"
    """Its name begins with `disabled_`."""
    UNFINISHED = "unfinished"
    """TEST_FINISHED() was not called in time."""


class CodePlace(NamedTuple):
    """A line of Structured Text. The path is as the project names it; line 0 is not known."""

    path: str
    line: int

    def __str__(self) -> str:
        return f"{self.path}:{self.line}" if self.line else self.path


@dataclass(frozen=True, slots=True)
class Failure:
    """An assertion that did not hold, as TcUnit words it."""

    message: str
    expected: str = ""
    actual: str = ""
    place: CodePlace | None = None
    """Place of the assertion; None if it is unknown."""

    def __str__(self) -> str:
        values = f"expected {self.expected}, got {self.actual}" if self.has_values else ""
        return ": ".join(part for part in (self.message, values) if part) or "failed"

    @property
    def has_values(self) -> bool:
        return bool(self.expected or self.actual)


@dataclass(frozen=True, slots=True)
class UnitTest:
    """One test."""

    suite: str
    """Path of its suite: `PRG_TEST.fbMathTests`."""
    name: str
    outcome: TestOutcome
    duration: float = 0.0
    """Seconds of PLC time."""
    assertions: int = 0
    failures: Sequence[Failure] = ()
    """Every assertion that failed, in order."""
    place: CodePlace | None = None
    """Place of TEST('name'); None if it is unknown."""

    __test__ = False

    @property
    def is_good(self) -> bool:
        return self.outcome in (TestOutcome.PASSED, TestOutcome.SKIPPED)


@dataclass(frozen=True, slots=True)
class Suite:
    """An instance of a block that extends FB_TestSuite."""

    name: str
    tests: Sequence[UnitTest]
    duration: float = 0.0


@dataclass(frozen=True, slots=True)
class TestRun:
    """All of a project. `problem` says why it could not end well, empty if it did."""

    suites: Sequence[Suite] = ()
    duration: float = 0.0
    """Seconds of PLC time."""
    problem: str = ""
    problem_place: CodePlace | None = None
    notes: Sequence[str] = field(default=())
    """Further notes for the user."""
    coverage: CoverageResult | None = None
    """Coverage of the project without its suites, if requested."""

    __test__ = False

    def __iter__(self) -> Iterator[UnitTest]:
        for suite in self.suites:
            yield from suite.tests

    def count(self, outcome: TestOutcome) -> int:
        """Return the number of tests with this outcome."""
        return sum(test.outcome is outcome for test in self)

    @property
    def is_good(self) -> bool:
        """True if there are tests, and all of them passed or are disabled."""
        return not self.problem and any(True for _ in self) and all(test.is_good for test in self)

    def __str__(self) -> str:
        counts = [f"{self.count(outcome)} {outcome.value}" for outcome in TestOutcome]
        shown = [text for text in counts if not text.startswith("0 ")] or ["no tests"]
        return f"{', '.join(shown)} in {self.duration:.9g} s of PLC time"
