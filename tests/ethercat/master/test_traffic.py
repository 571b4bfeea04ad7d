"""Acyclic traffic: requests share frames, lost ones are sent again, nothing foreign is taken."""

from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat import Datagram, DatagramCommand, EthercatFrame
from achse.ethercat.master.errors import FrameLost
from achse.ethercat.master.steps import Pause, Steps, read
from achse.ethercat.master.traffic import ACYCLIC, AcyclicTraffic, same_request

TIMEOUT = 5_000_000


def echo(frame: bytes, counter: int = 1) -> bytes:
    """The frame as slaves would give it back."""
    decoded = EthercatFrame.decode(frame)
    for each in decoded.datagrams:
        each.counter = counter
    return decoded.encode()


def waits(times: Iterable[int]) -> Steps[int]:
    total = 0
    for time in times:
        total = (yield Pause(time)).now_ns
    return total


def test_requests_of_many_share_a_frame() -> None:
    traffic = AcyclicTraffic(TIMEOUT)
    jobs = [traffic.start(read(1000 + n, 0x10, 2)) for n in range(20)]
    (frame,) = traffic.frames(0, 5)
    assert len(EthercatFrame.decode(frame).datagrams) == 20
    traffic.receive(echo(frame), 1)
    assert [job.result() for job in jobs] == [b"\0\0"] * 20
    assert (traffic.sent_frames, traffic.lost_frames, traffic.due_ns) == (1, 0, None)


def test_what_does_not_fit_goes_into_the_next_frame() -> None:
    traffic = AcyclicTraffic(TIMEOUT)
    for number in range(3):
        traffic.start(read(number, 0x1000, 1000))
    assert len(traffic.frames(0, 2)) == 2
    assert traffic.due_ns == 0  # one is left, and may go at once
    assert len(traffic.frames(0, 2)) == 1
    job = traffic.start(read(1, 0x1000, 1487))
    traffic.frames(0, 2)
    with pytest.raises(FrameLost, match="do not fit"):
        job.result()


def test_a_lost_frame_is_sent_three_times() -> None:
    traffic = AcyclicTraffic(TIMEOUT)
    job = traffic.start(read(1001, 0x10, 2))
    for number in range(3):
        assert len(traffic.frames(number * TIMEOUT, 1)) == 1
        assert traffic.frames(number * TIMEOUT + 1, 1) == []
    assert traffic.frames(3 * TIMEOUT, 1) == []
    with pytest.raises(FrameLost, match="sent 3 times"):
        job.result()
    assert traffic.lost_frames == 3


def test_an_answer_to_the_second_try_counts_the_first_late_one_does_not() -> None:
    traffic = AcyclicTraffic(TIMEOUT)
    job = traffic.start(read(1001, 0x10, 2))
    (first,) = traffic.frames(0, 1)
    (second,) = traffic.frames(TIMEOUT, 1)
    traffic.receive(echo(first), TIMEOUT)
    assert not job.is_done
    traffic.receive(echo(second), TIMEOUT)
    traffic.receive(echo(second), TIMEOUT)
    assert job.result() == b"\0\0"
    assert traffic.strays == 2


def test_pauses_end_in_order_and_take_no_frame() -> None:
    traffic = AcyclicTraffic(TIMEOUT)
    long, short = traffic.start(waits([500])), traffic.start(waits([100, 100, 0]))
    assert traffic.frames(0, 1) == []
    assert traffic.due_ns == 100
    traffic.frames(150, 1)
    traffic.frames(300, 1)
    assert (short.result(), long.is_done) == (300, False)
    traffic.frames(501, 1)
    assert long.result() == 501


def test_a_cancelled_request_is_not_sent() -> None:
    traffic = AcyclicTraffic(TIMEOUT)
    seen: list[object] = []
    job = traffic.start(read(1001, 0x10, 2), seen.append)
    job.cancel()
    other = traffic.start(read(1002, 0x10, 2))
    (frame,) = traffic.frames(0, 1)
    assert [each.adp for each in EthercatFrame.decode(frame).datagrams] == [1002]
    other.cancel()
    traffic.receive(echo(frame), 0)
    assert seen == []
    with pytest.raises(ValueError, match="under way"):
        job.result()


def test_no_more_frames_are_away_than_the_window_allows() -> None:
    traffic = AcyclicTraffic(TIMEOUT, window=2)
    for number in range(4):
        traffic.start(read(number, 0x1000, 1000))
    assert len(traffic.frames(0, 9)) == 2
    assert traffic.frames(1, 9) == []
    assert traffic.due_ns == TIMEOUT


@given(
    command=st.sampled_from(DatagramCommand),
    address=st.integers(0, 0xFFFF_FFFF),
    size=st.integers(0, 20),
    passed=st.integers(0, 0xFFFF),
)
def test_slaves_change_the_position_only(
    command: DatagramCommand, address: int, size: int, passed: int
) -> None:
    sent = Datagram(command, address, bytes(size))
    came = Datagram(command, address & 0xFFFF_0000 | passed, b"\1" * size, counter=3)
    by_position = {
        each for each in DatagramCommand if each.addressing.name in ("POSITION", "BROADCAST")
    }
    assert same_request(sent, came) == (command in by_position or came.address == address)
    assert not same_request(sent, Datagram(command, address, bytes(size + 1)))


@given(frame=st.binary(max_size=80), index=st.integers(0, 255))
def test_anything_else_is_left(frame: bytes, index: int) -> None:
    traffic = AcyclicTraffic(TIMEOUT)
    job = traffic.start(read(1001, 0x10, 2))
    traffic.frames(0, 1)
    traffic.receive(frame, 0)
    head = b"\xff" * 12 + b"\x88\xa4"
    traffic.receive(head + frame, 0)
    traffic.receive(EthercatFrame([Datagram(4, 1001, b"\0\0", index)]).encode(), 0)
    assert not job.is_done
    assert traffic.strays == 3
    assert index not in ACYCLIC or traffic.due_ns == TIMEOUT
