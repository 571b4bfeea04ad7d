"""Check of a PLC project: its errors, its warnings, and the verdict of a trial."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json
from achse.cli.test.check import ReportFormat
from achse.plc.system_info import lists_of_runtime
from achse.st.check import check
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.lint.options import LintOptions, LintOptionsError, lint_options
from achse.st.missing.libraries import findings_by_library, line_of_library
from achse.st.project import Project, examine_project
from achse.st.typed.project import TypedProject
from achse.st.workspace.findings import ProjectFindings, findings_of


@dataclass(frozen=True, slots=True)
class _Checked:
    """A project after its check."""

    project: Project
    typed: TypedProject
    findings: ProjectFindings
    lint: Sequence[Diagnostic]
    options: LintOptions
    runs: bool
    verdict: str
    hint: str

    @property
    def failing(self) -> list[Diagnostic]:
        """Findings of the linter that end the check with 1."""
        return [finding for finding in self.lint if self.options.fails(finding.code)]

    @property
    def noted(self) -> list[Diagnostic]:
        """Findings of the linter that do not."""
        return [finding for finding in self.lint if not self.options.fails(finding.code)]


def check_project(
    path: Path,
    libraries: list[Path],
    defines: list[str],
    warnings: bool,
    check_all: bool,
    report: ReportFormat,
    with_lint: bool | None = None,
) -> None:
    """Print the findings in a project and whether it would run. Ends with 1 if it would not.

    `with_lint` switches all rules of the linter on or off; by default achse.toml decides.
    """
    options = _options(path, with_lint)
    try:
        project, error = examine_project(
            path,
            libraries=libraries,
            defines=defines,
            check_all=check_all,
            unknown="refuse" if check_all else "libraries",
        )
    except SourceError as nothing:
        if report in (ReportFormat.TEXT, ReportFormat.JSON):
            fail(str(nothing))
        _print_report(report, path, [], nothing.faults, [], [], "")
        raise typer.Exit(1) from None
    found = _checked(project, error, check_all, options)
    if report is ReportFormat.JSON:
        _print_json(found)
    elif report is ReportFormat.TEXT:
        _print_text(found, warnings, check_all)
    else:
        sources = [parsed.source.path for parsed in project.sources]
        unreached = found.findings.unreached if warnings else []
        softer = [*found.findings.warnings, *found.noted] if warnings else []
        problem = "" if found.runs or found.findings.errors else found.verdict
        errors = [*found.findings.errors, *found.failing]
        _print_report(report, path, sources, errors, unreached, softer, problem)
    if not found.runs or found.failing:
        raise typer.Exit(1)


def _options(path: Path, with_lint: bool | None) -> LintOptions:
    if with_lint is False:
        return LintOptions()
    try:
        options = lint_options(path)
    except LintOptionsError as failure:
        fail(str(failure), name="INVALID_FILE")
    return options.with_all() if with_lint else options


def _checked(
    project: Project, error: SourceError | None, check_all: bool, options: LintOptions
) -> _Checked:
    typed = check(
        project.declarations,
        predefined=lists_of_runtime(project.tasks),
        reach=project.reach,
        unreached=project.unreached,
    )
    found = findings_of(project, error, typed, check_all=check_all)
    runs, verdict = _verdict(project, typed, found.errors)
    hint = error.hint if error is not None else ""
    linted: Sequence[Diagnostic] = ()
    if options.codes:
        from achse.st.lint.linting import lint  # off by default

        linted = lint(project.sources, project.declarations, typed, options)
    return _Checked(project, typed, found, linted, options, runs, verdict, hint)


def _verdict(
    project: Project, typed: TypedProject, errors: Sequence[Diagnostic]
) -> tuple[bool, str]:
    if errors:
        return False, f"would not run: {len(errors)} error{'s' * (len(errors) > 1)}"
    from achse.cli.test.trial import try_project  # half of a check

    verdict = try_project(project, typed)
    return verdict.runs, str(verdict)


def _print_json(found: _Checked) -> None:
    print_json(
        {
            "sources": len(found.project.sources),
            "units": len(found.typed.units),
            "routines": len(found.typed.routines),
            "errors": [_finding(fault) for fault in found.findings.errors],
            "warnings": [_finding(warning) for warning in found.findings.warnings],
            "unreached": [_finding(fault) for fault in found.findings.unreached],
            "lint": [
                {**_finding(each), "fails": found.options.fails(each.code)} for each in found.lint
            ],
            "would_run": found.runs,
            "verdict": found.verdict,
            "hint": found.hint,
        }
    )


def _print_text(found: _Checked, warnings: bool, check_all: bool) -> None:
    project, typed = found.project, found.typed
    _print_findings(project, found.findings.errors, "error", check_all)
    if warnings:
        _print_findings(project, found.findings.unreached, "warning: not reached", check_all)
        for warning in found.findings.warnings:
            print(shown(warning, "warning"))
        for finding in found.noted:
            print(shown(finding, "warning"))
    for finding in found.failing:
        print(shown(finding, "error"))
    if found.hint and not project.missing:
        print(found.hint)
    for library in project.missing:
        print(library)
    if project.stubs:
        lines = sum(text.count("\n") for text in project.stubs.values())
        print(f"{lines} lines of stubs, which do nothing (--stubs FOLDER writes them)")
    unreached = len(found.findings.unreached)
    count = len(found.findings.warnings) + unreached
    apart = f", {unreached} of them in units that no task reaches" if unreached else ""
    linted = f", {len(found.lint)} findings of the linter" if found.options.codes else ""
    print(
        f"{len(project.sources)} sources, {len(typed.units)} programs and lists,"
        f" {len(typed.routines)} routines checked: {len(found.findings.errors)} errors,"
        f" {count} warnings{apart}{linted}"
    )
    print(found.verdict)


def _print_report(
    report: ReportFormat,
    path: Path,
    sources: Iterable[str],
    errors: Iterable[Diagnostic],
    unreached: Iterable[Diagnostic],
    warnings: Iterable[Diagnostic],
    problem: str,
) -> None:
    """Print a report for another program."""
    from achse.cli.test.reports import Finding, Level, github_lines, junit_document, sarif_log

    findings = [Finding(Level.ERROR, fault) for fault in errors]
    findings += [Finding(Level.WARNING, fault, "not reached") for fault in unreached]
    findings += [Finding(Level.WARNING, fault) for fault in warnings]
    if report is ReportFormat.SARIF:
        print_json(sarif_log(path, findings, problem))
    elif report is ReportFormat.JUNIT:
        print(junit_document(sources, findings, problem), end="")
    else:
        for line in github_lines(path, findings, problem):
            print(line)


def _print_findings(
    project: Project, findings: Sequence[Diagnostic], word: str, check_all: bool
) -> None:
    """Print findings; those that follow from a missing library are one line, unless all count."""
    libraries, rest = (
        ([], findings) if check_all else findings_by_library(project.missing, findings)
    )
    for finding in rest:
        print(shown(finding, word))
    for library, following in libraries:
        print(f"{word}: {line_of_library(library, following)} (--all lists)")


def _finding(finding: Diagnostic) -> dict[str, Any]:
    place = finding.location
    return {
        "file": place.path,
        "line": place.line,
        "column": place.column,
        "end_line": finding.end_line,
        "end_column": finding.end_column,
        "code": finding.code,
        "message": finding.message,
    }


def shown(finding: Diagnostic, word: str) -> str:
    """Return `file:line:column: word: message [code]` and the line, as editors and CI read it."""
    place, separator, message = str(finding).partition(": ")
    head, newline, line = message.partition("\n")
    return f"{place}{separator}{word}: {head} [{finding.code}]{newline}{line}"
