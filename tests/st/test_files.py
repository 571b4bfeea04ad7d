"""Which files a project has, and what is in one."""

from pathlib import Path

import pytest

from achse.st.files import content_of, files_below, project_file, source_files, symbol_files
from achse.st.source import SourceError


def test_what_is_hidden_does_not_count(tmp_path: Path) -> None:
    for name in ("b.st", "a.st", ".git/c.st"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert [item.name for item in files_below(tmp_path)] == ["a.st", "b.st"]
    assert [name for _, name in source_files(tmp_path)] == ["a.st", "b.st"]


def test_the_file_that_says_what_is_in_a_project(tmp_path: Path) -> None:
    assert project_file(tmp_path) is None
    (tmp_path / "sub").mkdir()
    first = tmp_path / "sub/a.PLCPROJ"
    first.touch()
    assert project_file(tmp_path) == project_file(first) == first
    (tmp_path / "b.plcproj").touch()
    assert project_file(tmp_path) is None
    with pytest.raises(SourceError, match=r"several projects: name one of b\.plcproj, sub/a"):
        source_files(tmp_path)


def test_symbol_files_are_those_beside_it(tmp_path: Path) -> None:
    for name in ("a.st", "a.tmc", "b.TMC"):
        (tmp_path / name).touch()
    assert [item.name for item in symbol_files(tmp_path)] == ["a.tmc", "b.TMC"]
    assert [item.name for item in symbol_files(tmp_path / "a.st")] == ["a.tmc"]


def test_what_cannot_be_read_is_told(tmp_path: Path) -> None:
    for path in (tmp_path / "none", tmp_path, Path("a\0b")):
        with pytest.raises(SourceError, match="cannot be read"):
            content_of(path, "x")
