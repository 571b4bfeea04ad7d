"""`achse check` looks at a station.toml, or at the sources of a PLC project, without running it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.options import Library
from achse.cli.output import print_json
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.st.source import Diagnostic, Location

__all__ = ["register"]


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(check)


def check(
    file: Annotated[
        Path,
        typer.Argument(
            help="A station.toml; or a folder with PLC sources, a .plcproj, one source file.",
            show_default=False,
        ),
    ],
    library: Library = None,
    define: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="What {IF defined (NAME)} finds, once for each."),
    ] = None,
    warnings: Annotated[bool, typer.Option(help="Tell what may lose values, too.")] = True,
    machine: Annotated[
        bool,
        typer.Option("--machine", help="Tell what cannot become machine code, and why."),
    ] = False,
    stand_ins: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Write declarations for names that the sources use and nothing declares.",
            show_default=False,
        ),
    ] = None,
    in_json: Json = False,
) -> None:
    """Check a station.toml or a PLC project without starting it.

    Warnings of a station.toml name what the sources of a PLC say and only a running program could
    do. Of a project every declaration and statement is checked; errors and warnings have file,
    line, column and a caret. Ends with 1 if there are errors.

    Declarations of --stand-ins have the members, values and inputs that the sources use. A guess
    has a question mark: fill it in, and name the folder in `libraries`.
    """
    if stand_ins is not None:
        from achse.cli.test.stand_ins import write_stand_ins

        write_stand_ins(file, stand_ins, library or [], in_json)
        return
    is_project = file.suffix.lower() != ".toml" and file.exists()
    if is_project:
        _check_project(file, library or [], define or [], warnings, in_json)
    else:
        from achse.cli.start.run import check_configuration  # brings asyncio along

        check_configuration(file, in_json)
    if machine and not in_json:
        _tell_plain(file, library or [], is_project)


def _tell_plain(file: Path, libraries: list[Path], is_project: bool) -> None:
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
        for key, why in execution.kept_plain.items():
            place = routines[key].locate(routines[key].at)
            print(f"{place}: note: {routines[key].name} stays plain Python: {why}")
        count = len(execution.machine.keys)
        print(f"{runtime.name}: {count} routines are machine code, {len(execution.kept_plain)} not")


def _check_project(
    project: Path, libraries: list[Path], defines: list[str], warnings: bool, in_json: bool
) -> None:
    from achse.plc import Task
    from achse.plc.system_info import system_info_list
    from achse.st.check import check as check_bodies
    from achse.st.project import examine_project
    from achse.st.source import SourceError

    try:
        found, error = examine_project(project, libraries=libraries, defines=defines)
    except SourceError as nothing:
        fail(str(nothing))
    tasks = [Task(task.name) for task in found.tasks] or [Task()]
    system = system_info_list(tasks, app_name="", project_name="", port=851, timestamp=0)
    typed = check_bodies(found.declarations, given=[system])
    faults = list(dict.fromkeys([*(error.faults if error else ()), *typed.faults]))
    units, routines = len(typed.units), len(typed.routines)
    if in_json:
        print_json(
            {
                "sources": len(found.sources),
                "units": units,
                "routines": routines,
                "errors": [_finding(fault) for fault in sorted(faults, key=_place)],
                "warnings": [_finding(warning) for warning in typed.warnings],
                "hint": error.hint if error is not None else "",
            }
        )
        if faults:
            raise typer.Exit(1)
        return
    for fault in sorted(faults, key=_place):
        print(f"{_with_word(str(fault), 'error')}")
    if warnings:
        for warning in typed.warnings:
            print(f"{_with_word(str(warning), 'warning')}")
    if error is not None and error.hint and not found.missing:
        print(error.hint)
    for library in found.missing:
        print(library)
    print(
        f"{len(found.sources)} sources, {units} programs and lists, {routines} routines checked:"
        f" {len(faults)} errors, {len(typed.warnings)} warnings"
    )
    if faults:
        raise typer.Exit(1)


def _place(fault: "Diagnostic") -> "Location":
    return fault.location


def _finding(finding: "Diagnostic") -> dict[str, Any]:
    place = finding.location
    return {
        "file": place.path,
        "line": place.line,
        "column": place.column,
        "message": finding.message,
    }


def _with_word(text: str, word: str) -> str:
    """`file:line:column: word: message`, as editors and CI read it."""
    place, separator, message = text.partition(": ")
    return f"{place}{separator}{word}: {message}"
