"""Operators of addresses, types and memory."""

from collections.abc import Callable

import pytest

Lines = Callable[..., list[str]]

UNITS = """
TYPE ST : STRUCT a : BYTE; b : BIT; d : DINT; END_STRUCT END_TYPE
INTERFACE I_A END_INTERFACE
INTERFACE I_B EXTENDS I_A END_INTERFACE
FUNCTION_BLOCK FB IMPLEMENTS I_B
    METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; n : INT; END_VAR END_METHOD
END_FUNCTION_BLOCK
FUNCTION F : DINT VAR_IN_OUT x : ARRAY [*, *] OF INT; END_VAR
    F := LOWER_BOUND(x, 1) + UPPER_BOUND(x, 2);
END_FUNCTION
"""
VARIABLES = """p : POINTER TO INT; n : INT; u : UDINT; st : ST; a : ARRAY [2..5] OF INT; b : BOOL;
    r : REFERENCE TO INT; ia : I_A; ib : I_B; fb : FB; pfb : POINTER TO FB; s : STRING;
    rp : REFERENCE TO POINTER TO INT; rfb : REFERENCE TO FB;"""

ROWS = [
    ("p := ADR(n);", "p := ADR(n);"),
    ("p := ADR(a[3]);", "p := ADR(a[3]);"),
    ("p := ADR(p^);", "p := p;"),
    ("p := ADR(r);", "p := r;"),
    ("u := BITADR(n);",
     "u := ADD.UDINT(MUL.UDINT(AND.UDINT(CUT.UDINT(ADR(n)), 268435455), 8), 0);"),
    ("u := SIZEOF(a);", "u := 8;"),
    ("u := SIZEOF(INT);", "u := 2;"),
    ("u := SIZEOF(ST);", "u := 8;"),
    ("u := SIZEOF(ARRAY [0..3] OF LREAL);", "u := 32;"),
    ("n := LOWER_BOUND(a, 1);", "n := 2;"),
    ("n := UPPER_BOUND(a, 1);", "n := 5;"),
    ("n := UPPER_BOUND(a, 2);", "fault: UPPER_BOUND takes the number of a dimension, 1..1"),
    ("n := UPPER_BOUND(n, 1);", "fault: UPPER_BOUND takes an array, got a INT"),
    ("b := __ISVALIDREF(r);", "b := NE.BOOL(r, 0);"),
    ("b := __ISVALIDREF(n);", "fault: __ISVALIDREF takes a REFERENCE, got a INT"),
    ("p := __NEW(INT);", "p := NEW(INT);"),
    ("p := __NEW(INT, u);", "p := NEW(INT, CUT.DINT(u));"),
    ("pfb := __NEW(FB(n := 3));",
     "pfb := NEW(FB, callee.bInitRetains := True, callee.bInCopyCode := False, callee.n := 3);"),
    ("p := __NEW(n);", "fault: __NEW takes a type"),
    ("__DELETE(p);", "DELETE(p);"),
    ("__DELETE(rp);", "DELETE(rp^);"),
    ("__DELETE(rfb);", "DELETE(rfb);"),
    ("__DELETE(n);", "fault: __DELETE takes a pointer variable, got a INT"),
    ("b := __QUERYINTERFACE(ia, ib);", "b := QUERY(ia, ib, i_b);"),
    ("b := __QUERYINTERFACE(fb, ia);", "b := QUERY(ADR(fb), ia, i_a);"),
    ("b := __QUERYPOINTER(ia, pfb);", "b := QUERY(ia, pfb, POINTER);"),
    ("b := __QUERYINTERFACE(n, ia);",
     "fault: __QUERYINTERFACE takes an interface or a block, got a INT"),
    ("s := __POUNAME();", "s := b'MAIN';"),
    ("s := __POSITION();", "s := b'Line 7, Column 6';"),
]  # fmt: skip


@pytest.mark.parametrize(("statement", "expected"), ROWS)
def test_system_operators(lines: Lines, statement: str, expected: str) -> None:
    assert lines(VARIABLES, statement, UNITS) == [expected]


def test_a_bit_has_the_address_of_its_byte(lines: Lines) -> None:
    assert lines("p : POINTER TO BOOL; st : ST;", "p := ADR(st.b);", UNITS) == [
        "p := ADR(st.b);",
        "warning: a bit has no address: ADR gives that of its byte",
    ]


def test_varinfo_is_a_record_about_the_variable(lines: Lines) -> None:
    (line,) = lines("n : INT; i : __SYSTEM.VAR_INFO;", "i := __VARINFO(n);")
    assert line.startswith("i := VAR_INFO(+0 := CUT.UDINT(ADR(n))")
