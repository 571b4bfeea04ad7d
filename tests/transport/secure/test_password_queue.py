"""Who waits for the check of a password, and how long; time is the test's own."""

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.transport.secure.password_queue import PasswordQueue


class Clock:
    now = 1000.0

    def __call__(self) -> float:
        return self.now


def checked_after(clock: Clock, waiting: PasswordQueue[str]) -> tuple[float, str]:
    """Let time pass until a request is due; how long that took, and whose it is."""
    pause = waiting.pause()
    clock.now += pause
    taken = waiting.take()
    assert taken is not None
    return pause, taken[0]


def test_one_request_of_a_host_waits_the_newest() -> None:
    waiting = PasswordQueue[str](Clock())
    assert waiting.pause() == float("inf")
    assert waiting.take() is None
    assert waiting.put("a", "first")
    assert waiting.put("a", "second")
    assert (len(waiting), waiting.take(), waiting.take()) == (1, ("a", "second"), None)


def test_wrong_passwords_slow_a_host_down() -> None:
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    pauses = []
    for _ in range(12):
        waiting.put("a", "")
        pauses.append(round(checked_after(clock, waiting)[0], 3))
        waiting.checked("a", right=False)
        clock.now += 0.2
    expected = [0, 0, 0, 0.8, 1.8, 3.8, 7.8, 15.8, 31.8, 59.8, 59.8, 59.8]
    assert pauses == expected
    clock.now += 700
    waiting.put("a", "")
    assert checked_after(clock, waiting)[0] == 0
    waiting.checked("a", right=False)
    waiting.put("a", "")
    assert checked_after(clock, waiting)[0] < 0.3, "long ago is forgiven"


def test_who_knew_the_password_goes_first_and_waits_for_no_stranger() -> None:
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    waiting.put("known", "")
    waiting.take()
    waiting.checked("known", right=True)
    for number in range(300):
        waiting.put(f"stranger {number}", "")
    assert len(waiting) == 256
    assert waiting.put("known", "")
    assert checked_after(clock, waiting) == (0, "known")


def test_a_guesser_is_displaced_by_an_honest_host_when_all_places_are_taken() -> None:
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    for number in range(256):
        waiting.checked(str(number), right=False)
        assert waiting.put(str(number), "")
    assert waiting.put("honest", "")
    assert checked_after(clock, waiting)[1] == "honest"
    assert waiting.put("honest", "")


def test_host_that_waits_replaces_its_request_when_all_places_are_taken() -> None:
    waiting = PasswordQueue[str](Clock())
    for number in range(256):
        assert waiting.put(str(number), "old")
    assert waiting.put("7", "new")
    waiting.checked("guesser", right=False)
    assert not waiting.put("guesser", "new")
    assert len(waiting) == 256
    assert waiting.remove(lambda request: request == "new") == [("7", "new")]


@given(before=st.integers(0, 600), wrong=st.integers(0, 2), turns=st.integers(0, 5))
def test_newcomer_is_one_of_the_next_two_however_many_wait(
    before: int, wrong: int, turns: int
) -> None:
    """All have guessed equally often."""
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    hosts = [str(number) for number in range(before)]
    for host in (*hosts, "newcomer"):
        for _ in range(wrong):
            waiting.checked(host, right=False)
    for host in hosts:
        assert waiting.put(host, "")
    for _ in range(min(turns, before)):
        checked_after(clock, waiting)
    assert waiting.put("newcomer", "")
    assert len(waiting) <= 256
    assert "newcomer" in [checked_after(clock, waiting)[1] for _ in range(min(2, len(waiting)))]


def test_crowd_displaces_none_of_those_that_waited_before() -> None:
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    for number in range(1000):
        assert waiting.put(str(number), "")
    turns = [checked_after(clock, waiting)[1] for _ in range(256)]
    assert turns[:4] == ["0", "999", "1", "998"]
    assert {str(number) for number in range(128)} < set(turns)


@pytest.mark.parametrize(("quiet", "pause"), [(600.0, 1.0), (600.5, 0.0)])
def test_wrong_passwords_are_forgiven_after_ten_minutes(quiet: float, pause: float) -> None:
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    for _ in range(2):
        waiting.checked("a", right=False)
    clock.now += quiet
    waiting.checked("a", right=False)
    waiting.put("a", "")
    assert waiting.pause() == pause


def test_who_knew_the_password_takes_no_turn_from_strangers() -> None:
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    waiting.checked("known", right=True)
    for host in ("a", "known", "b", "c", "known", "d"):
        waiting.put(host, "")
    assert checked_after(clock, waiting) == (0, "known")
    assert checked_after(clock, waiting) == (0, "a")
    waiting.put("known", "")
    assert checked_after(clock, waiting) == (0, "known")
    assert checked_after(clock, waiting)[1] == "d"
    assert checked_after(clock, waiting)[1] == "b"


def test_right_password_starts_afresh() -> None:
    waiting = PasswordQueue[str](Clock())
    for right in (False, True, False, False):
        waiting.checked("a", right=right)
    waiting.put("a", "")
    assert waiting._rank("a") == -1
    assert waiting.pause() == 0
    waiting.checked("a", right=False)
    assert waiting._rank("a") == 3
    assert waiting.pause() == 1


def test_hosts_that_were_checked_last_are_remembered() -> None:
    waiting = PasswordQueue[str](Clock())
    for number in (*range(4096), 0, 4096):
        waiting.checked(str(number), right=False)
    assert len(waiting._hosts) == 4096
    assert "0" in waiting._hosts
    assert "1" not in waiting._hosts


def test_nothing_grows() -> None:
    waiting = PasswordQueue[str](Clock())
    for number in range(10_000):
        waiting.put(str(number), "")
        waiting.checked(str(number), right=False)
    assert (len(waiting), len(waiting._hosts)) == (256, 4096)


@given(
    crowd=st.integers(1, 255),
    began=st.floats(0, 100),
    mistyped=st.integers(0, 2),
    again=st.lists(st.integers(0, 254), max_size=20),
)
def test_a_newcomer_is_checked_within_two_turns_whatever_crowd_of_guessers_waits(
    crowd: int, began: float, mistyped: int, again: list[int]
) -> None:
    """Those who were checked ask again at once; others repeat what they asked before."""
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    for number in range(crowd):
        waiting.put(f"guesser {number}", "wrong")

    def pass_time(until: float) -> None:
        while (pause := waiting.pause()) + clock.now <= until:
            clock.now += pause
            taken = waiting.take()
            assert taken is not None
            waiting.checked(taken[0], right=False)
            waiting.put(taken[0], "wrong")
        clock.now = until

    pass_time(clock.now + began)
    for _ in range(mistyped):
        waiting.checked("newcomer", right=False)
    assert waiting.put("newcomer", "right")
    for number in again:
        waiting.put(f"guesser {number % crowd}", "wrong")
    fewer_wrong = sum(waiting._rank(f"guesser {number}") < mistyped for number in range(crowd))
    ahead = 0
    while checked_after(clock, waiting)[1] != "newcomer":
        ahead += 1
    assert ahead <= fewer_wrong + 1


def test_requests_that_match_are_taken_out_and_count_as_no_check() -> None:
    waiting = PasswordQueue[str](Clock())
    for host in "abc":
        waiting.put(host, "old" if host != "b" else "new")
    assert waiting.remove(lambda request: request == "old") == [("a", "old"), ("c", "old")]
    assert (len(waiting), waiting.pause(), waiting.take()) == (1, 0, ("b", "new"))


events = st.tuples(st.floats(0, 5), st.sampled_from("abcdef"), st.booleans())


@given(st.lists(events, max_size=300), st.sets(st.sampled_from("abcdef")))
def test_all_strangers_together_get_five_checks_a_second(
    drawn: list[tuple[float, str, bool]], knowing: set[str]
) -> None:
    """Whatever is sent when by whom: strangers never get more, and nobody waits for ever."""
    clock = Clock()
    waiting = PasswordQueue[str](clock)
    began, strangers, wrong = clock.now, 0, Counter[str]()
    for pause, host, right in drawn:
        clock.now += pause
        waiting.put(host, "")
        while (taken := waiting.take()) is not None:
            answer = right and taken[0] in knowing
            known = waiting._hosts.get(taken[0])
            strangers += known is None or not known.right
            wrong[taken[0]] += not answer
            waiting.checked(taken[0], right=answer)
            assert strangers <= 1 + 5 * (clock.now - began) * (1 + 1e-9)
    while len(waiting):
        pause, _ = checked_after(clock, waiting)
        assert pause <= 60.0
    assert waiting.pause() == float("inf")
