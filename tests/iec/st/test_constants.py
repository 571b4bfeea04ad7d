"""Constant expressions and how they fit into types."""

from typing import Any

import pytest

from achse.iec import (
    BOOL,
    BYTE,
    INT,
    LREAL,
    LTIME,
    REAL,
    SINT,
    STRING,
    TIME,
    UINT,
    WSTRING,
    IecType,
    pointer_to,
)
from achse.iec.st.constants import Constant, Evaluator, NotConstant, Path, fitted, path_of
from achse.iec.st.cursor import Unexpected
from achse.iec.st.parser import parse_expression
from achse.iec.st.source import SourceError
from achse.iec.st.tree import Expression

CONSTANTS = {("c",): Constant(7), ("G", "t"): Constant(1500, TIME), ("w",): Constant(5, UINT)}


def lookup(path: Path, at: int) -> Constant:
    if path == ("v",):
        raise NotConstant(at)
    if path not in CONSTANTS:
        raise Unexpected(at, f"no {path}")
    return CONSTANTS[path]


def size_of(tree: Expression) -> int:
    return 42


def evaluated(text: str) -> Constant:
    return Evaluator(lookup, size_of).value(parse_expression(text))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("10 - 4 - 3", 3),
        ("7 / 2", 3),
        ("-7 / 2", -3),
        ("7 MOD 3", 1),
        ("-7 MOD 3", -1),
        ("7 / 2.0", 3.5),
        ("2 ** 3", 8.0),
        ("1 < 2", True),
        ("1 >= 2", False),
        ("'a' = 'a'", True),
        ("1 = 1.0", True),
        ("TRUE AND NOT FALSE", True),
        ("TRUE XOR TRUE", False),
        ("TRUE OR_ELSE FALSE", True),
        ("2#1100 AND 2#1010", 8),
        ("2#1100 OR 2#1010", 14),
        ("6 XOR 3", 5),
        ("NOT 16#0F", 0xF0),
        ("NOT WORD#1", 0xFFFE),
        ("NOT 0", -1),
        ("-16#80", -128),
        ("+5", 5),
        ("c - 1", 6),
        ("G.t", 1500),
        ("G.t + T#1s", 2500),
        ("G.t * 2", 3000),
        ("G.t / 2", 750),
        ("G.t * 1.5", 2250),
        ("T#3s / T#1s", 3),
        ("T#1s < T#2s", True),
        ("5.3", 5.3),
        ("c.0", True),
        ("c.3", False),
        ("w.%B0", 5),
        ("SIZEOF(x)", 42),
        ("TO_INT(2.5)", 3),
        ("TO_INT(-2.5)", -3),
        ("LREAL_TO_INT(1.4)", 1),
        ("TO_BYTE(300)", 44),
        ("TO_SINT(255)", -1),
        ("TO_BOOL(5)", True),
        ("BOOL_TO_INT(TRUE)", 1),
        ("TO_LREAL(3)", 3.0),
        ("TO_TIME(1500)", 1500),
        ("TIME_TO_DINT(T#2s)", 2000),
        ("TO_LTIME(T#1ms)", 1_000_000),
        ("ABS(-5)", 5),
        ("MIN(3, 1, 2)", 1),
        ("MAX(3, c)", 7),
        ("LIMIT(0, 11, 10)", 10),
        ("SEL(TRUE, 1, 2)", 2),
        ("TRUNC(-2.7)", -2),
        ("SQRT(9)", 3.0),
        ("EXPT(2, 10)", 1024.0),
        ("SHL(1, 4)", 16),
        ("SHR(16, 4)", 1),
    ],
)
def test_values(text: str, value: object) -> None:
    found = evaluated(text).value
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize("text", ["v", "v + 1", "ADR(c)", "f(1)", "c[1]", "c^", "THIS^.x", "(v)^",
                                  "c := 1", "v.x.y + 1", "TO_STRING(5)"])  # fmt: skip
def test_what_shows_at_run_time(text: str) -> None:
    with pytest.raises((NotConstant, Unexpected)) as caught:
        evaluated(text)
    assert isinstance(caught.value, NotConstant) or "no (" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x", "no ('x',)"),
        ("1 / 0", "a division by zero"),
        ("1 MOD 0", "a division by zero"),
        ("1.0 / 0", "a division by zero"),
        ("TRUE + 1", "'+' takes numbers"),
        ("'a' + 1", "'+' takes numbers"),
        ("1 AND 1.5", "AND takes two truths or two whole numbers"),
        ("'a' < 1", "'<' compares values of one kind"),
        ("-TRUE", "- takes a number, got True"),
        ("NOT 1.5", "NOT takes a number, got 1.5"),
        ("1.5.0", "expected"),
        ("c.%X3.%X0", "a bit of a whole number, got False"),
        ("T#1s - LTIME#1s", "'-' takes times of one type"),
        ("10.0 ** 999", "there is no such value"),
        ("(-8) ** 0.5", "the result is no finite number"),
        ("SHL(16#FFFF_FFFF_FFFF_FFFF, 1)", "the result does not fit into 64 bits"),
        ("SQRT()", "SQRT takes another number of arguments"),
        ("LIMIT(1)", "LIMIT takes another number of arguments"),
    ],
)
def test_what_has_no_value(text: str, message: str) -> None:
    with pytest.raises((Unexpected, SourceError)) as caught:
        evaluated(text)
    assert message in str(caught.value)


def test_what_is_no_number_stays_none() -> None:
    assert evaluated("LOG(-1)").value != evaluated("LOG(-1)").value


@pytest.mark.parametrize(
    ("constant", "type", "value"),
    [
        (Constant(5), INT, 5),
        (Constant(5), LREAL, 5.0),
        (Constant(1.5), REAL, 1.5),
        (Constant(True), BOOL, True),
        (Constant(1), BOOL, 1),
        (Constant("x"), STRING(1), "x"),
        (Constant("x"), WSTRING(1), "x"),
        (Constant(0xFF, BYTE), SINT, -1),
        (Constant(0x8000, UINT), INT, -0x8000),
        (Constant(5, BYTE), INT, 5),
        (Constant(1500, TIME), TIME, 1500),
        (Constant(1500, TIME), LTIME, 1_500_000_000),
        (Constant(2_000_000, LTIME), TIME, 2),
        (Constant(7), TIME, 7),
        (Constant(0), pointer_to(INT), 0),
    ],
)
def test_constants_fit(constant: Constant, type: IecType[Any], value: object) -> None:
    assert fitted(constant, type, 0) == value


@pytest.mark.parametrize(
    ("constant", "type"),
    [
        (Constant(40000), INT),
        (Constant(0x18000, UINT), INT),
        (Constant(1.5), INT),
        (Constant(True), INT),
        (Constant("x"), INT),
        (Constant(5), STRING(5)),
        (Constant("xy"), STRING(1)),
        (Constant(1, LTIME), TIME),
        (Constant(1.5), BOOL),
        (Constant(-1), pointer_to(INT)),
    ],
)
def test_constants_do_not_fit(constant: Constant, type: IecType[Any]) -> None:
    with pytest.raises(Unexpected):
        fitted(constant, type, 0)


def test_paths() -> None:
    assert path_of(parse_expression("a.b.c")) == ("a", "b", "c")
    assert path_of(parse_expression(".a")) == ("a",)
    assert path_of(parse_expression("a[1].b")) is None
    assert path_of(parse_expression("THIS^.b")) is None


def test_long_sums_are_worked_out_without_recursion() -> None:
    assert evaluated(" + ".join(["1"] * 1000)).value == 1000
