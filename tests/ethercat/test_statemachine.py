"""The table of states and requests."""

import pytest

from achse.codes import AlState, AlStatus
from achse.ethercat.statemachine import TRANSITIONS, Light, Transition, request

STATES = (AlState.INIT, AlState.PREOP, AlState.BOOT, AlState.SAFEOP, AlState.OP)

REFUSED = {
    # 001 table 2.10.1; from Init to Bootstrap the slave refuses that has none
    ("INIT", "SAFEOP"): AlStatus.INVALID_CHANGE,
    ("INIT", "OP"): AlStatus.INVALID_CHANGE,
    ("PREOP", "OP"): AlStatus.INVALID_CHANGE,
    ("PREOP", "BOOT"): AlStatus.INVALID_CHANGE,
    ("SAFEOP", "BOOT"): AlStatus.INVALID_CHANGE,
    ("OP", "BOOT"): AlStatus.INVALID_CHANGE,
    ("BOOT", "PREOP"): AlStatus.INVALID_CHANGE,
    ("BOOT", "SAFEOP"): AlStatus.INVALID_CHANGE,
    ("BOOT", "OP"): AlStatus.INVALID_CHANGE,
}


def test_each_request_in_each_state_has_its_row() -> None:
    assert set(TRANSITIONS) == {(state, wanted) for state in STATES for wanted in AlState}


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("number", range(16))
def test_a_request_is_refused_stays_or_leads_to_the_requested_state(
    state: AlState, number: int
) -> None:
    meaning = request(state, number)
    if number not in list(AlState):
        assert meaning is AlStatus.UNKNOWN_STATE
    elif refusal := REFUSED.get((state.name, AlState(number).name)):
        assert meaning is refusal
    elif number == state:
        assert meaning is AlStatus.NO_ERROR
    else:
        assert isinstance(meaning, Transition)
        assert meaning.target == number


def test_a_transitions_name_is_from_where_to_where() -> None:
    letters = {state: state.name[0] for state in STATES}
    for (state, wanted), meaning in TRANSITIONS.items():
        if isinstance(meaning, Transition):
            assert meaning.name == letters[state] + letters[wanted]


def test_upwards_goes_one_step_at_a_time() -> None:
    up = {meaning for (state, to), meaning in TRANSITIONS.items() if to > state}
    assert {each for each in up if isinstance(each, Transition)} == {
        Transition.IP,
        Transition.PS,
        Transition.SO,
        Transition.IB,
    }


def test_each_state_has_its_light() -> None:
    assert [Light(state).name for state in STATES] == [
        *("OFF", "BLINKING", "FLICKERING", "SINGLE_FLASH", "ON")
    ]
