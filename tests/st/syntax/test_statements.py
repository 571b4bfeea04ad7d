"""Statements: 60 snippets, what is wrong with others, and how reading goes on."""

import pytest

from achse.st.lexis.source import Source
from achse.st.syntax import tree
from achse.st.syntax.cursor import DEEPEST
from achse.st.syntax.parser import Parser, parse_statements
from achse.st.syntax.printer import print_statements


def flat(text: str) -> str:
    """The statements of a text as they are printed, in one line."""
    return " ".join(line.strip() for line in print_statements(parse_statements(text)).split("\n"))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a := 1;",
        "a := b := 1;",
        "a.b[1]^.c := 1;",
        "a.3 := TRUE;",
        "THIS^.a := SUPER^.b;",
        "a REF= b;",
        "a S= b;",
        "a R= b AND c;",
        "f();",
        "f(a := 1, b => c);",
        "fb.Run(1);",
        "fb.aParts[1].Run(1).Stop();",
        "SUPER^.FB_Init();",
        "MyAction;",
        "fb.MyAction;",
        ".gAction;",
        "p^;",
        "EXIT;",
        "CONTINUE;",
        "RETURN;",
        "JMP again;",
        "again: a := 1;",
        "IF a THEN END_IF",
        "IF a THEN b := 1; END_IF",
        "IF a THEN b := 1; ELSE b := 2; END_IF",
        "IF a THEN b := 1; ELSIF c THEN b := 2; ELSIF d THEN ELSE b := 3; END_IF",
        "IF a THEN IF b THEN c(); END_IF END_IF",
        "IF a := f() THEN END_IF",
        "CASE a OF 1: b := 1; END_CASE",
        "CASE a OF 1, 2, 3: b := 1; 4..6, 8: b := 2; ELSE b := 3; END_CASE",
        "CASE a OF ELSE b := 3; END_CASE",
        "CASE a OF -1: b(); END_CASE",
        "CASE a OF E_X.Idle: b(); E_X.Run, E_X.Stop: c(); END_CASE",
        "CASE a OF cFirst..cLast: b(); END_CASE",
        "CASE a OF cFirst + 1: b(); END_CASE",
        "CASE a OF E_X#Idle: b(); INT#5: c(); END_CASE",
        "CASE a OF 1: 2: b(); END_CASE",
        "CASE a OF 1: CASE b OF 2: c(); END_CASE 3: d(); END_CASE",
        "CASE a OF END_CASE",
        "FOR i := 1 TO 10 DO a(); END_FOR",
        "FOR i := 10 TO 1 BY -1 DO EXIT; END_FOR",
        "FOR a.i := b.c TO f(x) BY n + 1 DO END_FOR",
        "FOR a[1] := 0 TO 1 DO FOR j := 0 TO 1 DO CONTINUE; END_FOR END_FOR",
        "WHILE a < 5 DO a := a + 1; END_WHILE",
        "REPEAT a := a + 1; UNTIL a > 5 END_REPEAT",
        "__TRY a(); __CATCH(exc) b(); __FINALLY c(); __ENDTRY",
        "S := 1; R := 2; REF := 3;",
        "a := S = 1;",
        "IF S = 1 THEN R := 1; END_IF",
        "Get := 1; Set(2); Public := 3; Constant := 4; Step := 5;",
    ],
)
def test_statements_are_read_as_they_are_written(text: str) -> None:
    assert flat(text) == text


def test_else_need_not_be_the_last_branch_of_a_case() -> None:
    """Two public projects have a branch behind it (decision 0239)."""
    text = "CASE a OF 1: b(); ELSE c(); 2, 3: d(); 4: e(); END_CASE"
    assert flat(text) == "CASE a OF 1: b(); 2, 3: d(); 4: e(); ELSE c(); END_CASE"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (";;;", ""),
        ("a := 1;; b := 2;", "a := 1; b := 2;"),
        ("if a then b := 1; end_if;", "IF a THEN b := 1; END_IF"),
        ("For i:=0 To 9 Do a(); End_For;", "FOR i := 0 TO 9 DO a(); END_FOR"),
        ("REPEAT a(); UNTIL b; END_REPEAT;", "REPEAT a(); UNTIL b END_REPEAT"),
        ("a s= b;", "a S= b;"),
        ("(* (* in *) *) a := 1; // end", "a := 1;"),
        ("{region 'x'} a := 1; {endregion}", "a := 1;"),
        ("a := 1 /* /* in */ */ + 2;", "a := 1 + 2;"),
        ("a:=b+c*d;", "a := b + c * d;"),
        ("CASE a OF 1:; 2:b();END_CASE", "CASE a OF 1: 2: b(); END_CASE"),
    ],
)
def test_other_spellings(text: str, expected: str) -> None:
    assert flat(text) == expected


def faults_of(text: str) -> list[tuple[int, int, str]]:
    parser = Parser(Source(text))
    parser.attempt(parser.statements.statements)
    return [(*fault.location[1:], fault.message) for fault in parser.faults]


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("a := 1", 1, 7, "expected ';', got the end"),
        ("a := 1\nb := 2;", 1, 7, "expected ';', got 'b'"),
        ("a := ;", 1, 6, "expected an expression, got ';'"),
        ("a = 1;", 1, 1, "expected an assignment or a call, got an expression"),
        ("a + 1;", 1, 1, "expected an assignment or a call, got an expression"),
        ("5;", 1, 1, "expected an assignment or a call, got an expression"),
        ("a b;", 1, 3, "expected ':=', got 'b'"),
        (":= 5;", 1, 1, "expected an expression, got ':='"),
        ("IF a b := 1; END_IF", 1, 6, "expected THEN, got 'b'"),
        ("IF THEN END_IF", 1, 4, "expected an expression, got 'THEN'"),
        ("IF a THEN b();", 1, 15, "expected END_IF, got the end"),
        ("IF a THEN b(); END_FOR", 1, 16, "expected END_IF, got 'END_FOR'"),
        ("CASE a 1: b(); END_CASE", 1, 8, "expected OF, got '1'"),
        ("CASE a OF 1 b(); END_CASE", 1, 13, "expected ',' or ':' after the label, got 'b'"),
        ("CASE a OF 1: b();", 1, 18, "expected END_CASE, got the end"),
        ("FOR i = 1 TO 2 DO END_FOR", 1, 11, "expected ':=', got 'TO'"),
        ("FOR i := 1 DO END_FOR", 1, 12, "expected TO, got 'DO'"),
        ("FOR i := 1 TO 2 END_FOR", 1, 17, "expected BY or DO, got 'END_FOR'"),
        ("FOR i := 1 TO 2 BY 3 END_FOR", 1, 22, "expected DO, got 'END_FOR'"),
        ("WHILE a b(); END_WHILE", 1, 9, "expected DO, got 'b'"),
        ("REPEAT a(); END_REPEAT", 1, 13, "expected UNTIL, got 'END_REPEAT'"),
        ("JMP 5;", 1, 5, "expected the name of a label, got '5'"),
        ("END_IF", 1, 1, "expected the end, got 'END_IF'"),
        ("x(1;", 1, 4, "expected ',' or ')', got ';'"),
        ("(* a := 1;", 1, 1, "this comment has no end"),
        ("a := 1; /* b", 1, 9, "this comment has no end"),
        ("a := 1; {attribute 'x'", 1, 9, "expected } at the end of this pragma"),
    ],
)
def test_faults_say_where_and_what(text: str, line: int, column: int, message: str) -> None:
    assert faults_of(text)[0] == (line, column, message)


def test_reading_goes_on_after_a_fault() -> None:
    text = """
a := ;
b := 1;
IF x THEN
    c := 2
    d := 3;
    e := * 4;
ELSE
    f 5;
END_IF
FOR i := 1 TO DO
    g();
END_FOR
h := );
"""
    assert [(line, message) for line, _, message in faults_of(text)] == [
        (2, "expected an expression, got ';'"),
        (5, "expected ';', got 'd'"),
        (7, "expected an expression, got '*'"),
        (9, "expected ':=', got '5'"),
        (11, "expected an expression, got 'DO'"),
        (14, "expected an expression, got ')'"),
    ]


def test_deep_nesting_is_a_fault() -> None:
    for opening in ("IF a THEN ", "WHILE a DO ", "REPEAT ", "CASE a OF 1: ", "__TRY "):
        faults = faults_of(opening * 10_000)
        assert f"this nests deeper than {DEEPEST} levels" in [message for _, _, message in faults]


def test_many_branches_nest_nothing() -> None:
    text = "IF a THEN b();" + "ELSIF c THEN d();" * 5000 + "END_IF"
    (statement,) = parse_statements(text)
    assert isinstance(statement, tree.If)
    assert len(statement.branches) == 5001
