"""Routines: frames, parameters, results, and calls from Python."""

from collections.abc import Callable
from typing import Any

Run = Callable[..., Any]


def test_python_calls_with_values_of_all_kinds(run: Run) -> None:
    ran = run(
        "TYPE T : STRUCT a : INT; b : LREAL; END_STRUCT END_TYPE\n"
        "FUNCTION F : STRING(9) VAR_INPUT i : INT; r : REAL; s : STRING(5); t : T; b : BOOL;"
        " END_VAR"
        " VAR_OUTPUT n : DINT; o : STRING(4); u : T; x : LREAL; END_VAR\n"
        "F := CONCAT(s, INT_TO_STRING(i)); n := -i; o := s; u := t; u.a := u.a + 1; x := r;"
        " IF b THEN x := -x; END_IF END_FUNCTION\n"
        "PROGRAM MAIN VAR s : STRING; END_VAR s := F(1, 1, '', b := FALSE); END_PROGRAM"
    )
    function = ran.plc.bodies.execution.function("f")
    record = bytes([7, 0, 0, 0, 0, 0, 0, 0]) + b"\0\0\0\0\0\0\xf8\x3f"
    assert function(12, 0.5, b"hello", record, True) == (
        b"hello12", -12, b"hell", bytes([8]) + record[1:], -0.5,
    )  # fmt: skip
    assert function(12, v_r=0.5, v_s=b"", v_t=record, v_b=False)[0] == b"12"


def test_results_are_taken_before_finally(run: Run) -> None:
    ran = run(
        "FUNCTION F : INT VAR_INPUT n : INT; END_VAR __TRY F := n; RETURN; __FINALLY F := 99;"
        " __ENDTRY END_FUNCTION\nPROGRAM MAIN VAR x : INT; END_VAR x := F(5); END_PROGRAM"
    )
    assert ran["x"] == 5
