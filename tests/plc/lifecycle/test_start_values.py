"""Initial values that are not constants, in a PLC as its sources declare it."""

import random
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.iec import DeclarationError, plain
from achse.plc import PlcRuntime, Task
from achse.plc.bodies import Bodies
from achse.plc.program import PlacedVariable
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.project import load_project
from achse.st.syntax.parser import parse

SOURCE = """
TYPE ST_Point : STRUCT x : INT := 1; y : INT := 2; END_STRUCT END_TYPE
TYPE ST_Link : STRUCT
    pPoint : POINTER TO ST_Point := ADR(P.aPoints[1]);
    n : INT;
END_STRUCT END_TYPE
INTERFACE I_Motor END_INTERFACE
FUNCTION_BLOCK FB_Motor IMPLEMENTS I_Motor
VAR
    nOwn : INT := 3;
    pOwn : POINTER TO INT := ADR(nOwn);
    pThis : POINTER TO FB_Motor := THIS;
    nTwice : INT := 2 * nOwn;
END_VAR
END_FUNCTION_BLOCK
PROGRAM P
VAR
    nA : INT := 5;
    nB : INT := nA + 1;
    nC : INT := nB * 2;
    pA : POINTER TO INT := ADR(nA);
    pFlag : POINTER TO WORD := ADR(wFlag);
    rA : REFERENCE TO INT REF= nA;
    rPoint : REFERENCE TO ST_Point REF= aPoints[2];
    aPoints : ARRAY [1..3] OF ST_Point := [(x := nA), 2((y := nB))];
    stCopy : ST_Point := aPoints[2];
    aLinks : ARRAY [1..2] OF ST_Link;
    wFlag AT %MW8 : WORD;
    fbOne : FB_Motor;
    aMotors : ARRAY [0..1] OF FB_Motor := [(nOwn := 10)];
    iMotor : I_Motor := fbOne;
    xLate : BOOL := nA > 4;
END_VAR
END_PROGRAM
"""


def declared(text: str) -> Declarations:
    return declare([parse(text)])


def running(text: str = SOURCE) -> PlcRuntime:
    return PlcRuntime([Task()], declared(text).units)


def placed(plc: PlcRuntime, name: str) -> PlacedVariable:
    return next(item for item in plc.variables if item.name.lower() == name.lower())


def address(plc: PlcRuntime, name: str) -> int:
    one = placed(plc, name)
    return plc.memory.address(one.area, one.offset)


def test_values_and_addresses_stand_at_the_start() -> None:
    plc = running()
    program = plc.instance("P")
    assert plc.warnings == ()
    assert (program["nB"], program["nC"], program["xLate"]) == (6, 12, True)
    assert program["pA"] == program["rA"] == address(plc, "P.nA")
    assert program["pFlag"] == address(plc, "P.wFlag")
    points = address(plc, "P.aPoints")
    assert program["rPoint"] == points + 4
    assert program["iMotor"] == address(plc, "P.fbOne")


def test_parts_of_arrays_and_structures_stand_too() -> None:
    plc = running()
    program = plc.instance("P")
    assert plain(program["aPoints"]) == [{"x": 5, "y": 2}, {"x": 1, "y": 6}, {"x": 1, "y": 6}]
    assert plain(program["stCopy"]) == {"x": 1, "y": 6}
    assert [link["pPoint"] for link in program["aLinks"]] == [address(plc, "P.aPoints")] * 2


def test_each_instance_of_a_block_points_to_itself() -> None:
    plc = running()
    program = plc.instance("P")
    motor = placed(plc, "P.fbOne").variable.type
    first = address(plc, "P.aMotors")
    for block, start in [
        (program["fbOne"], address(plc, "P.fbOne")),
        (program["aMotors"][0], first),
        (program["aMotors"][1], first + motor.size),
    ]:
        assert block["pThis"] == start
        assert block["pOwn"] == start + 8  # behind the table pointer
    # Members begin as their type says; what an instance says of itself comes after.
    assert program["aMotors"][0]["nOwn"] == 10
    assert program["aMotors"][0]["nTwice"] == program["fbOne"]["nTwice"] == 6


def test_they_come_again_with_a_reset_and_follow_an_online_change() -> None:
    plc = running()
    program = plc.instance("P")
    program["pA"] = 0
    program["nB"] = 77
    plc.reset()
    assert (program["pA"], program["nB"]) == (address(plc, "P.nA"), 6)
    program["nB"] = 77
    before = address(plc, "P.nA")
    moved = SOURCE.replace("    nA : INT", "    fNew : LREAL;\n    nA : INT")
    plc.online_change(declared(moved).units)
    program = plc.instance("P")
    assert address(plc, "P.nA") != before
    assert program["pA"] == program["rA"] == address(plc, "P.nA")
    assert program["nB"] == 77


@pytest.mark.parametrize(
    ("declaration", "warning"),
    [
        ("x : LREAL := Calculate(2);", "5:.*shows only when the program runs"),
        ("f : FB(1);", "5:.*FB_init of FB is not called"),
        ("p : POINTER TO INT; n : INT := p^;", "5:.*POINTER TO INT has no target yet"),
        ("n : INT := a[9]; a : ARRAY [0..1] OF INT;", "5:.*index 9 is outside"),
        ("n : USINT := m; m : INT := 300;", "5:.*USINT takes .* got 300"),
    ],
)
def test_what_takes_a_running_program_is_reported_once_with_its_place(
    declaration: str, warning: str
) -> None:
    text = f"""
FUNCTION_BLOCK FB END_FUNCTION_BLOCK
FUNCTION_BLOCK Many
VAR
    {declaration}
END_VAR
END_FUNCTION_BLOCK
PROGRAM P VAR aMany : ARRAY [1..5] OF Many; END_VAR END_PROGRAM
"""
    (report,) = running(text).warnings
    assert report.startswith("<text>:5:")
    assert "starts as its type says" in report
    head = warning.removeprefix("5:.*").split(".*")
    assert all(part.strip() in report for part in head)


def test_a_bit_starts_with_the_value_of_a_variable() -> None:
    plc = running("PROGRAM P VAR n : BOOL := TRUE; b AT %QX1.3 : BOOL := n; END_VAR END_PROGRAM")
    assert plc.instance("P")["b"] is True


def test_pointers_of_a_32_bit_plc_have_4_bytes() -> None:
    from achse.iec.layout import TC2_X86

    text = "PROGRAM P VAR n : INT; p : POINTER TO INT := ADR(n); END_VAR END_PROGRAM"
    plc = PlcRuntime([Task()], declare([parse(text)], rules=TC2_X86).units, pointer_size=4)
    one = placed(plc, "P.p")
    data = plc.memory[one.area].read(one.offset, 4)
    assert data == struct.pack("<I", address(plc, "P.n"))


# fmt: off
ATOMS = (
    "n", "p", "p^", "pNone^", "st", "st.x", "a", "a[1]", "a[n]", "a[9]", "r", "r.x", "ADR(n)",
    "ADR(st.y)", "THIS", "THIS^", "THIS^.n", "F(1)", "1", "TRUE", "'x'", "T#1s", "e", "E.B", "i",
    "fb", "fb.v", "fb.q^", "s", "c", "n.3", "-n", "NOT_ME", "ADR(ADR(n))", "SIZEOF(st)", "P.n", "P",
)
TYPES = (
    "INT", "LREAL", "POINTER TO INT", "ST", "ARRAY [0..2] OF INT", "STRING(5)", "TIME", "I_X", "E",
    "BOOL", "REFERENCE TO ST",
)
# fmt: on


def test_any_initial_values_give_a_plc_with_warnings_or_faults(many: Callable[[int], int]) -> None:
    chance = random.Random(1131)

    def expression() -> str:
        operators = chance.choices(["+", "/", "AND", "=", "MOD"], k=chance.choice([0, 0, 1, 2]))
        rest = "".join(f" {sign} {chance.choice(ATOMS)}" for sign in operators)
        return chance.choice(ATOMS) + rest

    outcomes = set()
    for _ in range(many(80)):
        late = [f"z{k} : {chance.choice(TYPES)} := {expression()};" for k in range(2)]
        text = f"""
TYPE ST : STRUCT x : INT := 4; y : DINT; END_STRUCT END_TYPE
TYPE E : (A, B) INT; END_TYPE
INTERFACE I_X END_INTERFACE
FUNCTION_BLOCK FB IMPLEMENTS I_X
VAR v : INT := 2; q : POINTER TO INT := ADR(v); END_VAR END_FUNCTION_BLOCK
PROGRAM P VAR
    n : INT := 1; p : POINTER TO INT := ADR(n); pNone : POINTER TO INT; st : ST; e : E;
    a : ARRAY [0..2] OF INT := [1, n]; r : REFERENCE TO ST REF= st; fb : FB; i : I_X := fb;
    c : BOOL; s : STRING := 'hi'; {late[0]} {late[1]}
    z2 : ARRAY [0..1] OF {chance.choice(TYPES)} := [2({expression()})];
END_VAR END_PROGRAM"""
        try:
            plc = running(text)
        except DeclarationError:
            outcomes.add("refused")
            continue
        plc.reset()
        plc.online_change(declared(text).units)
        assert plc.instance("P")["p"] == address(plc, "P.n")
        outcomes.add("warned" if plc.warnings else "whole")
    assert outcomes == {"refused", "warned", "whole"}


def test_what_a_base_from_a_symbol_file_has_is_known(tmp_path: Path) -> None:
    (tmp_path / "P.st").write_text(
        "FUNCTION_BLOCK FB EXTENDS FB_Lib VAR n : DINT := nState + 1; END_VAR END_FUNCTION_BLOCK\n"
        "PROGRAM P VAR fb : FB; END_VAR END_PROGRAM"
    )
    (tmp_path / "P.tmc").write_text("""<TcModuleClass><DataTypes>
<DataType><Name Namespace="Lib">FB_Lib</Name><BitSize>128</BitSize>
 <SubItem><Name>nState</Name><Type>DINT</Type><BitSize>32</BitSize><BitOffs>64</BitOffs>
  <Default><Value>41</Value></Default></SubItem>
 <Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType></DataTypes>
<Modules><Module TargetPlatform="TwinCAT RT (x64)"><Name>P</Name></Module></Modules>
</TcModuleClass>""")
    plc = PlcRuntime([Task()], load_project(tmp_path).declarations.units)
    assert plc.warnings == ()
    assert plain(plc.instance("P"))["fb"]["n"] == 42


def test_standard_functions_are_worked_out_as_a_compiler_does() -> None:
    plc = running("""
TYPE ST : STRUCT a : INT; aParts : ARRAY [1..4] OF LREAL; END_STRUCT END_TYPE
VAR_GLOBAL CONSTANT
    cName : STRING := CONCAT('axis', TO_STRING(cCount));
    cCount : INT := LEN('four') + 1;
END_VAR
PROGRAM P
VAR
    st : ST;
    p : POINTER TO ST;
    aGrid : ARRAY [-3..7] OF INT;
    nPart : UDINT := SIZEOF(st.aParts[1]);
    nWhole : UDINT := SIZEOF(p^);
    nGrid : DINT := UPPER_BOUND(aGrid, 1) - LOWER_BOUND(aGrid, 1);
    nLow : INT := MIN(nSet, 3);
    nSet : INT := 2;
    tLong : TIME := MAX(T#1s, T#2s);
    aText : ARRAY [0..LEN(cName)] OF BYTE;
END_VAR
END_PROGRAM
""")
    assert plc.warnings == ()
    values = plain(plc.instance("P"))
    assert (values["nPart"], values["nWhole"], values["nGrid"]) == (8, 40, 10)
    assert values["nLow"] == 2
    assert values["tLong"].total_seconds() == 2
    assert len(values["aText"]) == 6


def test_a_function_of_the_user_is_called_at_run_time_whatever_its_name() -> None:
    plc = running("""
FUNCTION MAX : INT VAR_INPUT a, b : INT; END_VAR END_FUNCTION
PROGRAM P VAR n : INT := MAX(1, 2); END_VAR END_PROGRAM
""")
    assert plain(plc.instance("P"))["n"] == 0
    (warning,) = plc.warnings
    assert "3:26: shows only when the program runs" in warning


def test_a_size_that_rests_on_itself_is_a_fault() -> None:
    with pytest.raises(DeclarationError, match="rest on each other"):
        declared("PROGRAM P VAR x : ARRAY [0..SIZEOF(x)] OF INT; END_VAR END_PROGRAM")


SIBLINGS = """
VAR_GLOBAL CONSTANT nSize : INT := 2; END_VAR
TYPE ST_Base : STRUCT nFirst : INT := 4; END_STRUCT END_TYPE
TYPE ST_Recipe EXTENDS ST_Base : STRUCT
    nSize : INT := nFirst * 2;
    aLimits : ARRAY [1..nSize] OF INT := [nSize, nFirst];
    nLast : INT := aLimits[1] + 1;
    pLast : POINTER TO INT := ADR(nLast);
    rLast : REFERENCE TO INT REF= nLast;
    sName : STRING(10) := 'ab';
    sFile : STRING(10) := CONCAT(sName, '.x');
    bA : BIT := TRUE;
    bB : BIT := bA;
END_STRUCT END_TYPE
PROGRAM P
VAR
    stA : ST_Recipe;
    stB : ST_Recipe := (nFirst := 10);
    stC : ST_Recipe := (nLast := 7, bB := FALSE);
    aAll : ARRAY [1..2, 1..1] OF ST_Recipe := [[(nLast := 8)], [(nSize := 1)]];
END_VAR
END_PROGRAM
"""


@pytest.mark.parametrize("executed", [False, True])
def test_members_initialised_by_their_siblings(executed: bool) -> None:
    """Types see constants, initial values see siblings; what a declaration says counts more."""
    project = declared(SIBLINGS)
    bodies = Bodies(check(project)) if executed else None
    plc = PlcRuntime([Task()], project.units, bodies=bodies)
    unit = plc.instance("P")

    def numbers(record: Any) -> tuple[int, ...]:
        return record.nFirst, record.nSize, *record.aLimits, record.nLast

    assert numbers(unit["stA"]) == (4, 8, 8, 4, 9)
    assert (unit["stA"].sFile, unit["stA"].bB) == ("ab.x", True)
    assert numbers(unit["stB"]) == (10, 8, 8, 4, 9)
    assert numbers(unit["stC"]) == (4, 8, 8, 4, 7)
    assert unit["stC"].bB is False
    assert numbers(unit["aAll"][1][1]) == (4, 8, 8, 4, 8)
    assert numbers(unit["aAll"][2][1]) == (4, 1, 8, 4, 9)
    last = unit["stB"]
    assert last.pLast == last.rLast
    found_at = plc.memory.at(last.pLast)
    assert found_at is not None
    assert found_at[0].read(found_at[1], 2) == struct.pack("<h", 9)


NESTED = """
TYPE ST_In : STRUCT n : INT := 3; m : INT := n * 2; bA : BIT; bB : BIT := NOT bA; END_STRUCT
END_TYPE
TYPE ST_Out : STRUCT
    one : ST_In := (n := 10);
    sum : INT := one.n + one.m;
    aParts : ARRAY [0..1] OF ST_In := [(m := one.m), (n := 7, bA := TRUE)];
END_STRUCT END_TYPE
TYPE ST_More EXTENDS ST_Out : STRUCT more : INT := sum + aParts[1].n; rOne : REFERENCE TO INT;
END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Base VAR a : INT := 1; b : INT := a + 1; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Next EXTENDS FB_Base VAR c : INT := b + 1; st : ST_In := (n := c); END_VAR
END_FUNCTION_BLOCK
PROGRAM P
VAR
    nOut : INT := 5;
    o0 : ST_More;
    o1 : ST_More := (one := (m := 1), aParts := [(n := 2)], rOne REF= nOut);
    o2 : ARRAY [0..1] OF ST_More := [
        (sum := nOut), (one := (n := nOut, bA := TRUE), more := 0, rOne := nOut)
    ];
    fb0 : FB_Next;
    fb1 : FB_Next := (a := 50, st := (m := 9));
    fb2 : ARRAY [0..1] OF FB_Next := [2((b := 60))];
    inline : STRUCT a : INT := 4; b : INT := nOut; in : ST_In; END_STRUCT
        := (a := 8, b := 9, in := (n := 1));
END_VAR
END_PROGRAM
"""


@pytest.mark.parametrize("executed", [False, True])
def test_siblings_see_what_their_type_says_at_any_depth(executed: bool) -> None:
    """The outer type is the declaration of what is inside; the instance comes last."""
    project = declared(NESTED)
    checked = check(project)
    assert not checked.faults
    plc = PlcRuntime([Task()], project.units, bodies=Bodies(checked) if executed else None)
    assert plc.warnings == ()
    unit = plc.instance("P")

    def inner(record: Any) -> tuple[Any, ...]:
        return record.n, record.m, record.bA, record.bB

    def outer(record: Any) -> tuple[Any, ...]:
        return record.sum, record.more, *map(inner, (record.one, *record.aParts))

    plain_parts = ((3, 6, False, True), (7, 6, True, True))
    assert outer(unit["o0"]) == (16, 23, (10, 6, False, True), *plain_parts)
    first = ((10, 1, False, True), (2, 6, False, True), plain_parts[1])
    assert outer(unit["o1"]) == (16, 23, *first)
    assert unit["o1"]["rOne"] == unit["o2"][1]["rOne"] == address(plc, "P.nOut")
    assert outer(unit["o2"][0]) == (5, 23, (10, 6, False, True), *plain_parts)
    assert outer(unit["o2"][1]) == (16, 0, (5, 6, True, True), *plain_parts)
    blocks = [unit["fb0"], unit["fb1"], *unit["fb2"]]
    assert [(fb.a, fb.b, fb.c, fb.st.n, fb.st.m) for fb in blocks] == [
        (1, 2, 3, 3, 6),
        (50, 2, 3, 3, 9),
        (1, 60, 3, 3, 6),
        (1, 60, 3, 3, 6),
    ]
    assert (unit["inline"].a, unit["inline"].b, *inner(unit["inline"]["in"])) == (
        8, 9, 1, 6, False, True,
    )  # fmt: skip


INITS = """
FUNCTION_BLOCK FB_In
VAR n : INT := 1; nSeen : INT; END_VAR
    METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR
        nSeen := n;
        n := n + 1;
    END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Out VAR fbIn : FB_In := (n := 5); m : INT; END_VAR END_FUNCTION_BLOCK
TYPE ST : STRUCT n : INT := 3; m : INT := n * 2; END_STRUCT END_TYPE
FUNCTION F : INT VAR st : ST := (n := 10); stOne : ST; END_VAR
    F := st.n * 1000 + st.m * 10 + stOne.m;
END_FUNCTION
PROGRAM P
VAR
    fb : FB_In := (n := 20);
    aFb : ARRAY [0..1] OF FB_In := [(n := 30)];
    fbOut : FB_Out := (m := 1);
    fbDeep : FB_Out := (fbIn := (n := 40));
    nCalled : INT;
END_VAR
nCalled := F();
END_PROGRAM
"""


def test_fb_init_sees_what_the_type_says_and_a_declaration_counts_more() -> None:
    project = declared(INITS)
    checked = check(project)
    assert not checked.faults
    task = Task("T", 10_000_000, [project.programs["p"]])
    plc = PlcRuntime([task], project.units, bodies=Bodies(checked))
    for _ in range(2):
        unit = plc.instance("P")
        blocks = [unit["fb"], *unit["aFb"], unit["fbOut"].fbIn, unit["fbDeep"].fbIn]
        assert [(fb.n, fb.nSeen) for fb in blocks] == [(20, 1), (30, 1), (2, 1), (5, 1), (40, 1)]
        plc.run()
        plc.run_due(task.due_ns)
        assert not plc.failure
        assert plc.instance("P")["nCalled"] == 10_066  # of a function's own structures, too
        plc.reset()


def test_an_online_change_leaves_members_that_were_given_a_value_alone() -> None:
    project = declared(NESTED)
    plc = PlcRuntime([Task()], project.units)
    unit = plc.instance("P")
    unit["o1"].one.m, unit["o1"].sum, unit["fb1"].b = 100, 101, 102
    plc.online_change(declared(NESTED.replace("nOut : INT", "f : LREAL; nOut : INT")).units)
    unit = plc.instance("P")
    assert (unit["o1"].one.m, unit["o1"].sum, unit["fb1"].b) == (100, 101, 102)
    assert unit["o1"]["rOne"] == address(plc, "P.nOut")
    stopped = declared(NESTED.replace("sum := nOut", "sum := 4"))
    unit["o2"][0].sum = 103
    plc.online_change(stopped.units)
    assert plc.instance("P")["o2"][0].sum == 103


def test_siblings_that_are_none() -> None:
    with pytest.raises(DeclarationError, match="no constant or variable is named 'nOther'"):
        declared("TYPE ST : STRUCT a : INT := nOther; END_STRUCT END_TYPE")
    text = "TYPE ST : STRUCT a : INT := 3; b : ARRAY [0..a] OF INT; END_STRUCT END_TYPE"
    with pytest.raises(DeclarationError, match="no constant or variable is named 'a'"):
        declared(text)


@pytest.mark.parametrize("block", ["FB_Sum", "FB_Heir"])
def test_fb_init_takes_arrays_of_any_length(block: str) -> None:
    text = f"""
FUNCTION_BLOCK FB_Sum
VAR nSum : INT; i : DINT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR
VAR_IN_OUT aParts : ARRAY [*] OF INT; END_VAR
FOR i := LOWER_BOUND(aParts, 1) TO UPPER_BOUND(aParts, 1) DO nSum := nSum + aParts[i]; END_FOR
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Heir EXTENDS FB_Sum END_FUNCTION_BLOCK
PROGRAM P
VAR aThree : ARRAY [2..4] OF INT := [1, 2, 4]; fb : {block}(aParts := aThree); END_VAR
END_PROGRAM"""
    project = declared(text)
    plc = PlcRuntime([Task("T", 10**9, [project.programs["p"]])], bodies=Bodies(check(project)))
    plc.run_due(10**9)
    assert (plc.failure, plc.instance("P")["fb"]["nSum"]) == ("", 7)
