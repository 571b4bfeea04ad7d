"""The linter: all rules over a checked project."""

from collections.abc import Iterable

from achse.st.declare import Declarations
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.source import Diagnostic, Source
from achse.st.lint.comparisons import check_comparisons
from achse.st.lint.options import LintOptions
from achse.st.lint.report import LintReport
from achse.st.lint.statements import check_statements
from achse.st.lint.uses import tracked_units
from achse.st.lint.variables import check_variables
from achse.st.syntax.parser import Parsed
from achse.st.typed.project import TypedProject


def lint(
    sources: Iterable[Parsed],
    declarations: Declarations,
    typed: TypedProject,
    options: LintOptions,
) -> tuple[Diagnostic, ...]:
    """Return the findings of the rules that are on, in the order of their places.

    `sources` are those of the project itself; one with syntax faults is left out, since what is
    missing in it might use anything.
    """
    if not options.codes:
        return ()
    with collection_paused():
        report, own = _lint_names(sources, declarations, options)
        check_comparisons(typed.routines.values(), own, report)
    return report.findings


@collection_paused()
def lint_warm(
    sources: Iterable[Parsed],
    declarations: Declarations,
    compared: Iterable[Diagnostic],
    options: LintOptions,
) -> tuple[Diagnostic, ...]:
    """Return the findings as `lint` does, from comparisons that were found while bodies were
    checked."""
    report, own = _lint_names(sources, declarations, options)
    for one in compared:
        if one.origin is not None and one.origin.source in own:
            report.add(one.code, one.origin.source, one.origin.at, one.origin.message)
    return report.findings


def _lint_names(
    sources: Iterable[Parsed], declarations: Declarations, options: LintOptions
) -> tuple[LintReport, frozenset[Source]]:
    """Apply the rules that go by names; return the report, and the sources that are read."""
    report = LintReport(options)
    own = frozenset(parsed.source for parsed in sources if not parsed.faults)
    scopes = declarations.names.scopes
    entries = [
        entry for entry in scopes.entries.values() if not entry.is_library and entry.source in own
    ]
    units = tracked_units(entries)
    check_variables(units, scopes, report)
    check_statements(units, scopes, report)
    return report, own
