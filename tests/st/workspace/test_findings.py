"""Findings in order."""

from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, Location
from achse.st.workspace.findings import sorted_findings


def test_findings_are_sorted_and_an_error_is_not_unreached_too() -> None:
    one = Diagnostic(Location("a", 2, 1), "x", Code.BAD_LITERAL)
    other = Diagnostic(Location("a", 1, 1), "y", Code.BAD_LITERAL)
    findings = sorted_findings([one, other, one], [one], [other, one])
    assert findings.errors == (other, one)
    assert findings.warnings == (one,)
    assert findings.unreached == ()
