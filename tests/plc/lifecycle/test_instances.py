"""Instances of function blocks: their begin, their end and online changes."""

import pytest

from achse.iec import plain
from achse.plc.runtime import PlcState
from tests.plc.one_text import bodies_of, declared_text, life_text, plc_of


def test_instances_are_created_with_the_arguments_of_their_declaration() -> None:
    plc = plc_of(life_text())
    main = plc.instance("MAIN")
    assert plain(main["a"])["nInit"] == 7
    assert plc.instance("GVL")["sLog"] == "i"
    plc.reset()
    assert plc.instance("GVL")["sLog"] == "i"


def test_a_fault_in_fb_init_is_an_exception_not_a_crash() -> None:
    plc = plc_of(life_text().replace("nInit := nStart;", "nInit := nStart / nInit;"))
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
    plc = plc_of(FOLLOW.replace("{more}", "").replace("{inner}", ""))
    plc.run_due(30_000_000)
    changed = declared_text(FOLLOW.replace("{more}", more).replace("{inner}", inner))
    main = changed.programs["main"]
    others = [unit for unit in changed.units if unit is not main]
    plc.online_change(others, {"PlcTask": [main]}, bodies=bodies_of(changed))
    plc.run_due(40_000_000)
    assert plc.state is PlcState.RUN, plc.failure
    values = plc.instance("MAIN")
    assert (values["n"], values["k"], values["aOf"][3]) == (34, 8, 34)
    assert plain(values["fb"])["nSteps"] == 44
