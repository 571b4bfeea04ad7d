"""The errors of axes."""

import copy
import pickle

import pytest

from achse.ams import AdsError, DeviceError
from achse.client.nc import AxisAborted, AxisError, AxisRefused
from achse.client.nc import errors as module
from tests.public_names import public_names


def test_they_name_axis_code_and_meaning() -> None:
    error = AxisError(0x4650, "X")
    assert (error.code, error.axis) == (0x4650, "X")
    assert str(error).startswith("X: 0x4650 ")
    assert str(AxisAborted(0, "X", "was stopped")) == "X: was stopped"


@pytest.mark.parametrize("name", public_names(module))
def test_each_is_an_ads_error_that_can_be_copied(name: str) -> None:
    kind: type[AxisError] = getattr(module, name)
    error = kind(0x4260, "Y", "in error")
    assert issubclass(kind, AdsError)
    copies: list[AxisError] = [copy.copy(error), pickle.loads(pickle.dumps(error))]
    for again in copies:
        assert type(again) is kind
        assert (again.code, again.axis, str(again)) == (error.code, "Y", str(error))


def test_a_refusal_is_what_a_device_answered() -> None:
    assert issubclass(AxisRefused, DeviceError)
