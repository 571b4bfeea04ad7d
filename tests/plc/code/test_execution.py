"""Execution: linking, dispatch, time of the cycle, what cannot run."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec import plain
from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

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


LIBRARY = """
TYPE E_Mode : (Slow := 3, Fast) INT; END_TYPE
TYPE ST_Data : STRUCT n : INT := 4; e : E_Mode := Fast; END_STRUCT END_TYPE
TYPE ST_More EXTENDS ST_Data : STRUCT k : INT := cMost; END_STRUCT END_TYPE
TYPE T_Alias : ARRAY [0..cMost] OF ST_More; END_TYPE
VAR_GLOBAL CONSTANT cMost : INT := 2; END_VAR
VAR_GLOBAL nCount : INT := 50; END_VAR
INTERFACE I_Get METHOD Get : INT END_METHOD PROPERTY Level : INT GET END_GET END_PROPERTY
END_INTERFACE
FUNCTION F_Add : INT VAR_INPUT a : INT; b : INT := cMost; END_VAR F_Add := a + b; END_FUNCTION
FUNCTION_BLOCK FB_Base IMPLEMENTS I_Get VAR d : T_Alias; s : ST_Data; END_VAR
METHOD Get : INT Get := F_Add(d[1].n) + d[0].k + E_Mode.Slow + s.e; END_METHOD
PROPERTY Level : INT GET Level := nCount; END_GET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Main EXTENDS FB_Base VAR_OUTPUT q : INT; END_VAR
VAR i : I_Get; p : POINTER TO FB_Base; END_VAR
i := THIS^; p := ADR(THIS^); nCount := nCount + 1;
q := 100 * i.Get() + p^.Level + SIZEOF(T_Alias) + Slow + SIZEOF(FB_Base);
END_FUNCTION_BLOCK
"""
_USER = """
PROGRAM MAIN VAR f : Lib.FB_Main; m : Lib.T_Alias; a, b, c, e : INT; END_VAR
f(); a := Lib.F_Add(1); b := Lib.nCount; c := Lib.cMost + Lib.E_Mode.Fast; e := m[2].k;
END_PROGRAM
"""
TYPES = ("E_Mode", "ST_Data", "ST_More", "T_Alias", "I_Get", "FB_Base", "FB_Main")
NAMES = (*TYPES, "cMost", "nCount", "F_Add", "Slow", "Fast", "Get")
_AGAIN = {
    "structure": "TYPE {0} : STRUCT other : LREAL; END_STRUCT END_TYPE",
    "enumeration": "TYPE {0} : (Some{0} := 9, Slow := 8) LINT; END_TYPE",
    "alias": "TYPE {0} : BYTE; END_TYPE",
    "block": "FUNCTION_BLOCK {0} VAR other : LREAL; END_VAR METHOD Other : BOOL END_METHOD"
    " END_FUNCTION_BLOCK",
    "function": "FUNCTION {0} : LREAL VAR_INPUT other : LREAL := 0.5; END_VAR {0} := other;"
    " END_FUNCTION",
    "interface": "INTERFACE {0} METHOD Other : BOOL END_METHOD END_INTERFACE",
    "variable": "VAR_GLOBAL {0} : LREAL := 77.5; END_VAR",
    "constant": "VAR_GLOBAL CONSTANT {0} : INT := 77; END_VAR",
    "list": "{{attribute 'qualified_only'}} VAR_GLOBAL k{0} : LREAL; END_VAR",
}


def _beside(kinds: list[str], form: CodeForm) -> dict[str, Any]:
    """What a library does beside a project that declares its names again, each as some kind."""
    library = Source(LIBRARY, "lib.st")
    library.library = "Lib"
    own = [
        parse(Source(_AGAIN[kind].format(name), f"{name}.st"), name=name)
        for name, kind in zip(NAMES, kinds, strict=True)
        if kind
    ]
    declared = declare(
        [parse(Source(_USER, "main.st")), *own], libraries=[parse(library, name="GVL_Lib").check()]
    )
    typed = check(declared)
    assert not typed.faults, "\n".join(map(str, typed.faults))
    task = Task("PlcTask", 10_000_000, [declared.programs["main"]])
    plc = PlcRuntime([task], declared.units, bodies=Bodies(typed, form=form))
    plc.run_due(20_000_000)
    assert plc.fault is None
    main = plc.instance("MAIN")
    values = {name: plain(main[name]) for name in ("m", "a", "b", "c", "e")}
    return {**values, "q": main["f"]["q"], "size": type(main["f"]).__iec__.size}


@settings(max_examples=12)
@given(st.lists(st.sampled_from(["", *_AGAIN]), min_size=len(NAMES), max_size=len(NAMES)))
def test_libraries_do_not_see_names_of_the_project(kinds: list[str]) -> None:
    alone = _beside([""] * len(NAMES), CodeForm.PLAIN)
    assert (alone["a"], alone["b"], alone["c"], alone["e"]) == (3, 52, 6, 2)
    assert _beside(kinds, CodeForm.PLAIN) == alone


@pytest.mark.parametrize("kind", _AGAIN)
def test_library_is_the_same_beside_all_its_names(kind: str, form: CodeForm) -> None:
    assert _beside([kind] * len(NAMES), form) == _beside([""] * len(NAMES), CodeForm.PLAIN)


def test_built_in_functions_work_beside_functions_of_their_name(run: Run) -> None:
    ran = run(
        "FUNCTION F_CheckMemoryArea : INT F_CheckMemoryArea := 77; END_FUNCTION\n"
        "PROGRAM MAIN VAR x : INT; a : INT; b : DINT; END_VAR a := F_CheckMemoryArea();"
        " b := Tc2_System.F_CheckMemoryArea(ADR(x), 2); END_PROGRAM"
    )
    assert (ran["a"], ran["b"]) == (77, 1)
