"""Findings of a project: errors, warnings, and faults of units that no task reaches."""

from collections.abc import Iterable
from typing import NamedTuple

from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.project import Project
from achse.st.typed.project import TypedProject


class ProjectFindings(NamedTuple):
    """All that is wrong with a project, each by file and place."""

    errors: tuple[Diagnostic, ...] = ()
    warnings: tuple[Diagnostic, ...] = ()
    unreached: tuple[Diagnostic, ...] = ()
    """Faults in units that no task reaches."""


def findings_of(
    project: Project, error: SourceError | None, typed: TypedProject, *, check_all: bool = False
) -> ProjectFindings:
    """Return the findings of a check."""
    return sorted_findings(
        [*(error.faults if error else ()), *typed.faults],
        typed.warnings,
        () if check_all else [*project.unreached, *typed.unreached],
    )


def sorted_findings(
    errors: Iterable[Diagnostic], warnings: Iterable[Diagnostic], unreached: Iterable[Diagnostic]
) -> ProjectFindings:
    """Return findings in order, each once; what is an error is not unreached, too."""
    found = _sorted(errors)
    known = set(found)
    return ProjectFindings(
        found, _sorted(warnings), tuple(one for one in _sorted(unreached) if one not in known)
    )


def _sorted(findings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(sorted(dict.fromkeys(findings), key=lambda one: (one.location, one.message)))
