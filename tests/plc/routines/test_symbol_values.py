"""Parts of values, and numbers as text."""

from struct import pack, unpack
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import BOOL, INT
from achse.iec.structs import StructType
from achse.iec.variables import Variable
from achse.plc.routines.symbol_values import members, real_text


@pytest.mark.parametrize(
    ("value", "size", "text"),
    [
        (0.1, 8, "0.1"),
        (2.0, 8, "2"),
        (unpack("<f", pack("<f", 0.1))[0], 4, "0.1"),
        (1e30, 8, "1e+30"),
    ],
)
def test_number_has_few_digits(value: float, size: int, text: str) -> None:
    assert real_text(value, size) == text


@given(st.floats(allow_nan=False, allow_infinity=False, width=32))
def test_real_is_brought_back(value: float) -> None:
    assert unpack("<f", pack("<f", float(real_text(value, 4))))[0] == value


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_lreal_is_brought_back(value: float) -> None:
    assert float(real_text(value, 8)) == value


def test_members_come_in_the_order_of_the_declaration() -> None:
    type: StructType[Any] = StructType("ST", [Variable(INT, name="b"), Variable(BOOL, name="a")])
    assert [member.name for member in members(type)] == ["b", "a"]
