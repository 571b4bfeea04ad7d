"""Paths: members, elements, bits and pointers, each with its known offset."""

from collections.abc import Callable

import pytest

from achse.st.typed.expressions import Read, Stored
from achse.st.typed.project import TypedProject
from achse.st.typed.statements import Do

Lines = Callable[..., list[str]]

UNITS = """
TYPE ST_Part : STRUCT b : BYTE; x : INT; f1, f2 : BIT; s : STRING(9); END_STRUCT END_TYPE
TYPE ST_Whole : STRUCT n : DINT; part : ST_Part; parts : ARRAY [1..3] OF ST_Part; END_STRUCT END_TYPE
TYPE U_Word : UNION w : WORD; b : ARRAY [0..1] OF BYTE; END_UNION END_TYPE
FUNCTION F_Part : ST_Part F_Part.x := 3; END_FUNCTION
VAR_GLOBAL CONSTANT cBit : INT := 9; END_VAR
"""  # noqa: E501

OFFSETS = [
    ("st.n", 0, None),
    ("st.part.x", 6, None),
    ("st.part.f2", 8, 1),
    ("st.parts[1].b", 20, None),
    ("st.parts[3].x", 54, None),
    ("st.parts[2].s[4]", 45, None),
    ("st.n.0", 0, 0),
    ("st.n.17", 2, 1),
    ("st.n.%X31", 3, 7),
    ("st.n.%W1", 2, None),
    ("st.n.%B3", 3, None),
    ("st.n.cBit", 1, 1),
    ("m[1, 2]", 14, None),
    ("u.b[1]", 1, None),
    ("p^.part.x", 6, None),
    ("p[2].n", 136, None),
    ("w[1].x", 18, None),
]


@pytest.mark.parametrize(("path", "offset", "bit"), OFFSETS)
def test_offsets(
    typed: Callable[[str], TypedProject], path: str, offset: int, bit: int | None
) -> None:
    project = typed(
        f"""{UNITS}
        PROGRAM MAIN
        VAR st : ST_Whole; m : ARRAY [0..1, -1..2] OF INT; u : U_Word; p : POINTER TO ST_Whole;
            w : ARRAY [0..1] OF ST_Part;
        END_VAR
        IF {path} = {path} THEN ; END_IF
        {path} := {path};
        END_PROGRAM"""
    )
    assert not project.faults
    statement = (project.routines["main"].body or ())[1]
    assert isinstance(statement, Do)
    assert isinstance(statement.value, Stored)
    assert isinstance(statement.value.value, Read)
    storage = statement.value.storage
    assert (storage.offset, storage.bit, storage.steps) == (offset, bit, ())


VARIABLES = """st : ST_Whole; n : INT; d : DINT; l : LINT; a : ARRAY [1..3] OF INT;
    m : ARRAY [0..1, 0..2] OF INT; p : POINTER TO INT; s : STRING; b : BOOL;"""

ROWS = [
    ("n := p^;", "n := p^;"),
    ("n := (p + 2)^;", "n := ADD.POINTER TO INT(p, 2)^;"),
    ("n := n^;", "fault: INT is not a pointer: ^ has no target"),
    ("n := p.x;", "fault: a POINTER TO INT has no members; write ^ before the dot"),
    ("n := st.y;", "fault: ST_Whole has no member 'y'"),
    ("n := F_Part().x;", "n := <__t1 := f_part()>+2;"),
    ("b := n.16;", "fault: a INT has parts 0..15, got 16"),
    ("n := b.0;", "fault: a bit of a whole number, got a BOOL"),
]


@pytest.mark.parametrize(("statement", "expected"), ROWS)
def test_paths(lines: Lines, statement: str, expected: str) -> None:
    assert lines(VARIABLES, statement, UNITS) == [expected]


def test_a_reference_is_followed_without_a_sign(lines: Lines) -> None:
    variables = "r : REFERENCE TO ST_Whole; st : ST_Whole; n : DINT;"
    assert lines(variables, "r REF= st; n := r.n; r.part.x := 1;", UNITS) == [
        "r := ADR(st);",
        "n := r^;",
        "r^+6 := 1;",
    ]
