"""A tap keeps what passes, in order, bounded, and as bytes that find back."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, DecodeError, Frame, NetId
from achse.router import Router
from achse.router.tap import Captured, Tap, decode_batch, encode_batch

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
    tap = Tap(router, lambda: next(times), spared=26_000)
    _ask(router, 851, 1)
    tap.open()
    _ask(router, 851, 2)
    _ask(router, 26_000, 3)
    request, answer = tap.take(1000)
    assert (request.time_ns, request.inwards, request.peer) == (10, True, "10.0.0.7:5000")
    assert (answer.time_ns, answer.inwards, answer.peer) == (20, False, "10.0.0.7:5000")
    assert (request.frame.invoke_id, answer.frame.data) == (2, b"answer")
    tap.close()
    _ask(router, 851, 4)
    assert tap.take(1000) == []


def test_the_oldest_are_lost_when_nobody_fetches(router: Router) -> None:
    tap = Tap(router, lambda: 0, limit=300)
    tap.open()
    for number in range(10):
        _ask(router, 851, number)
    kept = tap.take(1 << 20)
    assert [capture.frame.invoke_id for capture in kept] == [8, 8, 9, 9][-len(kept) :]
    assert tap.lost == 20 - len(kept)


def test_a_fetch_takes_what_fits(router: Router) -> None:
    tap = Tap(router, lambda: 0)
    tap.open()
    _ask(router, 851, 1)
    size = len(encode_batch(tap.take(1000)[:1]))
    _ask(router, 851, 2)
    assert len(tap.take(size)) == 1
    assert tap.take(10) == []  # the answer would never fit
    assert (tap.take(1000), tap.lost) == ([], 1)


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
