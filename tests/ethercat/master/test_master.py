"""The master as a whole: equal runs, objects by SDO, hostile and disturbed buses."""

import hashlib
import random
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.codes import AlState, SdoAbort
from achse.drive import Drive
from achse.ethercat import EthercatFrame, Segment, Slave, describe
from achse.ethercat.master import (
    BusConfiguration,
    BusError,
    ClockConfiguration,
    Master,
    Ring,
    SdoRefusal,
    from_description,
)
from achse.ethercat.master.errors import NoMailbox, SlaveNotReady

CSP_OUT = [(0x6040, 0, 16), (0x607A, 0, 32), (0x6060, 0, 8)]
CSP_IN = [(0x6041, 0, 16), (0x6064, 0, 32), (0x6061, 0, 8)]


def drives(count: int, rounds: int = 4) -> tuple[Master, Ring, list[Drive]]:
    line = [Drive() for _ in range(count)]
    slaves = tuple(
        from_description(
            describe(each), f"Drive {number}", clock=ClockConfiguration()
        ).with_entries(CSP_OUT, CSP_IN)
        for number, each in enumerate(line, 1)
    )
    master = Master(BusConfiguration(slaves, cycle_ns=1_000_000))
    return master, Ring(master, Segment(Slave(each) for each in line), rounds=rounds), line


def digest_of_a_run() -> str:
    """Drives brought up, enabled and moved; every frame and input goes into the digest."""
    master, ring, _ = drives(4)
    digest = hashlib.sha256()
    transmit = master.transmit

    def watched(now_ns: int, acyclic: int = 1) -> list[bytes]:
        frames = transmit(now_ns, acyclic)
        for frame in frames:
            digest.update(frame)
        return frames

    master.transmit = watched  # type: ignore[method-assign]
    master.request(AlState.OP)
    for cycle in range(1, 700):
        ring.exchange(cycle * 1_000_000)
        for slave in master.slaves:
            if not slave.operational:
                continue
            status = slave.read_input(0x6041) & 0x6F
            slave.write_output(0x6060, 0, 8)
            control = {0x40: 6, 0x60: 6, 0x21: 7, 0x23: 15, 0x27: 15}.get(status, 6)
            slave.write_output(0x6040, 0, control)
            position = slave.read_input(0x6064, signed=True)
            slave.write_output(0x607A, 0, position + 20 if status == 0x27 else position)
            digest.update(bytes(slave.inputs))
    assert all(slave.read_input(0x6041) & 0x6F == 0x27 for slave in master.slaves)
    assert all(slave.read_input(0x6064, signed=True) > 100 for slave in master.slaves)
    return digest.hexdigest()


def test_two_runs_are_equal_to_the_last_byte() -> None:
    assert digest_of_a_run() == digest_of_a_run()


def test_all_objects_of_a_drive_are_read_by_sdo() -> None:
    """What the dictionary holds is what comes over the wire, for each of its entries."""
    master, ring, (drive,) = drives(1, rounds=20)
    master.request(AlState.PREOP)
    ring.run(100_000_000)
    entries = [(each.index, entry.subindex) for each in drive.objects() for entry in each.entries]
    assert len(entries) >= 203
    for index, subindex in entries:
        job = master.upload(master.slaves[0], index, subindex)
        while not job.is_done:
            ring.exchange(master.now_ns + 1_000_000)
        try:
            expected: bytes | int = drive.read_object(index, subindex)
        except SdoAbort as abort:
            expected = abort.code.number
        came = job.error.number if isinstance(job.error, SdoRefusal) else job.result()
        assert came == expected, f"{index:04X}:{subindex:02X}"


def test_requests_that_cannot_be_served_say_why(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.INIT)
    (slave,) = ours.master.slaves
    job = ours.master.upload(slave, 0x1000)
    ours.run(2)
    with pytest.raises(SlaveNotReady, match="needs PreOp"):
        job.result()
    slave.sdo = None
    job = ours.master.download(slave, 0x1000, 0, b"")
    ours.run(2)
    with pytest.raises(NoMailbox):
        job.result()


def test_states_by_station(bus: Callable[..., Any]) -> None:
    ours = bus(3).up(AlState.SAFEOP)
    assert ours.master.state == AlState.SAFEOP
    second = ours.master.slave(1002)
    ours.master.request(AlState.OP, second)
    ours.until(lambda: second.state == AlState.OP)
    assert ours.master.state == AlState.SAFEOP
    assert ours.master.slave(7) is None


class Wire:
    """A wire that loses, doubles, delays and turns frames round."""

    def __init__(self, seed: int, harm: float) -> None:
        self.dice = random.Random(seed)
        self.harm = harm
        self.waiting: list[bytes] = []

    def carry(self, reply: bytes | None) -> list[bytes]:
        """The frames that arrive now."""
        if reply is not None:
            self.waiting.append(reply)
            if self.dice.random() < self.harm:
                self.waiting.append(reply)
        if self.dice.random() < self.harm:
            self.dice.shuffle(self.waiting)
        if self.dice.random() < self.harm:
            return []
        arrived, self.waiting = self.waiting, []
        return [each for each in arrived if self.dice.random() >= self.harm]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=10)
@given(seed=st.integers(0, 2**32), harm=st.floats(0, 0.5), count=st.integers(1, 6))
def test_a_wire_that_does_harm_ends_in_documented_states(
    bus: Callable[..., Any], seed: int, harm: float, count: int
) -> None:
    """Each slave is in a state of the table or absent; when the wire is well, all come to Op."""
    ours = bus(count)
    wire = Wire(seed, harm)
    process = ours.segment.process
    master = ours.master
    master.request(AlState.OP)
    for cycle in range(1, 400):
        now = cycle * 1_000_000
        ours.segment.advance(now)
        for frame in (*master.transmit(now), *master.poll(now)):
            for arrived in wire.carry(process(frame)):
                master.receive(arrived, now)
        assert all(each.state in (0, *AlState) for each in master.slaves)
    for slave in master.slaves:
        master.request(AlState.OP, slave)
    ours.until(lambda: master.operational, 4000)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=15)
@given(seed=st.integers(0, 2**32), harm=st.floats(0, 1))
def test_hostile_frames_never_escape_the_master(
    bus: Callable[..., Any], seed: int, harm: float
) -> None:
    """Answers whose bytes are changed at random, and frames made up, from the first cycle on."""
    ours = bus(2)
    dice = random.Random(seed)
    master = ours.master
    master.request(AlState.OP)
    for cycle in range(1, 250):
        now = cycle * 1_000_000
        ours.segment.advance(now)
        for frame in (*master.transmit(now), *master.poll(now)):
            reply = bytearray(ours.segment.process(frame) or b"")
            for _ in range(dice.randint(0, 4) if dice.random() < harm else 0):
                at = dice.randrange(len(reply))
                # mostly behind the headers, where the answers are
                reply[at] = dice.randrange(256)
            master.receive(bytes(reply), now)
            if dice.random() < harm:
                decoded = EthercatFrame.decode(frame)
                for each in decoded.datagrams:
                    each.data = dice.randbytes(len(each.data))
                    each.counter = dice.randint(0, 3)
                master.receive(decoded.encode(), now)
                master.receive(dice.randbytes(dice.randrange(100)), now)
        if cycle % 10 == 0:
            master.upload(master.slaves[0], dice.randrange(0x10000))
    for slave in ours.segment.slaves:
        slave.reset()
    for each in master.slaves:
        master.request(AlState.OP, each)
    ours.until(lambda: master.operational, 8000)


def test_errors_are_of_one_tree() -> None:
    assert issubclass(SdoRefusal, BusError)
