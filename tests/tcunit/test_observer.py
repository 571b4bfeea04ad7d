"""What is seen of a unit-test library while it runs."""

from pathlib import Path

import pytest

from achse.tcunit import run_tests


def test_assertions_in_what_suites_share(tmp_path: Path, tcunit_stub: Path) -> None:
    """The place is the innermost line that is not the library's: in a base, or a function."""
    source = tmp_path / "ours.st"
    source.write_text(
        "FUNCTION_BLOCK FB_Base EXTENDS FB_TestSuite\n"
        "METHOD Shared\n"
        "TEST('shared');\n"
        "AssertTrue(FALSE, 'in the base');\n"
        "TEST_FINISHED();\n"
        "END_METHOD\n"
        "END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK FB_First EXTENDS FB_Base\n"
        "Shared();\n"
        "END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK FB_Second EXTENDS FB_Base\n"
        "Shared();\n"
        "END_FUNCTION_BLOCK\n"
        "PROGRAM PRG_TEST\n"
        "VAR fbFirst : FB_First; aSecond : ARRAY [1..2] OF FB_Second; END_VAR\n"
        "RUN();\n"
        "END_PROGRAM\n"
    )
    run = run_tests(source, libraries=[tcunit_stub])
    assert [suite.name for suite in run.suites] == [
        "PRG_TEST.fbFirst",
        "PRG_TEST.aSecond[1]",
        "PRG_TEST.aSecond[2]",
    ]
    for test in run:
        assert test.place is not None
        assert test.place.line == 3
        (failure,) = test.failures
        assert failure.place is not None
        assert failure.place.line == 4


def test_many_failures_of_one_test_are_bounded(
    tmp_path: Path, tcunit_stub: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("achse.tcunit.observer._MOST_FAILURES", 5)
    source = tmp_path / "ours.st"
    source.write_text(
        "FUNCTION_BLOCK FB_Ours EXTENDS FB_TestSuite\nTEST('fails');\n"
        "AssertTrue(FALSE, 'each cycle');\nEND_FUNCTION_BLOCK\n"
        "PROGRAM PRG_TEST\nVAR fbOurs : FB_Ours; END_VAR\nRUN();\nEND_PROGRAM\n"
    )
    (test,) = run_tests(source, libraries=[tcunit_stub], limit=0.2)
    assert len(test.failures) == 5


@pytest.mark.parametrize("name", ["FB_TcUnitRunner", "FB_Test", "FB_AdsAssertMessageFormatter"])
def test_suite_with_a_name_of_the_library_keeps_its_places(
    tmp_path: Path, tcunit_stub: Path, name: str
) -> None:
    source = tmp_path / "ours.st"
    source.write_text(
        f"FUNCTION_BLOCK {name} EXTENDS FB_TestSuite\nTEST('a');\n"
        "AssertTrue(FALSE, 'no');\nTEST_FINISHED();\nEND_FUNCTION_BLOCK\n"
        f"PROGRAM MAIN VAR s : {name}; END_VAR\nTcUnit.RUN(); END_PROGRAM\n"
    )
    (test,) = run_tests(source, libraries=[tcunit_stub])
    assert [(each.message, each.place and each.place.line) for each in test.failures] == [("no", 3)]
    assert test.place is not None
    assert test.place.line == 2
