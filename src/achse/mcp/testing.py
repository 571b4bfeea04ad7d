"""Unit tests of a project, run by a tool: confined, with progress, cancelled between two cycles."""

import logging
import time
from collections.abc import Callable
from pathlib import Path

from achse.mcp.folder import ProjectFolder
from achse.mcp.results import TestFailure, TestReport, TestResult
from achse.tcunit import TestRun, UnitTest, run_tests
from achse.tcunit.results import TestOutcome

_OFTEN_S = 0.05
"""Seconds between two looks at whether the call was cancelled."""


def unit_test_report(
    folder: ProjectFolder,
    path: Path,
    *,
    limit: float,
    timeout: float,
    most: int,
    everything: bool,
    report: Callable[[float], None],
) -> TestReport:
    """Run the tests of a project; `report` is called now and then, and may end them.

    Raises ProjectError, TcUnitMissing, FolderError.
    """
    looked = time.monotonic()

    def between(plc_time: float) -> None:
        nonlocal looked
        if time.monotonic() - looked > _OFTEN_S:
            looked = time.monotonic()
            report(plc_time)

    if path.suffix.lower() != ".toml":
        folder.sources(path)
    logger = logging.getLogger("achse")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        run = run_tests(
            path,
            libraries=folder.libraries,
            limit=limit,
            timeout=timeout,
            environ={},
            confine=folder.confined,
            between=between,
        )
    finally:
        logger.setLevel(level)
    return _report(run, folder, most, everything)


def _report(run: TestRun, folder: ProjectFolder, most: int, everything: bool) -> TestReport:
    listed = [test for test in run if everything or not test.is_good]
    place = f"{run.problem_place}: " if run.problem_place else ""
    return TestReport(
        ok=run.is_good,
        passed=run.count(TestOutcome.PASSED),
        failed=run.count(TestOutcome.FAILED),
        skipped=run.count(TestOutcome.SKIPPED),
        unfinished=run.count(TestOutcome.UNFINISHED),
        plc_time_s=run.duration,
        problem=f"{place}{run.problem}" if run.problem else "",
        tests=[_result(test, folder) for test in listed[:most]],
        left_out=max(0, len(listed) - most),
    )


def _result(test: UnitTest, folder: ProjectFolder) -> TestResult:
    return TestResult(
        suite=test.suite,
        name=test.name,
        outcome=test.outcome.value,
        failures=[
            TestFailure(
                message=failure.message,
                expected=failure.expected,
                actual=failure.actual,
                file=folder.name(Path(failure.place.path)) if failure.place else "",
                line=failure.place.line if failure.place else 0,
            )
            for failure in test.failures
        ],
    )
