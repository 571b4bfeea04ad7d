"""The place in a part program on the wire."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes.program_place import FORMAT, ProgramPlaceRow

NUMBER = st.integers(0, 2**32 - 1)
WAY = st.floats(allow_nan=False)


@given(NUMBER, NUMBER, NUMBER, NUMBER, st.tuples(WAY, WAY, WAY), st.text("abÄ/.", max_size=259))
def test_a_place_comes_back_from_its_bytes(
    kind: int, line: int, block: int, counter: int, at: tuple[float, float, float], file: str
) -> None:
    place = ProgramPlaceRow(kind, line, block, counter, at, file)
    data = struct.pack(FORMAT, *place.fields)
    assert len(data) == ProgramPlaceRow.size()
    assert ProgramPlaceRow.decode(data) == place


def test_a_long_name_is_cut_with_its_end() -> None:
    data = struct.pack(FORMAT, *ProgramPlaceRow(1, file="x" * 300).fields)
    assert ProgramPlaceRow.decode(data).file == "x" * 259


def test_another_length_is_refused() -> None:
    with pytest.raises(struct.error):
        ProgramPlaceRow.decode(bytes(7))
