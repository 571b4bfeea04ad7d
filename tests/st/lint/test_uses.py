"""Uses of variables: what counts as read and as written."""

import pytest

from achse.st.lint.uses import UseKind, tracked_units, uses_of
from tests.st.lint.conftest import declared

BLOCK = """FUNCTION_BLOCK FB_Base
VAR_INPUT nIn : INT; END_VAR
VAR a, b : INT; END_VAR
END_FUNCTION_BLOCK
FUNCTION F_Any : INT
VAR_INPUT n : INT; END_VAR
F_Any := n;
END_FUNCTION
"""


def use_of(statements: str, variables: str = "x, y : INT;", name: str = "x") -> UseKind:
    """Return the use of a variable of a block by these statements."""
    text = f"{BLOCK}FUNCTION_BLOCK FB\nVAR\n{variables}\nEND_VAR\n{statements}\nEND_FUNCTION_BLOCK"
    names = declared(text).names
    units = tracked_units(
        [entry for entry in names.scopes.entries.values() if not entry.is_library]
    )
    uses_of(units, names.scopes)
    (unit,) = (unit for unit in units if unit.entry.name == "FB")
    return unit.variables[name].use


@pytest.mark.parametrize(
    ("statements", "use"),
    [
        ("", UseKind.NONE),
        ("y := x;", UseKind.READ),
        ("x := y;", UseKind.WRITE),
        ("x := x + 1;", UseKind.BOTH),
        ("x.3 := TRUE;", UseKind.WRITE),
        ("y := ABS(x);", UseKind.READ),
        ("y := TO_INT(x);", UseKind.READ),
        ("y := F_Any(x);", UseKind.BOTH),
        ("y := F_Any(n := x + 1);", UseKind.READ),
        ("FOR x := 0 TO y DO y := 1; END_FOR", UseKind.BOTH),
        ("FOR y := 0 TO x DO ; END_FOR", UseKind.READ),
        ("IF x > 3 THEN y := 1; END_IF", UseKind.READ),
        ("CASE x OF 1: y := 2; END_CASE", UseKind.READ),
        ("CASE y OF 1: x := 2; END_CASE", UseKind.WRITE),
        ("y := x := 1;", UseKind.WRITE),
        ("WHILE x > 3 DO y := 1; END_WHILE", UseKind.READ),
        ("REPEAT x := 1; UNTIL TRUE END_REPEAT", UseKind.WRITE),
        ("THIS^.x := 3;", UseKind.WRITE),
        ("y := THIS^.x;", UseKind.READ),
    ],
)
def test_statements_read_and_write(statements: str, use: UseKind) -> None:
    assert use_of(statements) == use


@pytest.mark.parametrize(
    ("variables", "statements", "use"),
    [
        ("x : INT; p : POINTER TO INT;", "p := ADR(x);", UseKind.BOTH),
        ("x : POINTER TO INT;", "x^ := 3;", UseKind.READ),
        ("x : ARRAY [0..3] OF INT; y : INT;", "x[y] := 3;", UseKind.WRITE),
        ("y : ARRAY [0..3] OF INT; x : INT;", "y[x] := 3;", UseKind.READ),
        ("x : INT; r : REFERENCE TO INT;", "r REF= x;", UseKind.BOTH),
        ("x : __SYSTEM.ExceptionCode;", "__TRY ; __CATCH(x) ; __ENDTRY", UseKind.BOTH),
        ("x : FB_Base;", "x(nIn := 3);", UseKind.BOTH),
        ("x : FB_Base;", "x.nIn := 3;", UseKind.WRITE),
        ("x : INT; y : INT := x;", "", UseKind.READ),
        ("x : INT; r : REFERENCE TO INT REF= x;", "", UseKind.BOTH),
    ],
)
def test_paths_and_declarations_read_and_write(
    variables: str, statements: str, use: UseKind
) -> None:
    assert use_of(statements, variables) == use


def test_derived_blocks_use_the_variables_of_their_base() -> None:
    text = (
        f"{BLOCK}FUNCTION_BLOCK FB EXTENDS FB_Base\nMETHOD M\nVAR b : INT; END_VAR\n"
        "a := b := 1;\nEND_METHOD\nEND_FUNCTION_BLOCK"
    )
    names = declared(text).names
    units = tracked_units(
        [entry for entry in names.scopes.entries.values() if not entry.is_library]
    )
    uses_of(units, names.scopes)
    variables = {unit.entry.name: unit.variables for unit in units}["FB_Base"]
    assert (variables["a"].use, variables["b"].use) == (UseKind.WRITE, UseKind.NONE)
