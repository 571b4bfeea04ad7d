"""An online change ends and creates only instances that it moves, and notifies the others."""

import pytest

from achse.iec import DeclarationError, plain
from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.lifecycle.instance_moves import InstanceMoves, unit_variable
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

pytest.importorskip("llvmlite")

TEXT = """
FUNCTION_BLOCK FB_Base
VAR sName : STRING(1); n : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; name : STRING(1); END_VAR
sName := name;
GVL.sLog := CONCAT(GVL.sLog, CONCAT('i', name));
IF bInCopyCode THEN GVL.sLog := CONCAT(GVL.sLog, 'c'); END_IF
IF bInitRetains THEN GVL.sLog := CONCAT(GVL.sLog, 'r'); END_IF
GVL.sLog := CONCAT(GVL.sLog, ' ');
END_METHOD
METHOD FB_exit : BOOL
VAR_INPUT bInCopyCode : BOOL; END_VAR
GVL.sLog := CONCAT(GVL.sLog, CONCAT('e', sName));
IF bInCopyCode THEN GVL.sLog := CONCAT(GVL.sLog, 'c'); END_IF
GVL.sLog := CONCAT(GVL.sLog, ' ');
END_METHOD
METHOD FB_reinit : BOOL
GVL.sLog := CONCAT(CONCAT(GVL.sLog, CONCAT('r', sName)), ' ');
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Same EXTENDS FB_Base
n := n + 1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Other EXTENDS FB_Base
VAR
    {other} fOld : REAL := 1.5; {{attribute 'no_copy'}} nFresh : INT := 3; inner : FB_Same('y');
END_VAR
n := n + 1; fOld := fOld + 1; nFresh := 8; inner();
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Watch
VAR pOther : POINTER TO FB_Other; END_VAR
{{attribute 'call_on_type_change' := 'FB_Nothing, FB_Other'}}
METHOD Changed : INT
VAR_INPUT n : INT := 4; END_VAR
GVL.sLog := CONCAT(CONCAT(GVL.sLog, 't'), INT_TO_STRING(n));
GVL.sLog := CONCAT(GVL.sLog, ' ');
END_METHOD
{{attribute 'call_after_online_change_slot' := '20'}}
METHOD Later
GVL.sLog := CONCAT(GVL.sLog, 's20 ');
END_METHOD
END_FUNCTION_BLOCK
{{attribute 'call_after_online_change_slot' := '3'}}
FUNCTION F_Slot : BOOL
GVL.sLog := CONCAT(GVL.sLog, 's3 ');
END_FUNCTION
VAR_GLOBAL sLog : STRING(200); END_VAR
PROGRAM MAIN
VAR
    a : FB_Same('a'); b : FB_Other('b'); c : ARRAY [1..{count}] OF FB_Other[('1'), ('2')];
    {{attribute 'init_on_onlchange'}} d : FB_Same('d');
    {{attribute 'init_on_onlchange'}} nAgain : INT := 2;
    {{attribute 'no_copy'}} nFresh : INT := 5; nKept : INT;
    w : FB_Watch; pA : POINTER TO FB_Same; {more}
END_VAR
a(); b(); c[2](); d(); nAgain := 9; nFresh := 9; nKept := nKept + {step};
pA := ADR(a);
END_PROGRAM
"""


def _declared(**parts: str) -> Declarations:
    texts = {"other": "", "more": "", "count": "2", "step": "1", **parts}
    return declare([parse(Source(TEXT.format(**texts), "moves.st"), name="GVL")])


def _bodies(declared: Declarations, form: CodeForm) -> Bodies:
    typed = check(declared)
    assert not typed.faults, "\n".join(map(str, typed.faults))
    return Bodies(typed, form=form)


def _plc(form: CodeForm, **parts: str) -> PlcRuntime:
    declared = _declared(**parts)
    task = Task("PlcTask", 10_000_000, [declared.programs["main"]])
    plc = PlcRuntime([task], declared.units, bodies=_bodies(declared, form))
    plc.run_due(30_000_000)
    assert plc.state is PlcState.RUN, plc.failure
    return plc


def _change(plc: PlcRuntime, form: CodeForm, **parts: str) -> list[str]:
    """What life did meanwhile, in order."""
    plc.instance("GVL")["sLog"] = ""
    declared = _declared(**parts)
    main = declared.programs["main"]
    units = [unit for unit in declared.units if unit is not main]
    plc.online_change(units, {"PlcTask": [main]}, bodies=_bodies(declared, form))
    assert plc.state is PlcState.RUN, plc.failure
    return str(plc.instance("GVL")["sLog"]).split()


forms = pytest.mark.parametrize("form", [CodeForm.PLAIN, CodeForm.MACHINE])


@forms
def test_a_start_begins_all(form: CodeForm) -> None:
    plc = _plc(form)
    log = str(plc.instance("GVL")["sLog"]).split()
    assert log == ["iar", "ibr", "iyr", "i1r", "iyr", "i2r", "iyr", "idr"]


@forms
def test_only_instances_of_a_changed_block_end_and_begin(form: CodeForm) -> None:
    plc = _plc(form)
    log = _change(plc, form, other="bNew : BOOL := TRUE;")
    assert log == [
        *("eyc", "ebc", "eyc", "e1c", "eyc", "e2c", "edc"),
        *("ibc", "iyc", "i1c", "iyc", "i2c", "iyc", "idc"),
        *("ry", "rb", "ry", "r1", "ry", "r2"),
        *("t4", "s3", "s20"),
    ], log
    main = plc.instance("MAIN")
    b, second = plain(main["b"]), plain(main["c"])[1]
    assert (b["n"], b["fOld"], b["inner"]["n"], b["bNew"]) == (3, 4.5, 3, True)
    assert b["nFresh"] == 3, "no_copy: it starts again where its instance moves"
    assert (second["n"], second["fOld"], second["sName"]) == (3, 4.5, "2")
    assert plain(main["a"])["n"] == 3, "nothing is done to what has not changed"
    assert (plain(main["d"])["n"], main["nAgain"]) == (0, 2), "init_on_onlchange"
    assert (main["nFresh"], main["nKept"]) == (5, 3), "its program has changed"
    plc.run_due(40_000_000)
    assert plc.state is PlcState.RUN, plc.failure
    assert (plain(main["b"])["n"], main["nKept"]) == (4, 4)


@forms
def test_a_new_variable_begins_as_at_a_start_and_one_that_goes_ends(form: CodeForm) -> None:
    plc = _plc(form)
    assert _change(plc, form, more="e : FB_Same('e');") == ["edc", "idc", "ier", "s3", "s20"]
    assert _change(plc, form) == ["edc", "ee", "idc", "s3", "s20"]


@forms
def test_elements_of_an_array_keep_their_values_by_index(form: CodeForm) -> None:
    plc = _plc(form)
    log = _change(plc, form, count="3", other="x : LREAL;")
    assert [entry for entry in log if entry[1:3] in ("1", "2", "1c", "2c")] == [
        *("e1c", "e2c"),
        *("i1c", "i2c"),
        *("r1", "r2"),
    ]
    array = plain(plc.instance("MAIN")["c"])
    assert [one["n"] for one in array] == [0, 3, 0]


@forms
def test_a_change_of_bodies_only_starts_nothing_again(form: CodeForm) -> None:
    plc = _plc(form)
    assert _change(plc, form, step="7") == ["s3", "s20"]
    main = plc.instance("MAIN")
    assert (main["nAgain"], main["nFresh"]) == (9, 9), "no code for start values is made"
    plc.run_due(40_000_000)
    assert main["nKept"] == 10


MADE = """
TYPE ST_Plain : STRUCT n : INT; {plain} END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Made
VAR n : INT; pOf : POINTER TO INT; {made} END_VAR
n := n + pOf^;
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
    {more} k : INT := 2; p : POINTER TO FB_Made; s : POINTER TO ST_Plain; nMade : INT;
END_VAR
IF p = 0 THEN p := __NEW(FB_Made); p^.pOf := ADR(k); s := __NEW(ST_Plain); END_IF
p^();
nMade := p^.n;
{delete}
END_PROGRAM
"""


def _run_version(plc: PlcRuntime | None, form: CodeForm, **parts: str) -> PlcRuntime:
    texts = {"plain": "", "made": "", "more": "", "delete": "", **parts}
    declared = declare([parse(Source(MADE.format(**texts), "made.st"), name="GVL")])
    main = declared.programs["main"]
    if plc is None:
        task = Task("PlcTask", 10_000_000, [main])
        plc = PlcRuntime([task], declared.units, bodies=_bodies(declared, form))
        plc.run_due(30_000_000)
    else:
        units = [unit for unit in declared.units if unit is not main]
        plc.online_change(units, {"PlcTask": [main]}, bodies=_bodies(declared, form))
    assert plc.state is PlcState.RUN, plc.failure
    return plc


@forms
@pytest.mark.parametrize(("part", "name"), [("made", "FB_Made"), ("plain", "ST_Plain")])
def test_what_new_made_takes_no_other_layout(form: CodeForm, part: str, name: str) -> None:
    plc = _run_version(None, form)
    with pytest.raises(DeclarationError, match=f"{name} has another layout.*a reset or a restart"):
        _run_version(plc, form, **{part: "x : LREAL;"})
    assert plc.online_changes == 0
    plc.run_due(40_000_000)
    assert plc.instance("MAIN")["nMade"] == 8, "it goes on as it was"
    plc.reset()
    plc.run()
    _run_version(plc, form, **{part: "x : LREAL;"})
    assert plc.online_changes == 1


@forms
def test_pointers_in_what_new_made_follow_what_moves(form: CodeForm) -> None:
    plc = _run_version(None, form)
    _run_version(plc, form, more="x : LREAL; y : STRING;")
    plc.instance("MAIN")["k"] = 5
    plc.run_due(40_000_000)
    assert plc.state is PlcState.RUN, plc.failure
    assert plc.instance("MAIN")["nMade"] == 11


def test_moves_are_named_by_variable() -> None:
    before = _plc(CodeForm.PLAIN).variables
    after = _plc(CodeForm.PLAIN, other="x : BOOL;", more="e : BOOL;").variables
    moves = InstanceMoves.between(before, after)
    assert moves.copied == {"main.b", "main.c", "main.w"} - {"main.w"}
    assert moves.renewed == {"main.d", "main.nagain", "main.nfresh"}
    assert (moves.new, moves.gone) == ({"main.e"}, frozenset())
    assert moves.again == moves.copied | moves.renewed


def test_lifecycle_statements_name_their_variable() -> None:
    typed = check(_declared())
    body = typed.routines["main.__create"].body
    assert body is not None
    assert [unit_variable(one) for one in body][:2] == ["main.a", "main.b"]
    assert unit_variable(()) == ""


POINTING = """
TYPE ST_Pair : STRUCT {pair} END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Part {part} END_FUNCTION_BLOCK
INTERFACE I_Part END_INTERFACE
FUNCTION_BLOCK FB_Gone IMPLEMENTS I_Part END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
    {vars}
    pGone, pStays, pFirst : POINTER TO INT; pPair : POINTER TO ST_Pair; iPart : I_Part;
    rGone : REFERENCE TO INT; pPart : POINTER TO FB_Part; pFresh : POINTER TO INT;
END_VAR
{body}
END_PROGRAM
VAR_GLOBAL sLog : STRING(200); END_VAR
"""


def test_pointers_to_what_is_gone_are_null() -> None:
    def declared(vars: str, pair: str, part: str, body: str = "") -> Declarations:
        text = POINTING.format(vars=vars, pair=pair, part=part, body=body)
        return declare([parse(Source(text, "pointing.st"), name="GVL")])

    first = declared(
        "nGone, nStays : INT; st : ST_Pair; fb : FB_Part; fbGone : FB_Gone;"
        "{attribute 'init_on_onlchange'} nFresh : INT := 3;",
        "a : INT; b : LREAL;",
        "VAR n : INT; END_VAR",
        "pGone := ADR(nGone); pStays := ADR(nStays); pFirst := ADR(st.a); pPair := ADR(st);"
        "iPart := fbGone; rGone REF= nGone; pPart := ADR(fb); pFresh := ADR(nFresh);",
    )
    task = Task("PlcTask", 10_000_000, [first.programs["main"]])
    plc = PlcRuntime([task], first.units, bodies=_bodies(first, CodeForm.PLAIN))
    plc.run_due(10_000_000)
    main = plc.instance("MAIN")
    names = ("pGone", "pStays", "pFirst", "pPair", "iPart", "rGone", "pPart", "pFresh")
    assert all(plain(main[name]) or name == "rGone" for name in names)
    second = declared(
        "fNew : ARRAY [0..9] OF LREAL; nStays : INT; st : ST_Pair; fb : FB_Part;"
        "{attribute 'init_on_onlchange'} nFresh : INT := 3;",
        "b : LREAL; c : INT;",
        "VAR z : LREAL; n : INT; END_VAR",
    )
    new = second.programs["main"]
    units = [unit for unit in second.units if unit is not new]
    plc.online_change(units, {"PlcTask": [new]}, bodies=_bodies(second, CodeForm.PLAIN))
    assert plc.state is PlcState.RUN, plc.failure
    places = {one.variable.name: plc.memory.address(one.area, one.offset) for one in plc.variables}
    leads = {name: plc.memory.at(places[name]) for name in names}
    pointers = {
        name: int.from_bytes(place[0].read(place[1], 8), "little")
        for name, place in leads.items()
        if place is not None
    }
    assert pointers == {
        "pGone": 0, "pFirst": 0, "iPart": 0, "rGone": 0, "pStays": places["nStays"],
        "pPair": places["st"], "pPart": places["fb"], "pFresh": places["nFresh"],
    }  # fmt: skip


@pytest.mark.parametrize("form", [CodeForm.PLAIN, CodeForm.MACHINE])
def test_implicit_fb_init_begins_an_instance_again(form: CodeForm) -> None:
    text = """
    FUNCTION_BLOCK FB_Inner VAR n : INT := 2; nFlags : INT; END_VAR n := n + 1;
    METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR
    nFlags := nFlags + 10; IF bInitRetains THEN nFlags := nFlags + 1; END_IF
    END_METHOD END_FUNCTION_BLOCK
    FUNCTION_BLOCK FB
    VAR s : STRING(4) := 'abc'; a : ARRAY [1..2] OF REAL := [1.5, 2.5]; b : BIT; x : FB_Inner;
        p : POINTER TO INT; r : REFERENCE TO INT; t : TIME := T#3S; END_VAR
    VAR_IN_OUT io : INT; END_VAR
    s := 'x'; a[2] := 7; b := TRUE; x(); x.nFlags := 0; t := T#0S; io := io + 1;
    END_FUNCTION_BLOCK
    PROGRAM MAIN
    VAR fb : FB; n : INT; bAgain : BOOL; fOld : REAL; END_VAR
    fb(io := n); fOld := fb.a[2];
    IF bAgain THEN fb.FB_init(FALSE, FALSE); END_IF
    bAgain := TRUE; P_Other.FB_init(FALSE, FALSE);
    END_PROGRAM
    PROGRAM P_Other
    METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR END_METHOD
    END_PROGRAM"""
    declared = declare([parse(Source(text, "a.st"))])
    typed = check(declared)
    assert typed.faults == ()
    task = Task("T", 10_000_000, [declared.programs["main"]])
    plc = PlcRuntime([task], declared.units, bodies=Bodies(typed, form=form))
    plc.run_due(10_000_000)
    fb = plc.instance("MAIN")["fb"]
    assert (fb["s"], fb["a"][2], fb["b"], fb["x"]["n"]) == ("x", 7, True, 3)
    plc.run_due(20_000_000)
    assert plc.failure == ""
    assert (fb["s"], fb["a"][2], fb["b"]) == ("abc", 2.5, False)
    assert fb["t"].seconds == 3
    assert (fb["x"]["n"], fb["x"]["nFlags"]) == (2, 10)
    assert (plc.instance("MAIN")["fOld"], plc.instance("MAIN")["n"]) == (7, 2)
