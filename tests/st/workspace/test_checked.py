"""Checked projects: findings between edits."""

from pathlib import Path

from achse.st.lint.options import LintOptions
from achse.st.workspace import Extent, Workspace
from tests.st.workspace.sample import FILES, cold_findings, write_project


def test_sources_names_and_findings_of_the_linter_are_kept_until_an_edit(tmp_path: Path) -> None:
    workspace = Workspace(
        write_project(tmp_path), lint_rules=lambda _: LintOptions().with_all(), check_all=True
    )
    assert not workspace.is_linted
    assert workspace.lint() is workspace.lint()
    assert workspace.is_linted
    file = tmp_path / "Functions.st"
    source = workspace.source_of(file)
    assert source is not None
    assert source in [one.source for one in workspace.all_sources]
    assert workspace.uses_of(source) is workspace.uses_of(source)
    assert [task.name for task in workspace.tasks] == ["PlcTask"]
    workspace.edit(file, FILES["Functions.st"].replace("nIdle > 3", "nIdle > 4").encode())
    assert not workspace.is_linted


def test_bodies_then_locals_then_declarations_of_one_method(tmp_path: Path) -> None:
    workspace = Workspace(write_project(tmp_path))
    file = tmp_path / "POUs" / "MAIN.TcPOU"
    text = FILES["POUs/MAIN.TcPOU"]
    for old, new, extent in (
        ("nOld := nSum;", "nOld := nSum + 1;", Extent.BODIES),
        ("    nOld : DINT;", "    nOld : LINT;\n    sNew : STRING;", Extent.BODIES),
        ("nOld := nSum", "sNew := nSum", Extent.BODIES),
        ("bAll : BOOL", "bAll : DINT", Extent.DECLARATIONS),
        ("METHOD Reset", "METHOD Renew", Extent.DECLARATIONS),
    ):
        assert old in text
        text = text.replace(old, new)
        assert workspace.edit(file, text.encode()) is extent
        assert workspace.findings == cold_findings(tmp_path, {file: text})
