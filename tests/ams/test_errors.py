"""The error tree: what it says, what it carries."""

import copy
import pickle

import pytest

from achse.ams import (
    AdsError,
    ConnectionLost,
    DecodeError,
    DeviceError,
    RequestTimeout,
    RouterError,
)
from achse.ams.errors import CodedError, describe_code
from achse.codes import ReturnCode


def test_a_code_is_described_by_its_row() -> None:
    assert describe_code(0x710) == "0x710 SYMBOL_NOT_FOUND: Symbol not found."


def test_an_nc_error_is_described_by_its_row() -> None:
    assert describe_code(0x4012) == "0x4012 AXIS_ID: Axis id out of range."


def test_a_code_without_row_is_described_by_its_number() -> None:
    assert describe_code(0x40) == "0x40"


@pytest.mark.parametrize("kind", [RouterError, DeviceError])
def test_errors_carry_the_number_that_travelled(kind: type[CodedError]) -> None:
    error = kind(ReturnCode.SYMBOL_NOT_FOUND, "MAIN.x")
    assert error.code == 0x710
    assert error.return_code is ReturnCode.SYMBOL_NOT_FOUND
    assert str(error) == "MAIN.x: 0x710 SYMBOL_NOT_FOUND: Symbol not found."
    assert str(kind(0x710)) == "0x710 SYMBOL_NOT_FOUND: Symbol not found."


def test_a_number_of_another_table_is_carried_as_it_is() -> None:
    error = DeviceError(0xABCD)
    assert (error.code, error.return_code) == (0xABCD, None)


def test_a_time_out_is_0x745() -> None:
    assert RequestTimeout("read").code == 0x745


@pytest.mark.parametrize(
    "error",
    [
        DecodeError("x"),
        RouterError(6, "c"),
        DeviceError(ReturnCode.BUSY),
        ConnectionLost("x"),
        RequestTimeout("read"),
    ],
)
def test_all_are_ads_errors_and_can_be_copied(error: AdsError) -> None:
    assert isinstance(error, AdsError)
    for twin in (copy.copy(error), pickle.loads(pickle.dumps(error))):
        assert type(twin) is type(error)
        assert str(twin) == str(error)
