"""Findings of a project: errors, warnings, and faults of units that no task reaches."""

from collections.abc import Iterable
from typing import NamedTuple

from achse.st.check.reached import faults_by_reach
from achse.st.check.warm import WarmChecking
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.project import Project
from achse.st.reach import Reach
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


def findings_by_reach(
    faults: Iterable[Diagnostic], checking: WarmChecking, reach: Reach
) -> tuple[ProjectFindings, list[Diagnostic]]:
    """Return the findings of a check, with `faults` of declarations, and the faults that no task
    reaches."""
    errors, unreached = reach.findings(faults)
    further, every = faults_by_reach(
        sorted_faults(checking), checking.faulty_routines, reach, tuple(unreached)
    )
    findings = sorted_findings([*errors, *further], checking.warnings, [*unreached, *every])
    return findings, list(every)


def sorted_faults(checking: WarmChecking) -> tuple[Diagnostic, ...]:
    """Return the faults that a check found, by their places."""
    return tuple(sorted(dict.fromkeys(checking.faults), key=lambda one: one.location))


def sorted_findings(
    errors: Iterable[Diagnostic], warnings: Iterable[Diagnostic], unreached: Iterable[Diagnostic]
) -> ProjectFindings:
    """Return findings in order, each once; what is an error is not unreached, too."""
    ordered = _sorted(errors)
    known = set(ordered)
    return ProjectFindings(
        ordered, _sorted(warnings), tuple(one for one in _sorted(unreached) if one not in known)
    )


def _sorted(findings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(sorted(dict.fromkeys(findings), key=lambda one: (one.location, one.message)))
