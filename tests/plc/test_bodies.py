"""Bodies: life of instances, calls from outside, online change."""

import pytest

from achse.iec import plain
from achse.plc.behaviour import with_behaviour
from achse.plc.bodies import Bodies
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.parser import parse
from achse.st.source import Source

LIFE = """
FUNCTION_BLOCK FB_Inner
VAR nInit : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; nStart : INT; END_VAR
nInit := nStart;
GVL.sLog := CONCAT(GVL.sLog, 'i');
END_METHOD
METHOD FB_exit : BOOL
VAR_INPUT bInCopyCode : BOOL; END_VAR
GVL.sLog := CONCAT(GVL.sLog, 'e');
END_METHOD
METHOD FB_reinit : BOOL
GVL.sLog := CONCAT(GVL.sLog, 'r');
END_METHOD
END_FUNCTION_BLOCK
VAR_GLOBAL sLog : STRING; END_VAR
PROGRAM MAIN
VAR a : FB_Inner(nStart := 7); n : INT; {more} END_VAR
n := n + {step};
END_PROGRAM
"""


def _declared(text: str) -> Declarations:
    return declare([parse(Source(text, "life.st"), name="GVL")])


def _bodies(declared: Declarations) -> Bodies:
    typed = check(declared)
    assert not typed.faults, "\n".join(map(str, typed.faults))
    return Bodies(typed)


def _plc(text: str) -> PlcRuntime:
    declared = _declared(text)
    main = declared.programs["main"]
    task = Task("PlcTask", 10_000_000, [main])
    return PlcRuntime([task], declared.units, bodies=_bodies(declared))


def _text(step: int = 1, more: str = "") -> str:
    return LIFE.replace("{step}", str(step)).replace("{more}", more)


def test_instances_come_to_life_with_the_arguments_of_their_declaration() -> None:
    plc = _plc(_text())
    main = plc.instance("MAIN")
    assert plain(main["a"])["nInit"] == 7
    assert plc.instance("GVL")["sLog"] == "i"
    plc.reset()
    assert plc.instance("GVL")["sLog"] == "i"


def test_an_online_change_copies_values_and_goes_on() -> None:
    plc = _plc(_text())
    plc.run_due(30_000_000)
    assert plc.instance("MAIN")["n"] == 3
    changed = _declared(_text(10, "x : LREAL := 2.5;"))
    plc.online_change(
        [unit for unit in changed.units if unit is not changed.programs["main"]],
        {"PlcTask": [changed.programs["main"]]},
        bodies=_bodies(changed),
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
        return _plc(text)
    declared = _declared(text)
    main = declared.programs["main"]
    units = [unit for unit in declared.units if unit is not main]
    plc.online_change(units, {"PlcTask": [main]}, bodies=_bodies(declared))
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


def test_a_fault_in_fb_init_is_an_exception_not_a_crash() -> None:
    plc = _plc(_text().replace("nInit := nStart;", "nInit := nStart / nInit;"))
    assert plc.state is PlcState.EXCEPTION
    assert plc.fault is not None
    assert plc.fault.name == "DIVIDEBYZERO"
    assert plc.fault.routine == "FB_Inner.FB_init"


CALLED = """
FUNCTION_BLOCK FB_Tank
VAR nLevel : DINT; END_VAR
{attribute 'TcRpcEnable'}
METHOD Fill : BOOL
VAR_INPUT nLitres : INT; sWho : STRING(10); END_VAR
VAR_OUTPUT nNow : DINT; sSaid : STRING(10); END_VAR
nLevel := nLevel + nLitres;
nNow := nLevel;
sSaid := sWho;
Fill := nLevel > 5;
END_METHOD
{attribute 'monitoring' := 'call'}
PROPERTY Twice : DINT
GET
Twice := nLevel * 2;
END_GET
SET
nLevel := Twice / 2;
END_SET
END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR a : FB_Tank; END_VAR
END_PROGRAM
"""


def test_clients_call_methods_and_properties_by_their_bytes() -> None:
    plc = _plc(CALLED)
    assert plc.bodies is not None
    tank = plc.instance("MAIN")["a"]
    method = type(tank).__iec__.method("Fill")
    data = b"\x07\0" + b"me".ljust(11, b"\0")
    answer = plc.bodies.call_encoded(tank, method, data)
    assert answer == b"\1" + b"\x07\0\0\0" + b"me".ljust(11, b"\0")
    assert plc.bodies.get_encoded(tank, "Twice") == b"\x0e\0\0\0"
    assert plc.bodies.set_encoded(tank, "Twice", b"\x14\0\0\0")
    assert tank["nLevel"] == 10
    assert plc.bodies.get_encoded(tank, "Other") is None


def test_a_reset_leaves_variables_with_no_init_alone() -> None:
    plc = _plc(
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


FOLLOW = """
INTERFACE I_Step METHOD Step : INT END_METHOD END_INTERFACE
FUNCTION_BLOCK FB_Step IMPLEMENTS I_Step
VAR {inner} nSteps : INT; END_VAR
METHOD Step : INT nSteps := nSteps + 1; Step := nSteps; END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR {more} fb : FB_Step; aSteps : ARRAY[1..2] OF I_Step; p : POINTER TO INT;
    r : REFERENCE TO FB_Step;
    pLast : POINTER TO INT; aOf : ARRAY[0..3] OF INT; n, k : INT; END_VAR
IF n = 0 THEN aSteps[2] := fb; p := ADR(k); r REF= fb; pLast := ADR(aOf[3]); END_IF
n := aSteps[2].Step(); p^ := p^ + 2; r.nSteps := r.nSteps + 10; pLast^ := n;
END_PROGRAM
"""


@pytest.mark.parametrize(("more", "inner"), [("x : LREAL;", ""), ("", "x : LREAL;")])
def test_addresses_follow_what_an_online_change_moves(more: str, inner: str) -> None:
    plc = _plc(FOLLOW.replace("{more}", "").replace("{inner}", ""))
    plc.run_due(30_000_000)
    changed = _declared(FOLLOW.replace("{more}", more).replace("{inner}", inner))
    main = changed.programs["main"]
    others = [unit for unit in changed.units if unit is not main]
    plc.online_change(others, {"PlcTask": [main]}, bodies=_bodies(changed))
    plc.run_due(40_000_000)
    assert plc.state is PlcState.RUN, plc.failure
    values = plc.instance("MAIN")
    assert (values["n"], values["k"], values["aOf"][3]) == (34, 8, 34)
    assert plain(values["fb"])["nSteps"] == 44


def test_blocks_of_python_that_take_turns_in_a_frame() -> None:
    class First:
        binds = "FB_A"
        n: int
        a: int

        def cycle(self) -> None:
            self.a = self.n + 1

    class Second:
        binds = "FB_B"
        m: int
        b: int

        def cycle(self) -> None:
            self.b = self.m * 10

    declared = _declared("""
FUNCTION_BLOCK FB_A VAR_INPUT n : INT; END_VAR VAR_OUTPUT a : INT; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_B VAR_INPUT m : INT; END_VAR VAR_OUTPUT b : INT; END_VAR END_FUNCTION_BLOCK
FUNCTION F : INT VAR inner : FB_A; END_VAR inner(n := 3); F := inner.a; END_FUNCTION
FUNCTION G : INT VAR inner : FB_B; END_VAR inner(m := 3); G := inner.b; END_FUNCTION
PROGRAM MAIN VAR x : ARRAY [0..3] OF INT; END_VAR
x[0] := F(); x[1] := G(); x[2] := F(); x[3] := G();
END_PROGRAM""")
    units = with_behaviour(declared.units, [First, Second], declared.types.values())
    task = Task("PlcTask", 10_000_000, list(declared.programs.values()))
    plc = PlcRuntime([task], units, bodies=_bodies(declared))
    plc.run_due(10_000_000)
    assert plc.failure == ""
    assert list(plc.instance("MAIN")["x"]) == [4, 30, 4, 30]
