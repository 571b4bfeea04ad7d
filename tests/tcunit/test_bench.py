"""A loaded station: its suites, which of them run, and what runs them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.tcunit.bench import ProjectError, TestBench


@pytest.fixture
def bench(press: Path, tcunit_stub: Path) -> TestBench:
    return TestBench.of(press, [tcunit_stub])


def test_suites_by_number_and_address(bench: TestBench) -> None:
    (tests,) = bench.plcs
    assert list(tests.suite_names.values()) == [
        *("PRG_TEST.fbNumbers", "PRG_TEST.fbTexts", "PRG_TEST.fbPress")
    ]
    assert sorted(tests.suite_numbers.values()) == [1, 2, 3]
    assert tests.suite_blocks == {
        *("fb_testsuite", "fb_numbertests", "fb_texttests", "fb_presstests")
    }


def test_chosen_suites_alone_run(bench: TestBench) -> None:
    (tests,) = bench.plcs
    seen = []

    def noted(function: Callable[..., Any]) -> Callable[..., Any]:
        def run(this: int) -> Any:
            seen.append(this)
            return function(this)

        return run

    numbers = tests.suite_numbers
    tests.wrap_suites(noted)
    tests.choose([2])
    run = bench.run(5.0, 60.0, None)
    assert [suite.name for suite in run.suites] == ["PRG_TEST.fbTexts"]
    assert {numbers[this] for this in seen} == {2}
    failing = frozenset({("PRG_TEST.fbTexts", "find from zero"), ("PRG_TEST.fbTexts", "left")})
    assert tests.failed_test(failing) == ("PRG_TEST.fbTexts", "find from zero")
    assert tests.failed_test(failing - {("PRG_TEST.fbTexts", "find from zero")}) is None


def test_the_program_that_runs_tests(bench: TestBench) -> None:
    (tests,) = bench.plcs
    assert [key for key, one in tests.routines.items() if tests.runs_tests(one)] == ["prg_test"]


def test_a_project_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ProjectError, match="does not exist"):
        TestBench.of(tmp_path / "none", [])
