"""Elements of arrays, pointers and texts: their steps, and indices outside."""

from collections.abc import Callable

import pytest

Lines = Callable[..., list[str]]

VARIABLES = """n : INT; d : DINT; l : LINT; a : ARRAY [1..3] OF INT;
    m : ARRAY [0..1, 0..2] OF INT; p : POINTER TO INT; s : STRING(9);"""

ROWS = [
    ("n := a[n];", "n := a[EXTEND.DINT(n)];"),
    ("n := a[l];", "n := a[l];"),
    ("n := m[n, 2];", "n := m[EXTEND.DINT(n)];"),
    ("n := m[n, d];", "n := m[EXTEND.DINT(n)][d];"),
    ("n := a[0];", "fault: index 0 is outside 1..3 of ARRAY [1..3] OF INT"),
    ("n := m[1];", "fault: ARRAY [0..1,0..2] OF INT takes 2 indices, got 1"),
    ("n := a[1.5];", "fault: an index is a whole number, got a LREAL"),
    ("n := n[1];", "fault: a INT has no elements"),
    ("n := p[d];", "n := p^[d];"),
    ("n := s[n];", "n := EXTEND.INT(s[EXTEND.DINT(n)]);"),
    ("n := s[10];", "fault: index 10 is outside 0..9"),
    ("n := p[2];", "n := p^+4;"),
]


@pytest.mark.parametrize(("statement", "expected"), ROWS)
def test_elements(lines: Lines, statement: str, expected: str) -> None:
    assert lines(VARIABLES, statement) == [expected]
