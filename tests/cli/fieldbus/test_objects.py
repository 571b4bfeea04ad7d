"""`achse drive objects`: the dictionary of the drive, one object, and objects it does not have."""

import json

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app
from achse.drive.identity import PRODUCT, VENDOR
from achse.drive.objects import ROWS


def _achse(*arguments: str, exit_code: int = 0) -> Result:
    result = CliRunner().invoke(app, ["drive", "objects", *arguments])
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


def test_the_list_has_a_line_for_every_entry() -> None:
    heading, *lines = _achse().stdout.splitlines()
    assert heading.split() == ["index", "type", "access", "pdo", "default", "unit", "name"]
    assert [line.split()[0] for line in lines] == [
        f"{row.index:04X}:{row.subindex:02X}" for row in ROWS
    ]


def test_the_list_can_be_narrowed_and_printed_as_json() -> None:
    facts = json.loads(_achse("0x607", "--json").stdout)
    assert {fact["index"][:5] for fact in facts} == {"0x607"}
    [target] = [fact for fact in facts if fact["index"] == "0x607A"]
    assert (target["name"], target["type"], target["pdo"]) == (
        "Target position",
        "I32",
        ["Rx", "Tx"],
    )


def test_one_entry_is_shown_with_all_that_is_known() -> None:
    shown = dict(line.split(None, 1) for line in _achse("1C32:02").stdout.splitlines())
    assert (shown["index"], shown["subindex"], shown["unit"]) == ("0x1C32", "2", "ns")
    assert "minimum" in shown


def test_an_object_is_shown_with_its_entries() -> None:
    facts = json.loads(_achse("1018h", "--json").stdout)
    assert [fact["default"] for fact in facts[:3]] == [4, VENDOR, PRODUCT]


@pytest.mark.parametrize("arguments", [("5FFF",), ("6041:7",), ("F",)])
def test_what_the_drive_does_not_have(arguments: tuple[str, ...]) -> None:
    assert "achse drive objects" in _achse(*arguments, exit_code=1).stderr


@pytest.mark.parametrize(
    ("entry", "same"),
    [
        ("Statusword", "6041:0"),
        ("position ACTUAL value", "6064"),
        ("target_position", "607A"),
        ("Identity object", "1018"),
        ("identity object: vendor id", "1018:1"),
    ],
)
def test_an_object_by_its_name(entry: str, same: str) -> None:
    assert _achse(entry).stdout == _achse(same).stdout


@pytest.mark.parametrize(
    ("words", "code", "hint"),
    [
        (("Contolword",), 1, "did you mean 'Controlword'?"),
        (("wombat",), 1, "see `achse drive objects`"),
    ],
)
def test_near_names_of_objects_are_offered(words: tuple[str, ...], code: int, hint: str) -> None:
    stderr = _achse(*words, exit_code=code).stderr
    assert hint in " ".join(stderr.replace("│", " ").split())


def test_the_list_can_be_searched_by_name() -> None:
    _, *lines = _achse("target pos").stdout.splitlines()
    assert [line.split()[0] for line in lines] == ["3058:00", "607A:00"]
    assert len(_achse("dec").stdout.splitlines()) > 3  # of deceleration


@pytest.mark.parametrize("entry", ["12345", "6041:", "6041:100"])
def test_an_entry_that_is_no_number(entry: str) -> None:
    assert "hexadecimal" in _achse(entry, exit_code=2).stderr
