"""Routines as Python functions that keep file and line of the source."""

from collections.abc import Callable
from typing import Any

from achse.plc.code.linker import Linker
from achse.plc.code.placement import Placement
from achse.plc.code.routines import source_of

Run = Callable[..., Any]

TEXT = """FUNCTION F : INT
VAR_INPUT a : INT; END_VAR
VAR p : POINTER TO INT; END_VAR
p := ADR(a);
p^ := p^ + 1;
F := a;
END_FUNCTION
PROGRAM MAIN
VAR x : INT; END_VAR
x := F(x);
END_PROGRAM
"""


def test_only_variables_that_need_an_address_are_in_the_frame(run: Run) -> None:
    ran = run(TEXT, cycles=3)
    assert ran["x"] == 3
    linker = Linker(ran.typed, Placement(ran.plc.memory, ran.plc.variables))
    source = source_of(ran.typed.routines["f"], linker)
    assert "enter(" in source
    assert "v_p =" in source
    assert "v_a =" not in source


def test_functions_bear_the_names_and_lines_of_the_source(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN\nVAR x : INT;\nd : INT; END_VAR\nx := 1;\nx := x\n MOD\n d\n / d;\n"
        "END_PROGRAM"
    )
    frames = [line for line in ran.plc.failure.splitlines() if "test.st" in line]
    assert frames == ['  File "test.st", line 5, in MAIN']
