"""Mailbox: one conversation at a time, lost messages repeated, time-outs."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import AlState
from achse.ethercat import Disturbance
from achse.ethercat.mailbox import MailboxError, MailboxProtocol
from achse.ethercat.master.errors import (
    FrameLost,
    MailboxRefusal,
    MailboxTimeout,
    NoAnswer,
    WrongAnswer,
)
from achse.ethercat.master.steps import Round, Trip


def test_an_unknown_protocol_is_refused_by_the_slave(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    mailbox = ours.master.slaves[0].mailbox
    with pytest.raises(MailboxRefusal) as refusal:
        ours.do(mailbox.converse(MailboxProtocol.FOE, b"file", lambda data: True))
    assert refusal.value.number == MailboxError.UNSUPPORTED_PROTOCOL


def test_a_slave_that_does_not_answer_is_not_waited_for(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    slave = ours.master.slaves[0]
    ours.segment.slaves[0].mailbox_delay_ns = 1 << 60
    with pytest.raises(MailboxTimeout, match="no answer within 30 ms"):
        ours.do(slave.sdo.upload(0x1000, response_ns=30_000_000))
    with pytest.raises(MailboxTimeout, match="stays full for 100 ms"):
        ours.do(slave.sdo.upload(0x1000))
    assert slave.mailbox.idle


def test_many_requests_to_one_slave_queue(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    slave = ours.master.slaves[0]
    jobs = [ours.master.upload(slave, 0x1000) for _ in range(20)]
    ours.until(lambda: all(job.is_done for job in jobs))
    assert {job.result() for job in jobs} == {(0xC0DE_0001).to_bytes(4, "little")}


def test_a_message_longer_than_the_mailbox_is_refused(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    mailbox = ours.master.slaves[0].mailbox
    with pytest.raises(WrongAnswer, match="250 bytes at most"):
        ours.do(mailbox.converse(MailboxProtocol.COE, bytes(251), lambda data: True))


@pytest.mark.parametrize("size", [1, 7, 230, 243, 244, 245, 500, 1200])
def test_split_messages_carry_the_same(bus: Callable[..., Any], size: int) -> None:
    """Of any length, those that fill the mailbox to its last byte too."""
    data = bytes(range(256)) * 5
    passed = []
    for split in (False, True):
        ours = bus(1, {}).up(AlState.PREOP)
        slave = ours.master.slaves[0]
        slave.mailbox.split_writes = split
        ours.segment.counters.frames = 0
        ours.do(slave.sdo.download(0x2000, 0, data[:size]))
        assert ours.line[0].text == data[:size]
        assert ours.do(slave.sdo.upload(0x2000)) == data[:size]
        assert ours.do(slave.sdo.object_list(1))[0] == 0x1000
        passed.append(ours.segment.slaves[0].esc.read(0x0805, 1))
    assert passed[0] == passed[1]


def test_split_writes_are_set_by_the_configuration(bus: Callable[..., Any]) -> None:
    from dataclasses import replace

    from achse.ethercat.master import BusConfiguration, Master, Ring

    ours = bus(2)
    slaves = tuple(replace(each, split_mailbox_writes=True) for each in ours.master.bus.slaves)
    ours.master = Master(BusConfiguration(slaves, cycle_ns=1_000_000))
    ours.ring = Ring(ours.master, ours.segment)
    ours.up()
    ours.line[1].emergencies.append(b"\x20\x43\x01abcde")
    ours.run(20)
    assert ours.kinds().count("EMERGENCY") == 1
    assert ours.master.slaves[1].mailbox.split_writes


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize("lose", [1, 2])
@pytest.mark.parametrize("after", range(12))
def test_a_lost_frame_at_any_moment_costs_no_answer(
    bus: Callable[..., Any], after: int, lose: int, split: bool
) -> None:
    """The message is asked for again by the repeat bit, or sent again with the same counter."""
    ours = bus().up(AlState.PREOP)
    ours.master.slaves[0].mailbox.split_writes = split
    ours.segment.disturbance = Disturbance()
    slave = ours.master.slaves[0]
    ours.line[0].text = bytes(range(256)) * 3
    job = ours.master.upload(slave, 0x2000)
    ours.ring.rounds = 1
    ours.run(after)
    ours.segment.disturbance.lose = 2 * lose  # the cyclic frames too
    ours.until(lambda: job.is_done)
    assert job.result() == bytes(range(256)) * 3


def test_emergencies_are_reported_and_answers_still_come(bus: Callable[..., Any]) -> None:
    ours = bus(2).up()
    ours.master.take_events()
    ours.line[1].emergencies += [b"\x20\x43\x01abcde", b"\x00\x00\x00fghij"]
    job = ours.master.upload(ours.master.slaves[1], 0x1000)
    ours.until(lambda: job.is_done)
    reports = [(each.station, each.number, each.data) for each in ours.master.take_events()]
    assert reports == [(1002, 0x4320, b"\x20\x43\x01abcde"), (1002, 0, b"\x00\x00\x00fghij")]


def test_a_slave_without_mailbox_state_does_not_act(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.INIT)
    with pytest.raises((NoAnswer, FrameLost, MailboxTimeout)):
        ours.do(ours.master.slaves[0].sdo.upload(0x1000))


def test_a_mailbox_is_looked_at_once_more_when_the_time_is_over(bus: Callable[..., Any]) -> None:
    """This process was away for seconds: the slave has answered meanwhile."""
    mailbox = bus().up(AlState.PREOP).master.slaves[0].mailbox
    looks: list[int] = []

    def play() -> None:
        steps = mailbox.receive(MailboxProtocol.COE, lambda data: True, 1_000_000)
        wanted, time = next(steps), 0
        while True:
            while isinstance(wanted, Trip):
                looks.append(time)
                time += 3_000_000_000
                (status,) = wanted.datagrams
                status.counter = 1  # the mailbox is empty
                wanted = steps.send(Round((status,), time))
            time += wanted.ns
            wanted = steps.send(Round((), time))

    with pytest.raises(MailboxTimeout):
        play()
    assert len(looks) == 2
