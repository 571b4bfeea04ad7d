"""A small project of all kinds of files, its cold check, and drawn edits."""

from pathlib import Path
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

from hypothesis import strategies as st

from achse.st.check import check
from achse.st.files.reading import file_key, reading
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.lint.linting import lint
from achse.st.lint.options import LintOptions
from achse.st.project import examine_project
from achse.st.workspace import ProjectFindings, findings_of
from achse.st.workspace.findings import sorted_findings

__all__ = ["FILES", "Edit", "cold_findings", "cold_lint", "edited", "edits", "write_project"]

FILES = {
    "POUs/MAIN.TcPOU": """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1"><POU Name="MAIN" Id="{1}"><Declaration><![CDATA[PROGRAM MAIN
VAR
    fbDrive : FB_Drive; // the drive
    fbFast : FB_Fast;
    eState : E_State;
    stData : ST_Data;
    nSum : DINT;
    tDelay : TON;
    iShape : I_Shape;
END_VAR]]></Declaration><Implementation><ST><![CDATA[fbDrive(bEnable := TRUE, nLimit := 5);
fbFast.Move(nSteps := 3);
nSum := F_Add(nSum, GVL.nCount) + fbDrive.Position;
CASE eState OF
    E_State.Idle: eState := Moving;
    E_State.Moving: nSum := 0;
END_CASE
iShape := fbFast;
tDelay(IN := fbDrive.bDone, PT := T#1S);
stData.aValues[2] := DINT_TO_REAL(nSum);
]]></ST></Implementation>
<Method Name="Reset" Id="{2}"><Declaration><![CDATA[METHOD Reset : BOOL
VAR_INPUT
    bAll : BOOL;
END_VAR
VAR
    nOld : DINT;
END_VAR]]></Declaration><Implementation><ST><![CDATA[nOld := nSum;
Reset := bAll AND nOld > cMost;]]></ST></Implementation></Method>
</POU></TcPlcObject>
""",
    "POUs/FB_Drive.TcPOU": """<TcPlcObject><POU Name="FB_Drive"><Declaration><![CDATA[
FUNCTION_BLOCK FB_Drive
VAR_INPUT
    bEnable : BOOL;
    nLimit : INT := 10;
END_VAR
VAR_OUTPUT
    bDone : BOOL;
END_VAR
VAR
    nPosition : DINT;
    aBuffer : ARRAY [0..7] OF ST_Data;
END_VAR
]]></Declaration><Implementation><ST><![CDATA[IF bEnable THEN
    Move(1);
END_IF
bDone := nPosition >= nLimit;
]]></ST></Implementation>
<Method Name="Move"><Declaration><![CDATA[METHOD PUBLIC Move : DINT
VAR_INPUT
    nSteps : DINT;
END_VAR]]></Declaration><Implementation><ST><![CDATA[nPosition := nPosition + nSteps;
Move := nPosition;]]></ST></Implementation></Method>
<Property Name="Position"><Declaration><![CDATA[PROPERTY Position : DINT]]></Declaration>
<Get Name="Get"><Declaration><![CDATA[VAR
END_VAR]]></Declaration><Implementation><ST><![CDATA[Position := nPosition;]]></ST></Implementation>
</Get></Property>
<Action Name="Halt"><Implementation><ST><![CDATA[bDone := FALSE;]]></ST></Implementation></Action>
</POU></TcPlcObject>
""",
    "POUs/FB_Fast.TcPOU": """<TcPlcObject><POU Name="FB_Fast"><Declaration><![CDATA[
FUNCTION_BLOCK FB_Fast EXTENDS FB_Drive IMPLEMENTS I_Shape
VAR CONSTANT
    cFactor : DINT := 2 * cMost;
END_VAR]]></Declaration><Implementation><ST><![CDATA[SUPER^();]]></ST></Implementation>
<Method Name="Move"><Declaration><![CDATA[METHOD Move : DINT
VAR_INPUT
    nSteps : DINT;
END_VAR]]></Declaration><Implementation><ST><![CDATA[Move := SUPER^.Move(nSteps * cFactor);]]></ST>
</Implementation></Method>
<Method Name="Area"><Declaration><![CDATA[METHOD Area : REAL]]></Declaration>
<Implementation><ST><![CDATA[Area := aBuffer[1].rScale;]]></ST></Implementation></Method>
</POU></TcPlcObject>
""",
    "DUTs/E_State.TcDUT": """<TcPlcObject><DUT Name="E_State"><Declaration><![CDATA[
TYPE E_State : (Idle := 0, Moving := 1, Failed := 7);
END_TYPE]]></Declaration></DUT></TcPlcObject>
""",
    "DUTs/ST_Data.TcDUT": """<TcPlcObject><DUT Name="ST_Data"><Declaration><![CDATA[TYPE ST_Data :
STRUCT
    rScale : REAL := 1.5; (* scale *)
    aValues : ARRAY [0..cMost] OF REAL;
END_STRUCT
END_TYPE]]></Declaration></DUT></TcPlcObject>
""",
    "GVLs/GVL.TcGVL": """<TcPlcObject><GVL Name="GVL"><Declaration><![CDATA[VAR_GLOBAL
    nCount : DINT := 3;
    fbSpare AT %MB100 : FB_Drive;
END_VAR
VAR_GLOBAL CONSTANT
    cMost : DINT := 4;
END_VAR]]></Declaration></GVL></TcPlcObject>
""",
    "Functions.st": """INTERFACE I_Shape
METHOD Area : REAL
END_METHOD
END_INTERFACE

FUNCTION F_Add : DINT
VAR_INPUT a, b : DINT; END_VAR
F_Add := a + b;
END_FUNCTION

FUNCTION_BLOCK FB_Spare
VAR nIdle : INT; END_VAR
METHOD PUBLIC Check : BOOL
    Check := nIdle > 3;
END_METHOD
nIdle := nIdle + 1;
END_FUNCTION_BLOCK
""",
    "Task.TcTTO": """<TcPlcObject><Task Name="PlcTask"><CycleTime>10000</CycleTime>
<Priority>20</Priority><PouCall><Name>MAIN</Name></PouCall></Task></TcPlcObject>
""",
}
_EDITED = [name for name in FILES if not name.endswith(".TcTTO")]
_WORDS = (
    *("x", ";", "\n", " ", "(", ")", ":= 1;", "END_IF;", "IF bEnable THEN ", "// ", "(*", "*)"),
    *("nSum", "nPosition := 'a';", "F_Add(1, 2);", "Halt();", "eState := 2;", "nCuont := 1;", "^"),
    *("VAR\n    nNew : INT;\nEND_VAR\n", "rScale", "ä€😀", "{attribute 'pack_mode' := '1'}"),
    *("METHOD M\nEND_METHOD\n", "FUNCTION F_New : INT\nF_New := 1;\nEND_FUNCTION\n", "THIS^."),
)
_NAMES = ("nSum", "FB_Drive", "Move", "nPosition", "cMost", "E_State", "Moving", "F_Add", "rScale")
_TYPES = ("DINT", "INT", "REAL", "BOOL", "ST_Data", "FB_Drive", "LREAL", "STRING(20)", "Unknown")


class Edit(NamedTuple):
    """An edit of one file: insert or delete characters, rename, or go back to the first text."""

    file: str
    kind: str
    place: float
    """Where in the file, 0 … 1."""
    length: int
    text: str
    other: str


def edits() -> st.SearchStrategy[list[Edit]]:
    """Return a strategy for some edits, one after the other."""
    one = st.builds(
        Edit,
        st.sampled_from(_EDITED),
        st.sampled_from(("insert", "delete", "delete", "replace", "rename", "type", "undo")),
        st.floats(0, 1),
        st.integers(1, 12),
        st.sampled_from(_WORDS),
        st.sampled_from(_NAMES),
    )
    return st.lists(one, min_size=1, max_size=5)


def edited(text: str, edit: Edit) -> str:
    """Return the text of a file after an edit."""
    at = int(edit.place * len(text))
    if "CDATA[" in text and edit.length > 1:  # nearly always in the code
        begin = max(text.rfind("CDATA[", 0, at), text.find("CDATA[")) + 6
        end = text.find("]]>", begin)
        at = begin + at % (end - begin + 1) if end >= 0 else at
    match edit.kind:
        case "insert":
            return text[:at] + edit.text + text[at:]
        case "delete":
            return text[:at] + text[at + edit.length :]
        case "replace":
            return text[:at] + edit.text + text[at + edit.length :]
        case "rename":
            return text.replace(edit.other, f"{edit.other}X")
        case "type":
            return text.replace(_TYPES[edit.length % 3], _TYPES[edit.length % len(_TYPES)])
        case _:
            return FILES[edit.file]


def write_project(folder: Path) -> Path:
    """Write the files of the project into a folder."""
    for name, text in FILES.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, "utf-8", newline="")
    return folder


def cold_findings(
    folder: Path, texts: dict[Path, str], *, predefined: Any = (), check_all: bool = False
) -> ProjectFindings:
    """Return the findings of a check that begins with nothing."""
    contents = {file_key(file): text.encode() for file, text in texts.items()}
    try:
        with reading(contents, WeakValueDictionary()):
            project, error = examine_project(folder, check_all=check_all)
    except SourceError as nothing:
        return sorted_findings(nothing.faults, (), ())
    typed = check(
        project.declarations,
        predefined=predefined,
        reach=project.reach,
        unreached=project.unreached,
    )
    return findings_of(project, error, typed, check_all=check_all)


def cold_lint(folder: Path, texts: dict[Path, str]) -> list[Diagnostic]:
    """Return what all rules of the linter find in a check that begins with nothing."""
    contents = {file_key(file): text.encode() for file, text in texts.items()}
    with reading(contents, WeakValueDictionary()):
        project, _ = examine_project(folder)
    declarations = project.declarations
    typed = check(declarations, reach=project.reach, unreached=project.unreached)
    return list(lint(project.sources, declarations, typed, LintOptions().with_all()))
