"""Constants come to what they would at run time."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import DINT, INT, LINT, REAL, UDINT, USINT, IntegerType
from achse.iec.times import DATE, DT, LTIME, TIME, TOD
from achse.iec.types import IecType
from achse.st.check.folding import cut, folded, rescaled, rounded
from achse.st.typed.expressions import Computed, Conversion, Converted, Known, Operator


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.5, 1), (2.5, 3), (-2.5, -3), (-0.5, -1), (1.5, 2), (0.49999999999999994, 0),
     (math.nan, 0), (1e30, -(1 << 63)), (math.inf, -(1 << 63))],
)  # fmt: skip
def test_reals_round_half_away_from_zero(value: float, expected: int) -> None:
    assert rounded(value) == expected


@given(st.integers(-(1 << 70), 1 << 70), st.sampled_from([USINT, INT, DINT, UDINT, LINT]))
def test_a_cut_keeps_the_low_bits(value: int, type: IntegerType) -> None:
    result = cut(value, type)
    assert type.low <= result <= type.high
    assert (result - value) % (1 << 8 * type.size) == 0


@pytest.mark.parametrize(
    ("count", "source", "target", "expected"),
    [
        (1, TIME, LTIME, 1_000_000),
        (1_999_999, LTIME, TIME, 1),
        (90_061, DT, DATE, 86_400),
        (90_061, DT, TOD, 3_661_000),
        (5, DT, TIME, 5000),
    ],
)
def test_times_change_their_unit(
    count: int, source: IecType[object], target: IecType[object], expected: int
) -> None:
    assert rescaled(count, source, target) == expected


@pytest.mark.parametrize(
    ("operator", "values", "type", "expected"),
    [
        (Operator.DIV, (-7, 2), DINT, -3),
        (Operator.MOD, (-7, 2), DINT, -1),
        (Operator.MOD, (7, 0), DINT, 0),
        (Operator.SHL, (1, 33), DINT, 2),
        (Operator.SHL, (1, -1), DINT, -(1 << 31)),
        (Operator.SHR, (-8, 1), DINT, -4),
        (Operator.ROL, (0x81, 1), USINT, 3),
        (Operator.ROR, (3, 1), USINT, 0x81),
        (Operator.LIMIT, (5, 7, 3), DINT, 3),
        (Operator.ADD, ((1 << 31) - 1, 1), DINT, -(1 << 31)),
    ],
)
def test_whole_numbers(
    operator: Operator, values: tuple[int, ...], type: IecType[object], expected: int
) -> None:
    operands = tuple(Known(value, type) for value in values)
    assert folded(Computed(operator, operands, type)) == Known(expected, type)


def test_undefined_operations_are_not_folded() -> None:
    for operator, values in ((Operator.DIV, (1.0, 0.0)), (Operator.SQRT, (-1.0,))):
        value = Computed(operator, tuple(Known(item, REAL) for item in values), REAL)
        assert folded(value) is value
    divided = Computed(Operator.DIV, (Known(1, DINT), Known(0, DINT)), DINT)
    assert folded(divided) is divided


def test_a_real_is_rounded_to_single_once() -> None:
    summed = Computed(Operator.ADD, (Known(16777216.0, REAL), Known(1.0, REAL)), REAL)
    assert folded(summed) == Known(16777216.0, REAL)


@pytest.mark.parametrize(
    ("value", "expected"),
    [(3.0e9, -(1 << 31)), (40000.5, 40000), (-1.9, -1), (math.nan, -(1 << 31))],
)
def test_truncation_out_of_range_gives_the_lowest(value: float, expected: int) -> None:
    node = Converted(Known(value, REAL), DINT, Conversion.TRUNCATE)
    assert folded(node) == Known(expected, DINT)
