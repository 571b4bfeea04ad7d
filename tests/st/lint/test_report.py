"""Findings of a run: rules that are off, and pragmas that suppress."""

import pytest

from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.lint.options import LintOptions
from achse.st.lint.report import LintReport


def codes_of(line: str, above: str = "") -> list[str]:
    """Return the codes of two findings at `x`, one that is off included."""
    text = f"{above}\n{line}\n"
    report = LintReport(LintOptions(select=("LT1001", "LT2")))
    source = Source(text, "x.st")
    at = text.index("x", len(above))
    for code in (Code.UNUSED_VARIABLE, Code.FLOAT_EQUALITY, Code.MISSING_ELSE):
        report.add(code, source, at, "no")
        report.add(code, source, at, "no")
    return [each.code.value for each in report.findings]


def test_a_finding_counts_once_if_its_rule_is_on() -> None:
    assert codes_of("x : INT;") == ["LT1001", "LT2001"]
    report = LintReport(LintOptions(select=("LT3",)))
    assert report.wants(Code.UNUSED_VARIABLE, Code.MISSING_ELSE)
    assert not report.wants(Code.UNUSED_VARIABLE)


@pytest.mark.parametrize(
    ("line", "above", "codes"),
    [
        ("x : INT; // achse: ignore", "", []),
        ("x : INT; // of clients, achse: ignore LT1001", "", ["LT2001"]),
        ("x : INT; (* achse: ignore LT1, LT2 *)", "", []),
        ("{achse: ignore LT2001} x : INT;", "", ["LT1001"]),
        ("x : INT;", "    // achse: ignore LT1", ["LT2001"]),
        ("x : INT;", "{achse: ignore}", []),
        ("x : INT;", "y : INT; // achse: ignore", ["LT1001", "LT2001"]),
        ("x : INT; // achse: ignore LT3", "", ["LT1001", "LT2001"]),
        ("x := 'achse: ignore';", "", ["LT1001", "LT2001"]),
        ("x : INT; // achse: ignored", "", ["LT1001", "LT2001"]),
    ],
)
def test_a_pragma_suppresses_in_its_line_or_the_next(
    line: str, above: str, codes: list[str]
) -> None:
    assert codes_of(line, above) == codes
