"""`achse test`: results with their lines, exit codes, JUnit XML."""

import logging
from pathlib import Path
from xml.etree import ElementTree as Tree

from typer.testing import CliRunner, Result

from achse.cli.app import app

DATA = Path(__file__).parents[2] / "data" / "unit_tests"
PRESS = DATA / "press"
TCUNIT_STUB = DATA / "tcunit_stub"


def outcome_of(*arguments: object, **environ: str) -> Result:
    return CliRunner().invoke(app, ["test", *map(str, arguments)], env=environ)


def test_failures_with_file_and_line_and_exit_code_1(tmp_path: Path) -> None:
    report = tmp_path / "report.xml"
    result = outcome_of(PRESS, "--library", TCUNIT_STUB, "--junit", report)
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1] == "20 passed, 10 failed in 0.12 s of PLC time"
    assert "FB_TextTests.TcPOU:44: no: expected TRUE, got FALSE" in result.stdout
    assert "mean of two" not in result.stdout
    root = Tree.parse(report).getroot()
    assert (root.attrib["tests"], root.attrib["failures"]) == ("30", "10")


def test_what_passes_is_named_on_request_and_the_variable_finds_the_library() -> None:
    result = outcome_of(PRESS, "-v", ACHSE_TCUNIT=str(TCUNIT_STUB))
    assert "PRG_TEST.fbNumbers: mean of two: passed" in result.stdout


def test_all_well_is_exit_code_0_and_tests_without_end_1(tmp_path: Path) -> None:
    source = tmp_path / "ours.st"
    source.write_text(
        "FUNCTION_BLOCK FB_Ours EXTENDS FB_TestSuite\nTEST('runs');\nTEST_FINISHED();\n"
        "END_FUNCTION_BLOCK\nPROGRAM PRG_TEST\nVAR fbOurs : FB_Ours; END_VAR\nRUN();\nEND_PROGRAM\n"
    )
    result = outcome_of(source, "--library", TCUNIT_STUB)
    assert result.exit_code == 0, result.output
    source.write_text(source.read_text().replace("TEST_FINISHED();", ""))
    endless = outcome_of(source, "--library", TCUNIT_STUB, "--limit", "0.5", "--log-level", "error")
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
            *(PRESS, "--library", TCUNIT_STUB, "--junit", tmp_path / "no" / "report.xml")
        ).stderr
    )
    assert logging.getLogger("achse").level == level


def test_coverage_is_printed_written_and_judged(tmp_path: Path) -> None:
    source = tmp_path / "ours.st"
    source.write_text(
        "FUNCTION F_Sign : INT\nVAR_INPUT n : INT; END_VAR\n"
        "IF n < 0 THEN\nF_Sign := -1;\nELSE\nF_Sign := 1;\nEND_IF\nEND_FUNCTION\n"
        "FUNCTION_BLOCK FB_Ours EXTENDS FB_TestSuite\nVAR n : INT; END_VAR\nTEST('runs');\n"
        "n := F_Sign(5);\nTEST_FINISHED();\nEND_FUNCTION_BLOCK\n"
        "PROGRAM PRG_TEST\nVAR fbOurs : FB_Ours; END_VAR\nRUN();\nEND_PROGRAM\n"
    )
    files = [tmp_path / f"cover{ending}" for ending in (".info", ".xml", ".html", ".txt")]
    reports = [word for file in files for word in ("--coverage-report", file)]
    result = outcome_of(
        source, "--library", TCUNIT_STUB, "--coverage", "--fail-under", 60, *reports
    )
    assert result.exit_code == 0, result.output
    rows = {line.split()[0]: line.split()[1:] for line in result.stdout.splitlines() if line}
    assert rows["F_Sign"] == ["60.0%", "2/3", "1/2", "4,", "3", "TRUE"]
    assert rows["TOTAL"] == ["66.7%", "3/4", "1/2"]
    assert "FB_Ours" not in rows
    texts = [file.read_text(encoding="utf-8") for file in files]
    assert "BRDA:3,0,0,0\nBRDA:3,0,1,1\n" in texts[0]
    assert Tree.fromstring(texts[1]).attrib["lines-valid"] == "4"
    assert texts[2].startswith("<!doctype html>")
    assert texts[3] in result.stdout
    less = outcome_of(source, "--library", TCUNIT_STUB, "--fail-under", 70)
    assert less.exit_code == 1
    assert less.stdout.splitlines()[-1] == "coverage: expected at least 70%, got 66.7%"
    refused = outcome_of(source, "--coverage-report", tmp_path / "cover.pdf")
    assert refused.exit_code == 1
    assert "expected a file that ends in .html, .info" in refused.stderr
