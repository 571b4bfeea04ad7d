"""Arguments are looked at before anything is sent."""

from decimal import Decimal
from typing import Any

import pytest

from achse.client.nc.arguments import buffer_mode, choice, real, seconds
from achse.codes.axis import BufferMode


@pytest.mark.parametrize("value", [0, -1, 2.5, True, Decimal("1.5")])
def test_numbers(value: Any) -> None:
    assert real("position", value) == float(value)


@pytest.mark.parametrize(
    "value", [float("nan"), float("inf"), -float("inf"), "1", None, 10**400, [], b"1", 1j]
)
def test_what_is_not_a_finite_number(value: Any) -> None:
    with pytest.raises(ValueError, match=r"position: expected a finite number, got"):
        real("position", value)


@pytest.mark.parametrize(
    ("value", "limit"), [(None, None), (0, 0.0), (1.5, 1.5), (float("inf"), None), (1e12, None)]
)
def test_time_limits(value: float | None, limit: float | None) -> None:
    assert seconds("within", value) == limit


@pytest.mark.parametrize("value", [-1.0, float("nan"), "soon"])
def test_what_is_not_a_time_limit(value: Any) -> None:
    with pytest.raises(ValueError, match="within: expected"):
        seconds("within", value)


@pytest.mark.parametrize("value", [BufferMode.BLENDING_LOW, "blending low", " Blending_Low "])
def test_buffer_modes_by_name(value: BufferMode | str) -> None:
    assert buffer_mode(value) is BufferMode.BLENDING_LOW


@pytest.mark.parametrize("value", ["blend", 1, None, []])
def test_what_is_not_a_buffer_mode(value: Any) -> None:
    with pytest.raises(ValueError, match="'aborting', 'buffered'"):
        buffer_mode(value)


def test_words() -> None:
    assert choice("direction", "+", {"+": 0, "-": 1}) == 0
    with pytest.raises(ValueError, match=r"direction: expected '\+', '-', got 'up'"):
        choice("direction", "up", {"+": 0, "-": 1})
