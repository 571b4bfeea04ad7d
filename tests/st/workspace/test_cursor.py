"""The cursor in a body: what completes it, and which call it is in."""

from pathlib import Path

import pytest

from achse.st.check.warm import WarmChecking
from achse.st.lexis.source import Source
from achse.st.workspace import Workspace
from achse.st.workspace.cursor import completions, open_call, routine_at
from tests.st.workspace.sample import FILES

NAME = "POUs/MAIN.TcPOU"


def _at(workspace: Workspace, folder: Path, code: str) -> tuple[WarmChecking, Source, int]:
    """Type some code into the body of MAIN; return the place behind it."""
    text = FILES[NAME].replace("nSum := F_Add", f"{code}\nnSum := F_Add")
    workspace.edit(folder / NAME, text.encode())
    source = workspace.source_of(folder / NAME)
    assert source is not None
    assert workspace.checking is not None
    return workspace.checking, source, source.text.index(code) + len(code)


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ("fbDrive.", ["bEnable", "nLimit", "bDone", "nPosition", "aBuffer", "Move", "Position"]),
        ("E_State.", ["Idle", "Moving", "Failed"]),
        ("stData.", ["rScale", "aValues"]),
        ("GVL.nC", ["nCount", "fbSpare", "cMost"]),
        ("iShape.", ["Area"]),
        ("fbDrive.aBuffer[2].r", ["rScale", "aValues"]),
        ("Tc2_Standard.", ["SR", "RS"]),
        ("fbDrive(", ["bEnable", "nLimit", "bDone", "fbDrive"]),
        ("tDelay(IN := TRUE, ", ["IN", "PT", "Q", "ET"]),
        ("n", ["fbDrive", "fbFast", "eState"]),
        ("stData.aValues[1].", []),
        ("unknown.", []),
        ("F_Add(1, 2).", []),
    ],
)
def test_completions(
    workspace: Workspace, sample_folder: Path, code: str, names: list[str]
) -> None:
    names_ = [one.name for one in completions(*_at(workspace, sample_folder, code))]
    assert names_[: len(names)] == names
    assert bool(names_) is bool(names)


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("F_Add(", ("F_Add", 0, "")),
        ("F_Add(1, ", ("F_Add", 1, "")),
        ("F_Add(b := ", ("F_Add", 0, "b")),
        ("fbDrive(bEnable := (1 + 2), nLimit := ", ("FB_Drive", 1, "nlimit")),
        ("fbFast.Move(F_Add(1, 2) + ", ("FB_Fast.Move", 0, "")),
        ("SUPER^(", None),
        ("nSum := (1 + ", None),
        ("nSum := 1; ", None),
        ("'F_Add(", None),
    ],
)
def test_open_calls(
    workspace: Workspace, sample_folder: Path, code: str, expected: tuple[str, int, str] | None
) -> None:
    call = open_call(*_at(workspace, sample_folder, code))
    call_ = None if call is None else (call.signature.name, call.number, call.parameter)
    assert call_ == expected


def test_routines_by_place(workspace: Workspace, sample_folder: Path) -> None:
    checking = workspace.checking
    assert checking is not None
    for file, code, name in [
        (NAME, "nOld := nSum", "MAIN.Reset"),
        (NAME, "bAll :", "MAIN.Reset"),
        (NAME, "fbFast.Move", "MAIN"),
        ("Functions.st", "nIdle := nIdle", "FB_Spare"),
        ("Functions.st", "Check := nIdle", "FB_Spare.Check"),
        ("POUs/FB_Drive.TcPOU", "bDone := FALSE", "FB_Drive.Halt"),
        ("POUs/FB_Drive.TcPOU", "\nPosition := nPosition", "FB_Drive.__getPosition"),
    ]:
        source = workspace.source_of(sample_folder / file)
        assert source is not None
        routine = routine_at(checking, source, source.text.index(code) + 1)
        assert routine is not None
        assert routine.name == name
