"""Calls: order of arguments, outputs, instances in arrays and behind pointers."""

from collections.abc import Callable
from typing import Any

Run = Callable[..., Any]


def test_order_and_outputs(run: Run) -> None:
    ran = run(
        "VAR_GLOBAL g : INT; END_VAR\n"
        "FUNCTION N : INT g := g + 1; N := g; END_FUNCTION\n"
        "FUNCTION F : INT VAR_INPUT a, b : INT := 5; c : INT; END_VAR"
        " VAR_OUTPUT o : BYTE; p : REAL; q : BOOL; END_VAR o := INT_TO_BYTE(a); p := b; q := c > 1;"
        " F := a * 100 + b * 10 + c; END_FUNCTION\n"
        "PROGRAM MAIN VAR x, y : INT; o : ARRAY[0..3] OF BYTE; p : LREAL; q : WORD; END_VAR"
        " x := F(c := N(), a := N(), o => o[N()], p => p, q => q.5); y := F(1, 2, 3); END_PROGRAM"
    )
    assert ran["x"] == 251
    assert ran["o"] == [0, 0, 0, 2]
    assert (ran["p"], ran["q"], ran["y"]) == (5.0, 0, 123)


def test_instances_in_arrays_and_behind_pointers(run: Run) -> None:
    ran = run(
        "FUNCTION_BLOCK FB VAR_INPUT i : INT; END_VAR VAR_OUTPUT o : INT; s : STRING; END_VAR"
        " VAR_IN_OUT io : INT; END_VAR o := o + i; io := io + o; s := INT_TO_STRING(o);"
        " END_FUNCTION_BLOCK\n"
        "PROGRAM MAIN VAR a : ARRAY[1..3] OF FB; p : POINTER TO FB; n, k, o : INT; s : STRING;"
        " END_VAR FOR k := 1 TO 3 DO a[k](i := k, io := n, o => o, s => s); END_FOR"
        " p := ADR(a[2]); p^(i := 10, io := n); END_PROGRAM"
    )
    assert ran["n"] == 1 + 2 + 3 + 12
    assert ran["s"] == "3"
