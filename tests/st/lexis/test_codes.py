"""Codes of findings: their form, and that each stands once."""

import re

from achse.st.lexis.codes import Code


def test_a_code_is_two_letters_and_four_digits() -> None:
    for code in Code:
        assert re.fullmatch("[A-Z]{2}[0-9]{4}", code), code


def test_codes_are_in_order_and_unique() -> None:
    values = [code.value for code in Code]
    assert values == sorted(set(values))
    assert len(Code.__members__) == len(values)
