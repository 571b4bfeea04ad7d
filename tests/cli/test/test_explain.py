"""`achse explain` shows what a code means, or lists all codes."""

import json

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app
from achse.st.lexis.codes import Code


def explained(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["explain", *arguments])


@pytest.mark.parametrize("code", Code)
def test_each_code_is_explained(code: Code) -> None:
    lines = explained(code.lower()).stdout.splitlines()
    assert lines[0].startswith(f"{code}  ")
    assert lines[-1] == f"reference/{code}/"
    document = json.loads(explained(code, "--json").stdout)
    assert document["code"] == code
    assert f"Remedy: {document['remedy']}" in lines


def test_codes_are_listed() -> None:
    lines = explained().stdout.splitlines()
    assert [line.split()[0] for line in lines] == [code.value for code in Code]
    assert [row["code"] for row in json.loads(explained("--json").stdout)] == list(Code)


def test_a_site_makes_the_link_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ACHSE_DOCS", "https://docs.example/achse")
    assert explained("ST4101").stdout.endswith("https://docs.example/achse/reference/ST4101/\n")


def test_an_unknown_code_is_refused_with_the_nearest() -> None:
    result = explained("ST410")
    assert result.exit_code == 1
    assert "expected the code of a finding, like ST4101, got 'ST410'" in result.stderr
    assert "did you mean 'ST410" in result.stderr
