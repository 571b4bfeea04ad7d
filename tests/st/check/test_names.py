"""Names: the nearest declaration wins, and what means nothing is told."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.check import check
from achse.st.project import load_project
from achse.st.typed.expressions import Stored
from achse.st.typed.project import TypedProject
from achse.st.typed.statements import Do
from achse.st.typed.text import lines_of, place_of

UNITS = """
VAR_GLOBAL
    nGlobal : INT;
END_VAR
VAR_GLOBAL CONSTANT
    cMax : INT := 5;
    cTable : ARRAY [0..1] OF INT := [1, 2];
END_VAR
{attribute 'qualified_only'}
TYPE E_State : (Idle, Run := 7); END_TYPE
TYPE E_Loose : (Red, Green); END_TYPE
FUNCTION F_Own : INT
    F_Own := 1;
    F_Own := F_Own + F_Own();
END_FUNCTION
"""

Lines = Callable[..., list[str]]

ROWS = [
    ("n : INT;", "n := nGlobal;", "n := nGlobal;"),
    ("n : INT;", "n := GVL.nGlobal;", "n := nGlobal;"),
    ("nGlobal : LINT;", "nGlobal := .nGlobal;", "nGlobal := EXTEND.LINT(nGlobal);"),
    ("n : INT;", "n := cMax;", "n := 5;"),
    ("n : INT;", "n := cTable[1];", "n := cTable[1];"),
    ("n : INT;", "n := E_State.Run;", "n := 7;"),
    ("n : INT;", "n := E_State#Run;", "n := 7;"),
    ("n : INT;", "n := Green;", "n := 1;"),
    ("n : INT;", "n := Tc2_Nowhere.cMax;", "n := 5;"),
    ("n : INT;", "n := MAIN.n;", "n := n;"),
    ("n : INT;", "n := F_Own();", "n := f_own();"),
    ("n : INT;", "n := Run;", "fault: nothing is named 'Run' here"),
    ("n : INT;", "n := nGlobl;", "fault: nothing is named 'nGlobl' here; near: nglobal"),
    ("n : INT;", "n := F_Won();",
     "fault: no function or instance is named 'F_Won'; near: f_own"),
    ("n : INT;", "cMax := 3;", "fault: cMax is CONSTANT: nothing can be assigned to it"),
    ("n : INT;", "cTable[0] := 3;",
     "fault: cTable[0] is CONSTANT: nothing can be assigned to it"),
    ("n : INT;", "n := E_State;", "fault: E_State is not a value"),
    ("n : INT;", "n := THIS^.n;", "n := n;"),
]  # fmt: skip


@pytest.mark.parametrize(("variables", "statement", "expected"), ROWS)
def test_names(lines: Lines, variables: str, statement: str, expected: str) -> None:
    assert lines(variables, statement, UNITS) == [expected]


def test_the_name_of_a_function_is_its_result_and_calls_it(
    typed: Callable[[str], TypedProject],
) -> None:
    project = typed(UNITS)
    assert list(lines_of(project.routines["f_own"].body or ()))[1] == (
        "F_Own := CUT.INT(ADD.DINT(EXTEND.DINT(F_Own), EXTEND.DINT(f_own())));"
    )


def test_every_variable_is_a_place(typed: Callable[[str], TypedProject]) -> None:
    project = typed(
        """
        FUNCTION_BLOCK FB EXTENDS FB_Base
        VAR a : BYTE; b : INT; END_VAR
        VAR_STAT s : INT; END_VAR
        VAR_TEMP t : INT; END_VAR
        VAR_IN_OUT r : INT; END_VAR
        inherited := a := 1; b := 2; s := 3; t := 4; r := 5; global := 6; %MW10 := 7;
        METHOD M VAR x : INT; END_VAR VAR_INST i : INT; END_VAR VAR_STAT m : INT; END_VAR
        x := 1; i := 2; m := 3;
        END_METHOD
        END_FUNCTION_BLOCK
        FUNCTION_BLOCK FB_Base VAR inherited : BYTE; END_VAR END_FUNCTION_BLOCK
        VAR_GLOBAL global : INT; END_VAR
        """
    )
    assert not project.faults
    places = []
    for key in ("fb", "fb.m"):
        for statement in project.routines[key].body or ():
            assert isinstance(statement, Do)
            assert isinstance(statement.value, Stored)
            places.append(place_of(statement.value.storage))
    assert places == [
        "this+8", "this+18", "static FB.s", "frame", "pointer", "GVL.global", "%M+10",
        "frame", "this+32", "static FB.M.m",
    ]  # fmt: skip


OWN_TEXTS = """
FUNCTION CONCAT : STRING VAR_INPUT STR1, STR2 : STRING; END_VAR CONCAT := 'own'; END_FUNCTION
FUNCTION LEFT : STRING VAR_INPUT STR : STRING; SIZE : INT; END_VAR LEFT := 'own'; END_FUNCTION
FUNCTION MAX : INT VAR_INPUT a, b : INT; END_VAR MAX := 7; END_FUNCTION
PROGRAM MAIN
VAR
    sOwn, sQualified, sLibrary, sTime : STRING; nOwn, nQualified : INT;
    nTime : T_DCTIME64 := 1000000000000;
END_VAR
sOwn := CONCAT('a', 'b');
sQualified := Tc2_Standard.CONCAT('a', Tc2_Standard.LEFT('bc', 1));
sLibrary := F_ConvStateToString(16#18);
sTime := DCTIME64_TO_STRING(nTime);
nOwn := MAX(1, 2);
nQualified := Tc2_Standard.MAX(1, 2);
END_PROGRAM
"""


def test_function_of_the_project_replaces_none_in_libraries(tmp_path: Path) -> None:
    """Neither inside a library nor behind its name (decision 0105)."""
    (tmp_path / "MAIN.st").write_text(OWN_TEXTS)
    declared = load_project(tmp_path / "MAIN.st").declarations
    typed = check(declared)
    assert [str(fault) for fault in typed.faults] == []
    task = Task("PlcTask", 10_000_000, [declared.programs["main"]])
    plc = PlcRuntime([task], declared.units, bodies=Bodies(typed, form=CodeForm.PLAIN))
    plc.run_due(10_000_000)
    main = plc.instance("MAIN")
    assert (main["sOwn"], main["nOwn"]) == ("own", 7)
    assert (main["sQualified"], main["nQualified"]) == ("ab", 2)
    assert main["sLibrary"] == "OP ERROR"
    assert main["sTime"] == "2000-01-01-00:16:40.000000000"


LIBRARY = """
TYPE E_Mode : (Off := 1, On := 2); END_TYPE
TYPE T_Length : INT; END_TYPE
TYPE ST_Part : STRUCT eMode : E_Mode; nLength : T_Length; END_STRUCT END_TYPE
TYPE ST_Whole EXTENDS ST_Part : STRUCT aParts : ARRAY [1..2] OF ST_Part; END_STRUCT END_TYPE
INTERFACE I_Count METHOD Count : DINT END_METHOD END_INTERFACE
FUNCTION_BLOCK FB_Base IMPLEMENTS I_Count
VAR stPart : ST_Part := (eMode := E_Mode.On, nLength := 5); END_VAR
METHOD Count : DINT Count := F_Twice(stPart.nLength); END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Derived EXTENDS FB_Base
VAR iCount : I_Count; stWhole : ST_Whole; pPart : POINTER TO ST_Part; END_VAR
METHOD Total : DINT
iCount := THIS^;
pPart := ADR(stWhole.aParts[2]);
pPart^.nLength := 3;
Total := iCount.Count() + stWhole.aParts[2].nLength + TO_DINT(stPart.eMode) + SIZEOF(ST_Whole);
END_METHOD
END_FUNCTION_BLOCK
FUNCTION F_Twice : DINT VAR_INPUT n : T_Length; END_VAR F_Twice := 2 * n; END_FUNCTION
"""
AGAIN = (
    "TYPE {} : STRUCT fOther : ARRAY [1..9] OF LREAL; END_STRUCT END_TYPE",
    "TYPE {} : (Other := 77, More := 78); END_TYPE",
    "TYPE {} : STRING(200); END_TYPE",
    "INTERFACE {} METHOD Other : LREAL END_METHOD END_INTERFACE",
    "FUNCTION_BLOCK {} VAR fOther : LREAL; END_VAR METHOD Count : LREAL Count := 9.5; END_METHOD"
    " END_FUNCTION_BLOCK",
    "FUNCTION {0} : LREAL VAR_INPUT a, b, c : LREAL; END_VAR {0} := 9.5; END_FUNCTION",
)


@given(again=st.lists(st.sampled_from((None, *AGAIN)), min_size=8, max_size=8))
@settings(max_examples=8)
def test_types_of_the_project_replace_none_in_a_library(
    tmp_path_factory: pytest.TempPathFactory, again: list[str | None]
) -> None:
    """Each name that a library declares is declared again by its project, as anything else."""
    folder = tmp_path_factory.mktemp("names")
    (folder / "Lib").mkdir()
    (folder / "Lib" / "library.st").write_text(LIBRARY)
    names = re.findall(r"^(?:TYPE|INTERFACE|FUNCTION_BLOCK|FUNCTION) (\w+)", LIBRARY, re.MULTILINE)
    own = [form.format(name) for form, name in zip(again, names, strict=True) if form]
    main = "PROGRAM MAIN VAR fb : Lib.FB_Derived; n : DINT; END_VAR n := fb.Total(); END_PROGRAM"
    (folder / "MAIN.st").write_text("\n".join((*own, main)))
    declared = load_project(folder / "MAIN.st", libraries=[folder / "Lib"]).declarations
    typed = check(declared)
    assert [str(fault) for fault in typed.faults] == []
    task = Task("PlcTask", 10_000_000, [declared.programs["main"]])
    plc = PlcRuntime([task], declared.units, bodies=Bodies(typed, form=CodeForm.PLAIN))
    plc.run_due(10_000_000)
    assert plc.instance("MAIN")["n"] == 10 + 3 + 2 + 12


def test_one_name_means_different_things_in_different_routines(
    typed: Callable[[str], TypedProject],
) -> None:
    """What a name means outside of routines is kept: not for routines that declare it."""
    project = typed(
        """
        FUNCTION F_Own : INT F_Own := 5; END_FUNCTION
        FUNCTION F_1 : INT F_1 := F_Own() + ABS(-1); END_FUNCTION
        FUNCTION F_2 : INT VAR F_Own, abs : INT; END_VAR F_2 := F_Own + abs; END_FUNCTION
        FUNCTION_BLOCK FB
            METHOD F_Own : INT F_Own := 6; END_METHOD
            METHOD Go : INT Go := F_Own() + ABS(-1); END_METHOD
        END_FUNCTION_BLOCK
        FUNCTION F_3 : INT F_3 := F_Own() + ABS(-1); END_FUNCTION
        """
    )
    assert not project.faults
    bodies = {key: list(lines_of(routine.body or ())) for key, routine in project.routines.items()}
    assert bodies["f_1"][0].replace("F_1", "F_3") == bodies["f_3"][0]
    assert "f_own()" in bodies["f_1"][0]
    assert "()" not in bodies["f_2"][0]
    assert "ADR(THIS^)->[f_own]()" in bodies["fb.go"][0]
