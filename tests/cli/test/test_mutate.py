"""`achse mutate`: what it prints and writes, exit codes, refusals."""

import json
from pathlib import Path

from typer.testing import CliRunner, Result

from achse.cli.app import app

DATA = Path(__file__).parents[2] / "data"
CLAMP = DATA / "mutation" / "clamp.st"
TCUNIT_STUB = DATA / "unit_tests" / "tcunit_stub"


def outcome_of(*arguments: object) -> Result:
    words = ["mutate", *map(str, arguments), "--library", str(TCUNIT_STUB)]
    return CliRunner().invoke(app, words)


def test_survivors_reports_and_exit_codes(tmp_path: Path) -> None:
    report = tmp_path / "mutants.json"
    result = outcome_of(CLAMP, "-j", "2", "--report", report, "--fail-under", "70")
    assert result.exit_code == 1
    assert "clamp.st:6: survived: F_Clamp: > becomes >=" in result.stdout
    assert "TOTAL 65.6% noticed, 80.8% of what tests run" in result.stdout
    assert "mutants noticed: expected at least 70%, got 65.6%" in result.stdout
    (file,) = json.loads(report.read_text(encoding="utf-8"))["files"].values()
    assert len(file["mutants"]) == 38
    drawn = outcome_of(CLAMP, "--sample", "3", "-v", "--fail-under", "0")
    assert drawn.exit_code == 0
    assert "3 of 38 mutants" in drawn.stdout


def test_refusals(tmp_path: Path) -> None:
    assert "expected a file that ends in" in outcome_of(CLAMP, "--report", "a.xml").stderr
    assert "does not exist" in outcome_of(tmp_path / "none").stderr
    (tmp_path / "clamp.st").write_text(CLAMP.read_text(encoding="utf-8"))
    (tmp_path / "achse.toml").write_text("[mutate]\nexclude = 1\n")
    assert "expected a list of texts" in outcome_of(tmp_path / "clamp.st").stderr
    unwritable = outcome_of(CLAMP, "--sample", "1", "--report", tmp_path / "no" / "a.txt")
    assert unwritable.exit_code == 1
    assert "No such file" in unwritable.stderr
