"""Outcomes of tests, as a tool reports them."""

from pathlib import Path

import pytest

from achse.mcp.folder import FolderError, ProjectFolder
from achse.mcp.results import TestReport
from achse.mcp.testing import unit_test_report


def _run(folder: Path, project: str, *, everything: bool = False, most: int = 99) -> TestReport:
    return unit_test_report(
        ProjectFolder(folder),
        folder / project,
        limit=10.0,
        timeout=60.0,
        most=most,
        everything=everything,
        report=lambda passed: None,
    )


def test_failures_have_values_and_a_place_in_the_folder(folder: Path) -> None:
    report = _run(folder, "station.toml")
    assert (report.passed, report.failed, len(report.tests)) == (20, 10, 10)
    wrong = next(test for test in report.tests if test.name == "wrong mean")
    [failure] = wrong.failures
    assert (failure.expected, failure.actual) == ("2.0", "1.5")
    assert failure.file == "press/POUs/FB_NumberTests.TcPOU"
    assert failure.line > 0
    assert len(_run(folder, "station.toml", everything=True).tests) == 30
    assert _run(folder, "station.toml", most=3).left_out == 7


def test_tcunit_outside_of_the_folder_is_not_read(folder: Path) -> None:
    (folder / "TcUnit").rename(folder.parent / "TcUnit")
    with pytest.raises(FolderError, match="outside"):
        _run(folder, "press")
