"""Findings after edits, compared with those of a check from nothing."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.st.workspace import Extent, Workspace
from tests.st.workspace.sample import (
    FILES,
    Edit,
    cold_findings,
    edited,
    edits,
    write_project,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_project(tmp_path_factory.mktemp("project"))


@settings(deadline=None)
@given(edits=edits(), check_all=st.booleans())
def test_any_edits_have_the_findings_of_a_cold_check(
    folder: Path, edits: list[Edit], check_all: bool
) -> None:
    workspace = Workspace(folder, check_all=check_all)
    texts: dict[Path, str] = {}
    for edit in edits:
        file = folder / edit.file
        texts[file] = edited(texts.get(file, FILES[edit.file]), edit)
        workspace.edit(file, texts[file].encode())
        assert workspace.findings == cold_findings(folder, texts, check_all=check_all)
    for file in texts:
        workspace.close(file)
    assert workspace.findings == cold_findings(folder, {}, check_all=check_all)


def _changed(name: str, before: str, after: str) -> bytes:
    assert before in FILES[name]
    return FILES[name].replace(before, after).encode()


@pytest.mark.parametrize(
    ("name", "before", "after", "extent"),
    [
        ("POUs/MAIN.TcPOU", "nSum := 0;", "nSum := 'a';", Extent.BODIES),
        ("POUs/MAIN.TcPOU", "nSum := 0;", "nSum := 0; (* new *)", Extent.BODIES),
        ("POUs/FB_Drive.TcPOU", "Position := nPosition;", "", Extent.BODIES),
        ("Functions.st", "F_Add := a + b;", "\nF_Add := a + c;", Extent.BODIES),
        ("POUs/MAIN.TcPOU", "nSum : DINT;", "nSum : LREAL;", Extent.PROJECT),
        ("DUTs/E_State.TcDUT", "Moving", "Running", Extent.PROJECT),
        ("GVLs/GVL.TcGVL", "]]>", "", Extent.FILES),
        ("GVLs/GVL.TcGVL", "nCount", "nCount", Extent.NOTHING),
        ("Task.TcTTO", "MAIN", "OTHER", Extent.FILES),
    ],
)
def test_an_edit_reaches_as_far_as_it_changes_declarations(
    folder: Path, name: str, before: str, after: str, extent: Extent
) -> None:
    workspace = Workspace(folder)
    content = _changed(name, before, after)
    assert workspace.edit(folder / name, content) is extent
    assert workspace.edit(folder / name, content) is Extent.NOTHING
    assert workspace.findings == cold_findings(folder, {folder / name: content.decode()})


def test_findings_move_with_the_lines_above_them(folder: Path) -> None:
    workspace = Workspace(folder)
    name = "POUs/MAIN.TcPOU"
    faulty = FILES[name].replace("nOld := nSum;", "nOld := nothing;")
    workspace.edit(folder / name, faulty.encode())
    (first,) = workspace.findings.errors
    longer = faulty.replace("fbFast.Move", "\n\n\nfbFast.Move")
    assert workspace.edit(folder / name, longer.encode()) is Extent.BODIES
    (second,) = workspace.findings.errors
    assert second.location.line == first.location.line + 3
    assert second.message == first.message


def test_a_library_that_changes_is_read_again(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    library = tmp_path / "lib" / "Lib.st"
    library.write_text("FUNCTION F_Lib : INT\nF_Lib := 1;\nEND_FUNCTION\n")
    main = tmp_path / "Main.st"
    main.write_text("PROGRAM MAIN\nVAR n : INT; END_VAR\nn := F_Lib();\nEND_PROGRAM\n")
    workspace = Workspace(main, libraries=[tmp_path / "lib"])
    assert not workspace.findings.errors
    assert workspace.edit(library, b"FUNCTION F_Other : INT\nEND_FUNCTION\n") is Extent.FILES
    assert "F_Lib" in workspace.findings.errors[0].message


def test_files_come_and_go(tmp_path: Path) -> None:
    folder = write_project(tmp_path)
    workspace = Workspace(folder)
    assert not workspace.findings.errors
    (folder / "DUTs" / "E_State.TcDUT").unlink()
    assert workspace.reread(folder / "DUTs" / "E_State.TcDUT") is Extent.FILES
    assert workspace.findings == cold_findings(folder, {})
    assert workspace.findings.errors
    (folder / "More.st").write_text("TYPE E_State : (Idle, Moving, Failed); END_TYPE")
    assert workspace.reread(folder / "More.st") is Extent.FILES
    assert not workspace.findings.errors


def test_a_folder_without_sources_is_a_finding(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "nothing")
    assert "expected a folder" in workspace.findings.errors[0].message
    assert workspace.sources == ()
    assert workspace.edit(tmp_path / "x.txt", b"text") is Extent.NOTHING
