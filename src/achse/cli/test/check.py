"""`achse check` looks at a station.toml, or at the sources of a PLC project, without running it."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.options import Library
from achse.cli.target import Json


class ReportFormat(StrEnum):
    """Form in which a check reports."""

    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"
    JUNIT = "junit"
    GITHUB = "github"


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(check)


def check(
    file: Annotated[
        Path,
        typer.Argument(
            help="A station.toml or a solution (.sln, .tsproj); or a folder with PLC sources, a"
            " .plcproj, one source file.",
            show_default=False,
        ),
    ],
    library: Library = None,
    define: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="What {IF defined (NAME)} finds, once for each."),
    ] = None,
    warnings: Annotated[
        bool, typer.Option(help="Report conversions that may lose values, too.")
    ] = True,
    machine: Annotated[
        bool,
        typer.Option(
            "--machine", help="Report code that cannot become machine code, with the reason."
        ),
    ] = False,
    stubs: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Write declarations for names that the sources use and nothing declares.",
            show_default=False,
        ),
    ] = None,
    check_all: Annotated[
        bool,
        typer.Option(
            "--all",
            help="Take errors in units that no task reaches as errors, list all that follow from"
            " missing libraries.",
        ),
    ] = False,
    report: Annotated[
        ReportFormat,
        typer.Option(
            "--format",
            help="Form of the report on a project; --json is the same as --format json.",
        ),
    ] = ReportFormat.TEXT,
    lint: Annotated[
        bool | None,
        typer.Option(
            "--lint/--no-lint",
            help="Switch all rules of the linter on or off; else achse.toml of a project decides.",
            show_default=False,
        ),
    ] = None,
    watch: Annotated[
        bool,
        typer.Option("--watch", help="Check a project again after each change of its files."),
    ] = False,
    in_json: Json = False,
) -> None:
    """Check a station.toml or a PLC project, and try the first cycles of its PLCs.

    Warnings of a station.toml name what the sources of a PLC say and only a running program could
    do. Of a project every declaration and statement is checked; errors and warnings have file,
    line, column, a caret, and a code for `achse explain`. Errors in units that no program of a task
    reaches are warnings. Ends with 1 if there are errors, or if a PLC stops in its first cycles,
    which run in virtual time.

    Declarations of --stubs have the members, values and inputs that the sources use. A guess
    has a question mark: fill it in, and name the folder in `libraries`.
    """
    if stubs is not None:
        from achse.cli.test.stubs import write_stubs

        write_stubs(file, stubs, library or [], in_json)
        return
    if in_json:
        report = ReportFormat.JSON
    from achse.st.files.forms import has_station

    is_project = not has_station(file) and file.exists()
    if watch:
        if not is_project or report is not ReportFormat.TEXT:
            fail(f"--watch prints the findings of a PLC project as text: got {file}, {report}")
        _watch(file, library or [], define or [], check_all)
    if is_project:
        from achse.cli.test.projects import check_project

        check_project(file, library or [], define or [], warnings, check_all, report, lint)
    else:
        if file.exists() and report not in (ReportFormat.TEXT, ReportFormat.JSON):
            fail(f"--format {report} is for PLC projects: expected text or json for {file}")
        from achse.cli.test.stations import check_station  # brings asyncio along

        check_station(file, report is ReportFormat.JSON)
    if machine and report is ReportFormat.TEXT:
        _report_plain(file, library or [], is_project)


def _watch(file: Path, libraries: list[Path], defines: list[str], check_all: bool) -> None:
    """Check again and again, until a signal ends the command."""
    import time

    from achse.cli.interrupts import leave_at_once
    from achse.cli.test.projects import shown
    from achse.cli.test.watching import watch_project

    leave_at_once()
    watch_project(file, libraries, defines, check_all=check_all, show=shown, pause=time.sleep)


def _report_plain(file: Path, libraries: list[Path], is_project: bool) -> None:
    """Print the routines of the PLCs that stay plain Python beside machine code, and the
    reasons."""
    from achse.station import ConfigError, Station
    from achse.station.configuration.station_file import parse

    try:
        if is_project:
            plc = {
                "sources": str(file.absolute()),
                "libraries": [str(item.absolute()) for item in libraries],
                "code": "machine",
            }
            station = Station(parse({"plc": [plc]}, str(file)))
        else:
            station = Station.load(file)
    except ConfigError as fault:
        fail(str(fault))
    for runtime in station.plcs.values():
        bodies = runtime.bodies
        if bodies is None or bodies.execution is None:
            continue
        execution, routines = bodies.execution, bodies.project.routines
        if execution.machine is None:
            print(f"{runtime.name}: all is plain Python")
            continue
        for key, reason in execution.plain_routines.items():
            place = routines[key].locate(routines[key].at)
            print(f"{place}: note: {routines[key].name} stays plain Python: {reason}")
        count, plain = len(execution.machine.keys), len(execution.plain_routines)
        print(f"{runtime.name}: {count} routines are machine code, {plain} not")
