"""Stubs for undeclared names: what uses tell, and projects that load with them."""

from pathlib import Path

import pytest

from achse.st.check import check
from achse.st.declare import declare, examine
from achse.st.lexis.source import Source, SourceError
from achse.st.missing.stubs import stub_files
from achse.st.missing.walk import MissingNames
from achse.st.project import examine_project, load_project
from achse.st.syntax.parser import parse

PROJECT = """
VAR_GLOBAL CONSTANT nOwn : INT := Lib.nMost; END_VAR
TYPE ST_Own EXTENDS ST_Base : STRUCT a : ARRAY [Lib.nLeast..nOwn] OF ST_Part; END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Own EXTENDS FB_Base IMPLEMENTS I_Thing, I_Other
VAR
    fbSend : Lib.FB_Send := (nPort := 3, aRates := [1, 2.5, 3]);
    fbNew : FB_New(nSize := 5);
    eMode : E_Mode := E_Mode.Auto;
    hFile : T_Handle := 0;
    aQueue : Queue<4>;
    pNode : POINTER TO ST_Node;
    refNode : REFERENCE TO ST_Node;
    nLength : UDINT;
    sText : STRING(20);
    eSet : SetType;
END_VAR
METHOD Run : BOOL
VAR_INPUT stIn : ST_In; END_VAR
fbSend(bExecute := TRUE, sName := sText, nDone => nLength);
IF fbSend.bBusy AND NOT fbSend.bError THEN
    fbSend.tWait := T#1S;
END_IF
nLength := F_Length(sText, 5) + pNode^.nSize;
Run := refNode.stNext.bLast;
CASE eMode OF
    E_Mode.Auto: fbSend.Reset(bAll := TRUE);
    E_Mode.Hand: SUPER^.Stop();
END_CASE
eSet := Lib.SetType.First;
bInherited := stIn.fPosition > 5.0;
fbSend.oData.aValues[7] := 1.5;
END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fb : FB_Own; n : INT; b : BOOL; x : INT; END_VAR
n := Lib.nMost;
fb(nFromBase := n);
b := E_Disk.ON_DISK = E_Disk.ON_TAPE;
LogText(Text := 'a', nLevel := 5);
LogText(Text := n, nLevel := 6);
fb.Check('x').Equal(1); fb.nFromBase := 4;
END_PROGRAM
"""


def files_of(text: str) -> dict[str, str]:
    declarations, _ = examine([parse(Source(text, "x.st"))])
    return stub_files(MissingNames(declarations.names))


def test_a_project_loads_and_checks_with_its_stubs() -> None:
    files = files_of(PROJECT)
    assert sorted(files) == ["Lib.st", "types.st"]
    libraries = [parse(Source(text, name), name=name[:-3]) for name, text in files.items()]
    project = check(declare([parse(PROJECT)], libraries=libraries))
    assert [str(fault) for fault in project.faults] == []


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("Lib.st", "nMost : INT := 16; // value?"),
        ("Lib.st", "nLeast : INT := 1; // value?"),
        ("types.st", "TYPE E_Mode : (Auto, Hand); END_TYPE // numbers?"),
        ("types.st", "TYPE SetType : (First); END_TYPE // numbers?"),
        ("types.st", "TYPE E_Disk : (ON_DISK, ON_TAPE); END_TYPE // numbers?"),
        ("types.st", "METHOD Stop : BOOL"),
        ("types.st", "TYPE T_Handle : DINT; END_TYPE"),
        ("types.st", "FUNCTION_BLOCK FB_New\nMETHOD FB_init : BOOL"),
        ("types.st", "    bExecute : BOOL;\n    sName : STRING(20);"),
        ("types.st", "aRates : ARRAY [0..2] OF LREAL;"),
        ("types.st", "tWait : TIME;"),
        ("types.st", "VAR_OUTPUT\n    nDone : UDINT;\n    bBusy : BOOL;\n    bError : BOOL;"),
        ("types.st", "METHOD Reset : BOOL\nVAR_INPUT\n    bAll : BOOL;"),
        ("types.st", "VAR_GENERIC CONSTANT nGeneric1 : DINT := 1; END_VAR"),
        ("types.st", "INTERFACE I_Other\nEND_INTERFACE"),
        ("types.st", "aValues : ARRAY [0..7] OF LREAL;"),
        ("types.st", "FUNCTION LogText : DINT\nVAR_INPUT\n    Text : ANY;"),
    ],
)
def test_stubs_have_what_uses_show(file: str, text: str) -> None:
    assert text in files_of(PROJECT)[file]


def test_opaque_projects(tmp_path: Path) -> None:
    (tmp_path / "x.st").write_text(PROJECT)
    _, error = examine_project(tmp_path)
    assert error is not None
    project = load_project(tmp_path, unknown="opaque")
    assert sorted(project.stubs) == ["Lib.st", "types.st"]
    (tmp_path / "x.st").write_text("PROGRAM MAIN END_PROGRAM")
    assert load_project(tmp_path, unknown="opaque").stubs == {}


def test_real_faults_stay_faults(tmp_path: Path) -> None:
    (tmp_path / "x.st").write_text("PROGRAM MAIN VAR a : ST_A; b : ARRAY [5..1] OF INT; END_VAR")
    with pytest.raises(SourceError, match="run backwards"):
        load_project(tmp_path, unknown="opaque")


@pytest.mark.parametrize(
    ("uses", "lines"),
    [
        ("VAR a : FB_Any; i : IAny; END_VAR i := a; i.Run();", ["INTERFACE IAny"]),
        ("VAR i : ITcoAny; n : DINT; END_VAR n := i.nCount + 1;", ["INTERFACE ITcoAny"]),
        ("VAR p : POINTER TO FB_Own; a : FB_Any; b : BOOL; END_VAR"
         " b := __QUERYPOINTER(a.Parent, p);", ["    Parent : IQueryInterface;"]),
        ("VAR g : T_Any; n : DINT; p : PVOID; END_VAR n := g.diSize; p := g.pValue;",
         ["TYPE T_Any : __SYSTEM.AnyType; END_TYPE"]),
        ("VAR b : BOOL; END_VAR b := Lib.F_Make(3).Run();", ["FUNCTION F_Make : Result_F_Make"]),
        ("VAR i : IAny; o : FB_Own; END_VAR i := o.Start(3);", ["INTERFACE IAny"]),
    ],
)  # fmt: skip
def test_interfaces_are_known_by_name_and_use(tmp_path: Path, uses: str, lines: list[str]) -> None:
    own = "FUNCTION_BLOCK FB_Own METHOD Start : IAny VAR_INPUT n : INT; END_VAR END_METHOD"
    (tmp_path / "a.st").write_text(f"PROGRAM P {uses} END_PROGRAM {own} END_FUNCTION_BLOCK")
    project, error = examine_project(tmp_path, unknown="opaque")
    assert error is None
    assert check(project.declarations).faults == ()
    text = project.stubs["types.st"].splitlines()
    assert set(lines) <= set(text)


def test_values_and_indices_of_missing_types() -> None:
    """Bare labels of CASE are values of the selector's type; values that index count from the
    array's first index; a type that is indexed is an array."""
    text = """
    TYPE ST_In : STRUCT a : INT; END_STRUCT END_TYPE
    VAR_GLOBAL CONSTANT nMost : INT := 4; END_VAR
    FUNCTION F_Number : INT VAR_INPUT nValue : INT; END_VAR END_FUNCTION
    PROGRAM MAIN
    VAR
        eState : E_State; aPoint : T_Point; aItems : ARRAY [1..nMost] OF ST_In; x : LREAL;
        aTable : ARRAY [1..2] OF ARRAY [1..nMost] OF ST_In;
        fb : FB_Own; fbBase : FB_Missing(nSize := 1); iOne : I_Stage := fbBase;
    END_VAR
    CASE eState OF CS_FIRST, CS_SECOND: x := aPoint[1]; END_CASE
    aItems[E_Item.First].a := F_Number(fb.eKind);
    fb.Take(aAll := aTable, slogText := CONCAT('a', 'b'));
    fbBase(bRun := TRUE);
    x := iOne.Position;
    fbEvent.CreateEx(TC_EVENTS.Mine.Low, TRUE, 0);
    END_PROGRAM
    FUNCTION_BLOCK FB_Own EXTENDS FB_Base END_FUNCTION_BLOCK
    """
    files = files_of(text)
    types = files["types.st"]
    assert "TYPE E_State : (CS_FIRST, CS_SECOND); END_TYPE" in types
    assert "CS_FIRST" not in files.get("constants.st", "")
    assert "TYPE T_Point : ARRAY [0..1] OF LREAL; END_TYPE" in types
    assert "TYPE E_Item : (First := 1); END_TYPE" in types
    assert "eKind : INT;" in types
    assert "aAll : ARRAY [*] OF ARRAY [1..nMost] OF ST_In;" in types
    assert "slogText : STRING(255);" in types
    assert "INTERFACE I_Stage" in types
    assert "Low : TcEventEntry;" in types
