"""A campaign over a project whose outcomes are known: what survives, and what runs with what."""

from collections import Counter
from pathlib import Path

import pytest

from achse.tcunit.bench import ProjectError
from achse.tcunit.mutation import campaign
from achse.tcunit.mutation.campaign import run_mutants
from achse.tcunit.mutation.marks import MutationOptions
from achse.tcunit.mutation.results import MutantOutcome, MutationRun
from tests.tcunit.mutation.conftest import CLAMP


@pytest.fixture(scope="module")
def run() -> MutationRun:
    return run_mutants(CLAMP, libraries=[CLAMP.parents[1] / "unit_tests" / "tcunit_stub"], jobs=2)


def test_outcomes(run: MutationRun) -> None:
    rows = {(one.line, one.change): one for one in run.mutants}
    survived = [key for key, one in rows.items() if one.outcome is MutantOutcome.SURVIVED]
    assert survived == [
        (6, "> becomes >="),
        (8, "condition becomes FALSE"),
        (8, "< becomes <="),
        (8, "0 becomes 1"),
        (8, "0 becomes -1"),
    ]
    lines = Counter(one.line for one in run.mutants if one.outcome is MutantOutcome.NOT_COVERED)
    assert lines == {9: 3, 27: 3}
    assert {key[0] for key, one in rows.items() if one.outcome is MutantOutcome.EQUIVALENT} == {26}
    endless = rows[23, "statement removed"]
    assert endless.outcome is MutantOutcome.TIMEOUT
    assert "CYCLE_TIME_EXCEED" in endless.test
    # FB_init runs before the first cycle: after a reset, and with all tests that pass
    start = rows[45, "10 becomes 11"]
    assert (start.test, start.tests) == ("PRG_TEST.fbCount: counts", 4)
    assert rows[7, "statement removed"].tests == 2
    assert run.failing == ["PRG_TEST.fbCount: wrong"]
    assert run.planted == len(run.mutants)


def test_a_draw_is_part_of_all(run: MutationRun, tcunit_stub: Path) -> None:
    drawn = run_mutants(CLAMP, libraries=[tcunit_stub], sample=9, seed=4)
    wanted = {(one.line, one.change): (one.outcome, one.test) for one in run.mutants}
    assert len(drawn.mutants) == 9
    assert drawn.planted == run.planted
    for one in drawn.mutants:
        assert wanted[one.line, one.change] == (one.outcome, one.test)


def test_where_no_process_can_be_copied_each_mutant_is_loaded(
    run: MutationRun, tcunit_stub: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(campaign, "CAN_FORK", False)
    drawn = run_mutants(
        CLAMP,
        libraries=[tcunit_stub],
        sample=4,
        options=MutationOptions(exclude=("F_*",)),
    )
    wanted = {(one.line, one.change): one.outcome for one in run.mutants}
    assert {one.routine for one in drawn.mutants} == {"FB_Count", "FB_Count.FB_init"}
    assert all(wanted[one.line, one.change] is one.outcome for one in drawn.mutants)


SHARED = """VAR_GLOBAL
    nShared : INT;
END_VAR
FUNCTION F_Next : INT
nShared := nShared + 1;
F_Next := nShared;
END_FUNCTION
FUNCTION_BLOCK FB_First EXTENDS FB_TestSuite
TEST('first');
AssertEquals_DINT(1, F_Next(), 'one');
TEST_FINISHED();
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Second EXTENDS FB_TestSuite
TEST('second');
AssertEquals_DINT(2, F_Next(), 'two');
TEST_FINISHED();
END_FUNCTION_BLOCK
PROGRAM PRG_TEST
VAR fbFirst : FB_First; fbSecond : FB_Second; END_VAR
RUN();
END_PROGRAM
"""


def test_suites_that_need_others_run_with_all(tmp_path: Path, tcunit_stub: Path) -> None:
    source = tmp_path / "shared.st"
    source.write_text(SHARED)
    run = run_mutants(source, libraries=[tcunit_stub])
    assert run.dependent == ["PRG_TEST.fbSecond"]
    assert {one.tests for one in run.mutants} == {2}
    assert run.score.percent == 100.0


@pytest.mark.parametrize(
    ("test", "message"),
    [
        ("AssertTrue(FALSE, 'no'); TEST_FINISHED();", "no test passes without any fault"),
        ("i := 1 / i; TEST_FINISHED();", "without any fault: exception DIVIDEBYZERO"),
        (";", "without any fault: not all tests ended within 0.05 s of PLC time"),
    ],
)
def test_projects_whose_tests_cannot_notice(
    tmp_path: Path, tcunit_stub: Path, test: str, message: str
) -> None:
    source = tmp_path / "ours.st"
    source.write_text(
        "FUNCTION_BLOCK FB_Ours EXTENDS FB_TestSuite\nVAR i : INT; END_VAR\n"
        f"TEST('runs'); {test}\nEND_FUNCTION_BLOCK\n"
        "PROGRAM PRG_TEST\nVAR fbOurs : FB_Ours; END_VAR\nRUN();\nEND_PROGRAM\n"
    )
    with pytest.raises(ProjectError, match=message):
        run_mutants(source, libraries=[tcunit_stub], limit=0.05)
