"""Texts: functions of strings, and texts to and from other values, as recorded."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import BOOL, DINT, INT, LREAL, REAL, UINT
from achse.iec.strings import STRING, WSTRING
from achse.iec.times import TIME
from achse.iec.types import IecType
from achse.plc.code.texts import TEXTS, recoded, text_read, text_written
from tests.plc.code.conftest import Ran

_S = STRING(80)


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("left", (b"abc", 5), b"abc"),
        ("left", (b"abc", -1), b""),
        ("right", (b"abc", 2), b"bc"),
        ("mid", (b"abcdef", 2, 3), b"cd"),
        ("mid", (b"abc", 2, 0), b""),
        ("mid", (b"abc", 0, 1), b""),
        ("insert", (b"abc", b"X", 0), b"Xabc"),
        ("insert", (b"abc", b"X", 3), b"abcX"),
        ("insert", (b"abc", b"X", 4), b"abc"),
        ("insert", (b"abc", b"X", -1), b"abc"),
        ("delete", (b"abcdef", 2, 3), b"abef"),
        ("delete", (b"abc", 1, 0), b"abc"),
        ("replace", (b"abcdef", b"XYZ", 2, 3), b"abXYZef"),
        ("find", (b"abcab", b"ab"), 1),
        ("find", (b"abc", b""), 0),
        ("find", (b"abc", b"x"), 0),
        ("len", (b"abc",), 3),
        ("concat", (b"a" * 200, b"b" * 100), b"a" * 200 + b"b" * 55),
    ],
)
def test_functions(name: str, arguments: tuple[Any, ...], expected: object) -> None:
    assert TEXTS[f"text_{name}"](*arguments, 1) == expected
    wide = [
        item.decode().encode("utf-16-le") if isinstance(item, bytes) else item for item in arguments
    ]
    result = TEXTS[f"text_{name}"](*wide, 2)
    assert (
        result.decode("utf-16-le").encode() if isinstance(result, bytes) else result
    ) == expected


@pytest.mark.parametrize(
    ("text", "type", "expected"),
    [
        (b"12abc", INT, 12),
        (b"- 5", INT, 0),
        (b" \t-5", INT, -5),
        (b"99999", INT, -31073),
        (b"99999", UINT, 34463),
        (b"1,5", REAL, 1.0),
        (b"1.5E2x", LREAL, 150.0),
        (b"TRUE", BOOL, True),
        (b"trueish", BOOL, True),
        (b"True", BOOL, False),
        (b"T#1s500ms", TIME, 1500),
        (b"x", DINT, 0),
    ],
)
def test_a_text_is_read_as_far_as_it_goes(
    text: bytes, type: IecType[Any], expected: object
) -> None:
    assert text_read(text, _S, type) == expected


@pytest.mark.parametrize(
    ("value", "type", "expected"),
    [
        (True, BOOL, b"TRUE"),
        (-5, INT, b"-5"),
        (3.0, REAL, b"3.0"),
        (1e8, REAL, b"1E08"),
        (1e-5, REAL, b"1E-05"),
        (math.inf, LREAL, b"Inf"),
        (93_600_000, TIME, b"T#1d2h"),
        (0, TIME, b"T#0ms"),
    ],
)
def test_a_value_is_written(value: Any, type: IecType[Any], expected: bytes) -> None:
    assert text_written(value, type, _S) == expected


def test_recoding_cuts_and_marks_what_has_no_code() -> None:
    assert recoded("ä✓".encode("utf-16-le"), WSTRING(10), _S) == b"\xe4?"
    assert recoded(b"abc", _S, WSTRING(2)) == "ab".encode("utf-16-le")


@given(st.integers(-(1 << 31), (1 << 31) - 1))
def test_whole_numbers_come_back(value: int) -> None:
    assert text_read(text_written(value, DINT, _S), _S, DINT) == value


@given(st.binary(max_size=300))
def test_no_text_breaks_a_conversion(text: bytes) -> None:
    text = text.replace(b"\0", b"")
    for type in (INT, LREAL, BOOL, TIME):
        text_read(text, _S, type)
    recoded(text, _S, WSTRING(20))


def test_text_behind_a_constant_in_out_is_not_cut() -> None:
    text = "x" * 120
    ran = Ran(
        "FUNCTION Long : STRING(200) Long := 'y'; WHILE LEN(Long) < 150 DO"
        " Long := CONCAT(Long, 'y'); END_WHILE END_FUNCTION"
        " FUNCTION Length : UDINT VAR_IN_OUT CONSTANT s : STRING; END_VAR"
        " Length := LEN2(ADR(s)); END_FUNCTION PROGRAM MAIN VAR n, m, k : UDINT; END_VAR"
        f" n := Length('{text}'); m := Length(Long()); k := Length('z'); END_PROGRAM"
    ).cycle()
    assert (ran["n"], ran["m"], ran["k"]) == (120, 150, 1)
