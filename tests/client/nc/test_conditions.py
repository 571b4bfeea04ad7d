"""What `wait_for` takes."""

from dataclasses import replace
from typing import Any

import pytest

from achse.client.nc import AxisFailed, AxisStatus, PlcOpenState
from achse.client.nc.conditions import CONDITIONS, ConditionCompletion, condition_of
from achse.client.nc.services import CYCLIC, services
from achse.codes.axis import StateBit

REST = AxisStatus.of(services()[CYCLIC]["nc_to_plc_structure"].layout.decode(bytes(256)))


@pytest.mark.parametrize("word", CONDITIONS)
def test_words(word: str) -> None:
    holds, name = condition_of(word.upper().replace(" ", "_"))
    assert name == word
    assert isinstance(holds(REST), bool)


@pytest.mark.parametrize("condition", ["in taget", "", 7, None, 1.5])
def test_what_is_not_a_condition(condition: Any) -> None:
    with pytest.raises(ValueError, match="got"):
        condition_of(condition)


def test_near_misses() -> None:
    with pytest.raises(ValueError, match="did you mean 'in target'"):
        condition_of("in taget")


def test_states_bits_and_functions() -> None:
    homed = replace(REST, state_word=int(StateBit.HOMED))
    assert condition_of(StateBit.HOMED)[0](homed)
    assert condition_of(PlcOpenState.DISABLED)[0](REST)
    assert condition_of(lambda status: status.position == 0.0)[0](REST)


def test_an_error_that_comes_meanwhile_ends_it_an_old_one_does_not() -> None:
    failed = replace(REST, error_code=0x4650)
    completion = ConditionCompletion("X", lambda status: False)
    assert not completion.check(REST)
    with pytest.raises(AxisFailed, match="0x4650"):
        completion.check(failed)
    patient = ConditionCompletion("X", lambda status: not status.failed)
    assert not patient.check(failed)
    assert patient.check(REST)
