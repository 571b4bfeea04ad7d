"""`achse check` looks at a station.toml, or at the sources of a PLC project, without running it."""

from pathlib import Path
from typing import Annotated

import typer

from achse.cli.run import check_configuration, fail

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
    library: Annotated[
        list[Path] | None,
        typer.Option(help="Sources of a library that the project uses, once for each."),
    ] = None,
    define: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="What {IF defined (NAME)} finds, once for each."),
    ] = None,
    warnings: Annotated[bool, typer.Option(help="Tell what may lose values, too.")] = True,
) -> None:
    """Check a station.toml or a PLC project without starting it.

    Warnings of a station.toml name what the sources of a PLC say and only a running program could
    do. Of a project every declaration and statement is checked; errors and warnings have file,
    line, column and a caret. Ends with 1 if there are errors.
    """
    if file.suffix.lower() == ".toml" or not file.exists():
        check_configuration(file)
    else:
        _check_project(file, library or [], define or [], warnings)


def _check_project(
    project: Path, libraries: list[Path], defines: list[str], warnings: bool
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
    for fault in sorted(faults, key=lambda fault: fault.location):
        print(f"{_with_word(str(fault), 'error')}")
    if warnings:
        for warning in typed.warnings:
            print(f"{_with_word(str(warning), 'warning')}")
    if error is not None and error.hint:
        print(error.hint)
    units, routines = len(typed.units), len(typed.routines)
    print(
        f"{len(found.sources)} sources, {units} programs and lists, {routines} routines checked:"
        f" {len(faults)} errors, {len(typed.warnings)} warnings"
    )
    if faults:
        raise typer.Exit(1)


def _with_word(text: str, word: str) -> str:
    """`file:line:column: word: message`, as editors and CI read it."""
    place, separator, message = text.partition(": ")
    return f"{place}{separator}{word}: {message}"
