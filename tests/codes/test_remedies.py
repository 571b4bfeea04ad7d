"""Remedies: each code that a newcomer meets has one, in the form of a hint."""

import pytest

from achse.codes import NcError, ReturnCode, code_of
from achse.codes.remedies import _REMEDIES, remedy_of

COMMON_ADS = (
    *(0x6, 0x7, 0x1B, 0x502, 0x508, 0x701, 0x702, 0x703, 0x704, 0x705, 0x706, 0x707),
    *(0x70C, 0x710, 0x711, 0x712, 0x714, 0x716, 0x723, 0x745, 0x274D),
)
COMMON_NC = (
    *(0x4003, 0x4012, 0x4052, 0x4220, 0x4221, 0x4222, 0x4223, 0x4225, 0x422F, 0x4231, 0x423B),
    *(0x4257, 0x4259, 0x425B, 0x425C, 0x4260, 0x4261, 0x4266, 0x4267, 0x42EF, 0x4460, 0x4461),
    *(0x4462, 0x4463, 0x4550, 0x4650, 0x4655, 0x4A18, 0x4B09),
)


@pytest.mark.parametrize("code", [*COMMON_ADS, *COMMON_NC], ids=hex)
def test_codes_that_a_newcomer_meets_have_a_remedy(code: int) -> None:
    assert code_of(code) is not None
    assert remedy_of(code)


def test_a_remedy_is_part_of_a_sentence() -> None:
    for code, text in _REMEDIES.items():
        assert code_of(code) is not None
        assert text == text.strip()
        assert text[0].islower() or text[0] == "`", text
        assert not text.endswith("."), text


def test_codes_without_a_remedy_have_an_empty_one() -> None:
    assert remedy_of(ReturnCode.NO_ERROR.number) == ""
    assert remedy_of(NcError.INTERNAL_ERROR.number) == ""
    assert remedy_of(0xFFFF_FFFF) == ""
