"""What a run of unit tests gives."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

__all__ = ["CodePlace", "Failure", "Suite", "TestOutcome", "TestRun", "UnitTest"]


class TestOutcome(Enum):
    """How a test ended."""

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
    """Where the assertion is."""

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
    """Where its suite is: `PRG_TEST.fbMathTests`."""
    name: str
    outcome: TestOutcome
    duration: float = 0.0
    """Seconds of PLC time."""
    assertions: int = 0
    failures: Sequence[Failure] = ()
    """Every assertion that failed, in order."""
    place: CodePlace | None = None
    """Where TEST('name') is."""

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
    """What else is worth to know."""

    __test__ = False

    def __iter__(self) -> Iterator[UnitTest]:
        for suite in self.suites:
            yield from suite.tests

    def count(self, outcome: TestOutcome) -> int:
        """How many tests ended so."""
        return sum(test.outcome is outcome for test in self)

    @property
    def is_good(self) -> bool:
        """Whether there are tests, and all of them passed or are disabled."""
        return not self.problem and any(True for _ in self) and all(test.is_good for test in self)

    def __str__(self) -> str:
        counts = [f"{self.count(outcome)} {outcome.value}" for outcome in TestOutcome]
        shown = [text for text in counts if not text.startswith("0 ")] or ["no tests"]
        return f"{', '.join(shown)} in {self.duration:.9g} s of PLC time"
