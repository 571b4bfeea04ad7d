"""What the tests of the linter share: a text in, findings out."""

from collections.abc import Callable

import pytest

from achse.st.check import check
from achse.st.declare import Declarations, declare, examine
from achse.st.lexis.source import Diagnostic, Source
from achse.st.lint.linting import lint
from achse.st.lint.options import LintOptions
from achse.st.syntax.parser import parse

Linted = Callable[..., list[str]]


def declared(text: str) -> Declarations:
    """Return what a sound text declares."""
    return declare([parse(Source(text, "x.st")).check()])


def findings(text: str, rules: str = "LT") -> list[Diagnostic]:
    """Return the findings in a text, which may have faults."""
    parsed = parse(Source(text, "x.st"), name="x")
    declarations, _ = examine([parsed])
    typed = check(declarations)
    return list(lint([parsed], declarations, typed, LintOptions(select=(rules,))))


def _linted(text: str, rules: str = "LT") -> list[str]:
    return [f"{each.location.line}: {each.code} {each.message}" for each in findings(text, rules)]


@pytest.fixture
def linted() -> Linted:
    """The findings in a text: line, code and message."""
    return _linted
