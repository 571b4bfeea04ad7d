"""`achse test`: results with their lines, exit codes, JUnit XML."""

import logging
from pathlib import Path
from xml.etree import ElementTree as Tree

from typer.testing import CliRunner, Result

from achse.cli.app import app

DATA = Path(__file__).parents[2] / "data" / "unit_tests"
PRESS = DATA / "press"
STANDIN = DATA / "standin"


def outcome_of(*arguments: object, **environ: str) -> Result:
    return CliRunner().invoke(app, ["test", *map(str, arguments)], env=environ)


def test_failures_with_file_and_line_and_exit_code_1(tmp_path: Path) -> None:
    report = tmp_path / "report.xml"
    result = outcome_of(PRESS, "--library", STANDIN, "--junit", report)
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1] == "20 passed, 10 failed in 0.12 s of PLC time"
    assert "FB_TextTests.TcPOU:44: no: expected TRUE, got FALSE" in result.stdout
    assert "mean of two" not in result.stdout
    root = Tree.parse(report).getroot()
    assert (root.attrib["tests"], root.attrib["failures"]) == ("30", "10")


def test_what_passes_is_named_on_request_and_the_variable_finds_the_library() -> None:
    result = outcome_of(PRESS, "-v", ACHSE_TCUNIT=str(STANDIN))
    assert "PRG_TEST.fbNumbers: mean of two: passed" in result.stdout


def test_all_well_is_exit_code_0_and_tests_without_end_1(tmp_path: Path) -> None:
    source = tmp_path / "ours.st"
    source.write_text(
        "FUNCTION_BLOCK FB_Ours EXTENDS FB_TestSuite\nTEST('runs');\nTEST_FINISHED();\n"
        "END_FUNCTION_BLOCK\nPROGRAM PRG_TEST\nVAR fbOurs : FB_Ours; END_VAR\nRUN();\nEND_PROGRAM\n"
    )
    result = outcome_of(source, "--library", STANDIN)
    assert result.exit_code == 0, result.output
    source.write_text(source.read_text().replace("TEST_FINISHED();", ""))
    endless = outcome_of(source, "--library", STANDIN, "--limit", "0.5", "--log-level", "error")
    assert endless.exit_code == 1
    assert "ours.st:2: TEST_FINISHED() was not called" in endless.stdout
    assert "error: not all tests ended within 0.5 s of PLC time" in endless.stdout


def test_without_the_library_or_the_project_it_says_what_to_do(tmp_path: Path) -> None:
    level = logging.getLogger("achse").level
    missing = outcome_of(PRESS, ACHSE_TCUNIT="")
    assert missing.exit_code == 1
    assert "get its sources (github.com/tcunit/TcUnit" in missing.stderr
    assert "does not exist" in outcome_of(tmp_path / "none").stderr
    assert (
        "report.xml"
        in outcome_of(
            *(PRESS, "--library", STANDIN, "--junit", tmp_path / "no" / "report.xml")
        ).stderr
    )
    assert logging.getLogger("achse").level == level
