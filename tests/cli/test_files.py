"""Files are written whole or not at all, and not over others."""

import os
from pathlib import Path

import pytest
import typer

from achse.cli.files import write_file


def _is_xml(there: bytes) -> bool:
    return b"<xml" in there


def test_a_file_is_made_or_replaced(tmp_path: Path) -> None:
    file = tmp_path / "a.xml"
    write_file(file, b"<xml>1")
    write_file(file, b"<xml>2", _is_xml, "XML")
    assert file.read_bytes() == b"<xml>2"
    assert os.listdir(tmp_path) == ["a.xml"]


def test_a_file_of_another_kind_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.xml"
    file.write_bytes(b"PROGRAM MAIN")
    with pytest.raises(typer.Exit):
        write_file(file, b"<xml>", _is_xml, "XML")
    assert file.read_bytes() == b"PROGRAM MAIN"
    assert "exists and is not XML" in capsys.readouterr().err


def test_an_empty_file_may_be_written(tmp_path: Path) -> None:
    file = tmp_path / "a.xml"
    file.write_bytes(b" \n")
    write_file(file, b"<xml>", _is_xml, "XML")
    assert file.read_bytes() == b"<xml>"


def test_rights_and_links_stay(tmp_path: Path) -> None:
    file, link = tmp_path / "a.xml", tmp_path / "link.xml"
    file.write_bytes(b"")
    file.chmod(0o640)
    link.symlink_to(file)
    write_file(link, b"new")
    assert link.is_symlink()
    assert file.read_bytes() == b"new"
    assert file.stat().st_mode & 0o777 == 0o640


def test_a_file_that_is_read_only_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a.st"
    file.write_bytes(b"old")
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # who is root may write it
    with pytest.raises(typer.Exit):
        write_file(file, b"new")
    assert file.read_bytes() == b"old"
    assert capsys.readouterr().err.startswith(f"{file}: Permission denied")


@pytest.mark.parametrize("name", ["missing/a.xml", "folder"])
def test_what_cannot_be_written_is_reported(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(typer.Exit):
        write_file(tmp_path / name, b"1")
    stderr = capsys.readouterr().err
    assert stderr.startswith(str(tmp_path / name))
    assert stderr.count("\n") == 1


def test_a_device_is_written_to(tmp_path: Path) -> None:
    write_file(Path(os.devnull), b"1")
