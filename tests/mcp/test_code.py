"""Code of a unit, and edits of one place."""

from pathlib import Path

import pytest

from achse.mcp.code import CodeError, edit_file, find_symbols, read_unit
from achse.mcp.folder import FolderError, ProjectFolder
from achse.st.workspace import Workspace
from tests.st.workspace.sample import write_project


@pytest.fixture
def project(tmp_path: Path) -> Path:
    return write_project(tmp_path)


def test_a_unit_is_read_without_its_parts_and_a_part_alone(project: Path) -> None:
    workspace, folder = Workspace(project), ProjectFolder(project)
    whole = read_unit(workspace, folder, "fb_drive", 10_000)
    assert whole.text.startswith("FUNCTION_BLOCK FB_Drive")
    assert whole.text.rstrip().endswith("bDone := nPosition >= nLimit;")
    assert whole.parts == ["FB_Drive.Move", "FB_Drive.Position", "FB_Drive.Halt"]
    move = read_unit(workspace, folder, "FB_Drive.Move", 10_000)
    assert move.text.startswith("METHOD PUBLIC Move")
    assert move.text.endswith("Move := nPosition;")
    halt = read_unit(workspace, folder, "FB_Drive.Halt", 5)
    assert (halt.text, halt.left_out) == ("bDone", 10)
    position = read_unit(workspace, folder, "FB_Drive.Position", 10_000)
    assert "Position := nPosition;" in position.text
    assert "bDone" not in position.text
    with pytest.raises(CodeError, match="did you mean 'FB_Drive'"):
        read_unit(workspace, folder, "FB_Drvie", 10)


def test_units_of_a_text_are_read_alone(tmp_path: Path) -> None:
    text = "FUNCTION F_A : INT\nF_A := 1;\nEND_FUNCTION\n\nFUNCTION F_B : INT\nEND_FUNCTION\n"
    (tmp_path / "all.st").write_text(text)
    unit = read_unit(Workspace(tmp_path), ProjectFolder(tmp_path), "F_A", 1000)
    assert unit.text == "FUNCTION F_A : INT\nF_A := 1;\nEND_FUNCTION"
    assert read_unit(Workspace(tmp_path), ProjectFolder(tmp_path), "F_B", 1000).line == 5


def test_symbols_are_found_by_a_piece_of_their_name(project: Path) -> None:
    result = find_symbols(Workspace(project), ProjectFolder(project), "DRIVE", 3)
    assert result.symbols[0].name == "FB_Drive"
    assert len(result.symbols) == 3
    assert result.left_out > 0


def test_an_edit_changes_code_alone(project: Path) -> None:
    file = project / "POUs" / "FB_Drive.TcPOU"
    before = file.read_bytes()
    workspace, folder = Workspace(project), ProjectFolder(project)
    path, line = edit_file(workspace, folder, "POUs/FB_Drive.TcPOU", "Move(1);", "Move(2);")
    assert path == file.resolve()
    assert before.splitlines()[line - 1].strip() == b"Move(1);"
    assert file.read_bytes() == before.replace(b"Move(1);", b"Move(2);")
    assert [item.name for item in file.parent.iterdir() if item.name.startswith(".")] == []
    for old, new in [
        ("nPosition", "nPlace"),
        ("nowhere", ""),
        ("", "x"),
        ('Name="FB_Drive"', 'Name="FB_Other"'),
        ("Move(2);", "]]><Evil/><![CDATA["),
        ("Move(2);", "Move(3);\0"),
        ("Move(2);", "Move(3);\x1b"),
        ("Move(2);", "Move(3);\ufffe"),
    ]:
        with pytest.raises(CodeError):
            edit_file(workspace, folder, "POUs/FB_Drive.TcPOU", old, new)
    assert file.read_bytes() == before.replace(b"Move(1);", b"Move(2);")


def test_an_edit_keeps_the_ends_of_lines(project: Path) -> None:
    file = project / "POUs" / "FB_Drive.TcPOU"
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    before = file.read_bytes()
    old = "IF bEnable THEN\n    Move(1);\n"
    workspace = Workspace(project)
    edit_file(workspace, ProjectFolder(project), "POUs/FB_Drive.TcPOU", old, "IF bEnable THEN\n")
    assert file.read_bytes() == before.replace(b"    Move(1);\r\n", b"")


def test_a_file_that_is_not_a_source_is_not_edited(project: Path) -> None:
    (project / "notes.txt").write_text("hello")
    with pytest.raises(FolderError):
        edit_file(Workspace(project), ProjectFolder(project), "notes.txt", "hello", "bye")
