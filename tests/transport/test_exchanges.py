"""Who asked, who is answered, and what goes in circles: without a socket."""

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Frame
from achse.codes import ReturnCode
from achse.transport import exchanges
from achse.transport.exchanges import Exchanges

SECOND = 1_000_000_000
CLIENT = AmsAddress("192.168.0.9.1.1:30000")
SERVER = AmsAddress("5.6.7.8.1.1:851")


class Side:
    """One who asks."""

    def deliver(self, frame: Frame) -> bool:
        return True


def request(invoke_id: int = 1) -> Frame:
    return Frame(SERVER, CLIENT, 2, 4, 0, invoke_id, b"?")


def test_answers_go_to_those_who_asked_in_order() -> None:
    found, first, second = Exchanges(), Side(), Side()
    for side in (first, second):
        assert found.ask(side, request(), 0) is None
    assert found.take(request().reply()) is first
    assert found.take(request().reply()) is second
    assert found.take(request(2).reply()) is second  # the one who was answered last
    sample = Frame(CLIENT, SERVER, 8)
    assert found.answered(sample) is second
    found.clear()
    assert found.take(request().reply()) is found.answered(sample) is None


def test_a_refused_request_makes_nobody_known() -> None:
    found = Exchanges()
    found.ask(Side(), request(), 0)
    assert found.take(request().reply(error=7)) is not None
    assert found.answered(Frame(CLIENT, SERVER, 8)) is None


def test_the_third_of_the_same_from_one_side_is_a_circle() -> None:
    found, side = Exchanges(), Side()
    answers = [found.ask(side, request(), now) for now in (0, 1, 2)]
    assert answers == [None, None, ReturnCode.TARGET_MACHINE_NOT_FOUND]
    assert found.ask(Side(), request(), 3) is None
    assert found.ask(side, request(2), 3) is None


def test_a_client_that_always_uses_one_invoke_id_may_ask_again_after_its_timeout() -> None:
    found, side = Exchanges(), Side()
    assert {found.ask(side, request(), second * SECOND) for second in range(100)} == {None}


def test_what_cannot_circle_is_not_refused() -> None:
    found, side = Exchanges(), Side()
    assert {found.ask(side, request(), 0, circles=False) for _ in range(100)} == {None}
    assert {found.take(request().reply()) for _ in range(100)} == {side}


def test_so_many_unanswered_that_circles_could_not_be_told_fill_the_mailbox(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(exchanges, "_REMEMBERED", 100)
    found, side = Exchanges(), Side()
    assert {found.ask(side, request(number), 0) for number in range(100)} == {None}
    assert found.ask(side, request(100), 1) is ReturnCode.ROUTER_MAILBOX_FULL
    assert found.ask(side, request(100), 1, circles=False) is None
    assert len(found._asked) == 100
    assert found.ask(side, request(101), SECOND) is None  # the oldest is not waited for any more
    assert len(found._asked) == 100


@given(
    rounds=st.lists(st.integers(1, 400), min_size=1, max_size=5),
    ring=st.integers(1, 5),
    hop_ns=st.integers(0, 50_000_000),
)
def test_in_any_ring_each_request_ends_after_few_hops(
    rounds: list[int], ring: int, hop_ns: int
) -> None:
    """Each host passes on to the next one, the last to the first; hosts are one connection each."""
    hosts = [Exchanges() for _ in range(ring)]
    sides = [Side() for _ in range(ring)]
    client = Side()
    now = 0
    hops: Counter[int] = Counter()
    for count in rounds:
        waiting = [(request(number), 0, client) for number in range(count)]
        while waiting:
            now += hop_ns
            onward = []
            for frame, place, asker in waiting:
                if hosts[place].ask(asker, frame, now) is None:
                    hops[frame.invoke_id] += 1
                    onward.append((frame, (place + 1) % ring, sides[place]))
                    assert hops[frame.invoke_id] <= 3 * ring + 1
            waiting = onward
        hops.clear()
        for host in hosts:
            host.clear()
