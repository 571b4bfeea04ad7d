"""Functions of the language."""

from collections.abc import Callable

import pytest

from achse.iec.elementary import INT, REAL
from achse.st.check.builtins import conversion_target, is_builtin

Lines = Callable[..., list[str]]

ROWS = [
    ("n : INT;", "n := MAX(n, 3, 5);", "n := CUT.INT(MAX.DINT(EXTEND.DINT(n), 3, 5));"),
    ("n : INT;", "n := LIMIT(MN := 0, IN := n, MX := 9);",
     "n := CUT.INT(LIMIT.DINT(0, EXTEND.DINT(n), 9));"),
    ("n : INT; b : BOOL;", "n := SEL(b, n, 2);", "n := CUT.INT(SEL.DINT(b, EXTEND.DINT(n), 2));"),
    ("n : INT;", "n := MUX(n, 1, 2, 3);", "n := CUT.INT(MUX.DINT(EXTEND.DINT(n), 1, 2, 3));"),
    ("n : INT;", "n := ABS(n);", "n := CUT.INT(ABS.DINT(EXTEND.DINT(n)));"),
    ("s, t : STRING; b : BOOL;", "s := SEL(b, s, t);", "s := SEL.STRING(80)(b, s, t);"),
    ("t : TIME;", "t := MIN(t, T#1s);", "t := MIN.TIME(t, 1000);"),
    ("l : LREAL; n : INT;", "l := SQRT(n);", "l := SQRT.LREAL(TO_REAL.LREAL(n));"),
    ("r : REAL;", "r := SIN(r);", "r := SIN.REAL(r);"),
    ("r : REAL;", "r := EXPT(r, r);", "r := EXPT.REAL(r, r);"),
    ("l : LREAL; n : INT;", "l := EXPT(n, n);",
     "l := EXPT.LREAL(TO_REAL.LREAL(n), TO_REAL.LREAL(n));"),
    ("l : LREAL;", "l := SQRT('a');", "fault: SQRT takes a number, got a STRING(1)"),
    # shifts: the promoted value; turns: in the value's own width
    ("w : WORD; b : BYTE;", "w := SHL(b, 9);", "w := CUT.WORD(SHL.DINT(EXTEND.DINT(b), 9));"),
    ("d : DWORD;", "d := SHL(DWORD#1, 33);", "d := 2;"),
    ("b : BYTE; n : INT;", "b := ROL(b, n);", "b := ROL.BYTE(b, EXTEND.DINT(n));"),
    # conversions
    ("n : INT;", "n := REAL_TO_INT(2.5);", "n := 3;"),
    ("n : INT;", "n := REAL_TO_INT(40000.0);", "n := -25536;"),
    ("d : DINT;", "d := LREAL_TO_DINT(3.0E9);", "d := -1294967296;"),
    ("n : INT;", "n := TRUNC_INT(40000.5);", "n := -25536;"),
    ("d : DINT;", "d := TRUNC(3.0E9);", "d := -2147483648;"),
    ("n : INT; l : LREAL;", "n := TO_INT(l);", "n := ROUND.INT(l);"),
    ("n : INT; b : BOOL;", "n := BOOL_TO_INT(b);", "n := FROM_BOOL.INT(b);"),
    ("n : INT; b : BOOL;", "b := TO_BOOL(n);", "b := TO_BOOL.BOOL(n);"),
    ("s : STRING; n : INT;", "s := INT_TO_STRING(n);", "s := WRITE_TEXT.STRING(80)(n);"),
    ("s : STRING; n : INT;", "n := STRING_TO_INT(s);", "n := READ_TEXT.INT(s);"),
    ("s : STRING;", "s := TO_STRING(5);", "s := WRITE_TEXT.STRING(80)(5);"),
    ("t : TIME; n : UDINT;", "n := TIME_TO_UDINT(t);", "n := EXTEND.UDINT(t);"),
    ("a : ARRAY [0..1] OF INT; n : INT;", "n := TO_INT(a);",
     "fault: a ARRAY [0..1] OF INT has no conversion to INT"),
    # texts
    ("s : STRING;", "s := LEFT(s, 3);", "s := CUT_TEXT.STRING(80)(LEFT.STRING(255)(s, 3));"),
    ("s : STRING; n : INT;", "n := FIND(s, 'x');", "n := FIND.INT(s, b'x');"),
    ("s : STRING;", "s := CONCAT(STR2 := s, STR1 := 'a');",
     "s := CUT_TEXT.STRING(80)(CONCAT.STRING(255)(b'a', s));"),
    ("w : WSTRING; n : INT;", "n := WLEN(w);", "n := LEN.INT(w);"),
    ("s : STRING; n : INT;", "n := WLEN(s);", "fault: WLEN takes a WSTRING, got a STRING(80)"),
    ("n : INT;", "n := LEN('a', 1);", "fault: LEN takes 1 arguments, got 2"),
    # the system
    ("t : TIME;", "t := TIME();", "t := TIME.TIME();"),
    ("n : DINT;", "n := GETCURTASKINDEXEX();", "n := TASK_INDEX.DINT();"),
    ("h : HRESULT; b : BOOL;", "b := FAILED(h);", "b := LT.BOOL(h, 0);"),
    ("n : INT;", "F_RaiseException(16#102);", "RAISE.UDINT(258);"),
]  # fmt: skip


@pytest.mark.parametrize(("variables", "statement", "expected"), ROWS)
def test_builtins(lines: Lines, variables: str, statement: str, expected: str) -> None:
    assert lines(variables, statement) == [expected]


def test_conversions_are_known_by_their_name() -> None:
    assert conversion_target("REAL_TO_INT") == (REAL, INT)
    assert conversion_target("TO_INT") == (None, INT)
    assert conversion_target("ANY_TO_INT") == (None, INT)
    assert conversion_target("ROAD_TO_INT") is None
    assert conversion_target("TO_NOWHERE") is None
    assert is_builtin("max")
    assert not is_builtin("maximum")


def test_an_enumeration_with_attribute_to_string_gives_its_name(
    lines: Lines,
) -> None:
    named = "{attribute 'to_string'} TYPE E : (A, B := 5); END_TYPE TYPE F : (C); END_TYPE"
    assert lines("e : E; f : F; s : STRING;", "s := TO_STRING(e); s := TO_STRING(f);", named) == [
        "s := NAME(e);",
        "s := WRITE_TEXT.STRING(80)(f);",
    ]


def test_what_a_project_declares_comes_first(lines: Lines) -> None:
    own = "FUNCTION MAX : INT VAR_INPUT a : INT; END_VAR MAX := a; END_FUNCTION"
    assert lines("n : INT;", "n := MAX(n);", own) == ["n := max(callee.a := n);"]
