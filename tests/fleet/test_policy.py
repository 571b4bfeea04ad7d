"""Restarts, in made-up time."""

from hypothesis import given
from hypothesis import strategies as st

from achse.fleet.policy import RestartPolicy


def test_pauses_get_longer_and_then_there_is_an_end() -> None:
    policy = RestartPolicy(3, 60.0)
    assert [policy.ended(float(now)) for now in range(4)] == [0.1, 0.2, 0.4, None]
    assert policy.restarts == 3
    policy.forget()
    assert policy.ended(4.0) == 0.1


def test_what_was_long_ago_does_not_count() -> None:
    policy = RestartPolicy(1, 10.0)
    assert policy.ended(0.0) == 0.1
    assert policy.ended(9.9) is None
    assert policy.ended(10.0) == 0.1


@given(
    most=st.integers(0, 20),
    window=st.floats(0.1, 100.0),
    waits=st.lists(st.floats(0.0, 50.0), max_size=40),
)
def test_never_more_within_the_window(most: int, window: float, waits: list[float]) -> None:
    policy = RestartPolicy(most, window)
    now, restarts = 0.0, []
    for wait in waits:
        now += wait
        pause = policy.ended(now)
        if pause is not None:
            assert 0.1 <= pause <= 10.0
            restarts.append(now)
            now += pause
    for last in restarts:
        assert sum(0 <= last - each < window for each in restarts) <= most
    assert policy.restarts == len(restarts)
