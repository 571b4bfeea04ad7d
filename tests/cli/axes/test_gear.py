"""`achse axis couple` and `decouple`: an axis follows another one."""

from collections.abc import Callable
from typing import Any

import pytest

Lines = Callable[..., list[str]]
Document = Callable[..., Any]
Cli = Callable[..., Any]


def test_a_gear_and_its_end(lines: Lines, document: Document) -> None:
    lines("axis", "enable", "X", "Y")
    lines("axis", "move", "X", "--to", "10", "-v", "200")
    [line] = lines("axis", "couple", "Y", "X", "-0.5")
    assert line.startswith("Y: follows X by a gear of -0.5")
    [before] = document("axis", "show", "Y")
    lines("axis", "move", "X", "--by", "10", "-v", "200")
    [after] = document("axis", "show", "Y")
    assert after["set_position"] - before["set_position"] == pytest.approx(-5.0)
    assert document("axis", "couple", "Y", "X", "2", "--change")["coupling_state"] == 3
    assert document("axis", "decouple", "Y")["coupling_state"] == 0
    lines("axis", "disable", "X", "Y")


def test_a_gear_has_no_table(cli: Cli) -> None:
    words = ("axis", "couple", "Y", "X", "2", "--table", "1")
    assert "--table is none" in cli(*words, exit_code=2).stderr.replace("│", " ")


def test_refusals_are_sentences(cli: Cli) -> None:
    for arguments, words in (
        (("couple", "Y", "Y"), ""),
        (("couple", "Y", "X", "0"), "0x421B"),
        (("couple", "Y", "XX"), "there are: 1 X"),
        (("couple", "Y", "X", "--table", "4000"), ""),
        (("decouple", "Y"), "0x424D"),
    ):
        result = cli("axis", *arguments, exit_code=1)
        assert words in result.stderr
        assert "Traceback" not in result.stderr
        assert result.stderr.count("\n") == 1
