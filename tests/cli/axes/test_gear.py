"""`achse axis gear`, `couple`, `decouple`: an axis follows another one."""

from collections.abc import Callable
from typing import Any

import pytest

Lines = Callable[..., list[str]]
Document = Callable[..., Any]
Cli = Callable[..., Any]


def test_a_gear_and_its_end(lines: Lines, document: Document) -> None:
    lines("axis", "enable", "X", "Y")
    lines("axis", "move", "X", "--to", "10", "-v", "200")
    [told] = lines("axis", "gear", "Y", "X", "-0.5")
    assert told.startswith("Y: follows X by a gear of -0.5")
    [before] = document("axis", "status", "Y")
    lines("axis", "move", "X", "--by", "10", "-v", "200")
    [after] = document("axis", "status", "Y")
    assert after["set_position"] - before["set_position"] == pytest.approx(-5.0)
    assert document("axis", "gear", "Y", "X", "2", "--change")["coupling_state"] == 3
    assert document("axis", "decouple", "Y")["coupling_state"] == 0
    lines("axis", "disable", "X", "Y")


def test_refusals_are_sentences(cli: Cli) -> None:
    for arguments, words in (
        (("gear", "Y", "Y"), ""),
        (("gear", "Y", "X", "0"), "0x421B"),
        (("gear", "Y", "XX"), "there are: 1 X"),
        (("couple", "Y", "X", "--table", "4000"), ""),
        (("decouple", "Y"), "0x424D"),
    ):
        result = cli("axis", *arguments, exit_code=1)
        assert words in result.stderr
        assert "Traceback" not in result.stderr
        assert result.stderr.count("\n") == 1
