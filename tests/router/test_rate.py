"""Rates let so many through and no more, for each key and for all."""

from hypothesis import given
from hypothesis import strategies as st

from achse.router.rate import Rate, Rates

SECOND = 1_000_000_000


def test_twice_a_second_s_worth_goes_at_once_then_so_many_a_second() -> None:
    rate = Rate(10)
    assert sum(rate.take(0) for _ in range(100)) == 20
    assert sum(rate.take(SECOND) for _ in range(100)) == 10
    assert sum(rate.take(100 * SECOND) for _ in range(100)) == 20


def test_rate_counts_from_the_last_request() -> None:
    rate = Rate(1, 3)
    assert sum(rate.take(5 * SECOND) for _ in range(9)) == 3
    assert not rate.take(5 * SECOND + SECOND // 2)


def test_clock_that_goes_back_takes_nothing_away() -> None:
    rate = Rate(1, 3)
    assert rate.take(10 * SECOND)
    assert rate.take(0)
    assert rate.take(0)
    assert not rate.take(0)


def test_how_many_go_at_once_can_be_said() -> None:
    rate = Rate(1, 3)
    assert sum(rate.take(0) for _ in range(10)) == 3
    assert sum(rate.take(10 * SECOND) for _ in range(10)) == 3
    rates = Rates(1, 100, at_once=2, all_at_once=3)
    assert [rates.take(key, 0) for key in "aaabb"] == [True, True, False, True, False]


def test_keys_have_their_own_rate_and_one_together() -> None:
    rates = Rates(1, 3)
    assert [rates.take("a", 0) for _ in range(3)] == [True, True, False]
    assert [rates.take(key, 0) for key in "bcdef"] == [True, True, True, True, False]


def test_keys_that_are_not_seen_are_forgotten() -> None:
    rates = Rates(1, 1 << 30, most=2)
    for key in ("a", "a", "b", "a", "c"):
        rates.take(key, 0)
    assert list(rates._each) == ["a", "c"]


@given(
    st.integers(1, 50),
    st.integers(1, 100),
    st.integers(1, 4),
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, SECOND)), max_size=300),
)
def test_in_no_time_more_goes_than_allowed(
    each: int, everybody: int, most: int, requests: list[tuple[int, int]]
) -> None:
    rates = Rates(each, everybody, most=most)
    now, passed = 0, list[tuple[int, int]]()
    for key, pause in requests:
        now += pause
        if rates.take(key, now):
            passed.append((key, now))
    for first, (_, begin) in enumerate(passed):
        for last, (_, end) in enumerate(passed[first:], first):
            assert last - first + 1 <= 2 * everybody + (end - begin) * everybody / SECOND + 1
