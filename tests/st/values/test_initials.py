"""Initial values of arrays, structures and what they are made of."""

from typing import Any

import pytest

from achse.iec import ARRAY, INT, LREAL, IecType, Struct, iec_type, var
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import Parser, parse
from achse.st.values.constants import Evaluator, Path
from achse.st.values.initials import InitialValues
from achse.st.values.values import Constant, NotConstant


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
    return value, [part.offset for part in values.remaining]


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
        ("[(n+1)(7), 1]", LINE, [7, 7, 7, 1]),
        ("[(n)(7), -(-1)(3)]", LINE, [7, 7, 3, 0]),
        ("[(n - 1)(7, 8), (n * n - 3)(3)]", LINE, [7, 8, 3, 0]),
        ("[0(7), 1]", LINE, [1, 0, 0, 0]),
        ("[2(), 1]", LINE, [0, 0, 1, 0]),
        ("[1, 2, 3, 4, 5, 6]", PLANE, [[1, 2, 3], [4, 5, 6]]),
        ("[[1, 2, 3], [4, 5, 6]]", PLANE, [[1, 2, 3], [4, 5, 6]]),
        ("[6(1)]", PLANE, [[1, 1, 1], [1, 1, 1]]),
        ("[[1, 2], [3]]", ROWS, [[1, 2], [3, 0]]),
        ("[1, -2, 3]", ROWS, [[1, -2], [3, 0]]),
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


NESTED = """
TYPE
    ST_In : STRUCT a : INT := 1; b : INT := 2; c : BIT := TRUE; d : BIT; END_STRUCT
    ST_Out : STRUCT
        i : ST_In := (a := 7, b := 8, c := FALSE);
        g : ARRAY [0..1] OF ST_In := [(a := 5), (b := 6)];
        n : INT := 9;
    END_STRUCT
    ST_Alias : ST_In := (a := 20, b := 30);
END_TYPE
FUNCTION_BLOCK FB VAR st : ST_Out := (i := (a := 4)); END_VAR END_FUNCTION_BLOCK
VAR_GLOBAL
    o : ST_Out := %s;
    x : ST_Alias := (a := 3);
    f : FB := (st := (i := (d := TRUE)));
END_VAR"""


@pytest.mark.parametrize(
    ("initial", "expected"),
    [
        ("(n := 9)", ((7, 8, False), (5, 2), (1, 6))),
        ("(i := (a := 3))", ((3, 8, False), (5, 2), (1, 6))),
        ("(i := (c := TRUE), g := [(b := 3)])", ((7, 8, True), (5, 3), (1, 6))),
        ("(g := [(b := 3), (a := 4, b := 4)])", ((7, 8, False), (5, 3), (4, 4))),
    ],
)
def test_what_an_inner_value_leaves_out_is_as_the_outer_type_has_it(
    initial: str, expected: tuple[tuple[int, ...], ...]
) -> None:
    record = declare([parse(NESTED % initial)]).globals["gvl"].__iec__
    o, x, f = (item.type.decode(item.initial_bytes()) for item in record.members)
    assert (o.i.a, o.i.b, o.i.c) == expected[0]
    assert tuple((item.a, item.b) for item in o.g) == expected[1:]
    assert (x.a, x.b) == (3, 30)
    assert (f.st.i.a, f.st.i.b, f.st.i.c, f.st.i.d) == (4, 8, False, True)
