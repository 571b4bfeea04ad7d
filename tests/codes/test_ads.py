"""The return code table against the keys of the manuals' tables."""

import csv
from pathlib import Path

import pytest

from achse.codes import ReturnCode

KEYS = Path(__file__).parents[1] / "data" / "ads_errors.tsv"
"""Number and vendor name of each printed row; positive HRESULTs by their own number."""


def _keys() -> list[tuple[int, str]]:
    with KEYS.open(encoding="utf-8", newline="") as file:
        return [(int(row["hex"], 16), row["name"]) for row in csv.DictReader(file, delimiter="\t")]


def test_the_table_has_exactly_the_printed_rows() -> None:
    keys = _keys()
    assert len(keys) == 143
    assert sorted((code.number, code.vendor_name) for code in ReturnCode) == sorted(keys)


def test_each_code_has_a_meaning() -> None:
    for code in ReturnCode:
        assert code.text.endswith("."), code
        assert code.name.isupper(), code


@pytest.mark.parametrize(("number", "name"), _keys())
def test_each_number_is_found(number: int, name: str) -> None:
    code = ReturnCode.of(number)
    assert code is not None
    assert int(code) == number
    if not name.startswith("S_") or number > 1:
        assert code.vendor_name == name


def test_errors_go_before_positive_hresults_of_the_same_number() -> None:
    assert ReturnCode.of(0) is ReturnCode.NO_ERROR
    assert ReturnCode.of(1) is ReturnCode.INTERNAL_ERROR
    assert ReturnCode.S_FALSE.number == 1


def test_hresults() -> None:
    assert ReturnCode.SYMBOL_NOT_FOUND.hresult == 0x98110710
    assert ReturnCode.S_PENDING.hresult == 0x203
    assert ReturnCode.SOCKET_TIMED_OUT.hresult is None
    assert ReturnCode(0x98110710) is ReturnCode.SYMBOL_NOT_FOUND  # type: ignore[call-arg]


@pytest.mark.parametrize("number", [0x4650, 0x40, -1, 0xFFFFFFFF])
def test_numbers_without_a_row_are_none(number: int) -> None:
    assert ReturnCode.of(number) is None
