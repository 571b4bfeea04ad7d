"""Instances of function blocks: their begin, their end and online changes."""

import pytest

from achse.iec import plain
from achse.plc.bodies import Bodies
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

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


def test_a_fault_in_fb_init_is_an_exception_not_a_crash() -> None:
    plc = _plc(_text().replace("nInit := nStart;", "nInit := nStart / nInit;"))
    assert plc.state is PlcState.EXCEPTION
    assert plc.fault is not None
    assert plc.fault.name == "DIVIDEBYZERO"
    assert plc.fault.routine == "FB_Inner.FB_init"


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
