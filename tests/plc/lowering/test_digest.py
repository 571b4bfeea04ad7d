"""The digest of a project in its memory differs with whatever emitted code depends on."""

import pytest

from achse.plc.lowering.digest import project_digest
from achse.plc.lowering.placement import Placement
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable, place
from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

TEXT = "PROGRAM MAIN VAR a, b : INT; END_VAR a := b + 1; END_PROGRAM"


def digest(
    text: str = TEXT,
    *,
    path: str = "a.st",
    by_python: tuple[str, ...] = (),
    exceptions: bool = True,
    conditions: bool = False,
    counted: dict[str, int] | None = None,
    first_byte: int = 0,
    inputs: int = 8,
) -> str:
    project = declare([parse(Source(text, path), name="GVL")])
    memory = Memory({Area.INPUT: inputs})
    memory[Area.DATA].allocate(first_byte)
    variables: list[PlacedVariable] = [
        each for unit in place(project.units, memory) for each in unit.variables
    ]
    return project_digest(
        check(project),
        Placement(memory, variables),
        variables,
        by_python,
        exceptions=exceptions,
        counted=counted,
        conditions=conditions,
    )


def test_equal_projects_have_equal_digests_wherever_their_files_are() -> None:
    assert digest() == digest(path="b.st")


@pytest.mark.parametrize(
    "other",
    [
        {"text": TEXT.replace("+ 1", "+ 2")},
        {"text": TEXT.replace("a, b : INT", "a, b : DINT")},
        {"by_python": ("main",)},
        {"exceptions": False},
        {"conditions": True},
        {"counted": {"main": 0}},
        {"first_byte": 64},
        {"inputs": 1024},
    ],
)
def test_what_code_depends_on_makes_another_digest(other: dict[str, object]) -> None:
    assert digest() != digest(**other)  # type: ignore[arg-type]
