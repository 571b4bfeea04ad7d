"""`achse test` runs the TcUnit tests of a PLC project."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.failure import fail
from achse.cli.logs import LogFormat, LogLevel, set_up_logs
from achse.cli.options import Library, TestedProject
from achse.cli.test.measures import (
    FailUnder,
    PlcTimeLimit,
    check_endings,
    reaches,
    without_log,
    write_reports,
)

if TYPE_CHECKING:
    from achse.plc.coverage.results import CoverageResult
    from achse.tcunit import TestRun, UnitTest


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command("test")(run_unit_tests)


def run_unit_tests(
    project: TestedProject,
    library: Library = None,
    junit: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the results as JUnit XML.", show_default=False),
    ] = None,
    limit: PlcTimeLimit = 60.0,
    timeout: Annotated[
        float,
        typer.Option(metavar="SECONDS", min=0.001, help="Real time that they may take."),
    ] = 600.0,
    coverage: Annotated[
        bool, typer.Option("--coverage", help="Print what the tests have run of the project.")
    ] = False,
    mcdc: Annotated[
        bool,
        typer.Option("--mcdc", help="The same with the conditions that were shown to decide."),
    ] = False,
    coverage_report: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Write that as .html, .info (lcov), .xml (Cobertura) or .txt.",
            show_default=False,
        ),
    ] = None,
    fail_under: FailUnder = None,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Name the tests that pass, too.")
    ] = False,
    log_level: Annotated[
        LogLevel | None,
        typer.Option(help="What the station logs, on stderr.", show_default="nothing"),
    ] = None,
) -> None:
    """Run the unit tests of a PLC project: suites of TcUnit, in virtual time.

    TcUnit is not part of achse: its sources are found by --library, the variable ACHSE_TCUNIT,
    `libraries` of the station.toml, or in a folder TcUnit beside the project. Ends with 1 if a
    test fails or does not end.

    Coverage counts statements and branches of the project without its suites and libraries. With
    --mcdc it also counts conditions of decisions (masking MC/DC).
    """
    from achse.plc.coverage.report import FORMS
    from achse.tcunit import ProjectError, TcUnitMissing, junit_xml, run_tests

    check_endings("--coverage-report", coverage_report or [], FORMS)
    coverage = coverage or mcdc
    measures = coverage or bool(coverage_report) or fail_under is not None
    if log_level is not None:
        set_up_logs(LogFormat.TEXT, log_level)
    try:
        with without_log(log_level is None):
            run = run_tests(
                project,
                libraries=library or [],
                limit=limit,
                timeout=timeout,
                coverage="conditions" if mcdc else measures,
            )
    except (ProjectError, TcUnitMissing) as refusal:
        fail(str(refusal))
    _show(run, verbose)
    if junit is not None:
        write_reports([junit], lambda _: junit_xml(run))
    is_enough = True
    if run.coverage is not None:
        is_enough = _report_coverage(run.coverage, coverage, coverage_report or [], fail_under)
    if not run.is_good or not is_enough:
        raise typer.Exit(1)


def _report_coverage(
    result: "CoverageResult", shows: bool, files: list[Path], least: float | None
) -> bool:
    """Print and write coverage; return False if it is below the least."""
    from achse.plc.coverage.report import report_of
    from achse.plc.coverage.text import summary_of

    if shows:
        print(summary_of(result))
    write_reports(files, lambda file: report_of(result, file))
    return reaches("coverage", result.covered.percent, least)


def _show(run: "TestRun", verbose: bool) -> None:
    for test in run:
        if verbose or not test.is_good:
            _show_test(test)
    if run.problem:
        place = f"{run.problem_place}: " if run.problem_place else ""
        print(f"{place}error: {run.problem}")
    print(run)


def _show_test(test: "UnitTest") -> None:
    print(f"{test.suite}: {test.name}: {test.outcome.value}")
    for failure in test.failures:
        place = f"{failure.place}: " if failure.place else ""
        print(f"    {place}{failure}")
    if test.outcome.value == "unfinished":
        place = f"{test.place}: " if test.place else ""
        print(f"    {place}TEST_FINISHED() was not called")
