"""What the tests of the checker share: a text in, typed lines, faults and warnings out."""

from collections.abc import Callable

import pytest

from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from achse.st.typed.project import TypedProject
from achse.st.typed.text import lines_of

Typed = Callable[[str], TypedProject]
Lines = Callable[..., list[str]]


def _typed(text: str) -> TypedProject:
    return check(declare([parse(Source(text, "x.st")).check()]))


def _lines(variables: str, statements: str, units: str = "") -> list[str]:
    program = f"PROGRAM MAIN\nVAR\n{variables}\nEND_VAR\n{statements}\nEND_PROGRAM\n"
    project = _typed(program + units)
    if project.faults:
        return [f"fault: {fault.message}" for fault in project.faults]
    return [
        *lines_of(project.routines["main"].body or ()),
        *(f"warning: {warning.message}" for warning in project.warnings),
    ]


@pytest.fixture
def typed() -> Typed:
    """The typed form of sources."""
    return _typed


@pytest.fixture
def lines() -> Lines:
    """The typed lines of a program with these variables and statements (and further units), then
    its warnings; or its faults."""
    return _lines
