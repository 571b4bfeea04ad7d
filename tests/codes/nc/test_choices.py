"""Enumerations of parameters and states are those that the motion core works with."""

from enum import IntEnum

import pytest

from achse.codes.nc import choices
from achse.motion import states
from tests.public_names import public_names

KINDS: list[type[IntEnum]] = [getattr(choices, name) for name in public_names(choices)]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_numbers_and_names_are_those_of_the_motion_core(kind: type[IntEnum]) -> None:
    assert states.choices_of(kind.__name__) is kind
