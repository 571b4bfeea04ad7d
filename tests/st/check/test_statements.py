"""Statements."""

from collections.abc import Callable

import pytest

Lines = Callable[..., list[str]]

ROWS: list[tuple[str, str, list[str]]] = [
    ("n : INT;", "IF n = 1 THEN n := 2; ELSIF TRUE THEN n := 3; ELSE n := 4; END_IF",
     ["IF EQ.BOOL(EXTEND.DINT(n), 1)", "    n := 2;", "ELSIF True", "    n := 3;",
      "ELSE", "    n := 4;"]),
    ("n : INT;", "IF n THEN ; END_IF", ["fault: expected a BOOL, got a INT"]),
    ("n : INT;", "CASE n OF 1, 3..5: n := 0; -1: ; ELSE n := 1; END_CASE",
     ["CASE n", "1, 3..5:", "    n := 0;", "-1:", "ELSE", "    n := 1;"]),
    ("b : BOOL;", "CASE b OF TRUE: b := FALSE; FALSE: ; END_CASE",
     ["CASE FROM_BOOL.USINT(b)", "1:", "    b := False;", "0:"]),
    ("w : WORD;", "CASE w OF 16#FFFF: w := 0; END_CASE", ["CASE w", "65535:", "    w := 0;"]),
    ("n : INT;", "CASE n OF 1: ; 1: ; END_CASE",
     ["CASE n", "1:", "1:", "warning: label 1 is there already: this one is never taken"]),
    ("n, m : INT;", "CASE n OF m: ; END_CASE",
     ["fault: a label of CASE is a constant whole number"]),
    ("n : INT;", "CASE n OF 5..3: ; END_CASE", ["fault: the range 5..3 runs backwards"]),
    ("r : REAL;", "CASE r OF 1: ; END_CASE",
     ["fault: CASE takes a whole number or enumeration, got a REAL"]),
    ("i : INT;", "FOR i := 0 TO 9 DO ; END_FOR",
     ["FOR i := 0; UNTIL GT.BOOL(EXTEND.DINT(i), 9);"
      " i := CUT.INT(ADD.DINT(EXTEND.DINT(i), 1))"]),
    ("i : INT;", "FOR i := 9 TO 0 BY -2 DO EXIT; END_FOR",
     ["FOR i := 9; UNTIL LT.BOOL(EXTEND.DINT(i), 0);"
      " i := CUT.INT(ADD.DINT(EXTEND.DINT(i), -2))", "    EXIT;"]),
    ("i, s, e : DINT;", "FOR i := 0 TO e BY s DO CONTINUE; END_FOR",
     ["FOR i := 0; UNTIL SEL.BOOL(LT.BOOL(s, 0), GT.BOOL(i, __t1 := e), LT.BOOL(i, __t1));"
      " i := ADD.DINT(i, s)", "    CONTINUE;"]),
    ("i : SINT; e : DINT;", "FOR i := 0 TO e DO ; END_FOR",
     ["FOR i := 0; UNTIL GT.BOOL(EXTEND.DINT(i), e);"
      " i := CUT.SINT(ADD.DINT(EXTEND.DINT(i), 1))",
      "warning: FOR ends at a DINT, wider than its counter SINT"]),
    ("r : REAL;", "FOR r := 0 TO 9 DO ; END_FOR", ["fault: FOR counts a whole number, got REAL"]),
    ("n : INT;", "WHILE n < 3 DO n := 4; END_WHILE",
     ["WHILE LT.BOOL(EXTEND.DINT(n), 3)", "    n := 4;"]),
    ("n : INT;", "REPEAT n := 4; UNTIL n = 0 END_REPEAT",
     ["REPEAT WHILE NOT.BOOL(EQ.BOOL(EXTEND.DINT(n), 0))", "    n := 4;"]),
    ("n : INT;", "EXIT;", ["fault: EXIT is not in a loop"]),
    ("n : INT;", "CONTINUE;", ["fault: CONTINUE is not in a loop"]),
    ("n : INT;", "RETURN;", ["RETURN;"]),
    ("b : BOOL;", "RETURN(b);", ["IF b", "    RETURN;"]),
    ("b : BOOL;", "WHILE TRUE DO EXIT(NOT b); CONTINUE(b); END_WHILE",
     ["WHILE True", "    IF NOT.BOOL(b)", "        EXIT;", "    IF b", "        CONTINUE;"]),
    ("n : INT;", "again: n := 1; IF n = 1 THEN JMP again; END_IF",
     ["again:", "n := 1;", "IF EQ.BOOL(EXTEND.DINT(n), 1)", "    JMP again;"]),
    ("n : INT;", "JMP nowhere;", ["fault: no label is named 'nowhere' here"]),
    ("n : INT;", "JMP inside; IF n = 1 THEN inside: n := 2; END_IF",
     ["fault: JMP cannot go into a block: inside is in one"]),
    ("e : __SYSTEM.ExceptionCode; n : INT;",
     "__TRY n := 1; __CATCH(e) n := 2; __FINALLY n := 3; __ENDTRY",
     ["TRY", "    n := 1;", "CATCH e", "    n := 2;", "FINALLY", "    n := 3;"]),
    ("n : INT;", "__TRY n := 1; __FINALLY n := 3; __ENDTRY",
     ["TRY", "    n := 1;", "FINALLY", "    n := 3;"]),
    ("n : INT;", "n;", ["warning: this does nothing: it is neither an assignment nor a call"]),
    ("n : INT;", "x := 1; n := y; n := 5; foo();",
     ["fault: nothing is named 'x' here", "fault: nothing is named 'y' here",
      "fault: no function or instance is named 'foo'"]),
]  # fmt: skip


@pytest.mark.parametrize(("variables", "statement", "expected"), ROWS)
def test_statements(lines: Lines, variables: str, statement: str, expected: list[str]) -> None:
    assert lines(variables, statement) == expected


def test_an_enumeration_has_its_values_as_labels(lines: Lines) -> None:
    enum = "TYPE E : (A, B := 5); END_TYPE"
    assert lines("e : E;", "CASE e OF A: ; E.B: ; 3: ; END_CASE", enum) == [
        "CASE e",
        "0:",
        "5:",
        "3:",
        "warning: 3 is not a value of E",
    ]
