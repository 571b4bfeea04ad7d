"""Calls: functions, methods, blocks, their inputs, outputs and in/outs."""

from collections.abc import Callable
from typing import Any

Run = Callable[..., Any]

POINT = "TYPE ST_Point : STRUCT x : INT; y : INT; END_STRUCT END_TYPE\n"


def test_functions_start_from_their_initial_values_each_time(run: Run) -> None:
    ran = run(
        "FUNCTION F : INT VAR_INPUT a : INT := 3; b : INT; END_VAR VAR n : INT := 10; END_VAR"
        " n := n + a; F := n * 2 + b; END_FUNCTION\n"
        "PROGRAM MAIN VAR x : INT; y : INT; END_VAR x := F(b := 1); y := F(1, 2); END_PROGRAM",
        cycles=2,
    )
    assert (ran["x"], ran["y"]) == (27, 24)


def test_outputs_and_in_outs_reach_the_caller(run: Run) -> None:
    ran = run(
        POINT + "FUNCTION F : BOOL VAR_INPUT d : INT; END_VAR VAR_IN_OUT p : ST_Point; END_VAR"
        " VAR_OUTPUT s : DINT; END_VAR p.x := p.x + d; s := p.x + p.y; F := s > 5; END_FUNCTION\n"
        "PROGRAM MAIN VAR p : ST_Point := (x := 1, y := 2); s : INT; b : BOOL; END_VAR"
        " b := F(d := 4, p := p, s => s); END_PROGRAM"
    )
    assert (ran["p"], ran["s"], ran["b"]) == ({"x": 5, "y": 2}, 7, True)


def test_result_of_a_function_is_stored_by_its_name(run: Run) -> None:
    ran = run(
        "FUNCTION F : INT VAR_INPUT a : INT; END_VAR VAR_OUTPUT b : INT; END_VAR"
        " b := a * 3; F := a * 2; END_FUNCTION\n"
        "FUNCTION G : LREAL VAR_INPUT a : LREAL; END_VAR G := a / 2; END_FUNCTION\n"
        "FUNCTION_BLOCK FB VAR n : INT := 5; END_VAR METHOD M : INT VAR_INPUT a : INT; END_VAR"
        " M := n + a; END_METHOD END_FUNCTION_BLOCK\n"
        "PROGRAM MAIN VAR fb : FB; x, y, v : INT; z, w : DINT; g : LREAL; END_VAR"
        " F(a := 4, F => x, b => y); z := F(a := 5, f => w); fb.M(a := 1, M => v);"
        " G(a := 3, G => g); END_PROGRAM"
    )
    assert (ran["x"], ran["y"], ran["v"]) == (8, 12, 6)
    assert (ran["z"], ran["w"], ran["g"]) == (10, 10, 1.5)


def test_a_branch_behind_else_is_one_of_the_branches(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR i : INT; a : ARRAY [0..3] OF INT; END_VAR FOR i := 0 TO 3 DO"
        " CASE i OF 1: a[i] := 10; ELSE a[i] := 99; 2: a[i] := 20; END_CASE END_FOR END_PROGRAM"
    )
    assert list(ran["a"]) == [99, 10, 20, 99]


def test_inputs_of_a_block_keep_their_value(run: Run) -> None:
    ran = run(
        "FUNCTION_BLOCK FB VAR_INPUT a : INT := 2; b : INT; END_VAR VAR_OUTPUT q : INT; END_VAR"
        " q := q + a * b; END_FUNCTION_BLOCK\n"
        "PROGRAM MAIN VAR f : FB; g : ARRAY[1..3] OF FB; i : INT; n : INT; END_VAR"
        " f(b := 5, q => n); f(); f.a := 1; f();"
        " FOR i := 1 TO 3 DO g[i](a := i, b := 10); END_FOR END_PROGRAM"
    )
    assert (ran["f.q"], ran["n"]) == (25, 10)
    assert [one["q"] for one in ran["g"]] == [10, 20, 30]


OBJECTS = """
INTERFACE I_Shape
METHOD Area : INT
VAR_INPUT scale : INT; END_VAR
END_METHOD
END_INTERFACE
FUNCTION_BLOCK ABSTRACT FB_Shape IMPLEMENTS I_Shape
VAR n : INT := 2; END_VAR
METHOD Area : INT
VAR_INPUT scale : INT; END_VAR
Area := n * scale;
END_METHOD
METHOD Twice : INT
Twice := THIS^.Area(2);
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Square EXTENDS FB_Shape
VAR side : INT := 5; END_VAR
METHOD Area : INT
VAR_INPUT scale : INT; END_VAR
Area := SUPER^.Area(scale) + side * side;
END_METHOD
PROPERTY Side2 : INT
GET
Side2 := side * 2;
END_GET
SET
side := Side2 / 2;
END_SET
END_PROPERTY
END_FUNCTION_BLOCK
"""


def test_methods_are_virtual_and_interfaces_lead_to_them(run: Run) -> None:
    ran = run(
        OBJECTS + "PROGRAM MAIN VAR s : FB_Square; i : I_Shape; a : INT; b : INT; c : INT; d : INT;"
        " END_VAR i := s; a := i.Area(3); b := s.Twice(); s.Side2 := 14; c := s.Area(scale := 0);"
        " d := s.Side2; END_PROGRAM"
    )
    assert [ran[name] for name in "abcd"] == [31, 29, 49, 14]


def test_a_call_through_a_null_interface_is_an_access_violation(run: Run) -> None:
    ran = run(
        OBJECTS + "PROGRAM MAIN VAR i : I_Shape; x : INT; END_VAR\nx := i.Area(1);\nEND_PROGRAM"
    )
    assert ran.stopped.name == "ACCESS_VIOLATION"
    assert ran.stopped.routine == "MAIN"


def test_endless_recursion_is_a_stack_overflow(run: Run) -> None:
    ran = run(
        "FUNCTION F : INT VAR_INPUT n : INT; END_VAR F := F(n + 1); END_FUNCTION\n"
        "PROGRAM MAIN VAR x : INT; END_VAR x := F(1); END_PROGRAM"
    )
    assert ran.stopped.name == "STACK_OVERFLOW"


def test_recursion_with_frames_in_memory(run: Run) -> None:
    ran = run(
        "FUNCTION F : INT VAR_INPUT n : INT; END_VAR VAR a : ARRAY[0..1] OF INT; END_VAR"
        " a[0] := n; IF n > 0 THEN a[1] := F(n - 1); END_IF F := a[0] + a[1]; END_FUNCTION\n"
        "PROGRAM MAIN VAR x : INT; END_VAR x := F(10); END_PROGRAM"
    )
    assert ran["x"] == 55


def test_new_and_delete(run: Run) -> None:
    ran = run(
        OBJECTS + "PROGRAM MAIN VAR p : POINTER TO FB_Square; q : POINTER TO INT; x : INT; n : INT;"
        " gone : BOOL; END_VAR p := __NEW(FB_Square); x := p^.Area(1); __DELETE(p); gone := p = 0;"
        " q := __NEW(INT, 4); q[3] := 7; n := q[3]; __DELETE(q); END_PROGRAM",
        cycles=50,
    )
    assert (ran["x"], ran["gone"], ran["n"]) == (27, True, 7)
    assert ran.plc.bodies.execution.heap.used == 0


_WRAPPERS = {
    "FB_B": "",
    "ST_W": ".fb",
    "ARRAY [1..2] OF FB_B": "[2]",
    "FB_W": ".fb",
}
_CALLS = (
    "CallInOut(fb := {0})",
    "CallPointer(p := ADR({0}))",
    "CallInterface(i := {0})",
    "{0}.Twice()",
)
_VALUE_UNITS = """
INTERFACE I_Get METHOD Get : INT END_METHOD END_INTERFACE
FUNCTION_BLOCK FB_A IMPLEMENTS I_Get VAR n : INT := 3; END_VAR
    METHOD Get : INT Get := n; END_METHOD
    METHOD Twice : INT Twice := THIS^.Get() + Get(); END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_B EXTENDS FB_A METHOD Get : INT Get := 10 * n; END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_W VAR_INPUT fb : FB_B; END_VAR END_FUNCTION_BLOCK
TYPE ST_W : STRUCT k : BYTE; fb : FB_B; END_STRUCT END_TYPE
FUNCTION CallInOut : INT VAR_IN_OUT fb : FB_A; END_VAR CallInOut := fb.Twice(); END_FUNCTION
FUNCTION CallPointer : INT VAR_INPUT p : POINTER TO FB_A; END_VAR
    CallPointer := p^.Twice(); END_FUNCTION
FUNCTION CallInterface : INT VAR_INPUT i : I_Get; END_VAR CallInterface := 2 * i.Get(); END_FUNCTION
"""


def test_blocks_passed_by_value_keep_their_methods(run: Run) -> None:
    """As input and result of a function, and as input of a method and of a property; alone, in a
    structure, an array and a block; called through each kind of address."""
    units, variables, lines = [_VALUE_UNITS], ["n : INT;"], []
    for number, (type, path) in enumerate(_WRAPPERS.items()):
        variables.append(f"w{number} : {type}; h{number} : FB_H{number};")
        lines.append(f"w{number}{path}.n := n;")
        methods = []
        for kind, call in enumerate(_CALLS):
            inside = call.format(f"w{path}")
            key = f"{number}_{kind}"
            head = f"VAR_INPUT w : {type}; END_VAR"
            units.append(f"FUNCTION F{key} : INT {head} F{key} := {inside}; END_FUNCTION")
            units.append(
                f"FUNCTION R{key} : {type} {head} VAR_OUTPUT q : INT; END_VAR R{key} := w;"
            )
            units.append(f"q := {call.format(f'R{key}{path}')}; END_FUNCTION")
            methods.append(f"METHOD M{key} : INT {head} M{key} := {inside}; END_METHOD")
            methods.append(
                f"PROPERTY P{key} : {type} SET k{key} := {call.format(f'P{key}{path}')};"
            )
            methods.append("END_SET END_PROPERTY")
            results = [f"{use}{key}" for use in ("f", "r", "m")]
            variables.append(f"{', '.join(results)} : INT;")
            lines.append(f"f{key} := F{key}(w{number}); R{key}(w{number}, q => r{key});")
            lines.append(f"m{key} := h{number}.M{key}(w{number}); h{number}.P{key} := w{number};")
        results_by_kind = "".join(f"k{number}_{kind} : INT;" for kind in range(len(_CALLS)))
        units.append(f"FUNCTION_BLOCK FB_H{number} VAR {results_by_kind} END_VAR")
        units += [*methods, "END_FUNCTION_BLOCK"]
    lines.append("n := n + 1;")
    body = "\n".join((*units, "PROGRAM MAIN VAR", *variables, "END_VAR", *lines, "END_PROGRAM"))
    ran = run(body, cycles=3)
    for number in range(len(_WRAPPERS)):
        for kind in range(len(_CALLS)):
            key = f"{number}_{kind}"
            values_of_call = [
                ran[path] for path in (f"f{key}", f"r{key}", f"m{key}", f"h{number}.k{key}")
            ]
            assert values_of_call == [40] * 4, (number, kind)
