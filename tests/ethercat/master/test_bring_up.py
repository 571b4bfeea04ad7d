"""The way up: what strict slaves ask for, what is refused, what is tried again."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from achse.codes import AlState, AlStatus
from achse.drive import Drive
from achse.ethercat import Loopback, Segment, Slave, describe
from achse.ethercat.configuration_checks import ConfigurationChecks
from achse.ethercat.master import (
    BusConfiguration,
    ClockConfiguration,
    InitCommand,
    Master,
    Ring,
    from_description,
)

CSP_OUT = [(0x6040, 0, 16), (0x607A, 0, 32), (0x6060, 0, 8)]
CSP_IN = [(0x6041, 0, 16), (0x6064, 0, 32), (0x6061, 0, 8)]


@pytest.mark.parametrize("clock", [None, ClockConfiguration()])
def test_a_strict_drive_takes_our_mapping(clock: ClockConfiguration | None) -> None:
    drive = Drive()
    slave = from_description(describe(drive), clock=clock).with_entries(CSP_OUT, CSP_IN)
    master = Master(BusConfiguration((slave,), cycle_ns=1_000_000))
    ring = Ring(master, Segment([Slave(drive)]))
    master.request(AlState.OP)
    ring.run(400_000_000)
    assert master.operational, master.take_events()
    assert [each.key >> 8 for each in drive.mapping.rx_data.rows] == [0x6040, 0x607A, 0x6060]
    assert (
        drive.record.sync0_ns == (1_000_000 if clock else 0)
        if hasattr(drive.record, "sync0_ns")
        else True
    )


def test_a_coupler_has_neither_mailbox_nor_process_data(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ConfigurationChecks, "mailbox", lambda _: AlStatus.NO_ERROR)
    line = [Loopback(0, "coupler"), Loopback(4)]
    coupler, box = (from_description(describe(each)) for each in line)
    coupler = replace(coupler, mailbox_out=None, mailbox_in=None, coe=False, sync_managers=())
    master = Master(BusConfiguration((coupler, box), cycle_ns=1_000_000))
    ring = Ring(master, Segment(map(Slave, line)))
    master.request(AlState.OP)
    ring.run(400_000_000)
    assert master.operational, master.take_events()


def test_start_commands_are_sent_before_the_mapping(bus: Callable[..., Any]) -> None:
    ours = bus(1, {}).up(AlState.INIT)
    drive = Drive()
    slave = from_description(describe(drive))
    commands = (InitCommand(0x6060, 0, b"\x08"), InitCommand(0x607A, 0, b"\0\0\0\0"))
    master = Master(BusConfiguration((replace_commands(slave, commands),)))
    ring = Ring(master, Segment([Slave(drive)]))
    master.request(AlState.SAFEOP)
    ring.run(400_000_000)
    assert master.slaves[0].state == AlState.SAFEOP
    assert drive.get(0x6060) == 8
    assert ours.master.state == AlState.INIT


@pytest.mark.parametrize("transition", ["IP", "PS", "SO", "OS", "SP"])
def test_start_commands_of_each_change_of_state(transition: str) -> None:
    drive = Drive()
    command = InitCommand(0x6081, 0, (4711).to_bytes(4, "little"), transition)
    slave = replace_commands(from_description(describe(drive)), (command,))
    master = Master(BusConfiguration((slave,), cycle_ns=1_000_000))
    ring = Ring(master, Segment([Slave(drive)]))
    written = []
    for state in (AlState.PREOP, AlState.SAFEOP, AlState.OP, AlState.SAFEOP, AlState.PREOP):
        master.request(state)
        ring.run(master.now_ns + 400_000_000)
        assert master.slaves[0].state == state
        written.append(drive.get(0x6081) == 4711)
    order = ("IP", "PS", "SO", "OS", "SP")
    assert written.index(True) == order.index(transition)


def replace_commands(slave: Any, commands: tuple[InitCommand, ...]) -> Any:
    from dataclasses import replace

    return replace(slave, commands=commands)


def test_a_refused_start_command_holds_the_slave(bus: Callable[..., Any]) -> None:
    ours = bus(2, {"clock": None})
    wrong = replace_commands(
        ours.master.bus.slaves[0], (InitCommand(0x5FFF, 0, b"\0", comment="not there"),)
    )
    master = Master(BusConfiguration((wrong, ours.master.bus.slaves[1]), cycle_ns=1_000_000))
    ring = Ring(master, ours.segment)
    master.request(AlState.OP)
    ring.run(500_000_000)
    first, second = master.slaves
    assert (first.state, first.failed_command) == (AlState.PREOP, True)
    assert "5FFF" in first.last_trouble
    assert second.state == AlState.OP
    assert "STATE_FAILED" in [each.kind.name for each in master.take_events()]


@pytest.mark.parametrize("times", [1, 2])
def test_a_refusal_is_acknowledged_and_tried_again(bus: Callable[..., Any], times: int) -> None:
    ours = bus(2)
    ours.line[0].refuse = AlStatus.NO_INPUTS if times == 1 else AlStatus.OUTPUT_CONFIGURATION
    ours.up()
    assert ours.master.slaves[0].last_trouble == ""


def test_after_three_tries_it_gives_up_until_requested_again(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    box = ours.line[0]
    enter = box.enter
    box.enter = lambda state, sync0, cause: (
        AlStatus.NO_MEMORY if state is AlState.SAFEOP else enter(state, sync0, cause)
    )
    ours.master.request(AlState.OP)
    ours.run(1000)
    (slave,) = ours.master.slaves
    assert (slave.state, slave.al_code) == (AlState.PREOP, AlStatus.NO_MEMORY.number)
    assert ours.kinds().count("STATE_FAILED") == 1
    box.enter = enter
    ours.run(500)
    assert slave.state == AlState.PREOP
    ours.up()


def test_a_hopeless_code_is_not_tried_again(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    ours.line[0].refuse = AlStatus.INPUT_MAPPING
    ours.master.request(AlState.OP)
    ours.run(300)
    assert ours.master.slaves[0].state == AlState.PREOP
    assert "0x0024" in ours.master.slaves[0].last_trouble


def test_down_and_up_again(bus: Callable[..., Any]) -> None:
    ours = bus(2).up()
    for state in (AlState.SAFEOP, AlState.OP, AlState.PREOP, AlState.OP, AlState.INIT, AlState.OP):
        ours.up(state)
        assert [slave.state for slave in ours.segment.slaves] == [state] * 2
    assert ours.master.slaves[0].abnormal_changes == 0
