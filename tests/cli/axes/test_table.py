"""`achse table`: tables come from files, are shown, drawn, checked, and go to files."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Lines = Callable[..., list[str]]
Document = Callable[..., Any]
Cli = Callable[..., Any]

STROKE = "master,slave,law\n0,0,5\n180,100,0\n"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "stroke.csv"
    file.write_text(STROKE)
    return file


def test_from_a_file_and_back(lines: Lines, document: Document, file: Path, tmp_path: Path) -> None:
    assert lines("table", "import", "77", str(file), "--replace") == [
        "table 77: motion function, 2 rows"
    ]
    assert any(line.split()[0] == "77" for line in lines("table", "show"))
    assert [each["kind"] for each in document("table", "show") if each["id"] == 77] == [
        "motion function"
    ]
    title, names, *rows = lines("table", "show", "77")
    assert title.startswith("77 Table 77: linear motion function")
    assert names.split()[:3] == ["master", "slave", "law"]
    assert rows[1].split()[:2] == ["180", "100"]
    shown = document("table", "show", "77")
    assert shown["content"][0]["law"] == 5
    out = tmp_path / "out.csv"
    assert lines("table", "show", "77", "--to", str(out)) == [f"{out}: 2 rows"]
    assert document("table", "import", "78", str(out), "--cyclic", "--replace")["cyclic"]
    assert document("table", "show", "78")["content"] == shown["content"]


def test_checks_of_a_table_of_the_nc(cli: Cli, file: Path) -> None:
    cli("table", "import", "77", str(file), "--replace")
    report = json.loads(
        cli(
            "table", "check", "77", "-v", "720", "--max-velocity", "700", "--json", exit_code=1
        ).stdout
    )
    assert report["extremes"]["velocity"]["most"] == pytest.approx(750.0)
    assert [each["quantity"] for each in report["violations"]] == ["velocity"]
    assert not report["ok"]
    stdout = cli("table", "check", "77", "-v", "1e6", "--axis", "X", exit_code=1).stdout
    assert "velocity" in stdout
    assert "is beyond its limit" in stdout
    cli("table", "check", "77", "-v", "0.001", "--axis", "X", "--max-position", "200")


def test_a_file_needs_no_station(cli: Cli, file: Path) -> None:
    stdout = cli("table", "check", str(file), "--tcp-port", "1").stdout
    assert stdout.splitlines()[1].split()[0] == "velocity"
    drawing = ("table", "check", str(file), "--tcp-port", "1", "--plot")
    drawn = cli(*drawing, "--max-velocity", "0.1", exit_code=1).stdout
    assert "beyond its limit" in drawn
    report = json.loads(cli(*drawing, "--json").stdout)
    assert len(report["jerk"]) == len(report["master"])


def test_pictures(cli: Cli, file: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "stroke.svg"
    assert cli("table", "check", str(file), "--out", str(out)).stdout.splitlines()[-1] == str(out)
    assert out.read_text().startswith("<?xml")


def test_refusals_are_sentences(cli: Cli, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.csv"
    wrong.write_text("0 0 16\n1 1 0\n")
    for arguments in (
        ("show", "4000"),
        ("show", "4000", "--to", str(tmp_path / "x.csv")),
        ("check", "4000", "--plot"),
        ("check", "9999"),
        ("check", str(tmp_path / "none.csv")),
        ("check", str(wrong)),
        ("import", "79", str(wrong)),
        ("check", str(wrong), "--axis", "XX"),
    ):
        result = cli("table", *arguments, exit_code=1)
        assert result.stderr
        assert "Traceback" not in result.stderr
    assert "79" not in [line.split()[0] for line in cli("table", "show").stdout.splitlines()]
