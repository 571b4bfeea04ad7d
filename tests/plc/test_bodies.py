"""Bodies: code linked with a memory, and linked again by an online change."""

import pytest

from achse.iec import plain
from achse.plc.runtime import PlcRuntime, PlcState
from tests.plc.one_text import bodies_of, declared_text, life_text, plc_of


def test_an_online_change_copies_values_and_goes_on() -> None:
    plc = plc_of(life_text())
    plc.run_due(30_000_000)
    assert plc.instance("MAIN")["n"] == 3
    changed = declared_text(life_text(10, "x : LREAL := 2.5;"))
    plc.online_change(
        [unit for unit in changed.units if unit is not changed.programs["main"]],
        {"PlcTask": [changed.programs["main"]]},
        bodies=bodies_of(changed),
    )
    assert plc.state is PlcState.RUN, plc.failure
    plc.run_due(40_000_000)
    main = plc.instance("MAIN")
    assert (main["n"], main["x"], plain(main["a"])["nInit"]) == (13, 2.5, 7)
    assert plc.instance("GVL")["sLog"] == "i", "its block is declared as before"


CHANGED = """
FUNCTION_BLOCK FB_Count
VAR_INPUT nStep : INT; END_VAR
VAR n : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR
GVL.sLog := CONCAT(GVL.sLog, 'i');
END_METHOD
METHOD FB_exit : BOOL
VAR_INPUT bInCopyCode : BOOL; END_VAR
GVL.sLog := CONCAT(GVL.sLog, 'e');
END_METHOD
n := n + nStep;
{method}
END_FUNCTION_BLOCK
{more}
FUNCTION F_Next : INT
VAR_STAT nCalls : INT{initial}; {statics} END_VAR
nCalls := nCalls + 1;
F_Next := nCalls;
END_FUNCTION
VAR_GLOBAL sLog : STRING; END_VAR
PROGRAM MAIN
VAR
    a : FB_Count; p : POINTER TO FB_Count; q : POINTER TO INT := ADR(k); k : INT; nCalls : INT;
    i : I_Count; nMade : INT; {variable}
END_VAR
IF p = 0 THEN p := __NEW(FB_Count); END_IF
a(nStep := {step});
p^(nStep := {step});
nCalls := F_Next();
nMade := p^.n;
{body}
END_PROGRAM
INTERFACE I_Count
END_INTERFACE
"""


def _changed(plc: PlcRuntime | None = None, **parts: str) -> PlcRuntime:
    """A PLC with the text, or the running one with the text from now on."""
    text = CHANGED.replace("{step}", parts.get("step", "1"))
    for name in ("method", "more", "initial", "statics", "variable", "body"):
        text = text.replace(f"{{{name}}}", parts.get(name, ""))
    if plc is None:
        return plc_of(text)
    declared = declared_text(text)
    main = declared.programs["main"]
    units = [unit for unit in declared.units if unit is not main]
    plc.online_change(units, {"PlcTask": [main]}, bodies=bodies_of(declared))
    return plc


def test_new_bodies_take_effect_without_touching_instances() -> None:
    plc = _changed()
    plc.run_due(30_000_000)
    units = plc.units
    plc.instance("MAIN")["k"] = 5
    _changed(
        plc,
        step="10",
        more="FUNCTION_BLOCK FB_Before METHOD M END_METHOD END_FUNCTION_BLOCK",
        method="METHOD More : INT More := n * 2; END_METHOD",
        body="q^ := a.More();",
    )
    assert plc.units is units, "nothing is placed again"
    assert plc.online_changes == 1
    plc.run_due(40_000_000)
    assert plc.state is PlcState.RUN, plc.failure
    main = plc.instance("MAIN")
    assert (plain(main["a"])["n"], main["k"], main["nCalls"], main["nMade"]) == (13, 26, 4, 13)
    assert plc.instance("GVL")["sLog"] == "ii", "no FB_exit, no FB_init"
    plc.reset()
    plc.run()
    plc.run_due(50_000_000)
    assert plain(main["a"])["n"] == 10


@pytest.mark.parametrize(
    "parts",
    [
        {"variable": "x : INT;"},
        {"variable": "(* said of it *) x : INT;"},
        {"statics": "nMore : INT;"},
        {"initial": " := 5"},
    ],
)
def test_changed_declarations_elsewhere_leave_instances_alone(parts: dict[str, str]) -> None:
    plc = _changed()
    plc.run_due(30_000_000)
    _changed(plc, step="10", **parts)
    plc.run_due(40_000_000)
    assert plc.state is PlcState.RUN, plc.failure
    main = plc.instance("MAIN")
    assert (plain(main["a"])["n"], main["nCalls"], main["nMade"]) == (13, 4, 13)
    assert plc.instance("GVL")["sLog"] == "ii", "their block is declared as before"


def test_a_reset_leaves_variables_with_no_init_alone() -> None:
    plc = plc_of(
        """
        FUNCTION_BLOCK FB VAR {attribute 'noinit'} n : INT; m : INT; END_VAR END_FUNCTION_BLOCK
        PROGRAM MAIN VAR {attribute 'no_init'} a : INT := 2; b : INT; f : FB; END_VAR
        a := a + 1; b := b + 1; f.n := f.n + 1; f.m := f.m + 1;
        END_PROGRAM
        """
    )
    plc.run_due(30_000_000)
    plc.reset()
    main = plc.instance("MAIN")
    assert (main["a"], main["b"], main["f"]["n"], main["f"]["m"]) == (5, 0, 3, 0)
    plc.reset(origin=True)
    assert (main["a"], main["f"]["n"]) == (2, 0)
