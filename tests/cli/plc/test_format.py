"""`achse format` over files and folders."""

import errno
import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from tests.st.workspace.sample import write_project

MAIN = "POUs/MAIN.TcPOU"


def test_sources_of_a_folder_are_formatted_once(tmp_path: Path) -> None:
    write_project(tmp_path)
    before = (tmp_path / MAIN).read_bytes()
    (tmp_path / MAIN).write_bytes(before.replace(b"    E_State.", b"  E_State."))
    runner = CliRunner()
    paths = [str(tmp_path / "POUs"), str(tmp_path / "DUTs")]
    check = runner.invoke(app, ["format", "--check", *paths])
    assert (check.exit_code, check.output) == (1, f"would format {tmp_path / MAIN}\n")
    done = runner.invoke(app, ["format", str(tmp_path / "POUs")])
    assert (done.exit_code, done.output) == (0, f"formatted {tmp_path / MAIN}\n")
    assert (tmp_path / MAIN).read_bytes() == before
    again = runner.invoke(app, ["format", "--check", str(tmp_path / "POUs")])
    assert (again.exit_code, again.output) == (0, "")


def test_faults_are_said(tmp_path: Path) -> None:
    runner = CliRunner()
    gone = runner.invoke(app, ["format", str(tmp_path / "gone.st")])
    assert gone.exit_code == 1
    (tmp_path / "achse.toml").write_text("[format]\nindent = 'x'\n")
    (tmp_path / "a.st").write_text("a;")
    wrong = runner.invoke(app, ["format", str(tmp_path)])
    assert wrong.exit_code == 1
    assert "blanks of one level" in wrong.stderr


def test_file_that_cannot_be_written_is_left_and_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a.st"
    file.write_bytes(b"x := 1;  \n")

    def refuse(source: str, target: Path) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(os, "replace", refuse)
    refused = CliRunner().invoke(app, ["format", str(file)])
    assert (refused.exit_code, refused.output) == (1, f"{file}: Permission denied\n")
    assert file.read_bytes() == b"x := 1;  \n"
    assert os.listdir(tmp_path) == ["a.st"]
