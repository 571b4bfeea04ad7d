"""Check of a PLC project: its errors, its warnings, and the verdict of a trial."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json
from achse.plc import Task
from achse.plc.system_info import system_info_list
from achse.st.check import check
from achse.st.lexis.source import Diagnostic, Location, SourceError
from achse.st.missing import findings_by_library
from achse.st.project import Project, examine_project
from achse.st.typed.project import TypedProject

__all__ = ["check_project"]


def check_project(
    path: Path,
    libraries: list[Path],
    defines: list[str],
    warnings: bool,
    check_all: bool,
    in_json: bool,
) -> None:
    """Print the findings in a project and whether it would run. Ends with 1 if it would not."""
    try:
        project, error = examine_project(
            path, libraries=libraries, defines=defines, check_all=check_all
        )
    except SourceError as nothing:
        fail(str(nothing))
    tasks = [Task(task.name) for task in project.tasks] or [Task()]
    system = system_info_list(tasks, app_name="", project_name="", port=851, timestamp=0)
    typed = check(
        project.declarations, given=[system], reach=project.reach, unreached=project.unreached
    )
    errors = _sorted([*(error.faults if error else ()), *typed.faults])
    unreached = [] if check_all else _sorted([*project.unreached, *typed.unreached])
    unreached = [fault for fault in unreached if fault not in errors]
    hint = error.hint if error is not None else ""
    runs, verdict = _verdict(project, typed, errors)
    if in_json:
        print_json(
            {
                "sources": len(project.sources),
                "units": len(typed.units),
                "routines": len(typed.routines),
                "errors": [_finding(fault) for fault in errors],
                "warnings": [_finding(warning) for warning in typed.warnings],
                "unreached": [_finding(fault) for fault in unreached],
                "would_run": runs,
                "verdict": verdict,
                "hint": hint,
            }
        )
    else:
        _print_findings(project, errors, "error", check_all)
        if warnings:
            _print_findings(project, unreached, "warning: not reached", check_all)
            for warning in typed.warnings:
                print(_with_word(str(warning), "warning"))
        if hint and not project.missing:
            print(hint)
        for library in project.missing:
            print(library)
        count = len(typed.warnings) + len(unreached)
        apart = f", {len(unreached)} of them in units that no task reaches" if unreached else ""
        print(
            f"{len(project.sources)} sources, {len(typed.units)} programs and lists,"
            f" {len(typed.routines)} routines checked: {len(errors)} errors,"
            f" {count} warnings{apart}"
        )
        print(verdict)
    if not runs:
        raise typer.Exit(1)


def _verdict(project: Project, typed: TypedProject, errors: list[Diagnostic]) -> tuple[bool, str]:
    if errors:
        return False, f"would not run: {len(errors)} error{'s' * (len(errors) > 1)}"
    from achse.cli.test.trial import try_project  # half of a check

    verdict = try_project(project, typed)
    return verdict.runs, str(verdict)


def _print_findings(
    project: Project, findings: list[Diagnostic], word: str, check_all: bool
) -> None:
    """Print findings; those that follow from a missing library are one line, unless all count."""
    libraries, rest = (
        ([], findings) if check_all else findings_by_library(project.missing, findings)
    )
    for finding in rest:
        print(_with_word(str(finding), word))
    for library, following in libraries:
        count = f"{len(following)} finding{'s' if len(following) > 1 else ''}"
        follow = "follow" if len(following) > 1 else "follows"
        print(
            f"{word}: library {library.reference.title} is not known:"
            f" {count} {follow} from it (--all lists)"
        )


def _sorted(faults: Iterable[Diagnostic]) -> list[Diagnostic]:
    return sorted(dict.fromkeys(faults), key=_place)


def _place(fault: Diagnostic) -> Location:
    return fault.location


def _finding(finding: Diagnostic) -> dict[str, Any]:
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
