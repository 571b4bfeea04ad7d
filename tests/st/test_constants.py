"""Constant expressions and how they fit into types."""

from typing import Any

import pytest

from achse.iec import (
    ARRAY,
    BYTE,
    INT,
    TIME,
    UINT,
    IecType,
)
from achse.st.constants import Evaluator, Path, path_of
from achse.st.cursor import Unexpected
from achse.st.parser import parse_expression
from achse.st.source import SourceError
from achse.st.tree import Expression, Name
from achse.st.values import Constant, NotConstant

CONSTANTS = {("c",): Constant(7), ("G", "t"): Constant(1500, TIME), ("w",): Constant(5, UINT)}

BLOCK = ARRAY(BYTE, (1, 42))
GRID = ARRAY(INT, (1, 3), (-2, 5))


def lookup(path: Path, at: int) -> Constant:
    if path == ("v",):
        raise NotConstant(at)
    if path not in CONSTANTS:
        raise Unexpected(at, f"no {path}")
    return CONSTANTS[path]


def type_of(tree: Expression) -> IecType[Any]:
    return BLOCK if isinstance(tree, Name) and tree.name == "x" else GRID


def evaluated(text: str) -> Constant:
    return Evaluator(lookup, type_of).value(parse_expression(text))


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
        ("XSIZEOF(x)", 42),
        ("UPPER_BOUND(x, 1)", 42),
        ("UPPER_BOUND(grid, 2)", 5),
        ("LOWER_BOUND(grid, c - 5)", -2),
        ("SHL(16#FF, 4)", 0xFF0),
        ("TO_INT(2.5) + MAX(c, 1)", 10),
    ],
)
def test_values(text: str, value: object) -> None:
    found = evaluated(text).value
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize("text", ["v", "v + 1", "ADR(c)", "f(1)", "c[1]", "c^", "THIS^.x", "(v)^",
                                  "c := 1", "v.x.y + 1", "TO_STRING(1.0E20)", "MAX(1, v)",
                                  "F_TO_INT(1)"])  # fmt: skip
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
        ("(-8) ** 0.5", "the result is not a finite number"),
        ("16#FFFF_FFFF_FFFF_FFFF + 1", "the result does not fit into 64 bits"),
        ("UPPER_BOUND(x, 2)", "has 1 dimensions"),
        ("SIZEOF(x, 1)", "SIZEOF takes 1 arguments, got 2"),
        ("MAX(a := 1, 2)", "MAX takes its arguments by position"),
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


def test_paths() -> None:
    assert path_of(parse_expression("a.b.c")) == ("a", "b", "c")
    assert path_of(parse_expression(".a")) == ("a",)
    assert path_of(parse_expression("a[1].b")) is None
    assert path_of(parse_expression("THIS^.b")) is None


def test_long_sums_are_worked_out_without_recursion() -> None:
    assert evaluated(" + ".join(["1"] * 1000)).value == 1000
