"""`achse fleet export` prints what `achse.fleet.export` makes, or what is wrong with the file."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from achse.cli.app import app


@pytest.fixture
def file(tmp_path: Path) -> str:
    (tmp_path / "t.toml").write_text("")
    file = tmp_path / "fleet.toml"
    file.write_text(
        'template = "t.toml"\ncount = 2\nnet_id = "5.1.1.1.1.1"\n'
        '[mqtt]\nbroker = "127.0.0.1"\ntopic = "t"\n'
    )
    return str(file)


@pytest.mark.parametrize(
    ("kind", "word"), [("compose", "services:"), ("kubernetes", "StatefulSet")]
)
def test_both_kinds(file: str, kind: str, word: str) -> None:
    words = ("fleet", "export", kind, file, "--image", "here/achse:1")
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert word in result.stdout
    assert '"here/achse:1"' in result.stdout
    as_json = json.loads(CliRunner().invoke(app, (*words, "--json")).stdout)
    assert as_json == {"kind": kind, "text": result.stdout}


def test_a_fault_of_the_file(file: str) -> None:
    Path(file).write_text("count = 0\n")
    result = CliRunner().invoke(app, ("fleet", "export", "compose", file))
    assert result.exit_code == 1
    assert "fleet.toml:1: count" in result.stderr
    result = CliRunner().invoke(app, ("fleet", "export", "compose", f"{file}.gone"))
    assert "No such file" in result.stderr
