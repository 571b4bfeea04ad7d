"""Statements whose ways are more than one: CASE, marks, loops with jumps out of them."""

from collections.abc import Callable
from typing import Any

Run = Callable[..., Any]


def test_case_by_table_and_by_ranges(run: Run) -> None:
    text = (
        "PROGRAM MAIN VAR i, x : INT; b : BYTE; END_VAR FOR i := -3 TO 300 DO CASE i OF"
        " -2, 5, 7..9: x := x + 1; 8: x := x + 1000; {} ELSE x := x + 10; END_CASE END_FOR\n"
        "CASE b OF 0..255: x := x + 1; END_CASE END_PROGRAM"
    )
    assert run(text.format(""))["x"] == 5 + 299 * 10 + 1
    assert run(text.format("100..299: x := x + 2;"))["x"] == 5 + 400 + 99 * 10 + 1


def test_jumps_out_of_loops_and_try(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR i, x, n : INT; END_VAR\n"
        "again: n := n + 1;\nFOR i := 1 TO 10 DO\n__TRY\n"
        "IF i = 4 AND n < 3 THEN JMP again; END_IF\n"
        "IF i = 6 THEN EXIT; END_IF\nIF i = 2 THEN CONTINUE; END_IF\nx := x + i;\n"
        "__FINALLY\nx := x + 100;\n__ENDTRY\nEND_FOR\nIF x > 10000 THEN JMP over; END_IF\n"
        "x := x + 1;\nover: ;\nEND_PROGRAM",
        budget=60,
    )
    assert ran["n"] == 3
    assert ran["x"] == 4 * 100 * 2 + 4 * 2 + 600 + 13 + 1


def test_the_line_of_a_fault_in_a_condition(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN\nVAR i, z : INT; END_VAR\nREPEAT\ni := i + 1;\nUNTIL 1 / z = 0\nEND_REPEAT\n"
        "END_PROGRAM"
    )
    assert ran.stopped.name == "DIVIDEBYZERO"


def test_finally_comes_before_a_loop_goes_on(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR i, n, z, x : INT; END_VAR\n"
        "REPEAT n := n + 1;\n__TRY CONTINUE;\n__FINALLY z := z + 1;\n__ENDTRY\n"
        "UNTIL z >= 2 END_REPEAT\n"
        "FOR i := 1 TO 3 DO __TRY CONTINUE; __FINALLY x := 10 * x + i; __ENDTRY END_FOR\n"
        "END_PROGRAM"
    )
    assert (ran["n"], ran["z"], ran["x"]) == (2, 2, 123)
