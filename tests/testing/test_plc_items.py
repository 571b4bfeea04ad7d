"""Unit tests of a PLC project as pytest's items, in a pytest run of its own."""

from pathlib import Path

from tests.warm_commands import WarmCommands

DATA = Path(__file__).parents[1] / "data" / "unit_tests"

SOURCE = """
FUNCTION_BLOCK FB_Ours EXTENDS FB_TestSuite
TEST('adds');
AssertTrue(1 + 1 = 2, 'sum');
TEST_FINISHED();
TEST('fails');
AssertTrue(1 + 1 = 3, 'wrong sum');
TEST_FINISHED();
TEST('disabled_later');
TEST_FINISHED();
TEST('left_out');
TEST_FINISHED();
TEST('never ends');
END_FUNCTION_BLOCK
PROGRAM PRG_TEST
VAR
    fbOurs : FB_Ours;
END_VAR
RUN();
END_PROGRAM
"""


WARNINGS = ("-W", "error", "-W", "ignore::pytest.PytestAssertRewriteWarning")
"""In a process that is forked, achse is loaded before pytest could rewrite its assertions."""


def run(commands: WarmCommands, folder: Path, *arguments: str) -> str:
    """Return what pytest prints."""
    words = ("-m", "pytest", "-q", *WARNINGS, "-rA", *arguments)
    return commands.run(*words, cwd=folder).stdout


def test_a_project_named_in_the_configuration(tmp_path: Path, warm_commands: WarmCommands) -> None:
    (tmp_path / "ours.st").write_text(SOURCE)
    (tmp_path / "other.st").write_text("nonsense")
    (tmp_path / "pytest.ini").write_text(
        f"[pytest]\nachse_plc_tests = ours.st\nachse_plc_libraries = {DATA / 'tcunit_stub'}\n"
    )
    out = run(warm_commands, tmp_path, "-k", "not left_out")
    assert "3 failed, 1 passed, 1 skipped, 1 deselected" in out, out
    assert "ours.st:7: wrong sum: expected TRUE, got FALSE" in out
    assert "not all tests ended within 60 s of PLC time" in out
    assert "TEST_FINISHED() was not called" in out
    assert "PRG_TEST.fbOurs::adds" in out
    assert "Traceback" not in out


def test_a_project_named_on_the_command_line(tmp_path: Path, warm_commands: WarmCommands) -> None:
    (tmp_path / "ours.st").write_text(SOURCE)
    (tmp_path / "other.st").write_text("nonsense")
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    out = run(warm_commands, tmp_path, "ours.st")
    assert "other.st" not in out
    assert "get its sources (github.com/tcunit/TcUnit" in out
