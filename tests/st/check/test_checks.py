"""A project's own check functions are called where the vendor's compiler calls them."""

from collections.abc import Callable

import pytest

Lines = Callable[..., list[str]]


def _function(name: str, type: str, parameters: str) -> str:
    first = parameters.partition(",")[0]
    body = f"{name} := {first};"
    return f"FUNCTION {name} : {type} VAR_INPUT {parameters} : {type}; END_VAR {body} END_FUNCTION"


CHECKS = "\n".join(
    [
        _function("CheckBounds", "DINT", "index, lower, upper"),
        _function("CheckDivDInt", "DINT", "divisor"),
        _function("CheckDivLInt", "LINT", "divisor"),
        _function("CheckDivReal", "REAL", "divisor"),
        _function("CheckDivLReal", "LREAL", "divisor"),
        _function("CheckRangeSigned", "DINT", "value, lower, upper"),
        _function("CheckRangeUnsigned", "UDINT", "value, lower, upper"),
        """FUNCTION CheckPointer : POINTER TO BYTE
        VAR_INPUT p : POINTER TO BYTE; iSize, iGran : DINT; bWrite : BOOL; END_VAR
        CheckPointer := p;
        END_FUNCTION""",
    ]
)
VARIABLES = """n : INT (0..9); u : UINT (1..2); d : DINT; l : LINT; r : REAL; x : LREAL;
    a : ARRAY [0..4] OF INT; p : POINTER TO INT;"""

ROWS = [
    ("a[d] := 1;",
     "a[checkbounds(callee.index := d, callee.lower := 0, callee.upper := 4)] := 1;"),
    ("a[2] := 1;", "a[2] := 1;"),
    ("d := d / d;", "d := DIV.DINT(d, checkdivdint(callee.divisor := d));"),
    ("d := d / 2;", "d := DIV.DINT(d, 2);"),
    ("l := l / l;", "l := DIV.LINT(l, checkdivlint(callee.divisor := l));"),
    ("r := r / r;", "r := DIV.REAL(r, checkdivreal(callee.divisor := r));"),
    ("x := x / x;", "x := DIV.LREAL(x, checkdivlreal(callee.divisor := x));"),
    ("n := n;", "n := CUT.INT(checkrangesigned(callee.value := EXTEND.DINT(n),"
     " callee.lower := 0, callee.upper := 9));"),
    ("u := u;", "u := CUT.UINT(checkrangeunsigned(callee.value := EXTEND.UDINT(u),"
     " callee.lower := 1, callee.upper := 2));"),
    ("d := p^;", "d := EXTEND.DINT(checkpointer(callee.p := p, callee.iSize := 2,"
     " callee.iGran := 2, callee.bWrite := False)^);"),
]  # fmt: skip


@pytest.mark.parametrize(("statement", "expected"), ROWS)
def test_checks(lines: Lines, statement: str, expected: str) -> None:
    assert lines(VARIABLES, statement, CHECKS) == [expected]


def test_an_attribute_switches_them_off(lines: Lines) -> None:
    block = """
    {attribute 'no_check'}
    FUNCTION_BLOCK FB VAR d : DINT; END_VAR d := d / d; END_FUNCTION_BLOCK
    """
    assert lines("fb : FB;", "fb();", CHECKS + block) == ["ADR(fb)->fb();"]
