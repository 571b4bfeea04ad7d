"""Types: words of values, and whole numbers in the order of the values."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.scope.types import SCOPE_TYPES, ScopeError, ScopeType, type_of_number, type_of_words

TYPES = st.sampled_from(sorted(SCOPE_TYPES.values(), key=lambda row: row.name))
BOUNDS = st.floats(allow_nan=False) | st.integers(-300, 300).map(float) | st.just(-0.0)


def values_of(type: ScopeType) -> st.SearchStrategy[float]:
    if type.real:
        return st.floats(allow_nan=False, width=32 if type.size == 4 else 64)
    low, high = type.range
    return st.integers(low, high) | st.integers(max(low, -3), min(high, 3))


def test_the_names_of_the_export_and_of_the_language_name_the_same() -> None:
    assert type_of_words("lreal") is SCOPE_TYPES["REAL64"] is type_of_number(5)
    assert type_of_words(" DWORD ") is SCOPE_TYPES["UINT32"]
    assert type_of_words("STRING") is None
    assert type_of_number(30) is None
    assert {row.name: row.size for row in SCOPE_TYPES.values()} == {
        "BIT": 1, "INT8": 1, "UINT8": 1, "INT16": 2, "UINT16": 2, "INT32": 4, "UINT32": 4,
        "INT64": 8, "UINT64": 8, "REAL32": 4, "REAL64": 8,
    }  # fmt: skip


@given(TYPES, st.data())
def test_keys_have_the_order_of_the_values(type: ScopeType, data: st.DataObject) -> None:
    first, second = data.draw(values_of(type)), data.draw(values_of(type))
    keys = type.key(type.word(first)), type.key(type.word(second))
    if first < second:
        assert keys[0] < keys[1]
    least, most = type.keys
    assert least <= keys[0] <= most


@given(TYPES, BOUNDS, st.data())
def test_a_bound_parts_values_as_numbers_do(
    type: ScopeType, bound: float, data: st.DataObject
) -> None:
    value = data.draw(values_of(type) | (st.just(bound) if type.code == "d" else st.nothing()))
    key = type.key(type.word(value))
    assert (key >= type.key_from(bound)) == (value >= bound)
    assert (key <= type.key_up_to(bound)) == (value <= bound)


@pytest.mark.parametrize("name", ["REAL32", "REAL64"])
def test_not_a_number_is_beyond_all_values(name: str) -> None:
    type = SCOPE_TYPES[name]
    least, most = type.keys
    for nan in (math.nan, -math.nan):
        key = type.key(type.word(nan))
        assert key > most or key < least


@given(TYPES, st.data())
def test_a_word_has_the_value_first_and_else_zeros(type: ScopeType, data: st.DataObject) -> None:
    value = data.draw(values_of(type))
    content = struct.pack("<q", type.word(value))
    assert struct.unpack_from(f"<{type.code}", content)[0] == value
    assert content[type.size :] == bytes(8 - type.size)
    assert type.word(value) & type.mask == type.word(value)


def test_a_value_that_the_type_does_not_have_is_refused() -> None:
    with pytest.raises(ScopeError, match="300 is not a UINT8"):
        SCOPE_TYPES["UINT8"].word(300)


def test_numpy_knows_the_types() -> None:
    numpy = pytest.importorskip("numpy")
    for type in SCOPE_TYPES.values():
        assert numpy.dtype(type.array_code).itemsize == type.size
