"""Expressions: literals, direct addresses, and what is not a value."""

from collections.abc import Callable

import pytest

Lines = Callable[..., list[str]]

ROWS = [
    ("n : INT;", "n := INT#5;", "n := 5;"),
    ("n : INT;", "n := 2#1010;", "n := 10;"),
    ("d : LREAL;", "d := 1.5E3;", "d := 1500.0;"),
    ("r : REAL;", "r := 0.1;", "r := 0.10000000149011612;"),
    ("t : TIME;", "t := T#1m30s;", "t := 90000;"),
    ("t : LTIME;", "t := LTIME#1us;", "t := 1000;"),
    ("d : DT;", "d := DT#1970-01-01-00:01;", "d := 60;"),
    ("b : BOOL;", "b := TRUE;", "b := True;"),
    ("s : STRING;", "s := 'a$N';", r"s := b'a\n';"),
    ("n : WORD;", "n := %MW10;", "n := %MW10;"),
    ("b : BOOL;", "%QX0.3 := b;", "%QX0.3 := b;"),
    ("n : INT;", "n := %Q*;", "fault: %Q* is allowed in declarations only"),
    ("n : INT;", "n := (n);", "n := n;"),
    ("n : INT;", "n := MAIN;", "fault: MAIN is not a value"),
    ("n : INT;", "n := INT;", "fault: INT is not a value"),
    ("n : INT;", "n := E_None#A;", "fault: 'E_None' is not an enumeration"),
]  # fmt: skip


@pytest.mark.parametrize(("variables", "statement", "expected"), ROWS)
def test_expressions(lines: Lines, variables: str, statement: str, expected: str) -> None:
    assert lines(variables, statement) == [expected]
