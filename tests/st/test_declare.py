"""Declarations of sources give what Python declarations give."""

# ruff: noqa: N815  (variables carry the prefixes of IEC programs)

from datetime import timedelta
from typing import Any

import pytest

from achse.iec import (
    ARRAY,
    BIT,
    BOOL,
    BYTE,
    INT,
    LREAL,
    STRING,
    TIME,
    UDINT,
    UINT,
    AliasType,
    Enumeration,
    EnumType,
    FunctionBlock,
    GlobalVariables,
    Program,
    Section,
    Struct,
    StructType,
    SubrangeType,
    Typelike,
    Union,
    bind,
    iec_type,
    method,
    reference_to,
    var,
    var_input,
    var_output,
)
from achse.iec.derived import InterfaceType, PointerType
from achse.iec.describe import describe_type
from achse.iec.layout import TC2_X86
from achse.iec.types import IecType
from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source, SourceError
from achse.st.syntax.parser import parse


def declared(text: str, **options: Any) -> Declarations:
    return declare([parse(text)], **options)


def messages(text: str, **options: Any) -> list[str]:
    with pytest.raises(SourceError) as caught:
        declared(text, **options)
    return [
        f"{fault.location.line}:{fault.location.column} {fault.message}"
        for fault in caught.value.faults
    ]


def messages_of_variable(text: str) -> list[str]:
    return messages(f"VAR_GLOBAL\n{text}\nEND_VAR")


class State(Enumeration, base=UINT, name="E_State", comment=" of the machine", initial=1):
    Idle = 0
    Run = 1


class Base(Struct, name="ST_Base"):
    nId = var(UDINT, 7, comment=" unique")


class Axis(Base, name="ST_Axis"):
    fPos = var(LREAL, 1.5)
    sName = var(STRING(5), "ab")
    eState = var(State)
    tRun = var(TIME, timedelta(seconds=90))
    bA = var(BIT)
    bB = var(BIT, True)
    aLimits = var(ARRAY(INT, (0, 2)), [1, 2, 2])


class Bits(Union, name="U_Bits"):
    nAll = var(UINT)
    aBytes = var(ARRAY(BYTE, (0, 1)))


class Valve(FunctionBlock, name="FB_Valve"):
    bOpen = var_input(BOOL)
    bIsOpen = var_output(BOOL)
    stAxis = var(Axis)

    @method(BOOL, outputs={"nLeft": INT}, nTo=INT, comment=" shuts it")
    def Close(self, nTo: int) -> tuple[bool, int]:  # noqa: N802, N803
        return True, nTo


class MAIN(Program):
    nCount = var(UDINT, 3, retain=True)
    bOut = var(BOOL, at="%QX3.2")
    fbValve = var(Valve, {"bOpen": True}, attributes={"TcLinkTo": "a^b"})
    aAxes = var(ARRAY(Axis, (1, 2)), initial=[{"fPos": 2.0}, {}])


class GVL(GlobalVariables):
    uBits = var(Bits, {"nAll": 0x1234})
    cMax = var(INT, 5, constant=True)


SOURCE = """
// of the machine
TYPE E_State : (Idle, Run) UINT := Run; END_TYPE
TYPE ST_Axis EXTENDS ST_Base : STRUCT
    fPos : LREAL := 3 / 2.0;
    sName : STRING(cMax) := 'ab';
    eState : E_State;
    tRun : TIME := T#1m + T#30s;
    bA : BIT;
    bB : BIT := TRUE;
    aLimits : ARRAY [0..cMax - 3] OF INT := [1, 2(2)];
END_STRUCT END_TYPE
TYPE ST_Base : STRUCT
    nId : UDINT := 7; // unique
END_STRUCT END_TYPE
TYPE U_Bits : UNION nAll : UINT; aBytes : ARRAY [0..1] OF BYTE; END_UNION END_TYPE
FUNCTION_BLOCK FB_Valve
VAR_INPUT bOpen : BOOL; END_VAR
VAR_OUTPUT bIsOpen : BOOL; END_VAR
VAR stAxis : ST_Axis; END_VAR
VAR_TEMP nTemp : INT; END_VAR
// shuts it
{attribute 'TcRpcEnable'}
METHOD Close : BOOL
VAR_INPUT nTo : INT; END_VAR
VAR_OUTPUT nLeft : INT; END_VAR
END_METHOD
METHOD Hidden : BOOL END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR RETAIN nCount : UDINT := 3; END_VAR
VAR
    bOut AT %QX3.2 : BOOL;
    {attribute 'TcLinkTo' := 'a^b'}
    fbValve : FB_Valve := (bOpen := TRUE);
    aAxes : ARRAY [1..2] OF ST_Axis := [(fPos := 2)];
END_VAR
END_PROGRAM
VAR_GLOBAL
    uBits : U_Bits := (nAll := 16#1234);
END_VAR
VAR_GLOBAL CONSTANT
    cMax : INT := 5;
END_VAR
"""


@pytest.mark.parametrize(
    ("name", "python"),
    [
        ("e_state", State),
        ("st_base", Base),
        ("st_axis", Axis),
        ("u_bits", Bits),
        ("fb_valve", Valve),
    ],
)
def test_types_are_those_that_python_declares(name: str, python: Typelike) -> None:
    type_of_source, expected = declared(SOURCE).types[name], iec_type(python)
    assert type(type_of_source) is type(expected)
    assert type_of_source.describe() == expected.describe()
    assert type_of_source.guid == expected.guid
    assert type_of_source.default == expected.default
    assert type_of_source.comment == expected.comment
    if name != "fb_valve":  # Python declares no attributes of methods.
        assert describe_type(type_of_source) == describe_type(expected)


@pytest.mark.parametrize("name", ["main", "gvl"])
def test_units_are_those_that_python_declares(name: str) -> None:
    units = {unit.__iec__.name.lower(): unit for unit in declared(SOURCE).units}
    expected = MAIN if name == "main" else GVL
    unit_of_source = units[name]
    assert issubclass(unit_of_source, Program if name == "main" else GlobalVariables)
    assert unit_of_source.__iec__.default == iec_type(expected).default
    for member, python in zip(
        unit_of_source.__iec__.members, iec_type(expected).members, strict=True
    ):
        assert (member.name, member.offset, member.bit) == (python.name, python.offset, python.bit)
        assert member.type.describe() == python.type.describe()
        assert member.initial_bytes() == python.initial_bytes()
        assert (member.address, member.retain, member.apart, member.constant) == (
            python.address, python.retain, python.apart, python.constant,
        )  # fmt: skip
        assert dict(member.attributes) == dict(python.attributes)
    assert {m.section for m in unit_of_source.__iec__.members} == (
        {Section.LOCAL} if name == "main" else {Section.GLOBAL}
    )


def test_declared_programs_work_in_memory() -> None:
    main = declared(SOURCE).programs["main"]()
    bind(main)
    assert main["aAxes"][1]["fPos"] == 2.0
    assert main["aAxes"][2]["fPos"] == 1.5
    assert main["fbValve"]["stAxis"]["eState"].name == "Run"
    main["nCount"] += 1
    assert main["nCount"] == 4


def test_methods_for_rpc() -> None:
    valve = declared(SOURCE).types["fb_valve"]
    assert isinstance(valve, StructType)
    (method,), (expected,) = valve.methods, iec_type(Valve).methods
    assert (method.name, method.parameters) == (expected.name, expected.parameters)
    assert (method.returns, method.comment) == (BOOL, " shuts it")
    assert method.attributes == {"TcRpcEnable": ""}


def one(text: str, name: str = "t", **options: Any) -> IecType[Any]:
    return declared(f"TYPE {text} END_TYPE", **options).types[name]


def test_aliases_and_subranges() -> None:
    alias = one("T : LREAL := 2.5;")
    assert isinstance(alias, AliasType)
    assert (alias.name, alias.default) == ("T", LREAL.encode(2.5))
    limited = one("T : INT (-5..5) := 3;")
    assert isinstance(limited, SubrangeType)
    assert (limited.name, limited.low, limited.high) == ("T", -5, 5)
    assert limited.default == INT.encode(3)
    text = one("{attribute 'TcEncoding' := 'UTF-8'} T : STRING(10);".replace("{", "{", 1))
    assert text.encode("ä")[:2] == "ä".encode()


def test_enumerations() -> None:
    enum = one("T : (A, B := 5, C, D := B * 2 + Lib.cOne) DINT;", constants={"cOne": 1})
    assert isinstance(enum, EnumType)
    assert enum.numbers == {"A": 0, "B": 5, "C": 6, "D": 11}
    assert enum.size == 4


def test_pack_mode() -> None:
    text = "{attribute '%s' := '1'}\nTYPE T : STRUCT a : BYTE; b : LREAL; END_STRUCT END_TYPE"
    assert declared(text % "pack_mode").types["t"].size == 9
    assert declared(text % "PACK_MODE").types["t"].size == 9
    assert declared(text % "hide").types["t"].size == 16
    assert declared(text % "hide", rules=TC2_X86).types["t"].size == 9


@pytest.mark.parametrize(("mode", "size"), [("1", 13), ("2", 14), ("3", 14), ("4", 16), ("8", 16)])
def test_pack_modes_between_the_powers_count_as_the_one_below(mode: str, size: int) -> None:
    text = (
        f"{{attribute 'pack_mode' := '{mode}'}}\n"
        "TYPE T : STRUCT a : BYTE; b : DINT; c : LREAL; END_STRUCT END_TYPE"
    )
    assert declared(text).types["t"].size == size


def test_pointers_may_lead_back() -> None:
    node = one("ST_Node : STRUCT p : POINTER TO st_node; r : REFERENCE TO ST_Node; END_STRUCT",
                "st_node")  # fmt: skip
    assert isinstance(node, StructType)
    pointer, reference = (member.type for member in node.members)
    assert isinstance(pointer, PointerType)
    assert (pointer.name, reference.name) == ("POINTER TO ST_Node", "REFERENCE TO ST_Node")
    assert pointer.target is node


def test_variables_by_reference() -> None:
    block = declared(
        "FUNCTION_BLOCK F VAR_IN_OUT a : INT; b : ARRAY [*] OF INT; END_VAR END_FUNCTION_BLOCK"
    ).types["f"]
    assert isinstance(block, StructType)
    assert [(m.type.name, m.section) for m in block.members] == [
        (reference_to(INT).name, Section.IN_OUT),
        (reference_to(INT).name, Section.IN_OUT),
        ("DINT", Section.LOCAL),  # the bounds of b, which a call brings along
        ("DINT", Section.LOCAL),
    ]


def test_interfaces() -> None:
    text = """
INTERFACE I_A METHOD m : BOOL END_METHOD END_INTERFACE
FUNCTION_BLOCK F IMPLEMENTS I_A VAR i : I_A; END_VAR END_FUNCTION_BLOCK"""
    types = declared(text).types
    assert isinstance(types["i_a"], InterfaceType)
    assert types["f"].size == 16


def test_names_without_case_and_across_files() -> None:
    project = declare(
        [
            parse("PROGRAM Main VAR a : ARRAY [0..gvl.CMAX] OF st_x; END_VAR END_PROGRAM"),
            parse("VAR_GLOBAL CONSTANT cMax : INT := E_X.b; END_VAR", name="GVL"),
            parse("TYPE ST_X : STRUCT x : INT; END_STRUCT END_TYPE TYPE E_X : (A, B); END_TYPE"),
        ]
    )
    (variable,) = project.programs["main"].__iec__.members
    assert variable.type.name == "ARRAY [0..1] OF ST_X"


def test_name_spaces() -> None:
    text = """
NAMESPACE N
    TYPE T : INT; END_TYPE
    TYPE S : STRUCT a : T; END_STRUCT END_TYPE
    VAR_GLOBAL CONSTANT c : INT := 4; END_VAR
END_NAMESPACE
TYPE T : LREAL; END_TYPE
PROGRAM P VAR a : N.T := N.N.c; b : T; c : N.S; d : Other.T; END_VAR END_PROGRAM"""
    project = declared(text)
    sizes = [member.type.size for member in project.programs["p"].__iec__.members]
    assert sizes == [2, 8, 2, 8]


def test_faults_in_a_library_count_where_it_is_named() -> None:
    prototype = parse("FUNCTION_BLOCK FB_Old n := ; END_FUNCTION_BLOCK")
    used = parse("TYPE ST_L : STRUCT a : INT; END_STRUCT END_TYPE")
    texts = "VAR_GLOBAL x : ST_L; END_VAR", "VAR_GLOBAL x : FB_Old; END_VAR"
    declare([parse(texts[0])], libraries=[prototype, used])
    with pytest.raises(SourceError, match="expected an expression") as caught:
        declare([parse(texts[1])], libraries=[prototype, used])
    assert len(caught.value.faults) == 1


def test_libraries_and_given_types() -> None:
    library = parse("TYPE ST_L : STRUCT a : INT; END_STRUCT END_TYPE TYPE T_Bad : X; END_TYPE")
    text = "PROGRAM P VAR a : Lib.ST_L; b : Tc2_Axes.AXIS_OWN; t : TON; END_VAR END_PROGRAM"
    project = declare([parse(text)], libraries=[library], types={"Axis_Own": Axis})
    members = project.programs["p"].__iec__.members
    assert [member.type.name for member in members] == ["ST_L", "ST_Axis", "TON"]
    assert list(project.types) == []
    own = declared("TYPE TON : INT; END_TYPE")
    assert own.types["ton"].size == 2


def test_generic_blocks() -> None:
    text = """
FUNCTION_BLOCK List
VAR_GENERIC CONSTANT nMax : INT := 1; END_VAR
VAR a : ARRAY [1..nMax] OF INT; b : POINTER TO List<nMax>; END_VAR
END_FUNCTION_BLOCK
PROGRAM P VAR x : List<3>; y : List<2 + 1>; z : List<4>; END_VAR END_PROGRAM"""
    x, y, z = declared(text).programs["p"].__iec__.members
    assert x.type is y.type
    assert (x.type.name, x.type.size, z.type.size) == ("List<3>", 24, 24)
    assert messages(text.replace("List<4>", "List")) == ["6:49 List<…> takes 1 constants"]
    assert messages(text.replace("List<4>", "INT<4>")) == ["6:49 INT has no VAR_GENERIC"]


def test_what_is_no_constant_becomes_a_start_value() -> None:
    text = """
PROGRAM P VAR
    n : INT := 5;
    p : POINTER TO INT := ADR(n);
    m : INT := n + 1;
    a : ARRAY [0..2] OF INT := [1, n, 3];
    r : REFERENCE TO INT REF= n;
    f : TON := (PT := T#1s, IN := n > 3);
    g : FB(1);
    x : LREAL := Calculate(2);
    h : ARRAY [0..1] OF FB[(k := 1), (k := 2)];
    i : FB := (Rate := 1.5);
END_VAR END_PROGRAM
FUNCTION_BLOCK FB EXTENDS Base END_FUNCTION_BLOCK
FUNCTION_BLOCK Base PROPERTY Rate : REAL SET END_SET END_PROPERTY END_FUNCTION_BLOCK"""
    project = declared(text)
    members = {member.name: member for member in project.programs["p"].__iec__.members}
    starts = {name: [s.offset for s in member.start_values] for name, member in members.items()}
    ton = members["f"].type
    assert isinstance(ton, StructType)
    expected = {"n": [], "p": [0], "m": [0], "a": [2], "r": [0], "g": [0], "x": [0]}
    expected |= {"h": [0], "i": [0]}
    assert starts == expected | {"f": [ton.member("IN").offset]}
    assert members["m"].initial is None
    assert members["a"].initial == [1, 0, 3]
    assert members["f"].initial == {"PT": 1000}
    assert messages(text.replace("Rate :=", "Rat :=")) == ["12:16 FB has no member 'Rat'"]


def test_addresses_from_var_config() -> None:
    text = """
PROGRAM P VAR a AT %I* : BOOL; b AT %Q* : BOOL; END_VAR END_PROGRAM
VAR_CONFIG P.a AT %IX4.1 : BOOL; END_VAR"""
    a, b = declared(text).programs["p"].__iec__.members
    assert (str(a.address), str(b.address)) == ("%IX4.1", "%Q*")
    assert messages(text.replace("P.a", "P.x")) == ["3:19 no variable 'p.x' waits for an address"]
    assert "VAR_CONFIG reaches" in messages(text.replace("P.a", "P.f.a"))[0]


def test_types_of_variables_without_a_name() -> None:
    text = "PROGRAM P VAR e : (A, B) := B; s : STRUCT x : INT := 2; END_STRUCT; END_VAR END_PROGRAM"
    e, s = declared(text).programs["p"].__iec__.members
    assert (e.type.name, e.initial, s.type.name, s.initial_bytes()) == ("P.e", 1, "P.s", b"\2\0")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a : X;", ["2:5 no type is named 'X'"]),
        ("a : Lib.X;", ["2:5 no type is named 'Lib.X'"]),
        ("a : INT; A : INT;", ["2:10 GVL has two variables named A"]),
        ("a : INT := 40000;", ["2:12 INT takes an integer in -32768..32767, got 40000"]),
        ("a : INT := 1.5;", ["2:12 INT takes an integer in -32768..32767, got 1.5"]),
        ("a : INT := TRUE;", ["2:12 INT takes an integer in -32768..32767, got True"]),
        ("a : INT := 'x';", ["2:12 INT takes an integer in -32768..32767, got 'x'"]),
        ("a : UINT := -32769;", ["2:13 UINT takes an integer in 0..65535, got -32769"]),
        ("a : UINT (0..9) := -1;", ["2:20 UINT (0..9) takes an integer in 0..9, got -1"]),
        ("a : BOOL := 2;", ["2:13 BOOL takes True or False, got 2"]),
        ("a : INT (0..9) := 10;", ["2:19 INT (0..9) takes an integer in 0..9, got 10"]),
        ("a : INT := x;", ["2:12 no constant or variable is named 'x'"]),
        ("a : INT := x.y;", ["2:14 no constant or variable is named 'x.y'"]),
        ("a : INT := GVL.y;", ["2:16 GVL has no variable 'y'"]),
        ("a : INT := 1 / 0;", ["2:14 a division by zero"]),
        ("a : INT := 1 + TRUE;", ["2:14 '+' takes numbers"]),
        ("a : BOOL := 1 AND TRUE;", ["2:15 AND takes two truths or two whole numbers"]),
        ("a : ARRAY [0..n] OF INT; n : INT;",
         ["2:15 an array bound is a constant, not known before run time"]),
        ("a : ARRAY [0..1.5] OF INT;", ["2:15 an array bound is a whole number, got 1.5"]),
        ("a : ARRAY [5..1] OF INT;", ["2:13 array bounds 5..1 run backwards"]),
        ("a : ARRAY [0..1] OF INT := [1, 2, 3];",
         ["2:35 ARRAY [0..1] OF INT has 2 elements, got more"]),
        ("a : ARRAY [0..1] OF INT := [1000000000(0)];",
         ["2:39 ARRAY [0..1] OF INT has 2 elements, got more"]),
        ("a : ARRAY [0..1] OF INT := 5;", ["2:28 ARRAY [0..1] OF INT takes a list of 2 values, "
                                           "got 5"]),
        ("a : INT := [1];", ["2:12 INT is not an array: it takes an integer in -32768..32767"]),
        ("a : INT := (x := 1);", ["2:12 INT has no members: it takes an integer in -32768..32767"]),
        ("a : TON := (x := 1);", ["2:13 TON has no member 'x'"]),
        ("a : TON := (PT := T#1s, pt := T#1s);", ["2:25 pt has two values"]),
        ("a : ARRAY [0..999999999] OF LREAL;",
         ["2:5 ARRAY [0..999999999] OF LREAL has 8000000000 bytes, more than 268435456"]),
        ("a : ARRAY [*] OF INT;", ["2:5 ARRAY [*] is for VAR_IN_OUT only"]),
        ("a : STRING(-1);", ["2:5 STRING(n) needs n from 0, got -1"]),
        ("a : LREAL (0..1);", ["2:5 a sub-range of whole numbers, got LREAL"]),
        ("a : INT (5..1);", ["2:11 5..1 is not a sub-range of INT"]),
        ("a : BYTE (0..300);", ["2:12 0..300 is not a sub-range of BYTE"]),
        ("a AT %IX0 : BOOL;", ["2:6 %IX has a bit and no other width has, got '%IX0'"]),
        ("a : POINTER TO X;", ["2:16 no type is named 'X'"]),
        ("__a : INT;", ["2:1 names with two underscores in front are reserved"]),
        ("a : TIME := T#1s + LTIME#1s;", ["2:18 '+' takes times of one type"]),
        ("a : INT := 5 = 'x';", ["2:14 '=' compares values of one kind"]),
        ("a : INT := 16#FFFF_FFFF_FFFF_FFFF * 16;",
         ["2:35 the result does not fit into 64 bits"]),
        ("a : LREAL := 1E300 * 1E300;", ["2:20 the result is not a finite number"]),
    ],
)  # fmt: skip
def test_what_is_wrong_with_variables(text: str, expected: list[str]) -> None:
    assert messages_of_variable(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("TYPE A : STRUCT a : A; END_STRUCT END_TYPE", ["1:21 A contains itself"]),
        ("TYPE A : STRUCT b : B; END_STRUCT B : ARRAY [0..1] OF A; END_TYPE",
         ["1:55 A contains itself"]),
        ("TYPE A : A; END_TYPE", ["1:10 A contains itself"]),
        ("TYPE A EXTENDS A : STRUCT END_STRUCT END_TYPE", ["1:16 A contains itself"]),
        ("TYPE A EXTENDS INT : STRUCT END_STRUCT END_TYPE",
         ["1:16 INT is not a STRUCT that can be extended"]),
        ("TYPE A EXTENDS B : INT; B : STRUCT END_STRUCT END_TYPE",
         ["1:16 only a structure extends another"]),
        ("FUNCTION_BLOCK A EXTENDS B END_FUNCTION_BLOCK TYPE B : STRUCT END_STRUCT END_TYPE",
         ["1:26 B is not a FUNCTION_BLOCK that can be extended"]),
        ("FUNCTION_BLOCK A IMPLEMENTS B END_FUNCTION_BLOCK TYPE B : INT; END_TYPE",
         ["1:29 B is not an interface"]),
        ("TYPE A : INT; A : INT; END_TYPE", ["1:15 A is declared already, at <text>:1:6"]),
        ("PROGRAM A END_PROGRAM TYPE a : INT; END_TYPE",
         ["1:28 a is declared already, at <text>:1:9"]),
        ("TYPE A : (x, X); END_TYPE", ["1:14 A has two values named X"]),
        ("TYPE A : (x := 300) BYTE; END_TYPE", ["1:11 x = 300 is not a BYTE"]),
        ("TYPE A : (x) LREAL; END_TYPE",
         ["1:14 an enumeration counts in a type of integers, not in LREAL"]),
        ("TYPE A : (x := y); END_TYPE", ["1:16 no constant or variable is named 'y'"]),
        ("{attribute 'pack_mode' := '9'} TYPE A : STRUCT END_STRUCT END_TYPE",
         ["1:41 pack_mode is 0 … 8, got '9'"]),
        ("TYPE A : STRUCT x : INT; END_STRUCT B EXTENDS A : STRUCT X : INT; END_STRUCT END_TYPE",
         ["1:58 B has two variables named X"]),
        ("PROGRAM P VAR a : Q; END_VAR END_PROGRAM PROGRAM Q END_PROGRAM",
         ["1:19 Q is not a type"]),
        ("VAR_GLOBAL CONSTANT a : INT := b; b : INT := a; END_VAR",
         ["1:46 the constant 'a' rests on itself"]),
        ("FUNCTION F : X END_FUNCTION", ["1:14 no type is named 'X'"]),
        ("FUNCTION F VAR_INPUT a : X; END_VAR VAR b : Y; END_VAR END_FUNCTION",
         ["1:26 no type is named 'X'", "1:45 no type is named 'Y'"]),
        ("PROGRAM P METHOD m VAR a : X; END_VAR END_METHOD END_PROGRAM",
         ["1:28 no type is named 'X'"]),
        ("PROGRAM P PROPERTY p : X GET END_GET END_PROPERTY END_PROGRAM",
         ["1:24 no type is named 'X'"]),
        ("PROGRAM P METHOD m END_METHOD ACTION M: END_ACTION END_PROGRAM",
         ["1:38 P has two parts named M"]),
        ("INTERFACE I EXTENDS J END_INTERFACE", ["1:21 no type is named 'J'"]),
        ("PROGRAM P VAR_TEMP a : X; END_VAR END_PROGRAM", ["1:24 no type is named 'X'"]),
        ("TYPE A : (x); B : (x); END_TYPE VAR_GLOBAL v : INT := x; END_VAR",
         ["1:55 'x' is a value of A and B: which one is meant?"]),
        ("TYPE A : STRUCT x : X1; y : X2; END_STRUCT B : STRUCT a : A; END_STRUCT END_TYPE",
         ["1:21 no type is named 'X1'", "1:29 no type is named 'X2'"]),
    ],
)  # fmt: skip
def test_what_is_wrong_with_types_and_units(text: str, expected: list[str]) -> None:
    assert messages(text) == expected


def test_a_fault_is_reported_once_and_in_its_file() -> None:
    bad = parse(Source("TYPE ST_Bad : STRUCT\n x : X; END_STRUCT END_TYPE", "bad.st"))
    users = [parse(f"PROGRAM P{n} VAR a : ST_Bad; END_VAR END_PROGRAM") for n in range(3)]
    with pytest.raises(SourceError) as caught:
        declare([*users, bad])
    assert str(caught.value) == (
        "bad.st:2:6: no type is named 'X'\n     x : X; END_STRUCT END_TYPE\n         ^"
        f"\n{caught.value.hint}"
    )
    assert caught.value.hint.startswith("types of libraries come from `libraries`")


def test_deep_dependencies_are_a_fault_or_flat() -> None:
    chain = "".join(f"T{n} : STRUCT a : T{n + 1}; END_STRUCT " for n in range(500))
    assert "rest on each other" in messages(f"TYPE {chain} T500 : INT; END_TYPE")[0]
    chain = "".join(f"c{n} : INT := c{n - 1} + 1; " for n in range(1, 500))
    project = declared(f"VAR_GLOBAL CONSTANT c0 : INT := 0; {chain} END_VAR")
    assert project.globals["gvl"].__iec__.members[-1].initial == 499
    turned = " ".join(reversed([f"c{n} : INT := c{n - 1} + 1;" for n in range(1, 500)]))
    assert (
        "rest on each other" in messages(f"VAR_GLOBAL CONSTANT {turned} c0 : INT := 0; END_VAR")[0]
    )


def test_syntax_faults_come_first() -> None:
    with pytest.raises(SourceError) as caught:
        declare([parse("TYPE a INT; END_TYPE"), parse("TYPE b : X; END_TYPE")])
    assert len(caught.value.faults) == 1


def test_instances_of_generic_blocks_share_no_inner_types() -> None:
    text = """
FUNCTION_BLOCK F
VAR_GENERIC CONSTANT n : INT := 1; END_VAR
VAR s : STRUCT a : ARRAY [1..n] OF INT; END_STRUCT; END_VAR
END_FUNCTION_BLOCK
PROGRAM P VAR x : F<4>; y : F<8>; END_VAR END_PROGRAM"""
    x, y = declared(text).programs["p"].__iec__.members
    assert (x.type.size, y.type.size) == (16, 24)


@pytest.mark.parametrize("name", ["name", "value", "real", "Values", "_order", "x__y", "self"])
def test_values_may_be_named_like_things_of_python(name: str) -> None:
    enum = one(f"T : (a, {name});")
    assert isinstance(enum, EnumType)
    assert enum.numbers == {"a": 0, name: 1}
    assert enum.decode(enum.encode(name)) == 1


def test_a_generic_block_is_looked_at_with_certain_values_only() -> None:
    text = """
FUNCTION_BLOCK ABSTRACT FB VAR_GENERIC CONSTANT nMost : INT := 0; END_VAR
METHOD ABSTRACT All : ARRAY [0..nMost - 1] OF INT
END_METHOD
END_FUNCTION_BLOCK
PROGRAM P VAR fb : FB<3>; sEmpty : STRING(0); END_VAR END_PROGRAM"""
    members = declare([parse(text)]).programs["p"].__iec__.members
    assert [item.type.size for item in members] == [8, 1]


def test_an_array_may_have_no_elements() -> None:
    text = "VAR_GLOBAL\n a : ARRAY [0..-1] OF INT;\nEND_VAR"
    record = declare([parse(text)]).globals["gvl"].__iec__
    assert record.member("a").type.size == 0


REFERRING = "TYPE ST : STRUCT x : INT; r : REFERENCE TO INT; END_STRUCT END_TYPE "


def test_a_member_is_bound_by_ref_too() -> None:
    for first in ("(r REF= b, x := 5)", "(x := 5, r REF= b)"):
        text = REFERRING + f"VAR_GLOBAL\n a : ST := {first}; b : INT;\nEND_VAR"
        variable = declare([parse(text)]).globals["gvl"].__iec__.member("a")
        assert variable.initial == {"x": 5}
        (start,) = variable.start_values
        assert (start.type.name, start.offset) == ("REFERENCE TO INT", 8)


def test_ref_binds_references_only() -> None:
    text = REFERRING + "VAR_GLOBAL a : ST := (x REF= b); b : INT; END_VAR"
    assert messages(text) == ["1:91 REF= binds a reference, not a INT"]


def test_missing_types_are_listed_in_one_order_whatever_their_case() -> None:
    text = "PROGRAM P VAR a : ST_b; b : St_B; c : st_a; END_VAR END_PROGRAM"
    with pytest.raises(SourceError) as refusal:
        declare([parse(text)])
    assert refusal.value.hint.splitlines()[0] == "missing types: st_a, ST_b, St_B"
