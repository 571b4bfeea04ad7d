"""ADS states and transmission modes against the numbers that travel."""

from achse.ams import AdsState, TransmissionMode


def test_states_are_0_to_19() -> None:
    assert [state.value for state in AdsState] == list(range(20))


def test_states_that_clients_look_for() -> None:
    assert (AdsState.RESET, AdsState.RUN, AdsState.STOP) == (2, 5, 6)
    assert (AdsState.CONFIG, AdsState.RECONFIG, AdsState.EXCEPTION) == (15, 16, 19)


def test_transmission_modes() -> None:
    assert [mode.value for mode in TransmissionMode] == [0, 1, 2, 3, 4, 5, 6, 10]
    assert (TransmissionMode.SERVER_CYCLE, TransmissionMode.SERVER_ON_CHANGE) == (3, 4)
