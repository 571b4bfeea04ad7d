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
    findings = _checked(project, error, check_all, options)
    if report is ReportFormat.JSON:
        _print_json(findings)
    elif report is ReportFormat.TEXT:
        _print_text(findings, warnings, check_all)
    else:
        sources = [parsed.source.path for parsed in project.sources]
        unreached = findings.findings.unreached if warnings else []
        softer = [*findings.findings.warnings, *findings.noted] if warnings else []
        problem = "" if findings.runs or findings.findings.errors else findings.verdict
        errors = [*findings.findings.errors, *findings.failing]
        _print_report(report, path, sources, errors, unreached, softer, problem)
    if not findings.runs or findings.failing:
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
    findings = findings_of(project, error, typed, check_all=check_all)
    runs, verdict = _verdict(project, typed, findings.errors)
    hint = error.hint if error is not None else ""
    linted: Sequence[Diagnostic] = ()
    if options.codes:
        from achse.st.lint.linting import lint  # off by default

        linted = lint(project.sources, project.declarations, typed, options)
    return _Checked(project, typed, findings, linted, options, runs, verdict, hint)


def _verdict(
    project: Project, typed: TypedProject, errors: Sequence[Diagnostic]
) -> tuple[bool, str]:
    if errors:
        return False, f"would not run: {len(errors)} error{'s' * (len(errors) > 1)}"
    from achse.cli.test.trial import try_project  # half of a check

    verdict = try_project(project, typed)
    return verdict.runs, str(verdict)


def _print_json(checked: _Checked) -> None:
    print_json(
        {
            "sources": len(checked.project.sources),
            "units": len(checked.typed.units),
            "routines": len(checked.typed.routines),
            "errors": [_finding(fault) for fault in checked.findings.errors],
            "warnings": [_finding(warning) for warning in checked.findings.warnings],
            "unreached": [_finding(fault) for fault in checked.findings.unreached],
            "lint": [
                {**_finding(each), "fails": checked.options.fails(each.code)}
                for each in checked.lint
            ],
            "would_run": checked.runs,
            "verdict": checked.verdict,
            "hint": checked.hint,
        }
    )


def _print_text(checked: _Checked, warnings: bool, check_all: bool) -> None:
    project, typed = checked.project, checked.typed
    _print_findings(project, checked.findings.errors, "error", check_all)
    if warnings:
        _print_findings(project, checked.findings.unreached, "warning: not reached", check_all)
        for warning in checked.findings.warnings:
            print(shown(warning, "warning"))
        for finding in checked.noted:
            print(shown(finding, "warning"))
    for finding in checked.failing:
        print(shown(finding, "error"))
    if checked.hint and not project.missing:
        print(checked.hint)
    for library in project.missing:
        print(library)
    if project.stubs:
        lines = sum(text.count("\n") for text in project.stubs.values())
        print(f"{lines} lines of stubs, which do nothing (--stubs FOLDER writes them)")
    unreached = len(checked.findings.unreached)
    count = len(checked.findings.warnings) + unreached
    apart = f", {unreached} of them in units that no task reaches" if unreached else ""
    linted = f", {len(checked.lint)} findings of the linter" if checked.options.codes else ""
    print(
        f"{len(project.sources)} sources, {len(typed.units)} programs and lists,"
        f" {len(typed.routines)} routines checked: {len(checked.findings.errors)} errors,"
        f" {count} warnings{apart}{linted}"
    )
    print(checked.verdict)


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
