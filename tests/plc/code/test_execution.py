"""Execution: linking, dispatch, time of the cycle, what cannot run."""

from collections.abc import Callable
from typing import Any

Run = Callable[..., Any]


def test_all_calls_of_a_cycle_see_its_time(run: Run) -> None:
    ran = run("PROGRAM MAIN VAR a : TIME; b : LTIME; n : DINT; END_VAR a := TIME(); b := LTIME();"
              " n := n + 1; END_PROGRAM", cycles=3)  # fmt: skip
    assert ran["n"] == 3
    assert ran["a"].total_seconds() == 0.03
    assert int(ran["b"]) == 30_000_000


def test_what_a_python_class_does_replaces_the_source(run: Run) -> None:
    ran = run("FUNCTION_BLOCK FB VAR n : INT; END_VAR n := n + 1; END_FUNCTION_BLOCK\n"
              "PROGRAM MAIN VAR f : FB; END_VAR f(); END_PROGRAM", cycles=4)  # fmt: skip
    assert ran["f.n"] == 4


def test_python_calls_a_block_and_the_block_keeps_its_state(run: Run) -> None:
    ran = run("FUNCTION_BLOCK FB VAR_INPUT d : INT; END_VAR VAR_OUTPUT n : INT; END_VAR"
              " n := n + d; END_FUNCTION_BLOCK\n"
              "PROGRAM MAIN VAR f : FB; END_VAR ; END_PROGRAM")  # fmt: skip
    block = ran.plc.instance("MAIN")["f"]
    block(d=3)
    block(d=4)
    assert ran["f.n"] == 7


def test_an_exception_stops_the_plc_and_a_reset_leads_out(run: Run) -> None:
    ran = run("PROGRAM MAIN\nVAR d : INT; x : INT := 5; END_VAR\nx := x / d;\nEND_PROGRAM")
    assert str(ran.stopped) == "exception DIVIDEBYZERO in MAIN (test.st, line 3)"
    assert 'File "test.st", line 3, in MAIN' in ran.plc.failure
    ran.plc.reset()
    assert ran.plc.fault is None
    ran.plc.instance("MAIN")["d"] = 1
    ran.plc.run()
    ran.cycle()
    assert ran["x"] == 5


def test_two_runs_give_the_same_bytes(run: Run) -> None:
    text = (
        "PROGRAM MAIN VAR a : ARRAY[0..99] OF LREAL; i : INT; s : LREAL := 0.1; END_VAR"
        " FOR i := 0 TO 99 DO s := s * 3.9 * (1.0 - s); a[i] := SIN(s); END_FOR END_PROGRAM"
    )
    assert run(text, cycles=20).plc.digest() == run(text, cycles=20).plc.digest()
