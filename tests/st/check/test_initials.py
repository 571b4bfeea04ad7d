"""Initial values as code: only what no image of bytes can say."""

from collections.abc import Callable

import pytest

from achse.st.typed.project import TypedProject
from achse.st.typed.text import lines_of

UNITS = """
TYPE ST : STRUCT a : INT; b : INT := 2; p : POINTER TO INT; END_STRUCT END_TYPE
FUNCTION F : INT F := 3; END_FUNCTION
FUNCTION_BLOCK FB VAR_INPUT n : INT; END_VAR
    PROPERTY P : INT SET n := P; END_SET END_PROPERTY
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize(
    ("declaration", "expected"),
    [
        ("n : INT := 5;", []),
        ("n : INT := x;", ["n := x;"]),
        ("n : INT := F() + 1;", ["n := CUT.INT(ADD.DINT(EXTEND.DINT(f()), 1));"]),
        ("p : POINTER TO INT := ADR(x);", ["p := ADR(x);"]),
        ("r : REFERENCE TO INT REF= x;", ["r := ADR(x);"]),
        ("s : ST := (a := 1, p := ADR(x));", ["s.p := ADR(x);"]),
        ("a : ARRAY [1..4] OF INT := [1, 2(x), F()];",
         ["a[1] := x;", "a[2] := x;", "a[3] := f();"]),
        ("b : FB := (n := x, P := 3);",
         ["CREATE b : FB", "    b.n := x;", "    ADR(b)->fb.__setp(callee.P := 3);"]),
    ],
)  # fmt: skip
def test_start_values(
    typed: Callable[[str], TypedProject], declaration: str, expected: list[str]
) -> None:
    project = typed(f"PROGRAM MAIN VAR x : INT := 1; {declaration} END_VAR END_PROGRAM{UNITS}")
    assert not project.faults
    create = project.routines.get(project.units["main"].create)
    assert list(lines_of(() if create is None else create.body or ())) == expected


def test_locals_start_at_each_call(typed: Callable[[str], TypedProject]) -> None:
    project = typed(
        f"FUNCTION G : INT VAR_INPUT i : INT; END_VAR VAR a : INT := 3; b : INT := i; END_VAR "
        f"VAR fb : FB; END_VAR G := a + b; END_FUNCTION {UNITS}"
    )
    routine = project.routines["g"]
    assert list(lines_of(routine.opening)) == ["b := i;", "CREATE fb : FB"]
    assert routine.frame.default[4:6] == b"\x03\x00"
