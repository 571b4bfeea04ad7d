"""The AL status table against the manual's."""

import pytest

from achse.codes import AlState, AlStatus, ErrorLight

MANUAL = {
    # 001 table 2.10.1: code, result state where it is not the present one, ERR light
    0x0000: (None, "off"),
    0x0011: (None, "blinking"),
    0x0012: (None, "blinking"),
    0x0013: (None, "blinking"),
    0x0016: (AlState.INIT, "blinking"),
    0x001A: (AlState.SAFEOP, "single flash"),
    0x001B: (AlState.SAFEOP, "double flash"),
    0x001D: (AlState.PREOP, "blinking"),
    0x001E: (AlState.PREOP, "blinking"),
    0x0035: (AlState.PREOP, "blinking"),
    0x8000: (AlState.INIT, "blinking"),
}


@pytest.mark.parametrize("number", MANUAL)
def test_the_manuals_codes_have_its_result_and_light(number: int) -> None:
    code = AlStatus.of(number)
    assert code is not None
    assert (code.result, code.light) == (MANUAL[number][0], ErrorLight(MANUAL[number][1]))
    assert int(code) == number


def test_each_code_has_a_meaning_of_its_own() -> None:
    assert len({code.text for code in AlStatus}) == len(AlStatus.__members__)
    assert all(code.text.endswith(".") for code in AlStatus)


@pytest.mark.parametrize("number", [0x0003, -1, 0xFFFF])
def test_numbers_without_a_row_are_none(number: int) -> None:
    assert AlStatus.of(number) is None
