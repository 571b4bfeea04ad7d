"""What emitted code computes with: rounding, division, mathematics at its limits."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.plc.code.faults import ExceptionCode, PlcFault
from achse.plc.code.operations import (
    OPERATIONS,
    out_of_bounds,
    quotient,
    real_operations,
    remainder,
    rotated,
    single,
)


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.5, 1), (2.5, 3), (-2.5, -3), (-0.5, -1), (0.49999999999999994, 0), (1e30, -(1 << 63)),
     (math.nan, 0), (-9.0, -9)],
)  # fmt: skip
def test_reals_round_halves_away_from_zero(value: float, expected: int) -> None:
    assert OPERATIONS["whole"](value) == expected


@given(st.integers(-(1 << 63), (1 << 63) - 1), st.integers(-(1 << 63), (1 << 63) - 1))
def test_division_is_towards_zero_and_mod_has_the_left_sign(left: int, right: int) -> None:
    rest = remainder(left, right)
    if right == 0:
        assert rest == 0
        with pytest.raises(PlcFault) as stopped:
            quotient(left, right)
        assert stopped.value.code == ExceptionCode.DIVIDEBYZERO
        return
    assert quotient(left, right) * right + rest == left
    assert abs(rest) < abs(right)
    assert rest == 0 or (rest < 0) == (left < 0)


@given(st.integers(0, 255), st.integers(-100, 100))
def test_rotating_there_and_back_changes_nothing(value: int, count: int) -> None:
    assert rotated(rotated(value, count, 8), -count, 8) == value


def test_single_precision_overflows_to_infinity() -> None:
    assert single(1e39) == math.inf
    assert single(0.1) == 0.10000000149011612


def test_an_index_outside_says_what_there_is() -> None:
    with pytest.raises(PlcFault, match=r"ARRAYBOUNDS 16#101: index 7, the array has 1..5"):
        out_of_bounds(7, 1, 5)


def test_the_task_option_decides_what_undefined_reals_are() -> None:
    loud, quiet = real_operations(exceptions=True), real_operations(exceptions=False)
    assert quiet["divided"](1.0, 0.0) == math.inf
    assert quiet["divided"](-1.0, 0.0) == -math.inf
    assert math.isnan(quiet["divided"](0.0, 0.0))
    assert math.isnan(quiet["sqrt"](-1.0))
    assert quiet["log"](0.0) == -math.inf
    for name, values, code in [
        ("divided", (1.0, 0.0), ExceptionCode.FPU_DIVIDEBYZERO),
        ("sqrt", (-1.0,), ExceptionCode.FPU_INVALID_OPERATION),
        ("log", (0.0,), ExceptionCode.FPU_DIVIDEBYZERO),
    ]:
        with pytest.raises(PlcFault) as stopped:
            loud[name](*values)
        assert stopped.value.code == code


def test_choices() -> None:
    assert OPERATIONS["chosen"](-1, 1, 2, 3) == 3
    assert OPERATIONS["selected"](True, 1, 2) == 2
    assert OPERATIONS["truncated"](3.0e9, -(1 << 31)) == -(1 << 31)
    assert OPERATIONS["truncated"](-3.9, -(1 << 31)) == -3
