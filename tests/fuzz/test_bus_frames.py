"""Frames from the bus that are not what slaves send: none escapes the master, and the bus is back.

With --deep a million of them. Half are changed answers, which the master takes where their headers
are right: states, EEPROM words, mailbox messages and process data of any content.
"""

from collections.abc import Callable
from random import Random

import pytest

from achse.codes import AlState
from achse.drive import Drive
from achse.drive.identity import VENDOR
from achse.ethercat import Loopback, Segment, Slave, describe
from achse.ethercat.application import Application
from achse.ethercat.frame import Datagram, EthercatFrame
from achse.ethercat.master import (
    BusConfiguration,
    BusError,
    BusJob,
    ClockConfiguration,
    Master,
    from_description,
)
from achse.ethercat.master.foe_client import FoeClient
from achse.ethercat.master.scanning import scan_bus
from achse.ethercat.master.soe_client import SoeClient
from achse.ethercat.master.voe_client import VendorMessage
from tests.ethercat.master.messaging import Messenger

CYCLE_NS = 1_000_000
MOST_JOBS = 8
PATIENCE = 60_000
HEAD = b"\xff" * 6 + b"\x02\x00\x00\x00\x00\x00" + b"\x88\xa4"
LONGEST = 1500
AMS_PACKET = bytes(16) + b"\x02\0\x04\0\x0c\0\0\0" + bytes(20)
"""A Read of anything."""


class Attack:
    """A bus whose answers pass somebody who changes, doubles, invents and drops frames."""

    def __init__(self, seed: int) -> None:
        self.dice = Random(seed)
        line: list[Application] = [Loopback(serial_number=1), Drive(), Messenger(serial_number=3)]
        self.segment = Segment(map(Slave, line))
        clock = ClockConfiguration()
        self.master = Master(
            BusConfiguration(
                tuple(from_description(describe(each), clock=clock) for each in line),
                cycle_ns=CYCLE_NS,
                settle_ns=20_000_000,
            )
        )
        self.master.request(AlState.OP)
        self.hostile = 0
        self.jobs: list[BusJob[object]] = []
        self._seen = [HEAD]

    def cycle(self, attacks: int) -> None:
        """One cycle with so many hostile frames."""
        master, dice = self.master, self.dice
        now = master.now_ns + CYCLE_NS
        self.segment.advance(now)
        frames = master.transmit(now, 2)
        while frames:
            for frame in frames:
                reply = self.segment.process(frame)
                if reply is None:
                    continue
                if attacks and dice.random() < 0.5:
                    attacks -= 1
                    self._give(self._changed(reply), now)
                if not attacks or dice.random() < 0.8:
                    master.receive(reply, now)
                self._seen[dice.randrange(len(self._seen))] = reply
                if len(self._seen) < 50:
                    self._seen.append(reply)
            frames = master.poll(now, 2) if attacks and dice.random() < 0.8 else []
        for _ in range(attacks):
            self._give(self._invented(), now)

    def _give(self, frame: bytes, now: int) -> None:
        self.hostile += 1
        self.master.receive(frame, now)

    def _changed(self, reply: bytes) -> bytes:
        """An answer with other data; headers mostly stay, so that it is taken."""
        dice, frame = self.dice, bytearray(reply)
        if dice.random() < 0.2:
            return bytes(frame[: dice.randrange(len(frame) + 1)])
        for _ in range(dice.choice((1, 1, 2, 8, 64))):
            first = 26 if dice.random() < 0.9 else 0
            at = dice.randrange(min(first, len(frame) - 1), len(frame))
            frame[at] = dice.choice((0, 0xFF, 0x80, 1, dice.randrange(256)))
        return bytes(frame)

    def _invented(self) -> bytes:
        """A frame of nobody's: old ones, any bytes, datagrams of any kind."""
        dice = self.dice
        kind = dice.randrange(5)
        if kind == 0:
            return self._changed(dice.choice(self._seen))
        if kind == 1:
            return dice.randbytes(dice.randrange(80))
        if kind == 2:
            return HEAD + dice.randbytes(dice.randrange(LONGEST))
        if kind == 3:
            size = dice.randrange(200)
            header = (size | dice.choice((1, 1, 4, 5)) << 12).to_bytes(2, "little")
            return HEAD + header + dice.randbytes(size)
        datagrams = [
            Datagram(
                dice.randrange(16),
                dice.randrange(1 << 32),
                dice.randbytes(dice.choice((0, 1, 2, 8, 16, 64))),
                dice.randrange(256),
                dice.choice((0, 1, 3, 0xFFFF)),
            )
            for _ in range(dice.randrange(1, 6))
        ]
        return EthercatFrame(datagrams).encode()

    def ask(self) -> None:
        """Let requests of all kinds be under way."""
        self.jobs = [each for each in self.jobs if not each.is_done]
        if len(self.jobs) >= MOST_JOBS:
            return
        master, dice = self.master, self.dice
        slave = dice.choice(master.slaves)
        assert slave.sdo is not None
        assert slave.mailbox is not None
        assert slave.aoe is not None
        assert slave.eoe is not None
        assert slave.voe is not None
        sdo, mailbox, aoe, eoe, voe = slave.sdo, slave.mailbox, slave.aoe, slave.eoe, slave.voe
        mailbox.split_writes = dice.random() < 0.5
        answer = 50_000_000
        steps = dice.choice(
            (
                lambda: sdo.upload(0x1018, 0, complete=True, response_ns=answer),
                lambda: sdo.upload(0x2000, 0, response_ns=answer),
                lambda: sdo.download(0x2000, 0, bytes(700), response_ns=answer),
                lambda: sdo.object_list(),
                lambda: sdo.object_information(0x1018),
                lambda: sdo.entry_information(0x1018, 1),
                lambda: slave.eeprom.image(),
                lambda: FoeClient(mailbox).read("file", response_ns=answer),
                lambda: FoeClient(mailbox).write("file", bytes(900), response_ns=answer),
                lambda: SoeClient(mailbox).read(32, response_ns=answer),
                lambda: aoe.request(AMS_PACKET, response_ns=answer),
                lambda: eoe.send(bytes(1000)),
                lambda: eoe.get_ip(response_ns=answer),
                lambda: voe.request(VendorMessage(1, 2, b"any"), response_ns=answer),
            )
        )
        self.jobs.append(master.run(steps()))

    def quiet(self) -> None:
        """Nobody attacks any more: the bus comes to Op by itself, and answers."""
        master = self.master
        master.request(AlState.OP)
        for _ in range(PATIENCE):
            self.cycle(0)
            if master.operational and not master.traffic.waiting - 1:
                return
        pytest.fail(
            f"not back: {[each.state for each in master.slaves]} {master.take_events()[-5:]}"
        )


@pytest.mark.parametrize("seed", range(4))
def test_hostile_frames_never_escape_the_master(seed: int, many: Callable[[int], int]) -> None:
    attack = Attack(seed)
    wanted = many(many(2_500))
    while attack.hostile < wanted:
        attack.cycle(attack.dice.randrange(8))
        attack.ask()
    for job in attack.jobs:
        job.cancel()
    assert len(attack.master.traffic._away) <= attack.master.traffic.window
    assert attack.master.traffic.waiting < 20
    attack.quiet()
    slave = attack.master.slaves[1]
    transfer = attack.master.upload(slave, 0x1018, 1)
    while not transfer.is_done:
        attack.cycle(0)
    assert transfer.result() == VENDOR.to_bytes(4, "little")


def test_a_scan_under_attack_ends(many: Callable[[int], int]) -> None:
    """It gives what it read, or says why it could not."""
    for seed in range(many(5)):
        attack = Attack(seed)
        job = attack.master.run(scan_bus())
        for _ in range(PATIENCE):
            if job.is_done:
                break
            attack.cycle(2)
        else:
            pytest.fail("the scan goes on for ever")
        if not isinstance(job.error, BusError):
            assert job.result()
