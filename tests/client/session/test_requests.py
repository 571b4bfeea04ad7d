"""The bookkeeping of requests under way."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, ConnectionLost, Frame, RequestTimeout
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteControlRequest,
    WriteRequest,
)
from achse.client.session.requests import Requests, describe_request

OURS = AmsAddress("1.2.3.4.1.1:30000")
THEIRS = AmsAddress("5.4.3.2.1.1:851")


class Waiting:
    """A waiter that remembers what it got."""

    def __init__(self, done: bool = False) -> None:
        self.is_done = done
        self.result: Frame | None = None
        self.error: Exception | None = None

    def done(self) -> bool:
        return self.is_done

    def set_result(self, frame: Frame) -> None:
        assert not self.is_done
        self.result = frame
        self.is_done = True

    def set_exception(self, error: Exception) -> None:
        assert not self.is_done
        self.error = error
        self.is_done = True


def read_request() -> Frame:
    return Frame(THEIRS, OURS, 2, data=ReadRequest(0x4020, 0x10, 4).encode())


def test_an_answer_goes_to_the_request_with_its_invoke_id() -> None:
    requests = Requests()
    sent = [(read_request(), Waiting()) for _ in range(5)]
    for frame, waiter in sent:
        requests.add(frame, waiter, 1.0)
    assert len({frame.invoke_id for frame, _ in sent}) == 5
    for frame, _ in reversed(sent):
        requests.answer(frame.reply(b"x"))
    for frame, waiter in sent:
        assert waiter.result is not None
        assert waiter.result.invoke_id == frame.invoke_id
    assert len(requests) == 0


def test_an_answer_no_client_waits_for_is_counted() -> None:
    requests = Requests()
    frame = read_request()
    requests.answer(frame.reply())
    waiter = Waiting()
    requests.add(frame, waiter, 1.0)
    other_command = frame.reply()
    other_command.command = 3
    requests.answer(other_command)
    assert waiter.result is None
    requests.answer(frame.reply())
    requests.answer(frame.reply())
    assert requests.unasked == 3


def test_an_answer_to_a_cancelled_request_is_no_stranger() -> None:
    requests = Requests()
    frame = read_request()
    requests.add(frame, Waiting(done=True), 1.0)
    requests.answer(frame.reply())
    assert requests.unasked == 0
    assert len(requests) == 0


def test_the_invoke_id_wraps_past_zero_and_skips_those_under_way() -> None:
    requests = Requests()
    old = read_request()
    requests.add(old, Waiting(), 1.0)
    assert old.invoke_id == 1
    requests._last_id = 0xFFFF_FFFE
    last, next_one = read_request(), read_request()
    requests.add(last, Waiting(), 1.0)
    requests.add(next_one, Waiting(), 1.0)
    assert (last.invoke_id, next_one.invoke_id) == (0xFFFF_FFFF, 2)


@given(st.lists(st.floats(0, 100), max_size=20), st.floats(0, 100))
def test_expire_fails_what_is_due_and_nothing_else(deadlines: list[float], now: float) -> None:
    requests = Requests()
    waiters = [(deadline, Waiting()) for deadline in deadlines]
    for deadline, waiter in waiters:
        requests.add(read_request(), waiter, deadline)
    assert requests.next_deadline == min(deadlines, default=None)
    requests.expire(now)
    for deadline, waiter in waiters:
        assert isinstance(waiter.error, RequestTimeout) == (deadline <= now)
    assert requests.next_deadline == min((d for d in deadlines if d > now), default=None)


def test_fail_fails_all_and_names_their_requests() -> None:
    requests = Requests()
    waiter, gone = Waiting(), Waiting(done=True)
    requests.add(read_request(), waiter, 1.0)
    requests.add(read_request(), gone, 1.0)
    requests.fail(ConnectionLost)
    assert isinstance(waiter.error, ConnectionLost)
    assert str(waiter.error) == "read 4 bytes at 0x4020:0x10 of 5.4.3.2.1.1:851"
    assert gone.error is None
    assert len(requests) == 0


@pytest.mark.parametrize(
    ("command", "data", "text"),
    [
        (1, b"", "read device info"),
        (4, b"", "read state"),
        (3, WriteRequest(0xF005, 7, b"ab").encode(), "write 2 bytes at 0xF005:0x7"),
        (9, ReadWriteRequest(0xF003, 0, 4, b"MAIN.x\0").encode(), "at 0xF003:0x0 with 'MAIN.x'"),
        (9, ReadWriteRequest(0xF003, 0, 4, b"\1\2").encode(), "at 0xF003:0x0 with 2 bytes"),
        (6, AddNotificationRequest(1, 2, 4, 4, 0, 0).encode(), "subscribe to 4 bytes at 0x1:0x2"),
        (7, DeleteNotificationRequest(9).encode(), "end subscription 9"),
        (5, WriteControlRequest(5, 0).encode(), "ask for state 5/0"),
        (77, b"", "command 77"),
    ],
)
def test_a_request_is_described_in_words(command: int, data: bytes, text: str) -> None:
    description = describe_request(Frame(THEIRS, OURS, command, data=data))
    assert text in description
    assert description.endswith("5.4.3.2.1.1:851")
