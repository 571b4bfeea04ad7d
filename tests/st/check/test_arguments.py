"""Arguments: by name and by place, of VAR_IN_OUT, of open arrays, of any type, and outputs."""

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
FUNCTION F_Text : INT VAR_IN_OUT CONSTANT s : STRING(20); END_VAR F_Text := LEN(s); END_FUNCTION
FUNCTION F_Sum : INT VAR_IN_OUT a : ARRAY [*] OF INT; END_VAR F_Sum := a[1]; END_FUNCTION
FUNCTION F_Any : DINT VAR_INPUT x : ANY; END_VAR F_Any := x.diSize; END_FUNCTION
FUNCTION F_Ref : INT VAR_INPUT r : REFERENCE TO INT; END_VAR F_Ref := r; END_FUNCTION
FUNCTION_BLOCK FB_P
    PROPERTY P : BOOL GET END_GET SET END_SET END_PROPERTY
END_FUNCTION_BLOCK
"""
VARIABLES = "n, m : INT; d : DINT; b : BOOL; a : ARRAY [1..3] OF INT; w : ARRAY [1..2] OF DINT;"

ROWS = [
    ("d := F_Add(b := n, a := 1);", "d := f_add(callee.b := n, callee.a := 1);"),
    ("d := F_Add(a := 1);", "d := f_add(callee.a := 1);"),
    ("d := F_Add(1, over => b);", "d := f_add(callee.a := 1 => b := callee.over);"),
    ("d := F_Add(1, c := 2);", "fault: F_Add has no parameter 'c'; it has a, b, over"),
    ("d := F_Add(1, 2, b, 4);", "fault: F_Add takes 3 arguments, got more"),
    ("d := F_Add(1, a := 2);", "fault: a is given twice"),
    ("d := F_Add('a');", "fault: a STRING(1) does not go into a DINT"),
    ("F_Swap(n, m);", "f_swap(callee.x := ADR(n), callee.y := ADR(m));"),
    ("F_Swap(n, 3);", "fault: y is a VAR_IN_OUT: it takes a variable, got a value"),
    ("F_Swap(n);", "fault: F_Swap is called without its VAR_IN_OUT y"),
    ("F_Swap(n, d);", "fault: y is a VAR_IN_OUT INT, got a DINT"),
    ("n := F_Text('abc');", "n := f_text(callee.s := ADR(<__t1 := b'abc'>));"),
    ("n := F_Sum(a);",
     "n := f_sum(callee.a := ADR(a), callee.__a_lower1 := 1, callee.__a_upper1 := 3);"),
    ("n := F_Sum(n);", "fault: a takes an array, got a INT"),
    ("d := F_Any(n);", "d := f_any(callee.x := AnyType(+8 := ADR(n)));"),
    ("d := F_Any(5);", "d := f_any(callee.x := AnyType(+8 := ADR(<__t1 := 5>)));"),
    ("n := F_Ref(n);", "n := f_ref(callee.r := ADR(n));"),
    ("n := F_Ref(r REF= n);", "n := f_ref(callee.r := ADR(n));"),
    ("n := F_Sum(w);", "fault: a takes an array of INT, got one of DINT"),
    ("d := F_Add(a := 1, over => 3);", "fault: over => takes a variable"),
    ("F_Add(a := 1, F_Add => d);", "f_add(callee.a := 1 => d := callee.F_Add);"),
    ("F_Add(a := 1, f_add => 3);", "fault: F_Add => takes a variable"),
    ("F_Add(a := 1, F_Add := d);", "fault: F_Add has no parameter 'F_Add'; it has a, b, over"),
]  # fmt: skip


@pytest.mark.parametrize(("statement", "expected"), ROWS)
def test_arguments(lines: Lines, statement: str, expected: str) -> None:
    assert lines(VARIABLES, statement, UNITS) == [expected]


def test_output_into_a_property_is_set_behind_the_call(lines: Lines) -> None:
    call, after = lines(VARIABLES + " fb : FB_P;", "d := F_Add(1, over => fb.P);", UNITS)
    assert "callee.a := 1" in call
    assert after.startswith("ADR(fb)->fb_p.__setp(callee.P := ")
