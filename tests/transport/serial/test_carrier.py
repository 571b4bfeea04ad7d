"""Frames over a serial line in virtual time: what fits goes, the rest is answered."""

import random
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Flags, Frame, NotificationStream
from achse.ams.commands import (
    AddNotificationRequest,
    DataResponse,
    ReadRequest,
    ResultResponse,
    WriteRequest,
)
from achse.ams.notification import encode_stream
from achse.transport.serial.carrier import LONGEST_SAMPLE, SerialCarrier, SerialTransport

CLIENT = AmsAddress("127.0.0.1.1.2:40000")
DEVICE = AmsAddress("127.0.0.1.1.1:851")


class Scheduler:
    """Time that tests let pass."""

    def __init__(self) -> None:
        self.now = 100.0
        self.calls: list[tuple[float, int, Callable[[], object]]] = []
        self.count = 0

    def time(self) -> float:
        return self.now

    def call_soon(self, callback: Callable[[], object]) -> object:
        return self.call_at(self.now, callback)

    def call_at(self, when: float, callback: Callable[[], object]) -> Any:
        self.count += 1
        call = (when, self.count, callback)
        self.calls.append(call)
        scheduler = self

        class Timer:
            def cancel(self) -> None:
                if call in scheduler.calls:
                    scheduler.calls.remove(call)

        return Timer()

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while due := sorted(call for call in self.calls if call[0] <= end):
            self.calls.remove(due[0])
            self.now = max(self.now, due[0][0])
            due[0][2]()
        self.now = end


class Pair:
    """A client's and a device's end, with a line between that may do harm."""

    def __init__(self, baud: int = 38_400, fault: Callable[[bytes], list[bytes]] | None = None):
        self.scheduler = Scheduler()
        self.fault = fault or (lambda data: [data])
        self.at_client: list[Frame] = []
        self.at_device: list[Frame] = []
        self.busy = [0.0, 0.0]
        self.client: SerialCarrier = SerialCarrier(
            *(self.scheduler, lambda data: self.carry(0, data), self.at_client.append), baud=baud
        )
        self.device: SerialCarrier = SerialCarrier(
            *(self.scheduler, lambda data: self.carry(1, data), self.at_device.append), baud=baud
        )
        self.baud = baud

    def carry(self, side: int, data: bytes) -> None:
        far = (self.device, self.client)[side]
        self.busy[side] = max(self.busy[side], self.scheduler.now) + len(data) * 10 / self.baud
        for piece in self.fault(data):
            self.scheduler.call_at(self.busy[side], lambda piece=piece: far.receive(piece))  # type: ignore[misc]


def request(command: Command, data: bytes, invoke_id: int = 1) -> Frame:
    return Frame(DEVICE, CLIENT, command, 4, 0, invoke_id, data)


def read(length: int = 4, invoke_id: int = 1) -> Frame:
    return request(Command.READ, ReadRequest(0x4040, 0, length).encode(), invoke_id)


def test_a_request_and_its_answer() -> None:
    pair = Pair()
    pair.client.send(read())
    assert pair.client.unsent == 44
    pair.scheduler.run(0.1)
    (request,) = pair.at_device
    pair.device.send(request.reply(DataResponse(0, b"abcd").encode()))
    pair.scheduler.run(0.1)
    assert [frame.data[8:] for frame in pair.at_client] == [b"abcd"]
    assert pair.client.unsent == pair.device.unsent == 0


@pytest.mark.parametrize("baud", [9_600, 19_200, 38_400, 57_600, 115_200])
def test_the_line_takes_its_time(baud: int) -> None:
    """Reset and request have 60 bytes of ten bits."""
    pair = Pair(baud)
    pair.client.send(read())
    pair.scheduler.run(599 / baud)
    assert not pair.at_device
    pair.scheduler.run(2 / baud)
    assert pair.at_device


def test_a_request_that_is_too_long_is_answered_0x705() -> None:
    pair = Pair()
    pair.client.send(request(Command.WRITE, WriteRequest(0x4040, 0, bytes(212)).encode(), 9))
    pair.client.send(request(Command.WRITE, WriteRequest(0x4040, 0, bytes(211)).encode(), 10))
    pair.scheduler.run(1)
    (refused,) = pair.at_client
    assert (refused.invoke_id, refused.is_response, refused.error) == (9, True, 0)
    assert ResultResponse.decode(refused.data).result == 0x705
    assert [frame.invoke_id for frame in pair.at_device] == [10]


def test_an_answer_that_is_too_long_becomes_0x705() -> None:
    pair = Pair()
    for invoke_id, length in ((1, 215), (2, 216)):
        answer = read(invoke_id=invoke_id).reply(DataResponse(0, bytes(length)).encode())
        pair.device.send(answer)
    pair.scheduler.run(1)
    assert [DataResponse.decode(frame.data).result for frame in pair.at_client] == [0, 0x705]


def test_one_that_wants_no_answer_gets_none() -> None:
    pair = Pair()
    frame = request(Command.WRITE, WriteRequest(0x4040, 0, bytes(300)).encode())
    frame.flags |= Flags.NO_RESPONSE
    pair.client.send(frame)
    pair.scheduler.run(1)
    assert not pair.at_client
    assert not pair.at_device


@pytest.mark.parametrize("side", ["asker", "device"])
def test_a_subscription_whose_samples_do_not_fit_is_refused(side: str) -> None:
    pair = Pair()
    for invoke_id, length in ((1, LONGEST_SAMPLE), (2, LONGEST_SAMPLE + 1)):
        wish = AddNotificationRequest(0x4040, 0, length, 4, 0, 0)
        frame = request(Command.ADD_NOTIFICATION, wish.encode(), invoke_id)
        if side == "asker":
            pair.client.send(frame)
        else:  # a foreign one that does not know
            pair.client.end.send(frame.encode(), pair.scheduler.now)
            pair.client._settle()
    pair.scheduler.run(1)
    assert [frame.invoke_id for frame in pair.at_device] == [1]
    assert [frame.invoke_id for frame in pair.at_client] == [2]
    assert pair.at_client[0].data[:4] == (0x705).to_bytes(4, "little")


def test_many_samples_come_in_several_frames_in_order() -> None:
    samples = [(100 + n // 3, [(n, bytes([n]) * (1 + 37 * n % LONGEST_SAMPLE))]) for n in range(40)]
    stream = encode_stream([*samples, (200, [(99, bytes(LONGEST_SAMPLE + 1))])])
    pair = Pair()
    pair.device.send(Frame(CLIENT, DEVICE, Command.NOTIFICATION, 4, 0, 0, stream))
    pair.scheduler.run(60)
    came = [
        (stamp.filetime, [(sample.handle, sample.data)])
        for frame in pair.at_client
        for stamp in NotificationStream.decode(frame.data).stamps
        for sample in stamp.samples
    ]
    assert came == samples
    assert 20 < len(pair.at_client) < 40


def test_who_does_not_acknowledge_makes_requests_fail_with_0x745() -> None:
    pair = Pair(fault=lambda data: [])
    pair.client.send(read(invoke_id=1))
    pair.client.send(read(invoke_id=2))
    pair.scheduler.run(10)
    assert [(frame.invoke_id, frame.error) for frame in pair.at_client] == [(1, 0x745), (2, 0x745)]
    assert pair.client.unsent == 0


def test_nothing_comes_or_goes_after_the_end() -> None:
    pair = Pair()
    pair.client.send(read())
    pair.client.close()
    pair.client.send(read())
    pair.client.receive(b"\x01\xa5")
    pair.scheduler.run(100)
    assert len(pair.at_device) == 1
    assert not pair.scheduler.calls


def test_a_packet_that_is_no_ams_is_dropped() -> None:
    pair = Pair()
    pair.client.end.send(b"not AMS", pair.scheduler.now)
    pair.client.send(read())
    pair.scheduler.run(1)
    assert len(pair.at_device) == 1


def test_a_peers_line_carries_packets_without_their_tcp_header() -> None:
    pair = Pair()
    closed: list[str] = []
    line = SerialTransport(
        pair.client, lambda: closed.append("close"), lambda: closed.append("abort")
    )
    both = read(invoke_id=1).encode_tcp() + read(invoke_id=2).encode_tcp()
    line.write(both[:50])
    line.write(both[50:])
    assert line.get_write_buffer_size() == 88
    line.pause_reading()
    line.resume_reading()
    line.close()
    line.abort()
    pair.scheduler.run(1)
    assert [frame.invoke_id for frame in pair.at_device] == [1, 2]
    assert closed == ["close", "abort"]


@pytest.mark.parametrize("seed", range(5))
def test_thousands_of_requests_over_a_bad_line(seed: int, many: Callable[[int], int]) -> None:
    """Each is answered once or fails with 0x745; no write is done twice."""
    dice = random.Random(seed)
    loss, harm, twice = (dice.choice([0, 0.01, 0.05]) for _ in range(3))

    def fault(data: bytes) -> list[bytes]:
        if dice.random() < loss:
            return []
        if dice.random() < harm:
            at = dice.randrange(len(data))
            data = data[:at] + bytes([data[at] ^ dice.randrange(1, 256)]) + data[at + 1 :]
        return [data, data] if dice.random() < twice else [data]

    pair = Pair(dice.choice([9_600, 38_400, 115_200]), fault)
    done: list[int] = []

    def do(frame: Frame) -> None:
        done.append(frame.invoke_id)
        pair.device.send(frame.reply(ResultResponse(0).encode()))

    pair.device = SerialCarrier(
        pair.scheduler, lambda data: pair.carry(1, data), do, baud=pair.baud
    )
    most = many(1_000)
    for invoke_id in range(most):
        data = bytes(dice.randrange(100))
        pair.client.send(request(Command.WRITE, WriteRequest(0x4040, 0, data).encode(), invoke_id))
        pair.scheduler.run(dice.choice([0.0, 0.02, 0.2]))
    pair.scheduler.run(10_000)
    assert pair.client.unsent == pair.device.unsent == 0
    assert len(set(done)) == len(done), "a write was done twice"
    assert all(one < other for one, other in pairwise(done)), "out of order"
    answered = [frame.invoke_id for frame in pair.at_client if not frame.error]
    failed = {frame.invoke_id for frame in pair.at_client if frame.error == 0x745}
    assert len(set(answered)) == len(answered)
    lost_answers = set(done) - set(answered)
    assert set(answered) | failed | lost_answers == set(range(most))
    assert len(lost_answers) <= 2
    if not loss and not harm:
        assert len(answered) == most
