"""`achse axis show|set`: names, units, ranges and refusals come from the rows and from the NC."""

from collections.abc import Callable
from typing import Any

import pytest

Lines = Callable[..., list[str]]
Document = Callable[..., Any]
Cli = Callable[..., Any]


def test_an_axis_is_shown_whole(document: Document) -> None:
    shown = {one["name"]: one for one in document("axis", "show", "C", "*")}
    assert shown["max_velocity"] == {
        "name": "max_velocity",
        "value": 3600.0,
        "error": None,
        "unit": "degree/s",
        "range": "0.001..1e+20",
        "type": "REAL64",
        "access": "R W",
        "index_group": 0x4003,
        "index_offset": 0x27,
        "meaning": "largest velocity of a command",
    }
    assert shown["axis_name"]["value"] == "C"
    assert shown["encoder_modulo_factor"]["unit"] == "degree"
    assert shown["set_position"]["index_group"] == 0x4103
    assert all(one["error"] is None for one in shown.values())
    # what the axis shows of encoder, controller and drive, and states as well as parameters
    assert {"controller_position_kv", "drive_reference_velocity", "drive_actual_torque"} <= {*shown}


def test_names_and_patterns_choose(lines: Lines) -> None:
    assert [line.split()[:3] for line in lines("axis", "show", "y", "jog_*", "Override_Type")] == [
        ["jog_velocity_slow", "100", "mm/s"],
        ["jog_velocity_fast", "600", "mm/s"],
        ["override_type", "1", "REDUCED"],
    ]
    [row] = lines("axis", "show", "Y", "override_type")
    assert row.endswith("(1=REDUCED, 2=ORIGINAL, 3=REDUCED_ITERATED, 4=ORIGINAL_ITERATED)")


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("jog_velocity_slow", "12.5", 12.5),
        ("loop_distance", "-5", -5.0),
        ("encoder_sub_mask", "0xFF", 0xFF),
        ("override_type", "original", 2),
        ("Controller_Position_Kv", "1e1", 10.0),
    ],
)
def test_set_shows_what_is_then(
    cli: Cli, document: Document, name: str, text: str, value: float
) -> None:
    cli("axis", "disable", "X")
    [before] = document("axis", "show", "X", name)
    report = document("axis", "set", "X", name, text)
    assert report == before | {"value": value}
    assert document("axis", "show", "X", name) == [report]
    cli("axis", "set", "X", name, str(before["value"]))


def test_the_nc_refuses_and_the_row_says_what_is_expected(cli: Cli) -> None:
    result = cli("axis", "set", "X", "max_velocity", "0", exit_code=1)
    assert "X, max velocity: 0x432F AXIS_MAX_VELOCITY" in result.stderr
    assert "expected 0.001..1e+20" in result.stderr
    cli("axis", "enable", "X")
    result = cli("axis", "set", "X", "encoder_position_offset", "1", exit_code=1)
    assert "0x4257" in result.stderr


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("set", "X", "max_velocty", "1"), 1, "did you mean max_velocity"),
        (("set", "X", "set_position", "1"), 1, "set_position is for reading only"),
        (("set", "X", "max_velocity", "fast"), 2, "a number expected"),
        (("set", "X", "loop_enable", "1.5"), 2, "a whole number expected"),
        (("set", "X", "encoder_sub_mask", "-1"), 2, "a whole number expected (15..4.29497e+09)"),
        (("set", "X", "override_type", "new"), 2, "expected (1=REDUCED, 2=ORIGINAL"),
        (("set", "X", "velocity", "1"), 1, "no velocity; names with it: homing_velocity_towards"),
        (("show", "X", "nothing*"), 1, "no nothing*; see `achse axis show X '*'`"),
        (("show", "X", "--element", "1"), 1, "0x4013"),
        (("set", "X", "max_velocity", "1", "--element", "1"), 1, "no max_velocity"),
    ],
)
def test_mistakes_are_reported(cli: Cli, words: tuple[str, ...], code: int, message: str) -> None:
    result = cli("axis", *words, exit_code=code)
    assert message in " ".join(result.stderr.replace("│", " ").split())
