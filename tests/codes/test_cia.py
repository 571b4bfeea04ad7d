"""Data types of an object dictionary."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import DataType


@pytest.mark.parametrize(
    ("kind", "least", "most", "number"),
    [
        (DataType.I8, -128, 127, 2),
        (DataType.I16, -32768, 32767, 3),
        (DataType.I32, -(2**31), 2**31 - 1, 4),
        (DataType.U8, 0, 255, 5),
        (DataType.U16, 0, 65535, 6),
        (DataType.U32, 0, 2**32 - 1, 7),
    ],
)
def test_types(kind: DataType, least: int, most: int, number: int) -> None:
    assert (kind.least, kind.most, int(kind)) == (least, most, number)
    assert kind.unpack(kind.pack(least)) == least
    assert kind.unpack(kind.pack(most)) == most


@given(st.sampled_from([kind for kind in DataType if kind.form]), st.data())
def test_values_travel_unchanged(kind: DataType, data: st.DataObject) -> None:
    if kind.is_real:
        value: float = data.draw(st.floats(float(kind.least), float(kind.most)))
        value = kind.unpack(kind.pack(value))
        assert kind.least <= value <= kind.most
    else:
        value = data.draw(st.integers(int(kind.least), int(kind.most)))
    assert kind.unpack(kind.pack(value)) == value
    assert len(kind.pack(value)) * 8 == kind.bits


def test_a_text_has_no_range() -> None:
    with pytest.raises(TypeError, match="VISIBLE_STRING is not a type of numbers"):
        _ = DataType.VISIBLE_STRING.most
