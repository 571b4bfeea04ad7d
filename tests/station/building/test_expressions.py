"""Expressions: their values, and what is refused."""

import contextlib
import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station.building.expressions import FUNCTIONS, ExpressionError, parse_expression

VARIABLES = {"main.n": 5.0, "GVL.a[3].x": 2.0, "GVL.a[1,-2]": 3.0, "MAIN.is": 7.0}


def _variable(name: str) -> Callable[[], float]:
    if name not in VARIABLES:
        raise ValueError(f"no {name}")
    return lambda: VARIABLES[name]


def _value(text: str, t: float = 2.0) -> float:
    return parse_expression(text, _variable).value(t)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("2 - 3 - 4", -5),
        ("-2 ** 2", -4),
        ("2 ** -1", 0.5),
        ("2 ^ 3 ^ 2", 512),
        ("7 MOD 4 + 7 % 4", 6),
        ("-7 mod 4", -3),
        ("1.5e3 / 3", 500),
        (".5 + 1_000", 1000.5),
        ("t * t", 4),
        ("1 < 2 and not 2 < 1", 1),
        ("1 = 1 xor 1 == 1", 0),
        ("3 <> 4 or 1 / 0", None),
        ("2 >= 2", 1),
        ("main.n + GVL.a[3].x * GVL.a[1,-2] - MAIN.is", 4),
        ("if(t > 1, 10, 20)", 10),
        ("IF(T > 3, 10, 20)", 20),
        ("limit(0, 5, 3) + min(4, 2, 9) + max(1)", 6),
        ("atan2(1, 0)", math.pi / 2),
        ("sign(-3) + trunc(-1.7) + floor(-1.2) + ceil(1.2) + round(2.6)", -1 - 1 - 2 + 2 + 3),
        ("TRUE + false", 1),
        ("sin(pi / 2)", 1),
    ],
)
def test_a_value(text: str, value: float | None) -> None:
    if value is None:
        with pytest.raises(ZeroDivisionError):
            _value(text)
    else:
        assert _value(text) == pytest.approx(value)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_each_function_computes_and_counts_its_arguments(name: str) -> None:
    count = FUNCTIONS[name].takes or 2
    assert math.isfinite(_value(f"{name}({', '.join(['0.5'] * count)})"))
    if FUNCTIONS[name].takes is not None:
        with pytest.raises(ExpressionError, match="arguments"):
            _value(f"{name}({', '.join(['0.5'] * (count + 1))})")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "column 1: expected a number, a name or '\\(', got the end"),
        ("1 +", "column 4"),
        ("1 2", "column 3: expected an operator or the end, got '2'"),
        ("(1", "expected '\\)'"),
        ("1;2", "got ';'"),
        ("foo(1)", "no function foo; there are sin"),
        ("__import__('os')", "no function __import__"),
        ("x.__class__", "no x.__class__"),
        ("min()", "expected a number"),
        ("min(1 2)", "',' or '\\)'"),
        ("(" * 80 + "1" + ")" * 80, "deeper than 50"),
        ("-" * 80 + "1", "deeper than 50"),
        ("1" * 1001, "up to 1000 characters"),
    ],
)
def test_what_is_refused_says_where_and_what(text: str, message: str) -> None:
    with pytest.raises(ExpressionError, match=message):
        _value(text)


def test_names_are_reported_once_in_order() -> None:
    assert parse_expression("main.n + MAIN.is * main.n", _variable).names == ("main.n", "MAIN.is")


def test_a_value_that_cannot_be_computed_raises() -> None:
    for text in ("1 / 0", "sqrt(-1)", "10 ** 400", "floor(10 ** 300 * 10 ** 300)"):
        with pytest.raises((ArithmeticError, ValueError)):
            _value(text)


@given(st.text(max_size=60), st.floats(-1e9, 1e9))
def test_any_text_is_a_value_or_an_error_of_ours(text: str, t: float) -> None:
    try:
        value = parse_expression(text, _variable).value
    except ExpressionError:
        return
    with contextlib.suppress(ArithmeticError, ValueError):
        assert isinstance(value(t), float)


@given(
    st.recursive(
        st.sampled_from(["1", "2.5", "t", "main.n"]),
        lambda inner: st.tuples(inner, st.sampled_from(["+", "-", "*"]), inner).map(
            lambda parts: f"({parts[0]} {parts[1]} {parts[2]})"
        ),
        max_leaves=12,
    ),
    st.integers(-100, 100),
)
def test_arithmetic_is_that_of_python(text: str, t: int) -> None:
    expected = eval(text.replace("main.n", "5.0"), {}, {"t": float(t)})
    assert _value(text, t) == pytest.approx(expected)
