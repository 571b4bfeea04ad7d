"""Assignments alone and in chains."""

from collections.abc import Callable

import pytest

Lines = Callable[..., list[str]]

ROWS: list[tuple[str, str, list[str]]] = [
    ("a, b : INT; c : DINT;", "c := a := b;", ["c := EXTEND.DINT(a := b);"]),
    ("a, b : BOOL;", "a S= b;", ["a S= b;"]),
    ("a, b, c : BOOL;", "a S= b R= c;", ["a S= b R= c;"]),
    ("a, b : BOOL; c : BOOL;", "a := b S= c;", ["a := b S= c;"]),
    ("n : INT; b : BOOL;", "n S= b;", ["fault: S= takes a BOOL, got a INT"]),
    ("n : INT;", "n + 1 := 3;", ["fault: expected a variable before the assignment, got a value"]),
    ("r : REFERENCE TO INT; n : INT;", "r REF= n;", ["r := ADR(n);"]),
    ("r, s : REFERENCE TO INT;", "r REF= s;", ["r := s;"]),
    ("r : REFERENCE TO INT;", "r REF= 0;", ["r := 0;"]),
    ("n, m : INT;", "n REF= m;", ["fault: REF= binds a REFERENCE, got a INT"]),
    ("r : REFERENCE TO INT; d : LREAL;", "r REF= d;",
     ["r := ADR(d);", "warning: a REFERENCE TO INT is bound to a LREAL"]),
    ("n : INT (0..9);", "n := 10;", ["n := 10;", "warning: 10 is outside INT (0..9)"]),
    ("n : INT;", "n := TEST_AND_SET(n);", ["n := MUX.INT(0, __t1 := n, n := 1);"]),
    ("n, d : DINT;", "n := __XADD(ADR(d), 2);",
     ["n := MUX.DINT(0, __t1 := ADR(d)^, ADR(d)^ := ADD.DINT(ADR(d)^, 2));"]),
    ("p : POINTER TO INT;", "p := 0;", ["p := 0;"]),
]  # fmt: skip


@pytest.mark.parametrize(("variables", "statement", "expected"), ROWS)
def test_assignments(lines: Lines, variables: str, statement: str, expected: list[str]) -> None:
    assert lines(variables, statement) == expected


def test_a_block_may_forbid_copies(lines: Lines) -> None:
    block = "{attribute 'no_assign'} FUNCTION_BLOCK FB END_FUNCTION_BLOCK"
    assert lines("a, b : FB;", "a := b;", block) == [
        "fault: FB has attribute no_assign: it is not copied"
    ]


def test_a_condition_may_assign(lines: Lines) -> None:
    assert lines("a : BOOL; n : INT;", "IF (a := n > 3) THEN RETURN; END_IF")[0] == (
        "IF a := GT.BOOL(EXTEND.DINT(n), 3)"
    )
