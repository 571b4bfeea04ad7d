"""RETAIN and PERSISTENT variables of a PLC go into the next one, if they have the same type."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.plc.memory import Area
from achse.plc.retention.retained_state import inherit_variables, retained_variables
from tests.plc.code.conftest import Ran

TEXT = """
FUNCTION_BLOCK FB_Pump
VAR PERSISTENT nStarts : {type}; END_VAR
VAR n : INT; END_VAR
END_FUNCTION_BLOCK
VAR_GLOBAL PERSISTENT sName : STRING(10); END_VAR
PROGRAM MAIN
VAR RETAIN r : INT := 3; END_VAR
VAR PERSISTENT p : ARRAY [1..2] OF DINT; END_VAR
VAR a : ARRAY [0..1] OF FB_Pump; n : INT; END_VAR
END_PROGRAM
"""


def _ran(type: str = "UDINT") -> Ran:
    return Ran(TEXT.replace("{type}", type)).cycle()


@given(
    st.integers(-(1 << 15), (1 << 15) - 1),
    st.lists(st.integers(0, (1 << 31) - 1), min_size=4, max_size=4),
    st.text("abcX", max_size=10),
)
def test_what_was_kept_is_there_again(number: int, numbers: list[int], text: str) -> None:
    before, after = _ran(), _ran()
    main = before.plc.instance("MAIN")
    main["r"], main["n"] = number, 7
    main["p"][1], main["p"][2] = numbers[:2]
    main["a"][0]["nStarts"], main["a"][1]["nStarts"] = numbers[2:]
    before.plc.instance("GVL")["sName"] = text
    retained = retained_variables(before.plc)
    assert set(retained) == {
        "MAIN.r", "MAIN.p", "MAIN.a[0].nStarts", "MAIN.a[1].nStarts", "GVL.sName"
    }  # fmt: skip
    assert inherit_variables(after.plc, retained) == []
    assert (after["r"], after["p"], after["n"]) == (number, numbers[:2], 0)
    assert [one["nStarts"] for one in after.plc.instance("MAIN")["a"]] == numbers[2:]
    assert after.plc.instance("GVL")["sName"] == text


def test_another_type_begins_as_declared_and_is_reported() -> None:
    before, after = _ran(), _ran("LINT")
    before.plc.instance("MAIN")["a"][0]["nStarts"] = 5
    left = inherit_variables(after.plc, retained_variables(before.plc))
    assert left == ["MAIN.a[0].nStarts", "MAIN.a[1].nStarts"]
    assert after.plc.instance("MAIN")["a"][0]["nStarts"] == 0


STARTS = """
FUNCTION_BLOCK FB_Pump
VAR PERSISTENT nTotal : INT := 7; END_VAR
VAR nIn : INT; {attribute 'no_init'} nLeft : INT; END_VAR
VAR_STAT PERSISTENT nAll : INT := 2; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; n : INT; END_VAR
nIn := nTotal := n; nLeft := nLeft + 1;
END_METHOD
nIn := nIn + 1; nTotal := nTotal + 1; nAll := nAll + 1;
END_FUNCTION_BLOCK
FUNCTION F_Count : INT
VAR_STAT RETAIN nCalls : INT; END_VAR
nCalls := nCalls + 1; F_Count := nCalls;
END_FUNCTION
PROGRAM MAIN
VAR
    a : FB_Pump(5) := (nTotal := 100);
    n : INT;
END_VAR
VAR PERSISTENT
    b : FB_Pump(50);
END_VAR
a(); b(); n := F_Count();
END_PROGRAM
"""


def _values(ran: Ran) -> dict[str, int]:
    plc = ran.plc
    assert plc.bodies is not None
    values = {
        one.name: int.from_bytes(plc.memory[one.area].read(one.offset, 2), "little")
        for one in (*plc.statics, *plc.bodies.statics)
    }
    for name in ("a", "b"):
        values |= {f"{name}.{n}": ran[f"{name}.{n}"] for n in ("nTotal", "nIn", "nLeft")}
    return values


def test_a_cold_reset_and_a_restart_keep_what_fb_init_and_declarations_set() -> None:
    ran = Ran(STARTS, has_twin=False).cycle(3)
    retained = {
        "a.nTotal": 103,
        "b.nTotal": 53,
        "b.nIn": 53,
        "FB_Pump.nAll": 8,
        "F_Count.nCalls": 3,
    }
    assert _values(ran) == retained | {"a.nIn": 8, "a.nLeft": 1, "b.nLeft": 1}
    values = retained_variables(ran.plc)
    ran.plc.reset()
    assert _values(ran) == retained | {"a.nIn": 5, "a.nLeft": 2, "b.nLeft": 1}
    after = Ran(STARTS, has_twin=False)
    assert inherit_variables(after.plc, values) == []
    assert _values(after) == retained | {"a.nIn": 5, "a.nLeft": 1, "b.nLeft": 1}
    ran.plc.reset(origin=True)
    assert _values(ran) == {
        "a.nTotal": 100, "b.nTotal": 50, "b.nIn": 50, "FB_Pump.nAll": 2, "F_Count.nCalls": 0,
        "a.nIn": 5, "a.nLeft": 1, "b.nLeft": 1,
    }  # fmt: skip


def test_what_is_kept_stays_when_the_start_after_a_reset_fails() -> None:
    text = STARTS.replace("nLeft := nLeft + 1;", "nLeft := n / GVL.nBy;")
    ran = Ran(f"VAR_GLOBAL {{attribute 'no_init'}} nBy : INT := 1; END_VAR {text}")
    ran.plc.instance("MAIN")["b"]["nTotal"], ran.plc.instance("GVL")["nBy"] = 9, 0
    ran.plc.reset()
    assert ran.stopped.name == "DIVIDEBYZERO"
    assert (ran["a.nTotal"], ran["b.nTotal"]) == (100, 9)


LEADING = """
{first}
INTERFACE I_Part METHOD M : INT END_METHOD END_INTERFACE
FUNCTION_BLOCK FB_Part IMPLEMENTS I_Part
VAR k : INT; END_VAR
METHOD M : INT k := k + 1; M := 100 + k; END_METHOD
METHOD W : INT W := THIS^.M(); END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR {before} t : INT := 5; u : ARRAY [0..2] OF {type} := [6, 7, 8]; END_VAR
VAR PERSISTENT
    fb : FB_Part; p : POINTER TO INT; i : I_Part; r : REFERENCE TO {type}; q : POINTER TO INT;
    m : POINTER TO INT;
END_VAR
VAR a, b, c, d, e : INT; bStarted : BOOL; {more} END_VAR
{body}
a := fb.W(); b := p^; c := i.M(); e := m^;
IF __ISVALIDREF(r) THEN d := TO_INT(r); END_IF
END_PROGRAM
"""
AIM = "p := ADR(t); r REF= u[1]; i := fb; q := __NEW(INT); m := ADR(%MW4); %MW4 := 44;"
OTHER = """FUNCTION_BLOCK FB_Early
METHOD M : INT M := -7; END_METHOD METHOD W : INT W := -8; END_METHOD
END_FUNCTION_BLOCK"""


def _leading(first: str = "", before: str = "", type: str = "INT", body: str = "") -> Ran:
    more = "early : FB_Early;" if first else ""
    body = f"{body} {'early.M();' if first else ''}"
    text = LEADING.format(first=first, before=before, type=type, body=body, more=more)
    return Ran(text.replace("ADR(%MW4)", "ADR(GVL.w)").replace("%MW4 :=", "GVL.w :=")
               + "VAR_GLOBAL w AT %MW4 : INT; END_VAR", has_twin=False)  # fmt: skip


def test_pointers_lead_to_the_same_variables_in_another_program() -> None:
    before = _leading(body=AIM).cycle()
    assert [before[name] for name in "abcde"] == [101, 5, 102, 7, 44]
    retained = retained_variables(before.plc)
    after = _leading(OTHER, "aMore : ARRAY [0..99] OF INT := [100(3)];")
    assert inherit_variables(after.plc, retained) == []
    assert after["q"] == 0, "what __NEW made is gone"
    after.plc.instance("GVL")["w"] = 9
    after.cycle()
    assert [after[name] for name in "abcde"] == [103, 5, 104, 7, 9]
    retyped = _leading(type="DINT", body="p := ADR(t); i := fb; m := ADR(t);")
    assert inherit_variables(retyped.plc, retained) == ["MAIN.r"]
    retyped.cycle()
    assert [retyped[name] for name in "abcde"] == [103, 5, 104, 0, 5]


BEHIND = """
TYPE ST_Node : STRUCT p : POINTER TO INT; n : INT; END_STRUCT END_TYPE
VAR_GLOBAL w AT %MW4 : INT; v AT %MW4 : INT; END_VAR
PROGRAM MAIN
VAR t : INT := 5; {more} END_VAR
VAR PERSISTENT s : ST_Node; q : POINTER TO INT; END_VAR
{body}
END_PROGRAM
"""


def _behind(more: str = "", body: str = "") -> Ran:
    return Ran(BEHIND.format(more=more, body=body), has_twin=False)


def test_values_behind_a_pointer_are_kept() -> None:
    before = _behind(body="s.p := ADR(t); s.n := 9; q := __NEW(INT);").cycle()
    after = _behind("u : LREAL;")
    assert inherit_variables(after.plc, retained_variables(before.plc)) == []
    assert (after["s.n"], after["q"]) == (9, 0)
    place = after.plc.memory.at(after["s.p"])
    assert place is not None
    assert place[0].read(place[1], 2) == b"\5\0"
    before.plc.instance("MAIN")["s"]["p"] = 0
    after = _behind()
    assert inherit_variables(after.plc, retained_variables(before.plc)) == []
    assert (after["s.n"], after["s.p"]) == (9, 0)


def test_pointer_into_an_image_stays_within_it() -> None:
    before = _behind(body="q := ADR(w);").cycle()
    retained = dict(retained_variables(before.plc))
    [lead] = retained["MAIN.q"].leads
    after = _behind()
    size = len(after.plc.memory[Area.FLAG])
    for offset, leads in ((size - 1, True), (size, False)):
        retained["MAIN.q"] = retained["MAIN.q"]._replace(leads=(lead._replace(offset=offset),))
        after = _behind()
        inherit_variables(after.plc, retained)
        assert (after["q"] != 0) is leads


def test_a_cold_reset_leaves_no_pointer_to_what_new_made() -> None:
    ran = _leading(body=f"IF NOT bStarted THEN bStarted := TRUE; {AIM} END_IF").cycle()
    assert ran["q"] != 0
    ran.plc.reset()
    assert (ran["q"], ran["fb.k"], ran["p"] != 0) == (0, 2, True)


def test_a_bit_is_kept_without_its_neighbours() -> None:
    text = """
    FUNCTION_BLOCK FB_Bits
    VAR a : BIT; END_VAR VAR PERSISTENT b : BIT; END_VAR VAR c : BIT; END_VAR
    END_FUNCTION_BLOCK
    PROGRAM MAIN VAR f : FB_Bits; END_VAR END_PROGRAM
    """
    before, after = Ran(text).cycle(), Ran(text)
    for name in "abc":
        before.plc.instance("MAIN")["f"][name] = True
    assert inherit_variables(after.plc, retained_variables(before.plc)) == []
    before.plc.reset()
    for each in (before, after):
        assert [each[f"f.{name}"] for name in "abc"] == [False, True, False]


def test_damaged_value_of_a_bit_changes_no_other_bit() -> None:
    text = """
    FUNCTION_BLOCK FB_Bits VAR PERSISTENT a, b : BIT; END_VAR END_FUNCTION_BLOCK
    PROGRAM MAIN VAR f : FB_Bits; END_VAR END_PROGRAM
    """
    after = Ran(text, has_twin=False)
    retained = dict(retained_variables(after.plc))
    retained["MAIN.f.a"] = retained["MAIN.f.a"]._replace(data=b"\1\1")
    del retained["MAIN.f.b"]
    assert inherit_variables(after.plc, retained) == []
    assert (after["f.a"], after["f.b"]) == (True, False)


@pytest.mark.parametrize("change", [-1, 1])
def test_value_of_another_length_is_reported_and_not_used(change: int) -> None:
    before, after = _ran(), _ran()
    before.plc.instance("MAIN")["r"] = 77
    retained = dict(retained_variables(before.plc))
    data = retained["MAIN.r"].data
    retained["MAIN.r"] = retained["MAIN.r"]._replace(data=(data + b"\0")[: len(data) + change])
    memory = bytes(after.plc.memory[Area.RETAIN].data)
    assert inherit_variables(after.plc, retained) == ["MAIN.r"]
    assert bytes(after.plc.memory[Area.RETAIN].data) == memory


TARGETS = """
TYPE ST_Empty : STRUCT END_STRUCT END_TYPE
TYPE ST_Node : STRUCT n : INT; p : POINTER TO INT := ADR(MAIN.t); k : INT; END_STRUCT END_TYPE
VAR_GLOBAL x AT %IX1.2 : BOOL; END_VAR
PROGRAM MAIN
VAR t : INT := 5; u : ARRAY [0..1] OF INT; b : BYTE; e : ST_Empty; END_VAR
VAR PERSISTENT s : ST_Node; END_VAR
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("target", "offset", "is_used"),
    [
        ("main.U", 0, True),
        ("MAIN.u", 3, True),
        ("MAIN.u", 4, False),
        ("MAIN.u", -1, False),
        ("MAIN.b", 0, True),
        ("MAIN.b", 1, False),
        ("MAIN.e", 0, True),
        ("MAIN.e", 1, False),
        ("MAIN.gone", 0, False),
        ("GVL.x", 0, False),
    ],
)
def test_pointer_begins_as_declared_if_its_target_is_none(
    target: str, offset: int, is_used: bool
) -> None:
    before, after = Ran(TARGETS, has_twin=False), Ran(TARGETS, has_twin=False)
    main = before.plc.instance("MAIN")
    main["s"]["n"], main["s"]["k"] = 3, 4
    places = {one.name.lower(): one for one in before.plc.variables}
    declared, place = before["s.p"], places.get(target.lower(), places["main.t"])
    retained = dict(retained_variables(before.plc))
    [lead] = retained["MAIN.s"].leads
    lead = lead._replace(target=target, offset=offset, type=place.variable.type.guid.hex())
    retained["MAIN.s"] = retained["MAIN.s"]._replace(leads=(lead,))
    assert inherit_variables(after.plc, retained) == []
    used = after.plc.memory.address(place.area, place.offset) + offset
    assert (after["s.n"], after["s.p"], after["s.k"]) == (3, used if is_used else declared, 4)


@pytest.mark.parametrize("change", [{"at": 0}, {"at": 999}, {"type": ""}])
def test_pointer_of_a_damaged_file_begins_as_declared(change: dict[str, Any]) -> None:
    before, after = Ran(TARGETS, has_twin=False), Ran(TARGETS, has_twin=False)
    retained = dict(retained_variables(before.plc))
    leads = [lead._replace(offset=1, **change) for lead in retained["MAIN.s"].leads]
    retained["MAIN.s"] = retained["MAIN.s"]._replace(leads=tuple(leads))
    assert inherit_variables(after.plc, retained) == []
    assert (after["s.n"], after["s.p"], after["s.k"]) == (0, before["s.p"], 0)


RESET = """
TYPE ST_Node :
STRUCT
    n : INT; p : POINTER TO INT := ADR(MAIN.t); q : POINTER TO INT; made : POINTER TO INT;
END_STRUCT
END_TYPE
FUNCTION_BLOCK FB_Node
VAR before : ARRAY [0..3] OF LINT := [4(16#70000000)]; END_VAR
VAR PERSISTENT s : ST_Node; m : POINTER TO INT; wrong : POINTER TO INT; END_VAR
VAR header, target : BOOL; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR
header := m <> 0; target := s.q <> 0;
END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR t : INT := 5; u : INT; f : FB_Node; bStarted : BOOL; END_VAR
IF NOT bStarted THEN
    bStarted := TRUE;
    f.s.n := 9; f.s.p := __NEW(INT); f.s.made := __NEW(INT); f.s.q := ADR(u);
    f.m := ADR(f); f.wrong := 16#1234;
END_IF
END_PROGRAM
"""


def test_cold_reset_lets_only_pointers_to_what_new_made_begin_as_declared() -> None:
    ran = Ran(RESET, has_twin=False)
    declared = ran["f.s.p"]
    ran.cycle()
    before = {name: ran[f"f.{name}"] for name in ("s.n", "s.q", "m", "wrong")}
    assert ran["f.s.p"] != declared != 0 != ran["f.s.made"]
    ran.plc.reset()
    assert ran.plc.failure == ""
    assert (ran["f.s.p"], ran["f.s.made"]) == (declared, 0)
    assert {name: ran[f"f.{name}"] for name in before} == before
    assert (ran["f.header"], ran["f.target"]) == (True, True)
