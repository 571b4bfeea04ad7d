"""Serial frames and one end of a line: the worked examples, and every rule of 000 §4."""

import random
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DecodeError, Frame
from achse.ams.serial import (
    FREE_AFTER,
    GAP,
    MAX_PACKET,
    QUICK_REPEAT_TIME,
    REPEAT_TIME,
    SENDINGS,
    FrameKind,
    SerialEnd,
    SerialFrame,
    crc16,
)

REQUEST = bytes.fromhex(
    "C0A864AE01012103 C0A8649C01010180 0200 0400 0C000000 00000000 07000000"
    "05F00000 0400009D 02000000"
)
ANSWER = bytes.fromhex(
    "C0A8649C01010180 C0A864AE01012103 0200 0500 0A000000 00000000 0700000000000000 02000000 AF27"
)
RESET = SerialFrame(FrameKind.RESET, 0).encode()


def data(fragment: int, packet: bytes = REQUEST) -> bytes:
    return SerialFrame(FrameKind.DATA, fragment, packet).encode()


def acknowledge(fragment: int) -> bytes:
    return SerialFrame(FrameKind.ACKNOWLEDGE, fragment).encode()


def frames(sent: bytes) -> Iterator[SerialFrame]:
    while sent:
        frame = SerialFrame.decode(sent)
        yield frame
        sent = sent[8 + len(frame.data) :]


# frames (000 §4.1, §4.3) --------------------------------------------------------------------------


def test_the_worked_frames() -> None:
    assert acknowledge(0x06) == bytes.fromhex("01 5A 00 00 06 00 67 5A")
    answer = data(0xEC, ANSWER)
    assert answer[:6] == bytes.fromhex("01 A5 00 00 EC 2A")
    assert answer[-2:] == bytes.fromhex("04 A9")
    assert len(answer) == 50
    request = data(0x06)
    assert request[:6] == bytes.fromhex("01 A5 00 00 06 2C")
    assert Frame.decode(SerialFrame.decode(request).data).invoke_id == 7


def test_the_checksum_is_the_reflected_0x8005() -> None:
    """0x4B37 is the published check value of this CRC for the digits 1 to 9."""
    assert crc16(b"123456789") == 0x4B37


@given(
    kind=st.sampled_from(FrameKind),
    fragment=st.integers(0, 255),
    packet=st.binary(max_size=255),
    sender=st.integers(0, 255),
    receiver=st.integers(0, 255),
    rest=st.binary(max_size=20),
)
def test_a_frame_is_what_it_was(
    kind: FrameKind, fragment: int, packet: bytes, sender: int, receiver: int, rest: bytes
) -> None:
    frame = SerialFrame(kind, fragment, packet, sender, receiver)
    assert SerialFrame.decode(frame.encode() + rest) == frame


@pytest.mark.parametrize(
    ("packet", "message"),
    [
        (b"", "begins with"),
        (b"\x02\xa5" + bytes(20), "begins with"),
        (data(1)[:20], "got 20"),
        (data(1)[:-1] + b"\0", "checksum"),
    ],
)
def test_what_is_not_a_frame(packet: bytes, message: str) -> None:
    with pytest.raises(DecodeError, match=message):
        SerialFrame.decode(packet)


# receiving ----------------------------------------------------------------------------------------


def test_a_good_frame_is_acknowledged_and_passed_on() -> None:
    end = SerialEnd()
    assert end.receive(data(0x06), 0.0) == [REQUEST]
    assert end.take(0.0) == acknowledge(0x06)


def test_an_acknowledge_goes_to_who_sent() -> None:
    end = SerialEnd(address=7)
    end.receive(SerialFrame(FrameKind.DATA, 1, REQUEST, sender=9, receiver=7).encode(), 0.0)
    (sent,) = frames(end.take(0.0))
    assert (sent.sender, sent.receiver) == (7, 9)


def test_the_first_number_is_free_and_the_next_ones_follow() -> None:
    end = SerialEnd()
    for fragment in (254, 255, 0, 1):
        assert end.receive(data(fragment), 0.0) == [REQUEST]
        assert end.take(0.0) == acknowledge(fragment)


def test_a_repeated_frame_is_acknowledged_but_not_passed_on() -> None:
    end = SerialEnd()
    end.receive(data(5), 0.0)
    end.take(0.0)
    assert end.receive(data(5), 0.6) == []
    assert end.take(0.6) == acknowledge(5)


@pytest.mark.parametrize("fragment", [3, 7, 200])
def test_a_wrong_number_is_neither_acknowledged_nor_passed_on(fragment: int) -> None:
    end = SerialEnd()
    end.receive(data(5), 0.0)
    end.take(0.0)
    assert end.receive(data(fragment), 0.1) == []
    assert end.take(0.1) == b""
    assert end.spoiled_frames == 1


def test_a_reset_and_a_long_silence_free_the_number() -> None:
    end = SerialEnd()
    end.receive(data(5), 0.0)
    assert end.receive(RESET + data(77), 0.1) == [REQUEST]
    assert end.receive(data(200), 0.1 + FREE_AFTER) == [REQUEST]
    assert end.resets == 1


def test_the_same_frame_behind_a_reset_is_taken_once() -> None:
    end = SerialEnd()
    assert end.receive(RESET + data(5) + RESET + data(5), 0.0) == [REQUEST]
    assert end.receive(RESET + data(5), FREE_AFTER) == [REQUEST]


def test_garbage_is_passed_over_byte_by_byte() -> None:
    end = SerialEnd()
    assert end.receive(b"\x01\x01\xa5\x00" + data(1) + b"\x5a", 0.0) == [REQUEST]
    assert end.receive(data(2), 0.0) == [REQUEST]
    assert end.spoiled_frames == 5


def test_a_frame_that_lacks_its_end_gives_way_after_a_gap() -> None:
    end = SerialEnd()
    assert end.receive(b"\x01\xa5\0\0\0\xff" + data(2), 0.0) == []
    assert end.deadline == pytest.approx(GAP)
    assert end.due(GAP) == [REQUEST]
    assert end.deadline is None


def test_the_longest_frame_has_263_bytes_and_no_packet_is_longer() -> None:
    end, other = SerialEnd(), SerialEnd()
    end.send(bytes(MAX_PACKET), 0.0)
    sent = end.take(0.0)
    assert len(sent) == len(RESET) + 263
    assert other.receive(sent, 0.3) == [bytes(255)]
    for length in (0, 256):
        with pytest.raises(ValueError, match=r"1\.\.255"):
            end.send(bytes(length), 0.0)


@given(
    noise=st.lists(st.binary(max_size=30), max_size=20),
    cut=st.integers(1, 40),
    numbers=st.lists(st.integers(0, 255), min_size=1, max_size=10),
)
def test_any_bytes_are_taken_and_good_frames_come_through(
    noise: list[bytes], cut: int, numbers: list[int]
) -> None:
    """Whatever came before: after a gap a reset and a frame go through."""
    end = SerialEnd()
    now = 0.0
    mixed = b"".join(noise) + b"".join(data(number) for number in numbers)
    for start in range(0, len(mixed), cut):
        end.receive(mixed[start : start + cut], now)
        now += 0.001
    now += FREE_AFTER
    while (deadline := end.deadline) is not None and deadline <= now:
        end.due(now)
    assert end.receive(RESET + data(9, ANSWER), now) == [ANSWER]


# sending ------------------------------------------------------------------------------------------


def test_frames_go_one_after_the_other_with_numbers_that_wrap() -> None:
    end = SerialEnd(first=255)
    end.send(REQUEST, 0.0)
    end.send(ANSWER, 0.0)
    assert end.take(0.0) == RESET + data(255)
    assert end.unsent == len(REQUEST) + len(ANSWER)
    end.receive(acknowledge(254), 0.1)
    assert end.take(0.1) == b""
    end.receive(acknowledge(255), 0.1)
    assert end.take(0.1) == data(0, ANSWER)
    end.receive(acknowledge(0), 0.2)
    assert (end.unsent, end.deadline, end.sent_packets) == (0, None, 2)


@pytest.mark.parametrize(
    ("baud", "patience"),
    [(9_600, REPEAT_TIME), (38_400, REPEAT_TIME), (115_200, QUICK_REPEAT_TIME)],
)
def test_what_is_not_acknowledged_is_repeated_then_given_up(baud: int, patience: float) -> None:
    end = SerialEnd(baud, first=4)
    end.send(REQUEST, 0.0)
    sent = end.take(0.0)
    now = 0.0
    for _ in range(SENDINGS - 1):
        assert end.deadline == pytest.approx(now + len(sent) * 10 / baud + patience)
        now = end.deadline or 0.0
        end.due(now)
        sent = end.take(now)
        assert sent == data(4)
    now = end.deadline or 0.0
    end.due(now)
    assert end.take(now) == RESET
    assert list(end.undelivered) == [REQUEST]
    assert end.deadline is None
    end.send(ANSWER, now + 1)
    assert end.take(now + 1) == RESET + data(5, ANSWER)


def test_a_line_needs_a_baud_rate() -> None:
    with pytest.raises(ValueError, match="1 baud or more"):
        SerialEnd(0)


# both ends over a bad line ------------------------------------------------------------------------


class BadLine:
    """Bytes from one end to the other: they take their time, and some do not come as they went."""

    def __init__(self, dice: random.Random, baud: int, loss: float, harm: float, twice: float):
        self.dice, self.baud = dice, baud
        self.loss, self.harm, self.twice = loss, harm, twice
        self.delay = dice.uniform(0, 0.02)
        self.busy_until = 0.0
        self.under_way: list[tuple[float, bytes]] = []

    def put(self, sent: bytes, now: float) -> None:
        if not sent:
            return
        self.busy_until = max(now, self.busy_until) + len(sent) * 10 / self.baud
        arrival = self.busy_until + self.delay
        if self.dice.random() < self.loss:
            cut = self.dice.randrange(len(sent) + 1)
            sent = sent[:cut] if self.dice.random() < 0.5 else b""
        if sent and self.dice.random() < self.harm:
            harmed = bytearray(sent)
            harmed[self.dice.randrange(len(harmed))] ^= self.dice.randrange(1, 256)
            sent = bytes(harmed)
        copies = 2 if self.dice.random() < self.twice else 1
        if sent:
            self.under_way += [(arrival, sent)] * copies

    @property
    def next(self) -> float | None:
        return self.under_way[0][0] if self.under_way else None


@pytest.mark.parametrize("seed", range(12))
def test_each_packet_arrives_once_or_is_given_up(seed: int) -> None:
    """Loss, harm, doubling, delay and speed at random: in order, never twice, none unaccounted."""
    dice = random.Random(seed)
    baud = dice.choice([9_600, 19_200, 38_400, 57_600, 115_200])
    faults = [dice.choice([0, 0.01, 0.1, 0.3]) for _ in range(3)]
    ends = [SerialEnd(baud), SerialEnd(baud)]
    lines = [BadLine(dice, baud, *faults), BadLine(dice, baud, *faults)]
    wanted: list[list[bytes]] = [[], []]
    came: list[list[bytes]] = [[], []]
    left = 60 if max(faults) else 400
    now = 0.0
    for number in range(left):
        for side in (0, 1):
            packet = bytes([side, *number.to_bytes(2, "big")]) * dice.randrange(1, 80)
            ends[side].send(packet, now)
            wanted[side].append(packet)
    for _ in range(200_000):
        for side in (0, 1):
            lines[side].put(ends[side].take(now), now)
        times = [
            t for t in (*(e.deadline for e in ends), *(x.next for x in lines)) if t is not None
        ]
        if not times:
            break
        now = max(now, min(times))
        for side in (0, 1):
            line, far = lines[side], ends[1 - side]
            while line.under_way and line.under_way[0][0] <= now:
                came[side] += far.receive(line.under_way.pop(0)[1], now)
            deadline = far.deadline
            if deadline is not None and deadline <= now:
                came[side] += far.due(now)
    assert not any(end.unsent for end in ends)
    for side in (0, 1):
        assert len(set(came[side])) == len(came[side]), "a packet came twice"
        positions = [wanted[side].index(packet) for packet in came[side]]
        assert positions == sorted(positions)
        undelivered = set(ends[side].undelivered)
        assert set(wanted[side]) - set(came[side]) <= undelivered
        if not max(faults):
            assert came[side] == wanted[side]
            assert not undelivered
