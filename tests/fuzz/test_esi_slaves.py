"""Hostile masters, and hostile ESI files, for slaves made from ESI files."""

import re
from collections.abc import Callable
from contextlib import suppress
from random import Random

import pytest

from achse.codes import AlState
from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Segment
from achse.ethercat.master import BusConfiguration, BusError, Master, Ring
from achse.ethercat.master.esi_reader import EsiDevice, EsiError, from_esi, read_esi
from achse.ethercat.master.scanning import scan_bus
from achse.ethercat.virtual import make_slave
from tests.ethercat.virtual import esi_text
from tests.fuzz.bus_attacks import FIRST_STATION, MAILBOX_IN, MAILBOX_OUT, SPEAKER, Attacker

CYCLE_NS = 1_000_000
FRAMES, MESSAGES, FILES = 800, 1_500, 60
PATIENCE = 20_000
LINE = (esi_text.COUPLER, SPEAKER, esi_text.DIGITAL_IN, esi_text.DIGITAL_OUT, SPEAKER)
SPEAKERS = (FIRST_STATION + 1, FIRST_STATION + 4)


class Line:
    """The slaves, and good masters that come and find them."""

    def __init__(self) -> None:
        devices = [read_esi(esi_text.esi(each))[0] for each in LINE]
        self.segment = Segment([make_slave(each) for each in devices])
        self.configuration = BusConfiguration(
            tuple(from_esi(each, f"Box {n}", cycle_ns=CYCLE_NS) for n, each in enumerate(devices)),
            cycle_ns=CYCLE_NS,
        )

    def pass_time(self, ns: int) -> None:
        self.segment.advance(self.segment.time.now_ns + ns)

    def bring_to(self, state: AlState, *, power: bool = True) -> None:
        """A good master brings all slaves to a state, after power was off unless told otherwise."""
        for slave in self.segment.slaves if power else ():
            slave.reset()
        master = Master(self.configuration)
        master.request(state)
        ring = Ring(master, self.segment)
        for _ in range(PATIENCE):
            ring.exchange(self.segment.time.now_ns + CYCLE_NS)
            if all(each.state == state for each in master.slaves):
                return
        pytest.fail(str([each.last_trouble for each in master.slaves]))

    def send(self, command: DatagramCommand, station: int, place: int, data: bytes) -> None:
        self.segment.process(EthercatFrame([Datagram.at(command, station, place, data)]).encode())


def test_nothing_escapes_and_a_good_master_gets_its_slaves_back(
    many: Callable[[int], int],
) -> None:
    line = Line()
    line.bring_to(AlState.OP)
    attacker = Attacker(1, len(LINE))
    for number, packet in enumerate(attacker.frames(many(FRAMES), lasting=False)):
        reply = line.segment.process(packet)
        assert reply is None or len(reply) == len(packet)
        line.pass_time((0, 100_000, 20_000_000)[number % 3])
        if number % 400 == 399:
            line.bring_to(AlState.OP, power=False)
    for number, packet in enumerate(attacker.frames(many(FRAMES))):
        reply = line.segment.process(packet)
        assert reply is None or len(reply) == len(packet)
        line.pass_time((0, 100_000, 20_000_000)[number % 3])


def test_mailboxes_bear_any_message(many: Callable[[int], int]) -> None:
    line = Line()
    line.bring_to(AlState.PREOP)
    attacker = Attacker(2, len(LINE))
    dice = Random(3)
    for _ in range(many(MESSAGES)):
        station = dice.choice(SPEAKERS)
        line.send(DatagramCommand.FPWR, station, MAILBOX_OUT, attacker.message())
        line.pass_time(100_000)
        for _ in range(dice.randrange(4)):
            line.send(DatagramCommand.FPRD, station, MAILBOX_IN, bytes(128))
    for slave in line.segment.slaves:
        assert len(slave._mailbox._waiting) < 80
    line.bring_to(AlState.OP)


def test_a_written_eeprom_is_reported_by_a_scan(many: Callable[[int], int]) -> None:
    dice = Random(4)
    for _ in range(many(2)):
        line = Line()
        for slave in line.segment.slaves:
            image = slave.esc.eeprom.image
            for _ in range(40):
                image[dice.randrange(len(image))] = dice.randrange(256)
            slave.reset()
        master = Master(line.configuration)
        ring = Ring(master, line.segment)
        job = master.run(scan_bus())
        for _ in range(PATIENCE):
            if job.is_done:
                break
            ring.exchange(line.segment.time.now_ns + CYCLE_NS)
        with suppress(BusError):
            assert len(job.result()) == len(LINE)


NUMBERS = re.compile(r'(?<=[">])[^<>"]{1,40}(?=[<"])')
ELEMENTS = re.compile(r"<[A-Za-z]+[^<>]*/>|<([A-Za-z]+)[^<>]*>[^<>]*</\1>")
HOSTILE = ("-1", "0", "1", "255", "256", "65535", "65536", "4294967296", "9" * 20, "9" * 5000, "#x",
           "#xFFFF", "#x-1", "#x0F00", "#xFFFE", "1e9", "NaN", "٣", "", "zz", "Outputs", "Inputs",
           "MBoxOut", "MBoxIn", "true")  # fmt: skip


def changed(text: str, dice: Random) -> str:
    """A file with other numbers, and with elements that are missing or there hundreds of times."""
    for _ in range(dice.randrange(1, 5)):
        if dice.randrange(5) < 3:
            match, parts = dice.choice(list(NUMBERS.finditer(text))), dice.choice(HOSTILE)
        else:
            match = dice.choice(list(ELEMENTS.finditer(text)))
            parts = match.group() * dice.choice((0, 2, 3, 40, 300))
        text = text[: match.start()] + parts + text[match.end() :]
    return text


def test_hostile_files_are_refused_or_make_slaves_that_bear_a_master(
    many: Callable[[int], int],
) -> None:
    dice = Random(5)
    texts = [esi_text.esi(each) for each in (*LINE, esi_text.ANALOG)]
    for _ in range(many(FILES)):
        devices: list[EsiDevice] = []
        with suppress(EsiError):
            devices = read_esi(changed(dice.choice(texts), dice))
        for device in devices[:1]:
            with suppress(EsiError):
                segment = Segment([make_slave(device)])
                configuration = from_esi(device, cycle_ns=CYCLE_NS)
                master = None
                with suppress(ValueError):  # more process data than a frame has
                    master = Master(BusConfiguration((configuration,), cycle_ns=CYCLE_NS))
                if master is None:
                    continue
                master.request(AlState.OP)
                ring = Ring(master, segment)
                for cycle in range(1, 60):
                    ring.exchange(cycle * CYCLE_NS)
