"""Supervision: slaves that leave their state, get lost, come back, are others than configured."""

from collections.abc import Callable
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.codes import AlState, AlStatus
from achse.ethercat import Disturbance, Loopback, Slave
from achse.ethercat.master import ClockConfiguration
from achse.ethercat.registers import Register


def test_a_fault_in_op_is_reported_acknowledged_and_op_is_back(bus: Callable[..., Any]) -> None:
    ours = bus(2).up()
    ours.master.take_events()
    ours.line[1].fault = AlStatus.SYNCHRONIZATION
    slave = ours.master.slaves[1]
    ours.until(lambda: not slave.operational)
    ours.until(lambda: ours.master.operational)
    events = ours.master.take_events()
    left = next(each for each in events if each.kind.name in ("STATE_LEFT", "AL_ERROR"))
    assert (left.station, left.number) == (1002, AlStatus.SYNCHRONIZATION.number)
    assert slave.abnormal_changes == 1
    assert ours.master.slaves[0].abnormal_changes == 0


def test_a_broken_link_loses_the_slaves_behind_and_they_come_back(bus: Callable[..., Any]) -> None:
    ours = bus(4).up()
    ours.master.take_events()
    ours.segment.break_link(ours.segment.slaves[2])
    ours.until(lambda: not ours.master.slaves[3].present)
    assert [each.present for each in ours.master.slaves] == [True, True, False, False]
    assert ours.kinds().count("SLAVE_LOST") == 2
    assert ours.master.slaves[0].state == AlState.OP
    ours.segment.repair_link(ours.segment.slaves[2])
    ours.until(lambda: ours.master.operational)
    assert ours.kinds().count("SLAVE_BACK") == 2
    assert [each.losses for each in ours.master.slaves] == [0, 0, 1, 1]


def test_a_slave_that_was_switched_off_gets_its_address_again(bus: Callable[..., Any]) -> None:
    ours = bus(3).up()
    changes = ours.master.supervision.changes
    ours.segment.slaves[1].reset()
    ours.run(3)
    ours.until(lambda: ours.master.operational)
    station = Register.STATION_ADDRESS
    assert ours.segment.slaves[1].esc.read(station, 2) == (1002).to_bytes(2, "little")
    assert ours.master.supervision.changes == changes + 2


def test_the_whole_bus_gone_and_back(bus: Callable[..., Any]) -> None:
    ours = bus(2).up()
    ours.master.take_events()
    ours.segment.break_link(ours.segment.slaves[0])
    ours.until(lambda: not ours.master.supervision.link)
    assert ours.master.state == 0
    ours.run(300)
    ours.segment.repair_link(ours.segment.slaves[0])
    ours.until(lambda: ours.master.operational)
    kinds = ours.kinds()
    assert kinds.index("LINK_LOST") < kinds.index("LINK_BACK")


def test_a_bus_that_is_not_there_yet_is_waited_for(bus: Callable[..., Any]) -> None:
    ours = bus(2)
    ours.segment.break_link(ours.segment.slaves[0])
    ours.master.request(AlState.OP)
    ours.run(500)
    assert ours.master.state == 0
    ours.segment.repair_link(ours.segment.slaves[0])
    ours.until(lambda: ours.master.operational)


def test_another_slave_is_left_in_init(bus: Callable[..., Any]) -> None:
    ours = bus(2)
    ours.segment.attach(Slave(Loopback(name="a third")))
    wrong = Loopback()
    object.__setattr__(wrong.identity, "product_code", 99)
    ours.segment.attach(Slave(wrong))
    ours.master.request(AlState.OP)
    ours.run(300)
    assert ours.master.operational
    assert ours.segment.slaves[2].state is AlState.INIT
    assert [each[1] for each in ours.master.supervision.strangers] == [0x100B, 99]
    assert ours.kinds().count("WRONG_SLAVE") == 2


def test_error_counters_are_taken_over_and_cleared(bus: Callable[..., Any]) -> None:
    ours = bus(2).up()
    ours.segment.process(b"\xff" * 12 + b"\x88\xa4\xff\x1f")  # announces more than there is
    ours.segment.break_link(ours.segment.slaves[1])
    ours.run(200)
    ours.segment.repair_link(ours.segment.slaves[1])
    ours.until(lambda: ours.master.operational)
    ours.run(2500)
    first, second = (each.counters for each in ours.master.slaves)
    assert (sum(first.lost_links), sum(second.lost_links)) == (1, 1)
    assert ours.segment.slaves[0].esc.read(Register.LOST_LINKS, 4) == bytes(4)


def test_emergencies_come_in_preop_too(bus: Callable[..., Any]) -> None:
    """There the mailbox state is not in the cyclic frames."""
    ours = bus().up(AlState.PREOP)
    ours.line[0].emergencies.append(b"\x10\x43\x01abcde")
    ours.run(300)
    assert [each.number for each in ours.master.take_events() if each.kind.name == "EMERGENCY"] == [
        0x4310
    ]


def test_lost_frames_for_a_while_end_in_op(bus: Callable[..., Any]) -> None:
    ours = bus(2).up()
    ours.segment.disturbance = Disturbance(lose=400)
    ours.until(lambda: not ours.master.supervision.link)
    ours.until(lambda: ours.master.operational)
    assert ours.master.slaves[0].al_code == 0


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=8)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["break", "repair", "reset", "fault", "hang", "wake"]),
            st.integers(0, 3),
            st.integers(1, 400),
        ),
        max_size=8,
    )
)
def test_whatever_happens_the_bus_comes_back(
    bus: Callable[..., Any], happenings: list[tuple[str, int, int]]
) -> None:
    ours = bus(4).up()
    for what, which, cycles in happenings:
        slave = ours.segment.slaves[which]
        match what:
            case "break":
                ours.segment.break_link(slave)
            case "repair":
                ours.segment.repair_link(slave)
            case "reset":
                slave.reset()
            case "fault":
                ours.line[which].fault = AlStatus.NO_VALID_DATA
            case "hang":
                slave.hang()
            case _:
                slave.hang(False)
        ours.run(cycles)
    for slave in ours.segment.slaves:
        slave.hang(False)
        ours.segment.repair_link(slave)
    ours.master.request(AlState.OP)
    ours.until(lambda: ours.master.operational, 20_000)


def test_a_slave_that_loses_synchronisation_again_and_again_is_left_where_it_is(
    bus: Callable[..., Any],
) -> None:
    ours = bus(2, {"clock": ClockConfiguration()}).up()
    slave, ours.segment.slaves[1].esc.clock.drift_ppb = ours.master.slaves[1], 1_400_000
    ours.kinds()
    ours.until(lambda: "lost 3 times" in slave.last_trouble, 20_000)
    assert (slave.state, slave.error) == (AlState.SAFEOP, True)
    assert AlStatus.of(slave.al_code) is AlStatus.SYNCHRONIZATION
    kinds = ours.kinds()
    assert (kinds.count("STATE_LEFT"), kinds.count("STATE_FAILED")) == (3, 1)
    ours.run(2_000)
    assert not {"STATE_LEFT", "STATE"} & {*ours.kinds()}, "nobody tries any more"
    assert ours.master.slaves[0].operational
    ours.segment.slaves[1].esc.clock.drift_ppb = 0
    ours.run(50)
    assert slave.state == AlState.SAFEOP
    ours.master.request(AlState.OP, slave)
    ours.until(lambda: slave.operational, 5_000)
    ours.run(200)
    assert abs(slave.clock_difference_ns) < 10_000
    assert slave.last_trouble == ""
