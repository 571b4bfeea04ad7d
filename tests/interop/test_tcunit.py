"""TcUnit's own sources, unmodified, give the results that the stub for it gives.

TcUnit is in no package registry: where ACHSE_TCUNIT names its sources this runs.
"""

import os
from pathlib import Path

import pytest

from achse.tcunit import TestRun, run_tests
from achse.tcunit.locate import VARIABLE
from achse.tcunit.results import TestOutcome

DATA = Path(__file__).parents[1] / "data" / "unit_tests"


@pytest.fixture(scope="module")
def run() -> TestRun:
    if not os.environ.get(VARIABLE):
        pytest.skip(f"{VARIABLE} does not name the sources of TcUnit (github.com/tcunit/TcUnit)")
    return run_tests(DATA / "press")


def test_thirty_tests_ten_fail(run: TestRun) -> None:
    assert (run.count(TestOutcome.PASSED), run.count(TestOutcome.FAILED), len(list(run))) == (
        20,
        10,
        30,
    )
    assert not run.problem


def test_names_messages_and_places_are_those_of_the_stub(run: TestRun) -> None:
    expected = list(run_tests(DATA / "press", libraries=[DATA / "tcunit_stub"]))
    for test, other in zip(run, expected, strict=True):
        assert (test.suite, test.name, test.outcome) == (other.suite, other.name, other.outcome)
        assert test.place == other.place
        assert list(test.failures) == list(other.failures)


def test_durations_are_plc_time(run: TestRun) -> None:
    waiting = next(test for test in run if test.name == "down after 100 ms")
    assert waiting.duration == pytest.approx(0.1)
