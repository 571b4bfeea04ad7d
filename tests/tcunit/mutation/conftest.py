"""Typed routines of a text."""

from collections.abc import Callable
from pathlib import Path

import pytest

from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from achse.st.typed.project import Routine

PLANTED = Path(__file__).parents[2] / "data" / "mutation" / "planted.st"

CLAMP = PLANTED.with_name("clamp.st")

Routines = Callable[[str], dict[str, Routine]]


def routines_of(text: str) -> dict[str, Routine]:
    project = check(declare([parse(Source(text, "a.st"))]))
    assert not project.faults, project.faults
    return {key: one for key, one in project.routines.items() if not one.source.library}


@pytest.fixture
def routines() -> Routines:
    """`routines(text)`: the routines of a text, by key."""
    return routines_of


@pytest.fixture
def planted() -> str:
    return PLANTED.read_text(encoding="utf-8")
