"""Answers that come later, whatever they are; nobody else waits."""

import struct
from typing import Any

import pytest

from achse.ams import Command, DeviceError, Frame, NetId
from achse.ams.commands import (
    DataResponse,
    ReadRequest,
    ReadWriteRequest,
    WriteControlRequest,
    WriteRequest,
    decode_response,
)
from achse.router import Router
from achse.server import Device, RawGroup
from achse.server.deferred import Answer, Deferred


class SlowDevice(Device):
    """A device that changes its state when the test lets it."""

    waiting: list[Answer]

    def write_control(self, ads_state: int, device_state: int, data: bytes) -> None:
        raise Deferred(self.waiting.append)


class Slow:
    """A device whose group 0x300 and changes of state answer when the test says, and a client."""

    def __init__(self) -> None:
        self.waiting: list[Answer] = []
        self.frames: list[Frame] = []
        self.router = Router(NetId("5.1.2.3.1.1"))
        group = RawGroup(
            0x300, "slow", read=self.serve, write=self.serve_write, read_write=self.serve
        )
        self.device = SlowDevice("slow", (1, 0, 0), [group], clock=lambda: 0)
        self.device.waiting = self.waiting
        self.target = self.device.attach(self.router, 800)
        self.address = self.router.register(0, self)

    def serve(self, *_: object) -> bytes:
        raise Deferred(self.waiting.append)

    def serve_write(self, *_: object) -> None:
        self.serve()

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return True

    def ask(self, command: Command, request: Any, flags: int = 4) -> None:
        frame = Frame(self.target, self.address, command, data=request.encode())
        frame.flags = flags
        self.router.deliver(frame)


def refuse() -> bytes:
    raise DeviceError(0x70C)


def fail() -> bytes:
    raise ZeroDivisionError


REQUESTS = [
    (Command.READ, ReadRequest(0x300, 0, 4)),
    (Command.WRITE, WriteRequest(0x300, 0, b"x")),
    (Command.READ_WRITE, ReadWriteRequest(0x300, 0, 4, b"x")),
    (Command.WRITE_CONTROL, WriteControlRequest(2, 0, b"")),
]


WITHOUT_DATA = (Command.WRITE, Command.WRITE_CONTROL)


@pytest.mark.parametrize(("command", "request_"), REQUESTS)
def test_each_request_is_answered_once_and_later(command: Command, request_: Any) -> None:
    slow = Slow()
    for _ in range(3):
        slow.ask(command, request_)
    assert slow.frames == []
    value = b"" if command in WITHOUT_DATA else b"abcd"
    for answer, result in zip(slow.waiting, (lambda: value, refuse, fail), strict=True):
        answer(result)
    answers = [decode_response(frame) for frame in slow.frames]
    assert [answer.result for answer in answers] == [0, 0x70C, 0x1]
    if command not in WITHOUT_DATA:
        data = [bytes(answer.data) for answer in answers if isinstance(answer, DataResponse)]
        assert data == [b"abcd", b"", b""]


def test_who_wants_no_answer_gets_none() -> None:
    slow = Slow()
    slow.ask(*REQUESTS[0], flags=4 | 2)
    slow.waiting[0](lambda: b"abcd")
    assert slow.frames == []


def test_within_a_sum_it_is_refused_and_nothing_begins() -> None:
    slow = Slow()
    sum_read = ReadWriteRequest(0xF080, 1, 8, struct.pack("<III", 0x300, 0, 4))
    slow.ask(Command.READ_WRITE, sum_read)
    answer = decode_response(slow.frames[0])
    assert isinstance(answer, DataResponse)
    assert bytes(answer.data)[:4] == b"\x01\x07\0\0"
    assert slow.waiting == []
