"""Unit tests of a PLC project as pytest's items: what the plugin collects."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from achse.tcunit import CodePlace, ProjectError, TcUnitMissing, TestRun, UnitTest, run_tests
from achse.tcunit.results import TestOutcome


class PlcTestFailure(Exception):
    """A test of the project failed, or did not end."""


class PlcProject(pytest.File):
    """A project, which runs while its tests are collected."""

    def collect(self) -> Iterable[pytest.Item]:
        """One item for each test; one more if something is wrong with the whole run."""
        try:
            run = run_tests(self.path, libraries=self.config.getini("achse_plc_libraries"))
        except (ProjectError, TcUnitMissing) as refusal:
            raise self.CollectError(str(refusal)) from None
        for test in run:
            yield PlcTest.from_parent(self, name=f"{test.suite}::{test.name}", test=test)
        if run.problem:
            yield PlcRun.from_parent(self, name="project", run=run)


class PlcTest(pytest.Item):
    """One test of the project."""

    def __init__(self, *, test: UnitTest, **settings: Any) -> None:
        super().__init__(**settings)
        self.test = test

    def runtest(self) -> None:
        """Report the outcome when the project ran."""
        test = self.test
        if test.outcome is TestOutcome.SKIPPED:
            pytest.skip("its name begins with disabled_")
        if test.is_good:
            return
        lines = [_line(failure.place, str(failure)) for failure in test.failures]
        if test.outcome is TestOutcome.UNFINISHED:
            lines.append(_line(test.place, "TEST_FINISHED() was not called"))
        raise PlcTestFailure("\n".join(lines))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> str:
        """Return the lines of Structured Text instead of ours."""
        return _shown(excinfo) or str(super().repr_failure(excinfo, style))

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Return the place of TEST in the sources."""
        place = self.test.place
        if place is None:
            return self.path, None, self.name
        return Path(place.path), place.line - 1, self.name


class PlcRun(pytest.Item):
    """Item for a problem with a run as a whole."""

    def __init__(self, *, run: TestRun, **settings: Any) -> None:
        super().__init__(**settings)
        self._run = run

    def runtest(self) -> None:
        """Fail with it."""
        raise PlcTestFailure(_line(self._run.problem_place, self._run.problem))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> str:
        """Return the problem of the run, without a traceback."""
        return _shown(excinfo) or str(super().repr_failure(excinfo, style))

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Return the project."""
        return self.path, None, self.name


def _line(place: CodePlace | None, text: str) -> str:
    return f"{place}: {text}" if place else text


def _shown(excinfo: pytest.ExceptionInfo[BaseException]) -> str:
    return str(excinfo.value) if isinstance(excinfo.value, PlcTestFailure) else ""
