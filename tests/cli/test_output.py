"""Values as text and JSON, tables, dumps."""

import math
from datetime import timedelta
from typing import Any

import pytest

from achse.cli.output import as_json, as_text, decimal, hex_dump, print_table
from achse.iec import (
    ARRAY,
    BOOL,
    INT,
    LREAL,
    STRING,
    TIME,
    Enumeration,
    IecType,
    Struct,
    iec_type,
    var,
)
from achse.iec.typetable import OpaqueType


class E_Mode(Enumeration):  # noqa: N801
    OFF = 0
    ON = 3


class ST_Axis(Struct):  # noqa: N801
    nId = var(INT)  # noqa: N815
    eMode = var(E_Mode)  # noqa: N815
    tRamp = var(TIME)  # noqa: N815
    aSteps = var(ARRAY(INT, (0, 1), (1, 2)))  # noqa: N815


@pytest.mark.parametrize(
    ("type", "value", "text", "document"),
    [
        (INT, -5, "-5", -5),
        (BOOL, True, "TRUE", True),
        (LREAL, 1.5, "1.5", 1.5),
        (LREAL, math.inf, "inf", "inf"),
        (STRING(10), "it's", "'it$'s'", "it's"),
        (TIME, timedelta(milliseconds=1500), "T#1s500ms", "T#1s500ms"),
        (iec_type(E_Mode), E_Mode.ON, "ON", "ON"),
        (ARRAY(INT, (1, 3)), [1, 2, 3], "[1, 2, 3]", [1, 2, 3]),
        (OpaqueType("?", 3, 1, 0), b"\1\2\xff", "01 02 ff", "01 02 ff"),
        (
            iec_type(ST_Axis),
            {"nId": 7, "eMode": 3, "tRamp": timedelta(seconds=2), "aSteps": [[1, 2], [3, 4]]},
            "(nId := 7, eMode := ON, tRamp := T#2s, aSteps := [[1, 2], [3, 4]])",
            {"nId": 7, "eMode": "ON", "tRamp": "T#2s", "aSteps": [[1, 2], [3, 4]]},
        ),
    ],
    ids=lambda item: item.name if isinstance(item, IecType) else "",
)
def test_a_value_as_text_and_as_json(
    type: IecType[Any], value: object, text: str, document: object
) -> None:
    received = type.decode(type.encode(value))
    assert as_text(type, received) == text
    assert as_json(type, received) == document


def test_zero_has_no_sign() -> None:
    assert [decimal(value) for value in (-0.0, -0.00004, 1.23456)] == ["0.0000", "0.0000", "1.2346"]


def test_columns_are_aligned_and_end_without_blanks(capsys: pytest.CaptureFixture[str]) -> None:
    print_table([("a", "1", "x"), ("long", "20", "")], right=frozenset({1}))
    assert capsys.readouterr().out == "a      1  x\nlong  20\n"


def test_a_dump_shows_offset_bytes_and_text() -> None:
    first, second = hex_dump(bytes(range(16)) + b"achse")
    assert first == "0000  00 01 02 03 04 05 06 07 08 09 0a 0b 0c 0d 0e 0f  ................"
    assert second.split() == ["0010", "61", "63", "68", "73", "65", "achse"]


def test_what_others_wrote_commands_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    print_table([("\x1b[31mred\r\nnext\x9b", "größer"), ("\u202eb", "c")])
    out = capsys.readouterr().out
    first, second = out.splitlines()
    assert first == r"\x1b[31mred\r\nnext\x9b  größer"
    assert second.split() == [r"\u202eb", "c"]
