"""Initial values of arrays, structures and what they are made of."""

from typing import Any

import pytest

from achse.iec import ARRAY, INT, LREAL, IecType, Struct, iec_type, var
from achse.st.constants import Evaluator, Path
from achse.st.initials import InitialValues
from achse.st.parser import Parser
from achse.st.source import Source
from achse.st.values import Constant, NotConstant


class Point(Struct):
    x = var(LREAL, 1.0)
    y = var(LREAL)


def lookup(path: Path, at: int) -> Constant:
    if path == ("n",):
        return Constant(2)
    raise NotConstant(at)


def value_of(text: str, type: IecType[Any]) -> tuple[object, list[int]]:
    """The value, and the offsets of what is not a constant in it."""
    parser = Parser(Source(text))
    initial = parser.attempt(parser.expressions.initial)
    assert initial is not None
    values = InitialValues(Evaluator(lookup, lambda tree: INT), lambda block, name: name == "Rate")
    value = values.value(type, initial)
    if value is not None:
        type.encode(value)
    return value, [part.offset for part in values.left]


LINE = ARRAY(INT, (1, 4))
PLANE = ARRAY(INT, (0, 1), (0, 2))
ROWS = ARRAY(ARRAY(INT, (0, 1)), (0, 1))
POINTS = ARRAY(Point, (0, 2))


@pytest.mark.parametrize(
    ("text", "type", "value"),
    [
        ("[1, 2, 3, 4]", LINE, [1, 2, 3, 4]),
        ("[1]", LINE, [1, 0, 0, 0]),
        ("[]", LINE, [0, 0, 0, 0]),
        ("[2(1), 5]", LINE, [1, 1, 5, 0]),
        ("[2(1, 2)]", LINE, [1, 2, 1, 2]),
        ("[n(7)]", LINE, [7, 7, 0, 0]),
        ("[0(7), 1]", LINE, [1, 0, 0, 0]),
        ("[2(), 1]", LINE, [0, 0, 1, 0]),
        ("[1, 2, 3, 4, 5, 6]", PLANE, [[1, 2, 3], [4, 5, 6]]),
        ("[[1, 2, 3], [4, 5, 6]]", PLANE, [[1, 2, 3], [4, 5, 6]]),
        ("[6(1)]", PLANE, [[1, 1, 1], [1, 1, 1]]),
        ("[[1, 2], [3]]", ROWS, [[1, 2], [3, 0]]),
        ("[2([5, 6])]", ROWS, [[5, 6], [5, 6]]),
        ("(x := 2)", iec_type(Point), {"x": 2.0}),
        ("(Y := 3, X := 1)", iec_type(Point), {"x": 1.0, "y": 3.0}),
        ("[n((x := 5, y := 2))]", POINTS, [{"x": 5.0, "y": 2.0}, {"x": 5.0, "y": 2.0}, {}]),
        ("[(x := 5), 1((y := 2))]", POINTS, [{"x": 5.0}, {"y": 2.0}, {}]),
    ],
)
def test_values(text: str, type: IecType[Any], value: object) -> None:
    assert value_of(text, type) == (value, [])


@pytest.mark.parametrize(
    ("text", "type", "value", "left"),
    [
        ("v", INT, None, [0]),
        ("[1, v, 3]", LINE, [1, 0, 3, 0], [2]),
        ("[f(1)]", LINE, [0, 0, 0, 0], [0]),
        ("[1, 2(v)]", LINE, [1, 0, 0, 0], [2, 4]),
        ("[0(v), 1]", LINE, [1, 0, 0, 0], []),
        ("[2(1, v)]", LINE, [1, 0, 1, 0], [2, 6]),
        ("[[1], [2, v]]", ROWS, [[1, 0], [2, 0]], [6]),
        ("(x := 1, y := v)", iec_type(Point), {"x": 1.0}, [8]),
        ("[2((y := v))]", POINTS, [{}, {}, {}], [8, 24]),
    ],
)
def test_what_is_no_constant_is_left_with_its_place(
    text: str, type: IecType[Any], value: object, left: list[int]
) -> None:
    assert value_of(text, type) == (value, left)


def test_a_million_elements_take_no_time() -> None:
    value, _ = value_of("[1000000(1)]", ARRAY(INT, (1, 1_000_000)))
    assert value == [1] * 1_000_000
