"""Calls: which routine, which parameter, in which order."""

from collections.abc import Callable

import pytest

Lines = Callable[..., list[str]]

UNITS = """
FUNCTION F_Add : DINT
VAR_INPUT a : DINT; b : INT := 3; END_VAR
VAR_OUTPUT over : BOOL; END_VAR
    F_Add := a + b;
END_FUNCTION
FUNCTION F_Swap VAR_IN_OUT x, y : INT; END_VAR x := y; END_FUNCTION
FUNCTION_BLOCK FB
VAR_INPUT i : INT; END_VAR
VAR_IN_OUT io : INT; END_VAR
VAR_OUTPUT q : INT; END_VAR
    METHOD M : INT VAR_INPUT x : INT; END_VAR END_METHOD
    METHOD FINAL Last END_METHOD
    METHOD Where : REFERENCE TO INT END_METHOD
    PROPERTY P : INT GET END_GET SET END_SET END_PROPERTY
    PROPERTY PRead : INT GET END_GET END_PROPERTY
    ACTION Act: q := i; END_ACTION
END_FUNCTION_BLOCK
INTERFACE I_M METHOD M : INT VAR_INPUT x : INT; END_VAR END_METHOD END_INTERFACE
FUNCTION_BLOCK FB_I IMPLEMENTS I_M
    METHOD M : INT VAR_INPUT x : INT; END_VAR END_METHOD
END_FUNCTION_BLOCK
PROGRAM P2 VAR_INPUT a : INT; END_VAR VAR_OUTPUT q : INT; END_VAR
    ACTION Act: q := a; END_ACTION
END_PROGRAM
"""
VARIABLES = """n, m : INT; d : DINT; s : STRING; b : BOOL; fb : FB; a : ARRAY [1..3] OF INT;
    itf : I_M; own : FB_I; p : POINTER TO FB; r : REFERENCE TO FB;"""

ROWS = [
    ("d := F_Add(1, n);", "d := f_add(callee.a := 1, callee.b := n);"),
    ("fb(i := 1, io := n, q => m);",
     "ADR(fb)->fb(callee.i := 1, callee.io := ADR(n) => m := callee.q);"),
    ("fb(io := n, i := );", "ADR(fb)->fb(callee.io := ADR(n));"),
    ("fb();", "fault: FB is called without its VAR_IN_OUT io"),
    ("n := fb.M(3);", "n := ADR(fb)->fb.m(callee.x := 3);"),
    ("n := p^.M(3);", "n := p->[m](callee.x := 3);"),
    ("n := r.M(3);", "n := r->[m](callee.x := 3);"),
    ("p^.Last();", "p->fb.last();"),
    ("p^(io := n);", "p->[](callee.io := ADR(n));"),
    ("fb.Act();", "ADR(fb)->fb.act();"),
    ("fb.Act;", "ADR(fb)->fb.act();"),
    ("fb.Act(i := 3, q => n);", "ADR(fb)->fb.act(callee.i := 3 => n := callee.q);"),
    ("n := fb.P;", "n := ADR(fb)->fb.__getp();"),
    ("fb.P := n;", "ADR(fb)->fb.__setp(callee.P := n);"),
    ("fb.PRead := n;", "fault: property PRead has no SET: it cannot be written"),
    ("fb.Where() := 3;", "ADR(fb)->fb.where()^ := 3;"),
    ("itf := own;", "itf := ADR(own);"),
    ("b := itf = own;", "b := EQ.BOOL(itf, ADR(own));"),
    ("fb.Where();", "ADR(fb)->fb.where();"),
    ("itf := fb;", "fault: FB does not implement I_M"),
    ("n := itf.M(1);", "n := itf->[m](callee.x := 1);"),
    ("n := itf.N();", "fault: I_M has no method or property 'N'"),
    ("P2(a := 1, q => n);", "p2(a := 1 => n := q);"),
    ("P2();", "p2();"),
    ("P2.Act();", "p2.act();"),
    ("n();", "fault: a INT cannot be called"),
    ("FB_I();", "fault: FB_I is a type and cannot be called"),
]  # fmt: skip


@pytest.mark.parametrize(("statement", "expected"), ROWS)
def test_calls(lines: Lines, statement: str, expected: str) -> None:
    assert lines(VARIABLES, statement, UNITS) == [expected]


def test_a_function_that_gives_nothing_is_false(lines: Lines) -> None:
    assert lines(VARIABLES, "b := F_Swap(n, m);", UNITS) == [
        "b := f_swap(callee.x := ADR(n), callee.y := ADR(m));",
        "warning: F_Swap gives no value: FALSE is taken",
    ]
    assert lines(VARIABLES, "n := fb(io := n);", UNITS) == ["fault: this call gives no value"]


def test_an_input_without_initial_value_is_missed(lines: Lines) -> None:
    assert lines("d : DINT;", "d := F_Add();", UNITS) == [
        "d := f_add();",
        "warning: F_Add is called without a",
    ]


def test_a_method_calls_its_instance_by_the_table(lines: Lines) -> None:
    block = """
    FUNCTION_BLOCK FB_Base
        METHOD M END_METHOD
        METHOD PRIVATE Own END_METHOD
    END_FUNCTION_BLOCK
    FUNCTION_BLOCK FB_Next EXTENDS FB_Base
        SUPER^();
        M(); THIS^.M(); SUPER^.M(); THIS^();
        METHOD M END_METHOD
    END_FUNCTION_BLOCK
    """
    # The program is empty: what counts is that all of it binds.
    assert lines("fb : FB_Next;", "fb();", block) == ["ADR(fb)->fb_next();"]
