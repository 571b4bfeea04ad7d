"""Hostile frames through a segment, with a good master beside them."""

import struct
from collections.abc import Callable, Iterator
from itertools import islice
from random import Random

from achse.codes import AlState
from achse.drive import Drive
from achse.ethercat import (
    Datagram,
    DatagramCommand,
    EthercatFrame,
    FrameError,
    Loopback,
    Segment,
    Slave,
)
from achse.ethercat.frame import datagram_offsets
from achse.testing import SegmentReach

FRAMES = 20_000
DRIVE_FRAMES = 5000
SLAVES = 2
LOOK_EVERY = 50
HEAD = b"\xff" * 6 + b"\x02\0\0\0\0\0" + b"\x88\xa4"

PLACES = (
    0x0000, 0x0010, 0x0040, 0x0100, 0x0110, 0x0120, 0x0130, 0x0200, 0x0300, 0x0400, 0x0420, 0x0440,
    0x0500, 0x0502, 0x0600, 0x0610, 0x0800, 0x0808, 0x0810, 0x0818, 0x080D, 0x0900, 0x0910, 0x0920,
    0x0980, 0x0990, 0x09A0, 0x09B0, 0x0F80, 0x0FFF, 0x1000, 0x10FF, 0x1100, 0x11FF, 0x1200, 0x1300,
    0x2000, 0x2FFF, 0xFFFF,
)  # fmt: skip
SDO_COMMANDS = (0x00, 0x10, 0x21, 0x23, 0x2B, 0x2F, 0x31, 0x40, 0x50, 0x51, 0x60, 0x70, 0x80)
OBJECTS = (
    0x1000, 0x1010, 0x1018, 0x1600, 0x1A00, 0x1C12, 0x1C13, 0x1C32, 0x3200, 0x3215, 0x6040, 0x6060,
    0x607A, 0x6098, 0x60FE,
)  # fmt: skip
STATIONS = (0x1001, 0x1002, 0, 0xFFFF, 1)


class GoodMaster:
    """Brings every slave to Op from wherever it is, and exchanges process data."""

    def __init__(self, segment: Segment) -> None:
        self.segment = segment
        self.cyclic = EthercatFrame([Datagram(DatagramCommand.LRW, 0, bytes(8 * SLAVES))]).encode()

    def send(self, command: DatagramCommand, address: int, offset: int, data: bytes) -> Datagram:
        reply = self.segment.process(
            EthercatFrame([Datagram.at(command, address, offset, data)]).encode()
        )
        assert reply is not None
        return EthercatFrame.decode(reply).datagrams[0]

    def bring_to_op(self) -> None:
        for slave in self.segment.slaves:  # what only a power cycle undoes
            slave.reset()
        for position in range(SLAVES):
            station = 0x1001 + position
            areas = ((0x1000, 256, 0x26), (0x1100, 256, 0x22), (0x1200, 4, 0x64), (0x1300, 4, 0x20))
            channels = b"".join(struct.pack("<HHBBBB", *area, 0, 1, 0) for area in areas)
            mapping = b"".join(
                struct.pack("<IHBBHBBB3x", logical, 4, 0, 7, physical, 0, direction, 1)
                for logical, physical, direction in (
                    (4 * position, 0x1200, 2),
                    (4 * (SLAVES + position), 0x1300, 1),
                )
            )
            self.send(DatagramCommand.APWR, -position, 0x0010, station.to_bytes(2, "little"))
            self.send(DatagramCommand.FPWR, station, 0x0800, channels)
            self.send(DatagramCommand.FPWR, station, 0x0600, mapping.ljust(48, b"\0"))
            for state in (AlState.PREOP, AlState.SAFEOP):
                self.send(DatagramCommand.FPWR, station, 0x0120, bytes((state | 0x10, 0)))
        self.cycle()
        self.send(DatagramCommand.BWR, 0, 0x0120, bytes((AlState.OP, 0)))
        assert self.cycle() == 3 * SLAVES
        assert all(slave.state is AlState.OP for slave in self.segment.slaves)

    def cycle(self) -> int:
        reply = self.segment.process(self.cyclic)
        assert reply is not None
        return EthercatFrame.decode(reply).datagrams[0].counter


def hostile(seed: int) -> Iterator[bytes]:
    """Frames of sound structure with wild content, the same damaged, and noise."""
    dice = Random(seed)
    pick, number, noise = dice.choice, dice.randrange, dice.randbytes
    while True:
        parts = []
        for left in range(number(3), -1, -1):
            size = pick((0, 1, 2, 6, 8, 16, 48, 256))
            if number(4) == 0:
                where = number(64) | number(2) << 16
            else:
                where = (pick(STATIONS) + number(3) & 0xFFFF) | pick(PLACES) << 16
            head = struct.pack(
                "<BBIHH", number(16), number(256), where, size | 0x8000 * (left > 0), 0
            )
            parts.append(head + noise(size) + b"\0\0")
        body = b"".join(parts)
        packet = HEAD + struct.pack("<H", len(body) | 0x1000) + body
        yield packet
        damaged = bytearray(packet)
        for _ in range(number(1, 4)):
            damaged[number(12, len(damaged))] = number(256)
        yield bytes(damaged[: number(len(damaged)) + 1])
        yield HEAD + noise(number(64))


def slaves() -> Segment:
    segment = Segment((Slave(Loopback()) for _ in range(SLAVES)), cycle_ns=1_000_000)
    for slave in segment.slaves:
        image = bytes(slave.esc.eeprom.image)
        slave.esc.eeprom.image = _ReadOnly(image)
    return segment


class _ReadOnly(bytearray):
    """An EEPROM whose write protection is on: a hostile master destroys a real one for good."""

    def __setitem__(self, *_: object) -> None:
        pass


def test_nothing_escapes_and_a_good_master_always_gets_its_slaves_back(
    many: Callable[[int], int],
) -> None:
    frames = many(FRAMES)
    segment = slaves()
    master = GoodMaster(segment)
    master.bring_to_op()
    for count, packet in enumerate(islice(hostile(1), frames)):
        reply = segment.process(packet)
        assert reply is None or len(reply) == len(packet)
        if count % LOOK_EVERY == 0:
            master.bring_to_op()
    master.bring_to_op()
    assert segment.counters.malformed > frames // 5
    assert segment.counters.foreign > frames // 500


def messages(seed: int) -> Iterator[bytes]:
    """Mailbox messages with wild content; most look like SDO requests for known objects."""
    dice = Random(seed)
    pick, number, noise = dice.choice, dice.randrange, dice.randbytes
    while True:
        body = noise(pick((0, 1, 2, 4, 8, 10, 12, 16, 40, 200)))
        if number(5) and len(body) >= 6:
            command = pick((*SDO_COMMANDS, number(256)))
            index = pick((*OBJECTS, number(1 << 16)))
            head = struct.pack("<HBHB", pick((1, 2, 3, 5, 8)) << 12, command, index, number(9))
            body = head + body[6:]
        length = pick((len(body), len(body), number(1 << 16)))
        kind = pick((3, 3, 3, number(16))) | number(8) << 4
        yield (struct.pack("<HHBB", length, 0, 0, kind) + body).ljust(256, b"\0")[:256]


def test_drives_bear_hostile_frames_and_messages(many: Callable[[int], int]) -> None:
    """What firmware sees of a hostile master: nothing of it escapes, and Op can be had again."""
    segment = Segment(Slave(Drive()) for _ in range(SLAVES))
    for slave in segment.slaves:
        slave.esc.eeprom.image = _ReadOnly(bytes(slave.esc.eeprom.image))
    for count, (packet, message) in enumerate(
        islice(zip(hostile(3), messages(4), strict=True), many(DRIVE_FRAMES))
    ):
        segment.process(packet)
        for station in (0x1001, 0x1002):
            for command, address, data in (
                (DatagramCommand.FPWR, 0x1000, message),
                (DatagramCommand.FPRD, 0x1100, bytes(256)),
            ):
                segment.process(
                    EthercatFrame([Datagram.at(command, station, address, data)]).encode()
                )
        segment.advance(segment.time.now_ns + 100_000)
        if count % 500 == 0:
            for slave in segment.slaves:
                slave.reset()
            for position in range(SLAVES):
                master = SegmentReach(segment, position)
                for state in (AlState.PREOP, AlState.SAFEOP):
                    assert master.request(state | 0x10) == (state, 0)
                master.exchange(b"")
                assert master.request(AlState.OP | 0x10) == (AlState.OP, 0)


def test_broken_frames_do_not_disturb_a_good_master(many: Callable[[int], int]) -> None:
    """Whatever has no sound structure touches nothing: the slaves stay in Op all along."""
    segment = slaves()
    master = GoodMaster(segment)
    master.bring_to_op()
    frames = many(FRAMES)
    broken = 0
    for packet in islice(hostile(2), frames):
        try:
            sound = packet[12:14] == b"\x88\xa4" and bool(datagram_offsets(packet, 14))
        except FrameError:
            sound = False
        if not sound:
            broken += 1
            reply = segment.process(packet)
            assert reply in (packet, None) or reply[:6] + reply[7:] == packet[:6] + packet[7:]
            if broken % 64 == 0:
                assert master.cycle() == 3 * SLAVES
    assert broken > frames // 2
    assert all(slave.state is AlState.OP for slave in segment.slaves)
