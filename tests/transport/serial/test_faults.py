"""Requests over serial lines that do all kinds of harm, in virtual time: who asks is answered."""

import random
from collections import Counter
from collections.abc import Callable
from itertools import pairwise

import pytest

from achse.ams import Command, Flags, Frame
from achse.ams.commands import DataResponse, ReadRequest, ResultResponse, WriteRequest
from achse.ams.serial import FrameKind, SerialEnd, SerialFrame
from achse.transport.serial.carrier import SerialCarrier
from tests.transport.serial.test_carrier import CLIENT, DEVICE, Scheduler

RESET = SerialFrame(FrameKind.RESET, 0).encode()


class Wire:
    """One direction: bytes take their time; the fault changes, drops, cuts, joins or delays them.

    `stretch` gives the seconds that a write waits on top; none comes before an earlier one.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        baud: int,
        fault: Callable[[bytes], list[bytes]],
        stretch: Callable[[], float],
    ) -> None:
        self.scheduler, self.baud, self.fault, self.stretch = scheduler, baud, fault, stretch
        self.free_at = self.last = 0.0
        self.far: Callable[[bytes], object] = bool

    def write(self, data: bytes) -> None:
        self.free_at = max(self.scheduler.now, self.free_at) + len(data) * 10 / self.baud
        self.last = max(self.last, self.free_at + self.stretch())
        for piece in self.fault(data):
            self.scheduler.call_at(self.last, lambda piece=piece: self.far(piece))  # type: ignore[misc]


class Line:
    """A client and a device that notes each write it does, with two wires."""

    def __init__(
        self,
        baud: int,
        *faults: Callable[[bytes], list[bytes]],
        stretch: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self.scheduler = Scheduler()
        self.came: list[Frame] = []
        self.done: list[int] = []
        both = faults or (lambda data: [data],) * 2
        self.wires = [Wire(self.scheduler, baud, fault, stretch) for fault in both]
        self.client: SerialCarrier = SerialCarrier(
            self.scheduler, self.wires[0].write, self.came.append, baud=baud
        )
        self.device: SerialCarrier = SerialCarrier(
            self.scheduler, self.wires[1].write, self._do, baud=baud
        )
        self.wires[0].far = lambda data: self.device.receive(data)
        self.wires[1].far = lambda data: self.client.receive(data)

    def _do(self, frame: Frame) -> None:
        self.done.append(frame.invoke_id)
        self.device.send(frame.reply(ResultResponse(0).encode()))


def write(invoke_id: int, size: int = 4) -> Frame:
    data = WriteRequest(0x4040, 0, bytes(size)).encode()
    return Frame(DEVICE, CLIENT, Command.WRITE, 4, 0, invoke_id, data)


def harm(dice: random.Random, rate: float) -> Callable[[bytes], list[bytes]]:
    """Each write may be lost, doubled, changed, lack bytes inside, or come with others' bytes."""
    delayed = bytearray()

    def fault(data: bytes) -> list[bytes]:
        data = bytes(delayed) + data
        delayed.clear()
        if dice.random() > rate:
            return [data]
        match dice.randrange(8):
            case 0:
                return []
            case 1:
                return [data, data]
            case 2:
                at = dice.randrange(len(data))
                return [data[:at] + bytes([data[at] ^ dice.randrange(1, 256)]) + data[at + 1 :]]
            case 3:  # bytes dropped inside
                at, size = dice.randrange(len(data)), dice.randrange(1, 20)
                return [data[:at] + data[at + size :]]
            case 4:  # comes with the next one
                delayed.extend(data)
                return []
            case 5:  # byte by byte
                return [data[at : at + 1] for at in range(len(data))]
            case 6:
                return [RESET * dice.randrange(1, 4) + data + RESET]
            case _:
                return [dice.randbytes(dice.randrange(30)) + data + b"\x01\xa5\0\0\0\xff"]

    return fault


@pytest.mark.parametrize("seed", range(6))
def test_thousands_of_requests_are_answered_once_or_fail(
    seed: int, many: Callable[[int], int]
) -> None:
    """No write is done twice, none is answered twice; delays are longer than the patience."""
    dice = random.Random(seed)
    rate = dice.choice([0.01, 0.05, 0.2])
    delay = dice.choice([0.0, 0.05, 0.7])
    line = Line(
        dice.choice([9_600, 19_200, 38_400, 57_600, 115_200]),
        *(harm(dice, rate), harm(dice, rate)),
        stretch=lambda: dice.random() * delay,
    )
    most = many(2_500 if seed == 0 else 1_000)
    for invoke_id in range(most):
        line.client.send(write(invoke_id, dice.randrange(200)))
        line.scheduler.run(dice.choice([0.0, 0.01, 0.1, 1.0]))
    line.scheduler.run(60_000)
    assert line.client.unsent == line.device.unsent == 0
    assert len(set(line.done)) == len(line.done), "a write was done twice"
    assert all(one < other for one, other in pairwise(line.done))
    answers = Counter(frame.invoke_id for frame in line.came)
    assert set(answers.values()) == {1}, "a request was answered twice"
    failed = {frame.invoke_id for frame in line.came if frame.error == 0x745}
    silent = set(range(most)) - set(answers)
    assert silent <= set(line.done), "a request was lost without a word"
    assert len(silent) <= most * rate * 0.1  # their answers were given up by the device
    assert set(range(most)) - failed - silent <= set(line.done)


def test_an_answer_behind_0x745_is_dropped_and_a_new_request_of_that_number_is_answered() -> None:
    deaf = True

    def fault(data: bytes) -> list[bytes]:
        frame = SerialFrame.decode(data[-8:]) if len(data) == 8 else None
        acknowledges = frame is not None and frame.kind is FrameKind.ACKNOWLEDGE
        return [] if deaf and acknowledges else [data]

    line = Line(38_400, fault, fault)
    line._do = line.device._received = lambda frame: line.scheduler.call_at(  # type: ignore[method-assign]
        line.scheduler.now + 5, lambda: line.device.send(frame.reply(ResultResponse(0).encode()))
    )
    line.client.send(write(1))
    line.scheduler.run(4)
    assert [(each.invoke_id, each.error) for each in line.came] == [(1, 0x745)]
    deaf = False
    line.scheduler.run(10)
    assert len(line.came) == 1
    line.client.send(write(1))
    line.scheduler.run(10)
    assert [(each.invoke_id, each.error) for each in line.came] == [(1, 0x745), (1, 0)]


@pytest.mark.parametrize("wrong", [1, 7, 128, 255])
def test_wrong_numbers_acknowledge_nothing(wrong: int) -> None:
    line = Line(38_400)
    line.client.end._fragment = 7  # so that no wrong number is 0, that of the reset
    frames: list[bytes] = []

    def answer(data: bytes) -> None:
        frames.append(data)
        if data != RESET:
            frame = SerialFrame.decode(data.removeprefix(RESET))
            number = (frame.fragment + wrong) % 256
            line.client.receive(SerialFrame(FrameKind.ACKNOWLEDGE, number).encode())

    line.wires[0].far = answer
    for invoke_id in range(3):
        line.client.send(write(invoke_id))
    line.scheduler.run(20)
    assert [(each.invoke_id, each.error) for each in line.came] == [(n, 0x745) for n in range(3)]
    assert line.client.unsent == 0


def test_a_far_end_that_begins_again_at_the_same_number_is_heard() -> None:
    """Without a reset: 000 §4.1 takes the first number of a sender as it comes."""
    end = SerialEnd()
    for invoke_id in range(20):
        frame = SerialFrame(FrameKind.DATA, 0, write(invoke_id).encode())
        assert end.receive(frame.encode(), invoke_id * 0.1) == [frame.data]
        assert end.receive(frame.encode(), invoke_id * 0.1 + 0.05) == []
    assert end.received_packets == 20


def test_more_than_a_line_carries_is_not_acknowledged() -> None:
    """A foreign end asks for long answers for ever and takes none: what waits is bounded."""
    line = Line(115_200)
    line.wires[1].far = bool  # nobody acknowledges
    line.device._received = lambda frame: line.device.send(
        frame.reply(DataResponse(0, bytes(200)).encode())
    )
    request = Frame(DEVICE, CLIENT, Command.READ, 4, 0, 1, ReadRequest(0x4040, 0, 200).encode())
    for number in range(5_000):
        line.device.receive(SerialFrame(FrameKind.DATA, number % 256, request.encode()).encode())
        request.invoke_id += 1
    assert 256 * 1024 < line.device.unsent < 257 * 1024
    line.wires[1].far = lambda data: line.client.receive(data)
    line.scheduler.run(3_000)
    line.device.receive(RESET + SerialFrame(FrameKind.DATA, 9, request.encode()).encode())
    line.scheduler.run(1)
    assert line.device.end.received_packets > 1_000
    assert request.invoke_id in {each.invoke_id for each in line.came}


def test_a_port_that_goes_answers_what_waits() -> None:
    line = Line(9_600)
    quiet = write(7)
    quiet.flags |= Flags.NO_RESPONSE
    for frame in (write(1), write(2), quiet, write(3)):
        line.client.send(frame)
    line.client.give_up()
    line.client.close()
    assert [(each.invoke_id, each.error) for each in line.came] == [(n, 0x745) for n in (1, 2, 3)]
    assert line.client.unsent == 0
    line.scheduler.run(10)
    assert len(line.came) == 3
