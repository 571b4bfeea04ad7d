"""Types and variables: 90 snippets, what is wrong with others, and how reading goes on."""

import pytest

from achse.st.syntax import tree
from achse.st.syntax.cursor import DEEPEST
from achse.st.syntax.parser import parse
from achse.st.syntax.printer import print_units
from achse.st.syntax.tree import Declaration, VarBlock
from achse.st.syntax.units import GlobalList, Program, TypeDeclaration


def declared(text: str) -> Declaration:
    """The one variable of a text."""
    (unit,) = parse(f"VAR_GLOBAL {text} END_VAR").check().units
    assert isinstance(unit, GlobalList)
    ((variable,),) = (block.variables for block in unit.blocks)
    return variable


def flat(text: str) -> str:
    lines = print_units(parse(text).check().units).split("\n")
    return " ".join(line.strip() for line in lines if line)


@pytest.mark.parametrize(
    "text",
    [
        "a : INT;",
        "a, b, c : INT;",
        "a : INT := 5;",
        "a : INT := cMax - 1;",
        "a AT %IX0.3 : BOOL;",
        "a AT %QB7 : BYTE := 16#FF;",
        "a AT %MD4 : DINT;",
        "a AT %I* : BOOL;",
        "a, b AT %Q* : BOOL;",
        "a : Tc2_MC2.AXIS_REF;",
        "a : A.B.C;",
        "a : INT (0..100);",
        "a : INT (-cMax..cMax) := 5;",
        "a : STRING;",
        "a : STRING(80);",
        "a : STRING(cLength + 1) := 'text';",
        'a : WSTRING(20) := "text";',
        "a : ARRAY [0..9] OF INT;",
        "a : ARRAY [0..cMax - 1, -1..1] OF ARRAY [1..2] OF STRING(5);",
        "a : ARRAY [1..3] OF INT := [1, 2, 3];",
        "a : ARRAY [1..9] OF INT := [1, 3(0), 5(7)];",
        "a : ARRAY [*] OF INT;",
        "a : ARRAY [*, *] OF LREAL;",
        "a : POINTER TO INT;",
        "a : POINTER TO POINTER TO ARRAY [0..1] OF INT := 0;",
        "a : REFERENCE TO ST_X;",
        "a : REFERENCE TO INT REF= b;",
        "a : POINTER TO INT := ADR(b);",
        "a : ST_X := (x := 1, y := (z := [1, 2]));",
        "a : ARRAY [0..1] OF ST_X := [(x := 1), (x := 2)];",
        "a : FB_X(1, 2);",
        "a : FB_X(nA := 1, nB := 2);",
        "a : FB_X(nA := 1) := (x := 2);",
        "a : E_X := E_X.Run;",
        "a : ST_X := (r REF= b.c, x := 1);",
        "a : ( Idle, Run ) := Run;",
        "a : ( Idle := 1, Run := 5 ) UINT;",
        "a : T_X := T#1h;",
        "a : LTIME := LTIME#1d2h3m4s5ms6us7ns;",
        "a : DT := DT#2024-02-29-12:00:00;",
        "a : List<8>;",
        "a : Map<cSize + 1, 2>(0);",
        "a : BOOL := NOT b;",
        "public : INT;",
        "constant : INT;",
        "get, set : INT;",
    ],
)
def test_variables_are_read_as_they_are_written(text: str) -> None:
    assert flat(f"VAR_GLOBAL {text} END_VAR") == f"VAR_GLOBAL {text} END_VAR"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a:int:=5;", "a : int := 5;"),
        ("a : STRING[80];", "a : STRING(80);"),
        ("a : array[0..1]of int;", "a : ARRAY [0..1] OF int;"),
        ("a:ARRAY[0..1]OF FB_X[2((n:=1))]:=[(m:=2)];",
         "a : ARRAY [0..1] OF FB_X[2((n := 1))] := [(m := 2)];"),
        ("a:ARRAY[0..1]OF FB_X[(1,b[2]),(3,n:=4)];",
         "a : ARRAY [0..1] OF FB_X[(1, b[2]), (3, n := 4)];"),
        ("a : INT;; b : INT;", "a : INT; b : INT;"),
        ("a : ST_X := ();", "a : ST_X := ();"),
        ("a (* x *) : (* y *) INT (* z *) ;", "a : INT;"),
    ],
)  # fmt: skip
def test_other_spellings(text: str, expected: str) -> None:
    assert flat(f"VAR_GLOBAL {text} END_VAR") == f"VAR_GLOBAL {expected} END_VAR"


@pytest.mark.parametrize(
    "text",
    [
        "TYPE T_X : LREAL; END_TYPE",
        "TYPE T_X : LREAL := 1.5; END_TYPE",
        "TYPE T_X : STRING(20); END_TYPE",
        "TYPE T_X : INT (1..5) := 2; END_TYPE",
        "TYPE T_X : ARRAY [0..1] OF INT := [1, 2]; END_TYPE",
        "TYPE T_X : POINTER TO ST_X; END_TYPE",
        "TYPE E_X : ( A ); END_TYPE",
        "TYPE E_X : ( A, B := 5, C ) UDINT; END_TYPE",
        "TYPE E_X : ( A, B ) := B; END_TYPE",
        "TYPE E_X : ( A := 16#1, B := A + 1, C := cMax * 2 ); END_TYPE",
        "TYPE ST_X : STRUCT END_STRUCT; END_TYPE",
        "TYPE ST_X : STRUCT a : INT; b, c : BIT; END_STRUCT; END_TYPE",
        "TYPE ST_X EXTENDS ST_Y : STRUCT a : INT := 1; END_STRUCT; END_TYPE",
        "TYPE ST_X EXTENDS Lib.ST_Y : STRUCT a : INT; END_STRUCT; END_TYPE",
        "TYPE INTERNAL ST_X : STRUCT a : INT; END_STRUCT; END_TYPE",
        "TYPE U_X : UNION a : LREAL; b : ARRAY [0..7] OF BYTE; END_UNION; END_TYPE",
        "TYPE ST_X : STRUCT s : STRUCT a : INT; END_STRUCT; END_STRUCT; END_TYPE",
        "{attribute 'pack_mode' := '1'} TYPE ST_X : STRUCT a : INT; END_STRUCT; END_TYPE",
        "{attribute 'a'} {attribute 'b' := 'it$'s'} (* c *) TYPE T_X : INT; END_TYPE",
        "VAR_GLOBAL CONSTANT a : INT := 1; END_VAR",
        "VAR_GLOBAL RETAIN a : INT; END_VAR VAR_GLOBAL PERSISTENT RETAIN b : INT; END_VAR",
        "VAR_CONFIG MAIN.fb.bIn AT %IX0.0 : BOOL; END_VAR",
        "VAR_CONFIG .bIn AT %IX0.0 : BOOL; MAIN.bOut AT %QX0.0 : BOOL; END_VAR",
        "VAR_GLOBAL {attribute 'hide'} a : INT; END_VAR",
    ],
)
def test_types_and_lists_are_read_as_they_are_written(text: str) -> None:
    assert flat(text) == text


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("TYPE ST_X : STRUCT a : INT; END_STRUCT END_TYPE",
         "TYPE ST_X : STRUCT a : INT; END_STRUCT; END_TYPE"),
        ("TYPE a : INT; b : ( A, B, ); END_TYPE",
         "TYPE a : INT; END_TYPE TYPE b : ( A, B ); END_TYPE"),
        ("TYPE E_X : UINT ( A, B ); END_TYPE", "TYPE E_X : ( A, B ) UINT; END_TYPE"),
        ("TYPE E_X : UINT ( A := 1, B ); END_TYPE", "TYPE E_X : ( A := 1, B ) UINT; END_TYPE"),
        ("type st_x : struct a : int; end_struct end_type;",
         "TYPE st_x : STRUCT a : int; END_STRUCT; END_TYPE"),
        ("TYPE {attribute 'x'} ST_X : STRUCT END_STRUCT END_TYPE",
         "{attribute 'x'} TYPE ST_X : STRUCT END_STRUCT; END_TYPE"),
    ],
)  # fmt: skip
def test_other_spellings_of_types(text: str, expected: str) -> None:
    assert flat(text) == expected


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("VAR_GLOBAL a INT; END_VAR", 1, 14, "expected ',', AT or ':', got 'INT'"),
        ("VAR_GLOBAL a : ; END_VAR", 1, 16, "expected a type, got ';'"),
        ("VAR_GLOBAL a : INT\nb : INT; END_VAR", 1, 19, "expected ':=' or ';', got 'b'"),
        ("VAR_GLOBAL a : INT := ; END_VAR", 1, 23, "expected an expression, got ';'"),
        ("VAR_GLOBAL a AT x : INT; END_VAR", 1, 17,
         "expected an address like %IX0.3 or %Q*, got 'x'"),
        ("VAR_GLOBAL a, : INT; END_VAR", 1, 15, "expected a name, got ':'"),
        ("VAR_GLOBAL 5 : INT; END_VAR", 1, 12, "expected the name of a variable, got '5'"),
        ("VAR_GLOBAL IF : INT; END_VAR", 1, 12, "expected the name of a variable, got 'IF'"),
        ("VAR_GLOBAL a : INT;", 1, 20, "expected the name of a variable or END_VAR, got the end"),
        ("VAR_GLOBAL a : ARRAY OF INT; END_VAR", 1, 22, "expected '[', got 'OF'"),
        ("VAR_GLOBAL a : ARRAY [1] OF INT; END_VAR", 1, 24, "expected '..', got ']'"),
        ("VAR_GLOBAL a : ARRAY [0..1 OF INT; END_VAR", 1, 28, "expected ',' or ']', got 'OF'"),
        ("VAR_GLOBAL a : ARRAY [0..1] INT; END_VAR", 1, 29, "expected OF, got 'INT'"),
        ("VAR_GLOBAL a : POINTER INT; END_VAR", 1, 24, "expected TO, got 'INT'"),
        ("VAR_GLOBAL a : STRING(; END_VAR", 1, 23, "expected an expression, got ';'"),
        ("VAR_GLOBAL a : STRING(5; END_VAR", 1, 24, "expected ')', got ';'"),
        ("VAR_GLOBAL a : INT (0..; END_VAR", 1, 24, "expected an expression, got ';'"),
        ("VAR_GLOBAL a : A. ; END_VAR", 1, 19, "expected a name, got ';'"),
        ("VAR_GLOBAL a : L<1; END_VAR", 1, 19, "expected ',' or '>', got ';'"),
        ("TYPE : INT; END_TYPE", 1, 6, "expected the name of a type or END_TYPE, got ':'"),
        ("TYPE a INT; END_TYPE", 1, 8, "expected EXTENDS or ':', got 'INT'"),
        ("TYPE a EXTENDS : STRUCT END_STRUCT END_TYPE", 1, 16,
         "expected the name of a type, got ':'"),
        ("TYPE a : INT END_TYPE", 1, 14, "expected ';', got 'END_TYPE'"),
        ("TYPE a : INT;", 1, 14, "expected END_TYPE, got the end"),
        ("TYPE a : ( ); END_TYPE", 1, 10, "expected at least one value of the enumeration"),
        ("TYPE a : ( 5 ); END_TYPE", 1, 12, "expected the name of a value, got '5'"),
        ("TYPE a : ( A B ); END_TYPE", 1, 14, "expected ',' or ')', got 'B'"),
        ("TYPE a : ( A := ); END_TYPE", 1, 17, "expected an expression, got ')'"),
        ("TYPE a : STRUCT x : INT; END_TYPE", 1, 26, "expected END_STRUCT, got 'END_TYPE'"),
        ("TYPE a : STRUCT x INT; END_STRUCT END_TYPE", 1, 19,
         "expected ',', AT or ':', got 'INT'"),
        ("TYPE a : UNION x : INT; END_STRUCT END_TYPE", 1, 25,
         "expected END_UNION, got 'END_STRUCT'"),
    ],
)  # fmt: skip
def test_faults_say_where_and_what(text: str, line: int, column: int, message: str) -> None:
    first = parse(text).faults[0]
    assert (*first.location[1:], first.message) == (line, column, message)


def test_reading_goes_on_after_a_fault() -> None:
    text = """
VAR_GLOBAL
    a INT;
    b : INT
    c : ARRAY [1] OF INT;
    d : INT := ;
    good : INT;
END_VAR
TYPE
    T_1 INT;
    T_2 : STRUCT x INT; y : INT; END_STRUCT
    T_3 : INT;
END_TYPE
"""
    parsed = parse(text)
    assert [fault.location.line for fault in parsed.faults] == [3, 4, 5, 6, 10, 11]
    names = [unit.name for unit in parsed.units]
    assert names == ["T_2", "T_3", "GVL"]
    (*_, variables) = parsed.units
    assert isinstance(variables, GlobalList)
    assert [item.names[0].name for item in variables.blocks[0].variables] == ["b", "good"]


def test_a_missing_end_var_is_one_fault() -> None:
    text = "PROGRAM MAIN VAR a : INT;\na := 1;\nb(); IF a THEN b(); END_IF\nEND_PROGRAM"
    parsed = parse(text)
    assert [fault.message for fault in parsed.faults] == [
        "expected the name of a variable or END_VAR, got 'a'"
    ]
    (program,) = parsed.units
    assert isinstance(program, Program)
    assert isinstance(program.body, tuple)
    assert len(program.body) == 3


def test_comments_and_attributes_belong_to_what_they_stand_beside() -> None:
    text = """
// of the type
{attribute 'pack_mode' := '1'}
TYPE ST_X :
STRUCT
    a : INT; // of a
    // of b
    // in two lines
    {attribute 'hide'}
    {attribute 'TcLinkTo' := 'TIID^x;y}z'}
    b : INT;
    (* of c *) c : INT; (* rather this of c *)
    (* of d *)
    d : INT;
    e : INT;
END_STRUCT
END_TYPE
"""
    (unit,) = parse(text).check().units
    assert isinstance(unit, TypeDeclaration)
    assert unit.note == tree.Note(" of the type", (("pack_mode", "1"),))
    assert isinstance(unit.type, tree.StructOf)
    assert [(item.names[0].name, item.note.comment) for item in unit.type.members] == [
        ("a", " of a"),
        ("b", " of b\n in two lines"),
        ("c", " rather this of c "),
        ("d", " of d "),
        ("e", ""),
    ]
    assert unit.type.members[1].note.attributes == (("hide", ""), ("TcLinkTo", "TIID^x;y}z"))


def test_comments_are_not_trimmed() -> None:
    text = "VAR_GLOBAL\n  a : INT; // of a  \n  b : INT; (*\n of b\n*)\nEND_VAR"
    (unit,) = parse(text).check().units
    assert isinstance(unit, GlobalList)
    notes = [item.note.comment for block in unit.blocks for item in block.variables]
    assert notes == [" of a  ", "\n of b\n"]


def test_values_of_enumerations_have_comments() -> None:
    text = (
        "TYPE E :\n(\n  A, // of a\n  {attribute 'x'}\n  B := 2, // of b\n  C // of c\n);\nEND_TYPE"
    )
    (unit,) = parse(text).check().units
    assert isinstance(unit, TypeDeclaration)
    assert isinstance(unit.type, tree.EnumOf)
    notes = [(value.note.comment, value.note.attributes) for value in unit.type.values]
    assert notes == [(" of a", ()), (" of b", (("x", ""),)), (" of c", ())]


def test_qualifiers_and_sections() -> None:
    text = "PROGRAM MAIN VAR CONSTANT RETAIN a : INT; END_VAR VAR_TEMP b : INT; END_VAR END_PROGRAM"
    (unit,) = parse(text).check().units
    assert isinstance(unit, Program)
    assert [(block.section, block.qualifiers) for block in unit.blocks] == [
        ("VAR", ("CONSTANT", "RETAIN")),
        ("VAR_TEMP", ()),
    ]
    assert isinstance(unit.blocks[0], VarBlock)


def test_deep_nesting_is_a_fault() -> None:
    for opening in ("POINTER TO ", "ARRAY [0..1] OF ", "STRUCT a : ", "L<L<" * 1):
        parsed = parse("VAR_GLOBAL a : " + opening * 10_000)
        assert parsed.faults
        if opening != "L<L<":
            assert f"deeper than {DEEPEST}" in parsed.faults[0].message


def test_an_address_is_kept_as_written() -> None:
    declaration = declared("a AT %IX12.7 : BOOL;")
    assert declaration.address == tree.DirectAddress("%IX12.7")
