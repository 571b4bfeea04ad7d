"""Runs with and without a fault, their limits, and what they leave of the project."""

from pathlib import Path

import pytest

from achse.tcunit.bench import TestBench
from achse.tcunit.mutation.operators import Mutant, mutants_of
from achse.tcunit.mutation.trials import Trial, TrialLimits, base_run, try_mutant
from achse.tcunit.results import TestOutcome
from tests.tcunit.mutation.conftest import CLAMP


@pytest.fixture
def bench(tcunit_stub: Path) -> TestBench:
    return TestBench.of(CLAMP, [tcunit_stub], coverage=True)


def mutant_of(bench: TestBench, key: str, change: str) -> Mutant:
    routine = bench.plcs[0].routines[key]
    return next(one for one in mutants_of(routine) if one.change == change)


def test_a_run_without_a_fault(bench: TestBench) -> None:
    base = base_run(bench, 5.0)
    assert base.problem == ""
    assert base.outcomes[0, "PRG_TEST.fbClamp", "stays"] is TestOutcome.PASSED
    assert base.outcomes[0, "PRG_TEST.fbCount", "wrong"] is TestOutcome.FAILED
    assert base.suites == ({1: "PRG_TEST.fbClamp", 2: "PRG_TEST.fbCount"},)
    assert 0 < base.seconds < 1
    assert 0 < base.spent < 1000


@pytest.mark.parametrize("resets", [False, True])
def test_a_suite_alone_gives_the_same(bench: TestBench, resets: bool) -> None:
    base = base_run(bench, 5.0, (0, 2), resets=resets)
    assert {suite: test for _, suite, test in base.outcomes} == {"PRG_TEST.fbCount": "wrong"}
    assert base.outcomes[0, "PRG_TEST.fbCount", "counts"] is TestOutcome.PASSED


PASSING = frozenset({(0, "PRG_TEST.fbClamp", "stays"), (0, "PRG_TEST.fbCount", "counts")})


@pytest.mark.parametrize(
    ("key", "change", "chosen", "resets", "noticed"),
    [
        ("f_clamp", "> becomes <=", [1], False, "PRG_TEST.fbClamp: stays"),
        ("f_clamp", "> becomes >=", [1], False, ""),
        ("fb_count", "+ becomes -", None, False, "PRG_TEST.fbCount: counts"),
        ("fb_count.fb_init", "10 becomes 9", None, True, "PRG_TEST.fbCount: counts"),
        ("fb_count.fb_init", "10 becomes 9", None, False, ""),
    ],
)
def test_who_notices_a_fault(
    bench: TestBench, key: str, change: str, chosen: list[int] | None, resets: bool, noticed: str
) -> None:
    mutant = mutant_of(bench, key, change)
    passing = PASSING if chosen is None else frozenset(t for t in PASSING if "Clamp" in t[1])
    trial = try_mutant(bench, 0, mutant, chosen, passing, TrialLimits(5.0), resets=resets)
    assert trial == Trial(noticed)


def test_what_is_endless_is_stopped(bench: TestBench) -> None:
    mutant = mutant_of(bench, "f_sum", "+ becomes -")
    trial = try_mutant(bench, 0, mutant, [2], PASSING, TrialLimits(5.0, 5000))
    assert trial.is_out_of_time
    assert "5000 loop passes" in trial.noticed
