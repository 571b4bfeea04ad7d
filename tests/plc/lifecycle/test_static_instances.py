"""Function blocks in VAR_STAT variables live: once, before all others, also over online changes."""

import pytest

from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from tests.plc.lifecycle.test_instance_moves import _bodies

TEXT = """
FUNCTION_BLOCK FB_Base
VAR n : INT := 2; {member} END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; k : INT := 8; END_VAR
n := n + k; GVL.nBegun := GVL.nBegun + 1;
END_METHOD
METHOD M : INT n := n + 1; M := n; END_METHOD
METHOD W : INT W := THIS^.M(); END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Derived EXTENDS FB_Base
VAR inner : FB_Base; END_VAR
METHOD M : INT M := SUPER^.M() + 100 * inner.W(); END_METHOD
END_FUNCTION_BLOCK
TYPE ST_Part : STRUCT fb : FB_Derived; END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Owner
VAR_STAT a : ARRAY [1..2] OF FB_Derived; s : FB_Base := (n := 30); END_VAR
METHOD All : INT
VAR_STAT p : ST_Part; END_VAR
All := a[2].W() + s.W() + p.fb.W();
END_METHOD
END_FUNCTION_BLOCK
FUNCTION F_Count : INT
VAR_STAT fb : FB_Derived; {static} END_VAR
F_Count := fb.W();
END_FUNCTION
PROGRAM MAIN
VAR owner : FB_Owner; r, q, z : INT; END_VAR
VAR_STAT own : FB_Derived; END_VAR
r := owner.All(); q := F_Count(); z := own.W();
END_PROGRAM
VAR_GLOBAL nBegun : INT; END_VAR
"""


@pytest.mark.parametrize("form", [CodeForm.PLAIN, CodeForm.MACHINE])
def test_static_blocks_live(form: CodeForm) -> None:
    if form is CodeForm.MACHINE:
        pytest.importorskip("llvmlite")

    def declared(member: str = "", static: str = "") -> Declarations:
        text = TEXT.format(member=member, static=static)
        return declare([parse(Source(text, "a.st"), name="GVL")])

    def values() -> list[int]:
        main = plc.instance("MAIN")
        return [main[name] for name in "rqz"]

    def change(**parts: str) -> None:
        new = declared(**parts)
        main = new.programs["main"]
        units = [unit for unit in new.units if unit is not main]
        plc.online_change(units, {"PlcTask": [main]}, bodies=_bodies(new, form))
        plc.run_due(task.due_ns)
        assert plc.state is PlcState.RUN, plc.failure

    first = declared()
    task = Task("PlcTask", 10_000_000, [first.programs["main"]])
    plc = PlcRuntime([task], first.units, bodies=_bodies(first, form))
    assert plc.instance("GVL")["nBegun"] == 2 * 5 + 1
    plc.run_due(10_000_000)
    one = 11 + 100 * 11
    assert values() == [2 * one + 31, one, one]
    plc.reset()
    plc.run()
    plc.run_due(task.due_ns)
    assert values() == [2 * one + 31, one, one]
    change(member="f : LREAL;")
    assert values() == [2 * (one + 101) + 32, one + 101, one + 101], "moved, with their values"
    begun = plc.instance("GVL")["nBegun"]
    change(member="f : LREAL;", static="more : FB_Derived;")
    assert plc.instance("GVL")["nBegun"] == begun + 2
    assert values() == [2 * (one + 202) + 33, one + 202, one + 202]


@pytest.mark.parametrize(
    ("old", "new"),
    [("fb : FB_Derived;", "fb : FB_Derived(4);"), ("own : FB_Derived;", "own : FB_Derived(4);"),
     ("p : ST_Part;", "p : ST_Part; x : FB_Base(k := 4);")],
)  # fmt: skip
def test_arguments_for_fb_init_of_a_static_block_are_a_fault(old: str, new: str) -> None:
    text = TEXT.format(member="", static="").replace(old, new)
    faults = check(declare([parse(Source(text, "a.st"), name="GVL")])).faults
    assert ["its FB_init takes no arguments here" in fault.message for fault in faults] == [True]
