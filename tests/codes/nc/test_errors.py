"""The NC error table."""

import subprocess
import sys

import pytest

from achse.codes import NcError, ReturnCode
from achse.codes.nc.error_texts import axes, general, groups, tables


def test_each_error_has_a_number_in_the_range_and_a_meaning() -> None:
    for error in NcError:
        assert 0x4000 <= error.number <= 0x4FFF, error
        assert error.name.isupper(), error
        assert error.text.endswith("."), error
        assert error.text[0].isupper() or not error.text[0].isalpha(), error


def test_numbers_are_unique_and_ascend() -> None:
    numbers = [error.number for error in NcError]
    assert numbers == sorted(set(numbers))
    assert len(numbers) == len(NcError.__members__) == 533


@pytest.mark.parametrize(
    ("number", "error"),
    [
        (0x4012, NcError.AXIS_ID),
        (0x4221, NcError.SET_VELOCITY_NOT_ALLOWED),
        (0x4223, NcError.ENABLE_MISSING),
        (0x4260, NcError.CONTROLLER_ENABLE_MISSING),
        (0x42EF, NcError.AXIS_LOCKED_BY_STOP),
        (0x435C, NcError.PEH_TIME_OVER),
        (0x4461, NcError.SOFT_LIMIT_MAX_AT_START),
        (0x4550, NcError.FOLLOWING_ERROR_POSITION),
        (0x4655, NcError.DRIVE_IO_INVALID),
        (0x4A06, NcError.TABLE_NOT_MONOTONIC),
        (0x4B07, NcError.PLC_TIMEOUT),
        (0x4C02, NcError.TRANSFORMATION_WORKSPACE),
    ],
)
def test_errors_that_clients_meet(number: int, error: NcError) -> None:
    assert NcError.of(number) is error
    assert int(error) == number


@pytest.mark.parametrize("number", [0, 0x4005, 0x710, -1, 0x5000])
def test_numbers_without_a_row_are_none(number: int) -> None:
    assert NcError.of(number) is None


def test_the_number_space_is_shared_with_ads() -> None:
    assert not {error.number for error in NcError} & {code.number for code in ReturnCode}


def test_each_error_has_one_text_and_each_text_an_error() -> None:
    names = [name for table in (axes, general, groups, tables) for name in table.TEXTS]
    assert sorted(names) == sorted(NcError.__members__)


def test_texts_are_imported_when_they_are_needed() -> None:
    code = (
        "import sys; from achse.codes import NcError\n"
        "loaded = lambda: 'achse.codes.nc.error_texts' in sys.modules\n"
        "print(loaded(), NcError.AXIS_ID.text, loaded())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False Axis id out of range. True\n"
