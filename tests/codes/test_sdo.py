"""The SDO abort codes."""

import pytest

from achse.codes import AbortCode, SdoAbort


@pytest.mark.parametrize(
    ("number", "code"),
    [
        (0x06010000, AbortCode.UNSUPPORTED_ACCESS),
        (0x06010002, AbortCode.READ_ONLY),
        (0x06020000, AbortCode.NO_OBJECT),
        (0x06040042, AbortCode.PDO_LENGTH),
        (0x06090030, AbortCode.VALUE_RANGE),
        (0x05030000, AbortCode.TOGGLE),
        (0x06090011, AbortCode.NO_SUBINDEX),
    ],
)
def test_codes_that_masters_meet(number: int, code: AbortCode) -> None:
    assert AbortCode.of(number) is code
    assert int(code) == number


def test_each_code_has_a_meaning_of_its_own() -> None:
    assert len({code.text for code in AbortCode}) == len(AbortCode.__members__)
    assert all(code.text.endswith(".") for code in AbortCode)


def test_an_abort_says_number_and_meaning() -> None:
    abort = SdoAbort(AbortCode.READ_ONLY)
    assert abort.code is AbortCode.READ_ONLY
    assert str(abort) == "0x06010002: Object is read-only."


def test_numbers_without_a_row_are_none() -> None:
    assert AbortCode.of(1) is None
