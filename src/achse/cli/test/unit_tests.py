"""`achse test` runs the TcUnit tests of a PLC project."""

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.failure import fail
from achse.cli.logs import LogFormat, LogLevel, set_up_logs
from achse.cli.options import Library

if TYPE_CHECKING:
    from achse.tcunit import TestRun, UnitTest

__all__ = ["register"]


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command("test")(run_unit_tests)


def run_unit_tests(
    project: Annotated[
        Path,
        typer.Argument(
            help="A folder with PLC sources, a .plcproj, one source file, or a station.toml.",
            show_default=False,
        ),
    ],
    library: Library = None,
    junit: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the results as JUnit XML.", show_default=False),
    ] = None,
    limit: Annotated[
        float,
        typer.Option(metavar="SECONDS", min=0.001, help="PLC time that the tests may take."),
    ] = 60.0,
    timeout: Annotated[
        float,
        typer.Option(metavar="SECONDS", min=0.001, help="Real time that they may take."),
    ] = 600.0,
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
    """
    from achse.tcunit import ProjectError, TcUnitMissing, junit_xml, run_tests

    if log_level is not None:
        set_up_logs(LogFormat.TEXT, log_level)
    logger = logging.getLogger("achse")
    before = logger.level
    try:
        if log_level is None:
            logger.setLevel(logging.CRITICAL + 1)
        run = run_tests(project, libraries=library or [], limit=limit, timeout=timeout)
    except (ProjectError, TcUnitMissing) as refusal:
        fail(str(refusal))
    finally:
        logger.setLevel(before)
    _show(run, verbose)
    if junit is not None:
        try:
            junit.write_text(junit_xml(run), encoding="utf-8")
        except OSError as failure:
            fail(f"{junit}: {failure.strerror}")
    if not run.is_good:
        raise typer.Exit(1)


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
