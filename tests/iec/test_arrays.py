"""Arrays: lists as values, views in memory."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.arrays import Array, ArrayType, Bounds
from achse.iec.elementary import BIT, BOOL, BYTE, INT, LREAL, UDINT
from achse.iec.errors import DeclarationError, IecDecodeError, IecPathError, IecValueError
from achse.iec.strings import STRING
from achse.iec.times import TIME
from achse.iec.types import IecType


def array(element: IecType[Any], *bounds: tuple[int, int]) -> ArrayType[Any]:
    return ArrayType(element, [Bounds(*pair) for pair in bounds])


@pytest.mark.parametrize(
    ("type", "name", "size"),
    [
        (array(BYTE, (0, 1023)), "ARRAY [0..1023] OF BYTE", 1024),
        (array(INT, (-1, 1), (1, 2)), "ARRAY [-1..1,1..2] OF INT", 12),
        (array(array(INT, (0, 1)), (0, 2)), "ARRAY [0..2] OF ARRAY [0..1] OF INT", 12),
        (array(STRING(4), (1, 3)), "ARRAY [1..3] OF STRING(4)", 15),
    ],
)
def test_name_and_size(type: ArrayType[Any], name: str, size: int) -> None:
    assert (type.name, type.size) == (name, size)
    assert type.adst == (30 if "STRING" in name else type.element.adst)


def test_the_last_dimension_runs_fastest() -> None:
    type = array(BYTE, (0, 1), (0, 2))
    assert type.encode([[1, 2, 3], [4, 5, 6]]) == bytes([1, 2, 3, 4, 5, 6])
    assert type.decode(bytes([1, 2, 3, 4, 5, 6])) == [[1, 2, 3], [4, 5, 6]]
    assert type.strides == (3, 1)


COUNTS = st.lists(st.integers(1, 4), min_size=1, max_size=3)


@given(COUNTS, st.data())
def test_any_shape_comes_back(counts: list[int], data: st.DataObject) -> None:
    def values(shape: list[int], item: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
        if not shape:
            return item
        return st.lists(values(shape[1:], item), min_size=shape[0], max_size=shape[0])

    bounds = [(low, low + n - 1) for n in counts for low in [data.draw(st.integers(-9, 9))]]
    for element, items in (
        (INT, st.integers(-(2**15), 2**15 - 1)),
        (BOOL, st.booleans()),
        (TIME, st.integers(0, 2**32 - 1).map(lambda n: TIME.to_python(n))),
    ):
        type = array(element, *bounds)
        value = data.draw(values(counts, items))
        assert type.decode(type.encode(value)) == value
        view = type.read(bytearray(type.encode(value)), 0)
        assert view == value


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([1, 2], r"takes a list of 3 values, got \[1, 2\]"),
        (5, "takes a list of 3 values, got 5"),
        ("abc", "takes a list of 3 values, got 'abc'"),
        ({1: 2, 3: 4, 5: 6}, "takes a list of 3 values"),
        ([1, 2, 70_000], r"element \[1\]: INT takes an integer in -32768..32767, got 70000"),
        ([1, None, 3], r"element \[0\]: INT takes"),
    ],
)
def test_what_does_not_fit_is_refused_by_its_index(value: object, message: str) -> None:
    with pytest.raises(IecValueError, match=message):
        array(INT, (-1, 1)).encode(value)


def test_the_refused_element_of_several_dimensions() -> None:
    with pytest.raises(IecValueError, match=r"element \[2,6\]: BYTE"):
        array(BYTE, (1, 2), (5, 7)).encode([[1, 2, 3], [4, 500, 6]])
    with pytest.raises(IecValueError, match="a list of 3 values in dimension 2"):
        array(BYTE, (1, 2), (5, 7)).encode([[1, 2, 3], [4, 5]])


def test_tuples_ranges_bytes_and_views_are_taken() -> None:
    type = array(BYTE, (1, 3))
    assert type.encode((1, 2, 3)) == type.encode(range(1, 4)) == type.encode(b"\1\2\3")
    assert type.encode(type.read(bytearray(b"\1\2\3"), 0)) == b"\1\2\3"
    with pytest.raises(IecValueError, match=r"ARRAY \[1..3\] OF BYTE takes"):
        type.encode(b"\1\2")


def test_impossible_arrays() -> None:
    with pytest.raises(DeclarationError, match="at least one dimension"):
        ArrayType(INT, [])
    with pytest.raises(DeclarationError, match="BIT cannot be the element"):
        array(BIT, (0, 1))
    with pytest.raises(DeclarationError, match="T_Empty has no size"):
        array(IecType("T_Empty", 0, 1, 65), (0, 2**31 - 1))
    for bounds in ((5, 3), (0, 2**31), (-(2**31) - 1, 0)):
        with pytest.raises(DeclarationError, match="array bounds"):
            array(INT, bounds)


def test_an_empty_array_is_an_empty_list() -> None:
    for type in (array(INT, (0, -1)), array(INT, (0, 4), (0, -1)), array(INT, (0, -1), (0, 4))):
        assert type.decode(type.encode([])) == []


def test_too_few_bytes_are_refused_before_anything_is_made() -> None:
    huge = array(LREAL, (0, 2**31 - 1), (0, 2**30))
    with pytest.raises(IecDecodeError, match="got 3"):
        huge.decode(b"abc")


def test_a_view_is_indexed_by_the_declared_bounds() -> None:
    memory = bytearray(20)
    view: Array[Any] = array(INT, (-1, 1), (1, 2)).read(memory, 4)
    view[-1, 1] = 1
    view[1, 2] = 6
    view[0] = [3, 4]
    assert bytes(memory) == bytes(4) + bytes([1, 0, 0, 0, 3, 0, 4, 0, 0, 0, 6, 0]) + bytes(4)
    assert view[0, 2] == view[0][2] == 4
    assert view[0] == [3, 4]
    assert view == [[1, 0], [3, 4], [0, 6]]
    assert view.tolist() == [[1, 0], [3, 4], [0, 6]]
    assert [list(row) for row in view] == view.tolist()
    assert len(view) == 3
    assert repr(view) == "Array[-1..1,1..2]([[1, 0], [3, 4], [0, 6]])"


def test_a_one_dimensional_view() -> None:
    memory = bytearray(12)
    view: Array[int] = array(UDINT, (1, 3)).read(memory, 0)
    view[2] = 7
    view[3] += 1
    assert list(view) == [0, 7, 1]
    assert 7 in view
    assert 8 not in view
    assert view.tobytes() == bytes(memory)
    assert view != [1]
    assert view != 5
    with pytest.raises(IecValueError, match="UDINT takes"):
        view[1] = -1
    for index in (0, 4, 10**30):
        with pytest.raises(IecPathError, match=r"is outside 1..3 of ARRAY"):
            view[index]
        with pytest.raises(IecPathError, match=r"is outside 1..3 of ARRAY"):
            view[index] = 0
    with pytest.raises(IecPathError, match="has 1 dimensions, got 2 indices"):
        view[1, 1]


def test_a_refused_write_changes_nothing() -> None:
    memory = bytearray(b"\1\2\3")
    with pytest.raises(IecValueError, match="element"):
        array(BYTE, (0, 2)).write(memory, 0, [9, 9, 999])
    assert memory == b"\1\2\3"
