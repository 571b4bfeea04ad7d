"""Projects in memory are as their files are on disk."""

import os
from pathlib import Path

import pytest

from achse.mcp.folder import FolderError, ProjectFolder
from achse.mcp.workspaces import WarmProjects
from achse.st.lint.options import LintOptionsError


def test_what_is_warm_equals_what_is_cold(folder: Path) -> None:
    warm = WarmProjects(ProjectFolder(folder))
    assert warm.check("station.toml", 9).ok
    file = folder / "press" / "POUs" / "F_Mean.TcPOU"
    good = file.read_text(encoding="utf-8")
    for text in (good.replace("fLeft +", "fLift +"), good.replace("LREAL;", "BOOL;"), good):
        file.write_text(text, encoding="utf-8")
        cold = WarmProjects(ProjectFolder(folder)).check("station.toml", 99)
        assert warm.check("station.toml", 99) == cold
        assert cold.ok == (text == good)


def test_added_and_removed_files_are_noticed(folder: Path) -> None:
    loose = folder / "loose"
    loose.mkdir()
    (loose / "a.st").write_text("PROGRAM A\nVAR n : INT; END_VAR\nn := F_B();\nEND_PROGRAM\n")
    warm = WarmProjects(ProjectFolder(folder))
    assert not warm.check("loose", 9).ok
    (loose / "b.st").write_text("FUNCTION F_B : INT\nEND_FUNCTION\n")
    assert warm.check("loose", 9).ok
    (loose / "b.st").unlink()
    assert not warm.check("loose", 9).ok


def test_a_project_in_memory_is_the_same_until_others_push_it_out(folder: Path) -> None:
    warm = WarmProjects(ProjectFolder(folder))
    first = warm.of("machine.st")
    assert warm.of("machine.toml") is first
    for number in range(5):
        (folder / f"p{number}.st").write_text(f"PROGRAM P{number}\nEND_PROGRAM\n")
        warm.of(f"p{number}.st")
    assert warm.of("machine.st") is not first


def test_rules_of_the_linter_count_as_the_project_has_them_on(folder: Path) -> None:
    (folder / "own").mkdir()
    (folder / "own" / "a.st").write_text("PROGRAM A\nVAR nUnused : INT; END_VAR\nEND_PROGRAM\n")
    (folder.parent / "achse.toml").write_text('[lint]\nselect = ["LT"]\n')  # outside
    warm = WarmProjects(ProjectFolder(folder))
    assert warm.check("own", 9).findings == []
    (folder / "achse.toml").write_text('[lint]\nselect = ["LT1"]\n')
    report = warm.check("own", 9)
    assert (report.ok, report.warnings, report.lint) == (True, 0, 1)
    assert (report.findings[0].severity, report.findings[0].code) == ("lint", "LT1001")
    (folder / "achse.toml").write_text("[lint]\nselect = 3\n")
    with pytest.raises(LintOptionsError, match="expected a list of codes"):
        warm.check("own", 9)


def test_findings_are_cut_and_counted(folder: Path) -> None:
    lines = "".join(f"n{number} := 1;\n" for number in range(20))
    (folder / "many.st").write_text(f"PROGRAM MANY\n{lines}END_PROGRAM\n")
    report = WarmProjects(ProjectFolder(folder)).check("many.st", 5)
    assert (report.errors, len(report.findings), report.left_out) == (20, 5, 15)
    assert {each.file for each in report.findings} == {"many.st"}


def test_a_project_with_a_source_elsewhere_is_refused(folder: Path) -> None:
    os.symlink(folder.parent, folder / "up")
    with pytest.raises(FolderError):
        WarmProjects(ProjectFolder(folder)).of("up")
