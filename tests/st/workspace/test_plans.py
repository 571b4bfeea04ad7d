"""Routines that an edit of declarations makes the checker check again."""

from pathlib import Path

import pytest

from achse.st.workspace import Extent, Workspace
from achse.st.workspace import plans as plans_module
from achse.st.workspace.plans import RoutinePlan
from tests.st.workspace.sample import FILES, cold_findings, write_project


@pytest.mark.parametrize(
    ("name", "old", "new", "again", "kept_keys"),
    [
        ("Functions.st", "a, b : DINT", "b, a : DINT", set(), {"fb_spare.check"}),
        ("GVLs/GVL.TcGVL", "nCount : DINT", "nCount : INT", {"main"}, set()),
        (
            "POUs/FB_Drive.TcPOU",
            "bDone : BOOL",
            "bDone : BIT",
            set(),
            {"fb_drive.move", "fb_drive.__getposition", "fb_fast.move", "fb_fast.area"},
        ),
        (
            "POUs/FB_Drive.TcPOU",
            "nSteps : DINT",
            "nSteps : LINT",
            set(),
            {"fb_drive.__getposition", "fb_drive.halt", "fb_fast.area", "main.reset"},
        ),
    ],
)
def test_an_edit_checks_what_has_a_changed_name(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    old: str,
    new: str,
    again: set[str],
    kept_keys: set[str],
) -> None:
    workspace = Workspace(write_project(tmp_path))
    plans: list[RoutinePlan] = []
    settled = plans_module.settled

    def noted(*arguments: object) -> RoutinePlan | None:
        plan = settled(*arguments)  # type: ignore[arg-type]
        assert plan is not None
        plans.append(plan)
        return plan

    monkeypatch.setattr("achse.st.workspace.checked.settled", noted)
    text = FILES[name].replace(old, new)
    assert workspace.edit(tmp_path / name, text.encode()) is Extent.DECLARATIONS
    (plan,) = plans
    assert {one.key for one in plan.again} == again
    assert {one.key for one in plan.unchanged} >= kept_keys
    assert workspace.findings == cold_findings(tmp_path, {tmp_path / name: text})


def test_local_variables_are_their_routine_s_alone(tmp_path: Path) -> None:
    workspace = Workspace(write_project(tmp_path))
    name = "POUs/MAIN.TcPOU"
    text = FILES[name].replace("nOld : DINT", "nOld, nNew : STRING")
    assert workspace.edit(tmp_path / name, text.encode()) is Extent.BODIES
    assert workspace.findings == cold_findings(tmp_path, {tmp_path / name: text})
    assert workspace.findings.errors
    worse = text.replace("STRING", "T_Nothing")
    assert workspace.edit(tmp_path / name, worse.encode()) is Extent.DECLARATIONS
    assert workspace.findings == cold_findings(tmp_path, {tmp_path / name: worse})
    assert workspace.close(tmp_path / name) is Extent.DECLARATIONS
    assert not workspace.findings.errors
