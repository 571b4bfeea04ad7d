"""`achse sweep`: a table, a file, mistakes."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app

SOURCE = """
def run(*, gain: float, seed: int) -> dict[str, float]:
    if gain == 3:
        raise ValueError("three")
    return {"value": gain + seed, "kind": "even" if seed % 2 == 0 else "odd"}
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    file = tmp_path / "scenario.py"
    file.write_text(SOURCE)
    return file


def run(*arguments: str, exit_code: int = 0) -> Any:
    result = CliRunner().invoke(app, ("sweep", *arguments), env={"COLUMNS": "100"})
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


def test_a_table_for_people(scenario: Path) -> None:
    output = run(
        *(str(scenario), "--param", "gain=1:3:3", "--seeds", "3", "--workers", "0")
    ).stdout.splitlines()
    assert output[0].split() == ["gain", "runs", "value", "kind"]
    assert output[1].split() == ["1", "3", "2", "(1", "…", "3)", "even"]
    assert output[3] == "run 6 failed: ValueError: three"
    assert output[6].startswith("9 runs, 3 failed, ")
    assert output[-1] == str(scenario.with_suffix(".parquet"))
    assert scenario.with_suffix(".parquet").exists()


def test_facts_for_programs(scenario: Path, tmp_path: Path) -> None:
    file = tmp_path / "x.parquet"
    result = run(str(scenario), "--param", "gain=1", "--out", str(file), "--workers", "0", "--json")
    facts = json.loads(result.stdout)
    assert (facts["runs"], facts["failed"], facts["file"]) == (1, 0, str(file))
    assert len(facts["digest"]) == 64


def test_mistakes(scenario: Path, tmp_path: Path) -> None:
    assert "name=from:to:count" in run(str(scenario), "--param", "gain", exit_code=2).stderr
    twice = run(str(scenario), "--param", "a=1", "--param", "a=2", exit_code=2)
    assert "each parameter once" in twice.stderr
    none = run(str(tmp_path / "none.py"), "--workers", "0", exit_code=1)
    assert "No such file" in none.stderr
    missing = run(str(scenario), "--function", "walk", "--workers", "0", exit_code=1)
    assert "has no function walk" in missing.stderr
