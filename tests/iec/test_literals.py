"""Values as IEC literal text."""

import contextlib
from datetime import date, datetime, time, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.declare import ARRAY, iec_type, pointer_to, var
from achse.iec.derived import AliasType, OpaqueType, SubrangeType
from achse.iec.elementary import BOOL, BYTE, INT, LREAL, LWORD, REAL, UINT, IntegerType, RealType
from achse.iec.enums import Enumeration
from achse.iec.errors import IecValueError
from achse.iec.literals import format_value, parse_value
from achse.iec.names import ELEMENTARY
from achse.iec.strings import STRING, WSTRING
from achse.iec.structs import Struct
from achse.iec.times import DATE, DT, LDATE, LDT, LTIME, LTOD, TIME, TOD
from achse.iec.types import IecType


class State(Enumeration, name="E_State"):
    Idle = 0
    Run = 5


class Part(Struct, name="ST_Part"):
    n = var(INT, 3)
    s = var(STRING(20))
    a = var(ARRAY(INT, (1, 2)))


@pytest.mark.parametrize(
    ("type", "text", "value"),
    [
        (BOOL, "true", True),
        (BOOL, "BOOL#0", False),
        (INT, "-5", -5),
        (INT, " 1_000 ", 1000),
        (INT, "INT#+7", 7),
        (BYTE, "16#fF", 255),
        (BYTE, "BYTE#2#1000_0001", 129),
        (BYTE, "8#17", 15),
        (LWORD, "0xFFFFFFFFFFFFFFFF", 2**64 - 1),
        (SubrangeType(INT, 0, 5), "5", 5),
        (pointer_to(INT), "16#10", 16),
        (LREAL, "2.5", 2.5),
        (LREAL, "-1E-3", -0.001),
        (LREAL, "LREAL#3", 3.0),
        (REAL, "16#10", 16.0),
        (TIME, "T#1h2m3s4ms", timedelta(hours=1, minutes=2, seconds=3, milliseconds=4)),
        (TIME, "TIME#1.5s", timedelta(seconds=1.5)),
        (TIME, "t#2d_12h", timedelta(days=2, hours=12)),
        (TIME, "250", timedelta(milliseconds=250)),
        (LTIME, "LTIME#1s500us3ns", 1_000_500_003),
        (DATE, "D#2024-02-29", date(2024, 2, 29)),
        (LDATE, "LDATE#2500-01-01", date(2500, 1, 1)),
        (TOD, "TOD#12:34:56.789", time(12, 34, 56, 789000)),
        (TOD, "12:34", time(12, 34)),
        (LTOD, "LTOD#0:0:0.000000001", 1),
        (DT, "DT#2024-02-29-12:34:56", datetime(2024, 2, 29, 12, 34, 56)),
        (DT, "2024-02-29T12:34:56", datetime(2024, 2, 29, 12, 34, 56)),
        (DT, "DT#1970-1-1-0:0:1", datetime(1970, 1, 1, 0, 0, 1)),
        (LDT, "LDT#1970-01-01-00:00:00.5", 500_000_000),
        (STRING(20), "'it$'s $$5$L$41'", "it's $5\nA"),
        (STRING(20), "plain text", "plain text"),
        (STRING(20), "'$80'", "€"),
        (WSTRING(20), '"$20ACx"', "€x"),
        (iec_type(State), "run", State.Run),
        (iec_type(State), "E_State.Idle", State.Idle),
        (iec_type(State), "7", 7),
        (AliasType("T", INT), "8", 8),
        (ARRAY(INT, (1, 3)), "[1, 2, 3]", [1, 2, 3]),
        (ARRAY(INT, (1, 4)), "[1, 3(-2)]", [1, -2, -2, -2]),
        (ARRAY(INT, (1, 2), (0, 1)), "[[1,2],[3,4]]", [[1, 2], [3, 4]]),
        (ARRAY(STRING(9), (0, 1)), "['a,b]', '$'']", ["a,b]", "'"]),
    ],
)
def test_texts_mean_values(type: IecType[Any], text: str, value: object) -> None:
    assert parse_value(type, text) == value


def test_members_left_out_start_as_declared() -> None:
    assert parse_value(iec_type(Part), "(S := 'a, (b', a := [7, 8])") == Part(s="a, (b", a=[7, 8])
    assert parse_value(iec_type(Part), "()") == Part()


@pytest.mark.parametrize(
    ("type", "text"),
    [
        (BOOL, "yes"),
        (INT, ""),
        (INT, "1.5"),
        (INT, "70000"),
        (INT, "2#3"),
        (INT, "1" * 10_000),
        (LREAL, "x"),
        (LREAL, "1" * 10_000),
        (TIME, "T#"),
        (TIME, "T#1x"),
        (TIME, "T#1us"),
        (TIME, "T#60d"),
        (TIME, "D#1970-01-01"),
        (DATE, "D#2023-02-29"),
        (DATE, "D#1969-01-01"),
        (TOD, "TOD#24:00:00"),
        (DT, "DT#2024-01-01"),
        (DT, "DT#2024-01-01-00:00:00.5"),
        (STRING(3), "'abcd'"),
        (iec_type(State), "Stop"),
        (ARRAY(INT, (0, 1)), "1, 2"),
        (ARRAY(INT, (0, 1)), "[1]"),
        (ARRAY(INT, (0, 1)), "[9999999(1)]"),
        (ARRAY(INT, (0, 1)), "[1, (2]"),
        (ARRAY(INT, (0, 1)), "[1, 2)]"),
        (ARRAY(STRING(3), (0, 1)), "['a, 'b']"),
        (iec_type(Part), "(n = 1)"),
        (iec_type(Part), "(z := 1)"),
        (iec_type(Part), "n := 1"),
    ],
    ids=range(29),
)
def test_texts_that_mean_nothing_are_refused(type: IecType[Any], text: str) -> None:
    with pytest.raises(IecValueError) as caught:
        parse_value(type, text)
    assert len(str(caught.value)) < 250


@pytest.mark.parametrize(
    ("type", "value", "text"),
    [
        (BOOL, True, "TRUE"),
        (INT, -5, "-5"),
        (LREAL, 2.5, "2.5"),
        (TIME, timedelta(hours=1, milliseconds=4), "T#1h4ms"),
        (TIME, 0, "T#0ms"),
        (LTIME, 1_000_000_001, "LTIME#1s1ns"),
        (DATE, date(2024, 2, 29), "D#2024-02-29"),
        (TOD, time(1, 2, 3, 4000), "TOD#01:02:03.004"),
        (DT, datetime(2024, 2, 29, 12), "DT#2024-02-29-12:00:00"),
        (LDT, 1, "LDT#1970-01-01-00:00:00.000000001"),
        (STRING(20), "it's\n$", "'it$'s$L$$'"),
        (WSTRING(20), 'a"', '"a$""'),
        (iec_type(State), State.Run, "Run"),
        (iec_type(State), 7, "7"),
        (pointer_to(INT), 255, "16#FF"),
        (ARRAY(INT, (1, 2), (0, 1)), [[1, 2], [3, 4]], "[[1, 2], [3, 4]]"),
        (iec_type(Part), Part(s="x"), "(n := 3, s := 'x', a := [0, 0])"),
    ],
)
def test_values_have_a_text(type: IecType[Any], value: object, text: str) -> None:
    assert format_value(type, value) == text
    assert parse_value(type, text) == parse_value(type, format_value(type, value))


def test_bytes_without_definition_have_no_text() -> None:
    with pytest.raises(IecValueError, match="no literal"):
        format_value(OpaqueType("T", 1, 1, 65), b"x")
    with pytest.raises(IecValueError, match="an integer"):
        format_value(UINT, -1)


@pytest.mark.parametrize("type", ELEMENTARY.values(), ids=lambda type: type.name)
@given(data=st.binary(min_size=170, max_size=170))
def test_any_value_is_read_back_from_its_text(type: IecType[Any], data: bytes) -> None:
    value = type.decode(data[: type.size])
    if isinstance(value, str) and "\ufffd" in value:
        return
    again = parse_value(type, format_value(type, value))
    assert again == value or value != value


@given(st.text(max_size=40))
def test_any_text_is_a_value_or_refused(text: str) -> None:
    for type in (INT, LREAL, TIME, DT, STRING(9), ARRAY(INT, (0, 1)), iec_type(Part)):
        with contextlib.suppress(IecValueError):
            assert type.encode(parse_value(type, text))


def test_brackets_nested_beyond_reason_are_refused() -> None:
    type: IecType[Any] = INT
    for _ in range(40):
        type = ARRAY(type, (0, 0))
    with pytest.raises(IecValueError, match="nests less deep"):
        parse_value(type, "[" * 40 + "1" + "]" * 40)


def test_the_numeric_types_are_covered() -> None:
    assert all(isinstance(ELEMENTARY[name], IntegerType | RealType) for name in ("int", "lreal"))
