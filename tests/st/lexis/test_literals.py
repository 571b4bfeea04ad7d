"""Literals: their types and values."""

import pytest

from achse.iec import IecValueError
from achse.st.lexis.literals import literal_value, malformed, whole_number


@pytest.mark.parametrize(
    ("text", "type", "value"),
    [
        ("0", None, 0),
        ("1_000", None, 1000),
        ("16#FF", None, 255),
        ("16#ff_00", None, 0xFF00),
        ("16#7f__ff", None, 0x7FFF),
        ("2#1010", None, 10),
        ("8#17", None, 15),
        ("1.5", None, 1.5),
        ("1E3", None, 1000.0),
        ("2.5e-1", None, 0.25),
        ("TRUE", "BOOL", True),
        ("False", "BOOL", False),
        ("BOOL#1", "BOOL", True),
        ("BOOL#false", "BOOL", False),
        ("INT#5", "INT", 5),
        ("INT#-5", "INT", -5),
        ("int#16#7F", "INT", 127),
        ("WORD#16#FFFF", "WORD", 65535),
        ("LREAL#5", "LREAL", 5.0),
        ("REAL#-1.5", "REAL", -1.5),
        ("T#1s500ms", "TIME", 1500),
        ("TIME#1d", "TIME", 86_400_000),
        ("T#1.5s", "TIME", 1500),
        ("TIME#0.2ms", "TIME", 0),
        ("TIME#334.9185S", "TIME", 334918),
        ("T#1s2.9MS", "TIME", 1002),
        ("LT#1us", "LTIME", 1000),
        ("LTIME#1h2ns", "LTIME", 3_600_000_000_002),
        ("D#1970-01-02", "DATE", 86_400),
        ("DT#1970-1-1-0:0:5", "DT", 5),
        ("DT#1970-1-1-0:0:5.9", "DT", 5),
        ("DATE_AND_TIME#1970-01-01-00:01:00", "DATE_AND_TIME", 60),
        ("TOD#0:0:1.5", "TOD", 1500),
        ("LTIME_OF_DAY#0:0:1", "LTOD", 1_000_000_000),
        ("LDATE_AND_TIME#1970-1-1-0:0:1", "LDT", 1_000_000_000),
        ("'abc'", "STRING(80)", "abc"),
        ("'a$'b$$c$N'", "STRING(80)", "a'b$c\n"),
        ("'$41$42'", "STRING(80)", "AB"),
        ('"a$"b$0041"', "WSTRING(80)", 'a"bA'),
        ("STRING#'x'", "STRING(80)", "x"),
        ("WSTRING#\"x\"", "WSTRING(80)", "x"),
        ("''", "STRING(80)", ""),
        ("'a\nb'", "STRING(80)", "a\nb"),
        ("'ä€Ω'", "STRING(80)", "ä€Ω"),
    ],
)  # fmt: skip
def test_values(text: str, type: str | None, value: object) -> None:
    literal = literal_value(text)
    assert (None if literal.type is None else literal.type.name, literal.value) == (type, value)


def test_values_of_enumerations() -> None:
    assert literal_value("E_State#Idle")[1:] == ("Idle", "E_State")
    assert literal_value("E_State#5")[1:] == (5, "E_State")


@pytest.mark.parametrize(
    "text",
    ["INT#40000", "BYTE#-1", "INT#1.5", "INT#", "BOOL#x", "T#", "T#5", "T#5x", "T#-5s", "T#100us",
     "T#0.5us", "T#1.2.3ms",
     "D#2024-02-30", "D#24-1-1", "TOD#24:00", "STRING#\"x\"", "WSTRING#'x'", "E#1.5.2",
     "1_", "16#G", "2#2", "3#1", "1.5.2", "INT#9" + "9" * 200, "REAL#1E99"],
)  # fmt: skip
def test_what_is_no_literal(text: str) -> None:
    assert malformed(text)
    with pytest.raises(IecValueError):
        literal_value(text)


@pytest.mark.parametrize(
    ("text", "number"),
    [("7", 7), (" -12 ", -12), ("", 3), ("--5", 3), ("\u0667", 3), ("\u00b2", 3), ("9" * 5000, 3)],
)
def test_whole_numbers_of_editors(text: str, number: int) -> None:
    assert whole_number(text, 3) == number
