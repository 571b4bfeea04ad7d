"""`achse mutate` plants faults in a PLC project and lists those that no test notices."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.failure import fail
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
    from achse.tcunit.mutation.results import MutationRun


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command("mutate")(mutate)


def mutate(
    project: TestedProject,
    library: Library = None,
    sample: Annotated[
        int | None,
        typer.Option(min=1, help="Number of mutants to draw.", show_default="all"),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the draw.")] = 1,
    jobs: Annotated[int, typer.Option("--jobs", "-j", min=1, help="Runs at the same time.")] = 1,
    limit: PlcTimeLimit = 60.0,
    report: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="Write the results as .html, .json (mutation-testing-elements) or .txt.",
            show_default=False,
        ),
    ] = None,
    fail_under: FailUnder = None,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Name the mutants that are killed, too.")
    ] = False,
) -> None:
    """Plant small faults in a PLC project and list those that its unit tests do not notice.

    A mutant is the project with one fault: another operator, constant or condition, a statement
    less. Each runs in virtual time with the suites that execute its statement. Mutants that no test
    can notice are marked by a comment `achse: equivalent`, or in the table `mutate` of achse.toml.
    """
    from achse.st.lint.options import LintOptionsError
    from achse.tcunit import ProjectError, TcUnitMissing
    from achse.tcunit.mutation.campaign import run_mutants
    from achse.tcunit.mutation.marks import mutation_options
    from achse.tcunit.mutation.report import FORMS

    check_endings("--report", report or [], FORMS)
    try:
        with without_log():
            run = run_mutants(
                project,
                libraries=library or [],
                limit=limit,
                sample=sample,
                seed=seed,
                jobs=jobs,
                options=mutation_options(project),
            )
    except LintOptionsError as failure:
        fail(str(failure), name="INVALID_FILE")
    except (ProjectError, TcUnitMissing) as refusal:
        fail(str(refusal))
    if not _report(run, report or [], fail_under, verbose):
        raise typer.Exit(1)


def _report(run: "MutationRun", files: list[Path], least: float | None, verbose: bool) -> bool:
    """Print and write results; return False if the tests notice less than the least."""
    from achse.tcunit.mutation.report import report_of, summary_of

    print(summary_of(run, shows_all=verbose))
    write_reports(files, lambda file: report_of(run, file))
    return reaches("mutants noticed", run.score.percent, least)
