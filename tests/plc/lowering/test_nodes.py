"""The lowered form: places that are aligned whatever their indexes are."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import DINT, IntegerType
from achse.plc.lowering.nodes import Home, ResolvedPlace, Temporary, Term
from achse.st.check.kinds import UNSIGNED

SIZES = st.sampled_from((1, 2, 4, 8))


@given(
    st.sampled_from(Home),
    st.integers(-64, 64),
    SIZES,
    SIZES,
    st.booleans(),
    st.lists(st.integers(-24, 24), max_size=3),
    st.data(),
)
def test_aligned_place_is_a_multiple_of_its_size_for_all_indexes(
    home: Home, offset: int, size: int, alignment: int, bounded: bool, strides: list[int], data: Any
) -> None:
    type: IntegerType = UNSIGNED[size]
    terms = tuple(Term(Temporary(1, DINT), stride) for stride in strides)
    place = ResolvedPlace(home, offset, type, None, terms, bounded, alignment=alignment)
    is_aligned = place.is_aligned(size)
    if is_aligned:
        assert home in (Home.AREA, Home.INSTANCE, Home.FRAME)
        assert bounded
        begin = data.draw(st.integers(0, 99)) * (8 if home is Home.AREA else alignment)
        indexes = data.draw(st.lists(st.integers(-9, 9), min_size=3, max_size=3))
        address = begin + offset + sum(map(int.__mul__, indexes, strides))
        assert address % size == 0
    elif home is Home.AREA and bounded:
        assert offset % size or any(stride % size for stride in strides)
    assert place.is_fixed is (not strides and home is not Home.ADDRESS)
