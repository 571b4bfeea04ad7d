"""Results of unit tests: what counts as good, and how they are worded."""

from achse.tcunit.results import CodePlace, Failure, Suite, TestOutcome, TestRun, UnitTest


def test_a_run_is_good_with_tests_that_pass_or_are_disabled() -> None:
    passed = UnitTest("PRG.fb", "adds", TestOutcome.PASSED)
    skipped = UnitTest("PRG.fb", "later", TestOutcome.SKIPPED)
    run = TestRun([Suite("PRG.fb", [passed, skipped])], 0.02)
    assert run.is_good
    assert str(run) == "1 passed, 1 skipped in 0.02 s of PLC time"
    assert not TestRun([Suite("PRG.fb", [passed])], 0.02, "the PLC stopped").is_good


def test_a_run_is_bad_with_no_test_or_a_failure() -> None:
    assert not TestRun().is_good
    assert str(TestRun()) == "no tests in 0 s of PLC time"
    for outcome in (TestOutcome.FAILED, TestOutcome.UNFINISHED):
        run = TestRun([Suite("PRG.fb", [UnitTest("PRG.fb", "adds", outcome)])])
        assert not run.is_good
        assert run.count(outcome) == 1


def test_failures_say_what_was_expected() -> None:
    assert str(Failure("sum", "4", "5")) == "sum: expected 4, got 5"
    assert str(Failure("", "4", "")) == "expected 4, got "
    assert str(Failure("sum")) == "sum"
    assert str(Failure("")) == "failed"


def test_places() -> None:
    assert str(CodePlace("press.st", 3)) == "press.st:3"
    assert str(CodePlace("press.st", 0)) == "press.st"
