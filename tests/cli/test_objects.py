"""`achse drive list|show`: what the drive's dictionary holds; complaints."""

import json

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app
from achse.drive.objects import ROWS


def _achse(*arguments: str, exit_code: int = 0) -> Result:
    result = CliRunner().invoke(app, ["drive", *arguments])
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


def test_the_list_has_a_line_for_every_entry() -> None:
    heading, *lines = _achse("list").stdout.splitlines()
    assert heading.split() == ["index", "type", "access", "pdo", "default", "unit", "name"]
    assert [line.split()[0] for line in lines] == [
        f"{row.index:04X}:{row.subindex:02X}" for row in ROWS
    ]


def test_the_list_can_be_narrowed_and_printed_as_json() -> None:
    facts = json.loads(_achse("list", "0x607", "--json").stdout)
    assert {fact["index"][:5] for fact in facts} == {"0x607"}
    [target] = [fact for fact in facts if fact["index"] == "0x607A"]
    assert (target["name"], target["type"], target["pdo"]) == (
        "Target position",
        "I32",
        ["Rx", "Tx"],
    )


def test_one_entry_is_shown_with_all_that_is_known() -> None:
    shown = dict(line.split(None, 1) for line in _achse("show", "1C32:02").stdout.splitlines())
    assert (shown["index"], shown["subindex"], shown["unit"]) == ("0x1C32", "2", "ns")
    assert "minimum" in shown


def test_an_object_is_shown_with_its_entries() -> None:
    facts = json.loads(_achse("show", "1018h", "--json").stdout)
    assert [fact["default"] for fact in facts[:3]] == [4, 0xAAAA, 5]


@pytest.mark.parametrize("arguments", [("show", "5FFF"), ("show", "6041:7"), ("list", "F")])
def test_what_the_drive_does_not_have(arguments: tuple[str, ...]) -> None:
    assert "achse drive list" in _achse(*arguments, exit_code=1).stderr


@pytest.mark.parametrize("entry", ["speed", "", "12345", "6041:", "6041:100"])
def test_an_entry_that_is_no_number(entry: str) -> None:
    assert "hexadecimal" in _achse("show", entry, exit_code=2).stderr
