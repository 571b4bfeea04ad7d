"""Taps keep what passes, in order, bounded for all together, and as bytes that find back."""

import sys
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, DecodeError, Frame, NetId, RouterError
from achse.router import Router
from achse.router.tap import Captured, Tap, Taps, decode_batch, encode_batch

OURS = NetId("5.1.2.3.1.1")
CLIENT = AmsAddress("10.0.0.7.1.1:30000")


class Device:
    """Answers each request at once, and keeps what comes to it."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        self.router.deliver(frame.reply(b"answer"))
        return True


class Peer:
    peer = "10.0.0.7:5000"

    def deliver(self, frame: Frame) -> bool:
        return True


@pytest.fixture
def router() -> Router:
    router = Router(OURS)
    for port in (851, 26_000):
        router.register(port, Device(router))
    return router


def _ask(router: Router, port: int, number: int) -> None:
    frame = Frame(AmsAddress.of(OURS, port), CLIENT, 2, 4, 0, number, b"request")
    frame.origin = Peer()
    router.deliver(frame)


def test_requests_and_answers_with_time_and_peer(router: Router) -> None:
    times = iter([10, 20])
    taps = Taps(router, lambda: next(times), spared=26_000)
    _ask(router, 851, 1)
    tap = taps.open()
    _ask(router, 851, 2)
    _ask(router, 26_000, 3)
    request, answer = tap.take(1000)
    assert (request.time_ns, request.inwards, request.peer) == (10, True, "10.0.0.7:5000")
    assert (answer.time_ns, answer.inwards, answer.peer) == (20, False, "10.0.0.7:5000")
    assert (request.frame.invoke_id, answer.frame.data) == (2, b"answer")
    tap.close()
    _ask(router, 851, 4)
    assert tap.take(1000) == []


def test_the_oldest_are_lost_when_they_are_not_fetched(router: Router) -> None:
    tap = Taps(router, lambda: 0, limit=300).open()
    for number in range(10):
        _ask(router, 851, number)
    captures = tap.take(1 << 20)
    assert [capture.frame.invoke_id for capture in captures] == [8, 8, 9, 9][-len(captures) :]
    assert tap.lost_captures == 20 - len(captures)


def test_a_fetch_takes_what_fits(router: Router) -> None:
    tap = Taps(router, lambda: 0).open()
    _ask(router, 851, 1)
    size = len(encode_batch(tap.take(1000)[:1]))
    _ask(router, 851, 2)
    assert len(tap.take(size)) == 1
    assert tap.take(10) == []  # the answer would never fit
    assert (tap.take(1000), tap.lost_captures) == ([], 1)


def test_a_request_costs_the_same_depth_however_many_taps_are_open(router: Router) -> None:
    """163 taps, four of each of 41 addresses, once ended in RecursionError for every client."""
    depths: list[int] = []

    class Deep:
        def deliver(self, frame: Frame) -> bool:
            depth, here = 0, sys._getframe()
            while here.f_back is not None:
                depth, here = depth + 1, here.f_back
            depths.append(depth)
            return True

    router.register(852, Deep())
    taps = Taps(router, lambda: 0, most=5000)
    _ask(router, 852, 1)
    for count in (1, 999, 4000):
        opened = [taps.open() for _ in range(count)]
        _ask(router, 852, 1)
    assert len(opened) == 4000
    assert depths[1:] == [depths[1]] * 3
    assert depths[1] - depths[0] < 4


def test_taps_have_a_limit_together(router: Router) -> None:
    taps = Taps(router, lambda: 0, most=2)
    first, second = taps.open(), taps.open()
    with pytest.raises(RouterError, match="0x508"):
        taps.open()
    first.close()
    third = taps.open()
    _ask(router, 851, 1)
    assert len(second.take(1000)) == len(third.take(1000)) == 2
    assert (first.take(1000), taps.size) == ([], 0)


@given(
    st.integers(100, 2000),
    st.lists(
        st.tuples(
            st.sampled_from(("open", "close", "take", "ask")),
            st.integers(0, 7),
            st.integers(1, 900),
        ),
        max_size=60,
    ),
)
def test_whatever_taps_come_fetch_and_go_memory_stays_within_the_limit_and_nothing_is_reordered(
    limit: int, steps: list[tuple[str, int, int]]
) -> None:
    router = Router(OURS)
    router.register(851, Device(router))
    taps = Taps(router, lambda: 0, limit=limit, most=4)
    opened: list[tuple[Tap, list[int]]] = []
    passed = 0
    begins: dict[Tap, int] = {}
    for what, number, size in steps:
        if what == "open" and len(opened) < 4:
            tap = taps.open()
            opened.append((tap, []))
            begins[tap] = passed
        elif what == "ask":
            for _ in range(number):
                passed += 1
                frame = Frame(AmsAddress.of(OURS, 851), CLIENT, 2, 6, 0, passed, bytes(size))
                router.deliver(frame)
        elif opened and what in ("close", "take"):
            tap, fetched = opened[number % len(opened)]
            if what == "take":
                fetched += [capture.frame.invoke_id for capture in tap.take(size)]
            else:
                tap.close()
                opened.remove((tap, fetched))
        assert taps.size == sum(len(encode_batch([each])) for each in taps._captures) <= limit
        assert len(taps) == len(opened)
        assert router.attended == bool(opened)
    for tap, fetched in opened:
        fetched += [capture.frame.invoke_id for capture in tap.take(1 << 30)]
        assert fetched == sorted(fetched)
        assert len(fetched) + tap.lost_captures == 2 * (passed - begins[tap])
    assert (taps.size, len(taps._captures)) == (0, 0)


captures = st.builds(
    Captured,
    st.integers(0, 2**64 - 1),
    st.booleans(),
    st.text(st.characters(codec="ascii"), max_size=60),
    st.binary(max_size=100),
)


@given(st.lists(captures, max_size=5))
def test_bytes_find_back(batch: list[Captured]) -> None:
    assert list(decode_batch(encode_batch(batch))) == batch


@pytest.mark.parametrize("size", [1, 13, 20])
def test_a_batch_that_ends_in_the_middle_is_an_error(size: int) -> None:
    data: Any = encode_batch([Captured(1, True, "peer", b"packet")])
    with pytest.raises(DecodeError):
        list(decode_batch(data[:size]))
