"""Codes by their numbers, whichever table has them."""

from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError, ReturnCode, code_of


@given(st.one_of(st.sampled_from([*ReturnCode]).map(int), st.sampled_from([*NcError]).map(int)))
def test_every_code_of_a_table_is_found(number: int) -> None:
    result = code_of(number)
    assert result is not None
    assert result in (ReturnCode.of(number), NcError.of(number))


@given(st.integers(0, 0xFFFF_FFFF))
def test_others_are_none(number: int) -> None:
    known = ReturnCode.of(number) is not None or NcError.of(number) is not None
    assert (code_of(number) is not None) == known
