"""Routines as Python functions that keep file and line of the source."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.plc.code.linker import Linker
from achse.plc.code.routines import source_of
from achse.plc.lowering.placement import Placement
from achse.plc.lowering.project import LoweredProject

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
    placement = Placement(ran.plc.memory, ran.plc.variables)
    linker = Linker(LoweredProject(ran.typed, placement))
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


GENERIC = """FUNCTION_BLOCK Base
VAR_GENERIC CONSTANT n : INT := 0; END_VAR
VAR list : ARRAY [0..n] OF INT; END_VAR
METHOD Count : INT
Count := n;
END_METHOD
METHOD Size : DINT
Size := SIZEOF(list);
END_METHOD
PROPERTY Half : INT GET Half := n / 2; END_GET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK Three EXTENDS Base<3>
VAR own : ARRAY [0..n - 1] OF INT := [1, 2, 3]; k : INT := n; END_VAR
METHOD Mine : INT
VAR a : ARRAY [1..n] OF INT; END_VAR
Mine := n + 10 * Count() + 100 * SIZEOF(a) / 2;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Wide VAR_GENERIC CONSTANT m : INT := 1; END_VAR EXTENDS Base<2 * m>
METHOD Both : INT
Both := 10 * n + m;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Last EXTENDS Wide<4>
VAR z : INT := n; END_VAR
METHOD All : INT
All := SUPER^.Both();
END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
    t : Three; w : Wide<2>; l : Last; b : Base<5>;
    a, c, d, e, f, g, h : INT; s : DINT;
END_VAR
a := t.Mine(); c := t.Count(); d := w.Both(); e := l.All(); f := l.Half;
g := b.Count(); h := t.k + 10 * l.z; s := t.Size();
END_PROGRAM"""


def test_constants_of_a_generic_base(run: Run) -> None:
    ran = run(GENERIC)
    values = {name: ran[name] for name in "acdefghs"}
    assert values == {"a": 333, "c": 3, "d": 42, "e": 84, "f": 4, "g": 5, "h": 83, "s": 8}


def test_locals_that_start_with_a_property(run: Run) -> None:
    ran = run("""
FUNCTION_BLOCK Base
VAR n : INT := 3; END_VAR
PROPERTY Place : POINTER TO INT GET Place := ADR(n); END_GET END_PROPERTY
PROPERTY Twice : INT GET Twice := 2 * n; END_GET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB EXTENDS Base
METHOD Sum : INT
VAR p : POINTER TO INT := Place; t : INT := Twice + 1; i : INT := THIS^.Twice; END_VAR
p^ := p^ + 1;
Sum := p^ + 10 * t + 100 * i;
END_METHOD
PROPERTY Next : INT GET VAR k : INT := Twice; END_VAR Next := k; END_GET END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM MAIN VAR f : FB; a, b : INT; END_VAR
a := f.Sum(); b := f.Next;
END_PROGRAM""")
    assert (ran["a"], ran["b"]) == (674, 8)


def test_variables_that_start_with_a_property(run: Run) -> None:
    ran = run("""
FUNCTION_BLOCK FB
VAR n : INT := 3; m : INT := Twice; END_VAR
PROPERTY Twice : INT GET Twice := 2 * n; END_GET END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM MAIN VAR f : FB; a : INT := f.Twice; b : INT; END_VAR
b := f.m;
END_PROGRAM""")
    assert (ran["a"], ran["b"]) == (6, 6)


@pytest.mark.parametrize("way", ["b", "i", "r"])
def test_a_property_has_the_accessor_of_its_base_that_it_lacks(run: Run, way: str) -> None:
    use = {"b": "c", "i": "i", "r": "r"}[way]
    ran = run(f"""
INTERFACE I_A
PROPERTY Value : INT GET END_GET END_PROPERTY
END_INTERFACE
INTERFACE I_B EXTENDS I_A
PROPERTY Value : INT SET END_SET END_PROPERTY
END_INTERFACE
FUNCTION_BLOCK A IMPLEMENTS I_A
VAR x : INT; END_VAR
PROPERTY Value : INT GET Value := x; END_GET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK B EXTENDS A IMPLEMENTS I_B
PROPERTY Value : INT SET x := Value + 1; END_SET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK C EXTENDS B
PROPERTY Value : INT GET Value := 100 + x; END_GET END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM MAIN VAR b : B; c : C; i : I_B := c; r : REFERENCE TO B REF= c; k, m : INT; END_VAR
b.Value := 4; k := b.Value; {use}.Value := 6; m := {use}.Value;
END_PROGRAM""")
    assert (ran["k"], ran["m"]) == (5, 107)
