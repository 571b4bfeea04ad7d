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


@pytest.mark.parametrize(
    ("word", "near"), [("ST410", "ST410"), ("MC_MoveAbsolut", "MC_MoveAbsolute'")]
)
def test_an_unknown_code_is_refused_with_the_nearest(word: str, near: str) -> None:
    result = explained(word)
    assert result.exit_code == 1
    assert "expected ST4101, 0x4655 or the name of a PLC library's block, got" in result.stderr
    assert f"did you mean '{near}" in result.stderr


def test_error_code_has_its_remedy() -> None:
    name, remedy, link = explained("0x4A18").stdout.splitlines()
    assert name.startswith("0x4A18  TABLE_SLAVE_RANGE  ")
    assert remedy.startswith("remedy: the slave would jump: ")
    assert link == "reference/0x4A18/"
    shown = json.loads(explained("1", "--json").stdout)
    assert (shown["name"], shown["remedy"]) == ("INTERNAL_ERROR", None)
    assert "no table has the code 0xABCDEF" in explained("0xabcdef").stderr


def test_name_of_a_library_is_explained() -> None:
    printed = explained("mc_moveabsolute").stdout
    assert printed.startswith("MC_MoveAbsolute  function block of tc2_mc2  ")
    assert "\ninputs: Execute, " in printed.replace("Axis, Execute", "Execute")
    assert printed.endswith("plc-library-tc2_mc2/#MC_MoveAbsolute\n")
    assert json.loads(explained("MC_Power", "--json").stdout)["library"] == "tc2_mc2"
