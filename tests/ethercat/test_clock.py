"""Distributed clocks: receive times, the time loop, SYNC0, latches."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import Datagram, DatagramCommand, Loopback, Segment, Slave
from achse.ethercat.registers import RESOURCES, ControllerResources
from tests.ethercat.conftest import Master

STATION = 0x1001


def receive_times(master: Any, station: int) -> list[int]:
    data = master.read(0x0900, 16, station)
    return [int.from_bytes(data[4 * port : 4 * port + 4], "little") for port in range(4)]


def configure(master: Any, count: int) -> None:
    """Offsets and delays as masters compute them from the receive times, for a line."""
    master.one(DatagramCommand.BWR, 0, 0x0900, bytes(4))
    times = [receive_times(master, STATION + n) for n in range(count)]
    round_trips = [each[1] - each[0] for each in times[:-1]] + [0]
    delay = 0
    for n in range(count):
        station = STATION + n
        if n:
            delay += (round_trips[n - 1] - round_trips[n]) // 2
        local = master.number(0x0918, 8, station)
        offset = (10**18 - local + delay) % 2**64
        master.write(0x0920, offset.to_bytes(8, "little"), station)
        master.write(0x0928, delay.to_bytes(4, "little"), station)


def system_times(master: Any, count: int) -> list[int]:
    return [master.number(0x0910, 8, STATION + n) for n in range(count)]


def cycle(master: Any) -> None:
    """A millisecond passes, then the reference time goes to all."""
    master.advance(1)
    master.send(Datagram.at(DatagramCommand.FRMW, STATION, 0x0910, bytes(8)))


def differences(master: Any, count: int) -> list[int]:
    raw = [master.number(0x092C, 4, STATION + n) for n in range(count)]
    return [-(each & 0x7FFF_FFFF) if each >> 31 else each for each in raw]


def test_receive_times_grow_along_the_frames_path(line: Callable[..., Any]) -> None:
    master = line(3)
    master.address()
    master.advance(5)
    master.one(DatagramCommand.BWR, 0, 0x0900, bytes(4))
    first, second, third = (receive_times(master, STATION + n) for n in range(3))
    assert first[0] < second[0] < third[0] < second[1] < first[1]
    assert third[1] == 0  # nothing behind the last
    assert master.number(0x0918, 8) == first[0]


def test_delays_computed_by_the_master_make_the_times_equal(line: Callable[..., Any]) -> None:
    master = line(4)
    master.address()
    for n, slave in enumerate(master.segment.slaves):
        slave.esc.clock.offset_ns = 12_345_678 * n
    configure(master, 4)
    for _ in range(3):
        cycle(master)
    assert differences(master, 4) == [0, 0, 0, 0]
    times = system_times(master, 4)
    path = [slave.esc.clock.arrival_ns for slave in master.segment.slaves]
    assert [time - times[0] for time in times] == [delay - path[0] for delay in path]


@pytest.mark.parametrize("drift_ppb", [50_000, -50_000])
def test_the_time_loop_follows_a_drifting_slave(line: Callable[..., Any], drift_ppb: int) -> None:
    master = line(2)
    master.address()
    configure(master, 2)
    master.segment.slaves[1].esc.clock.drift_ppb = drift_ppb
    for _ in range(500):
        cycle(master)
    assert abs(differences(master, 2)[1]) <= 64
    for _ in range(500):
        master.advance(1)  # without comparison it runs away, 50 ns each millisecond
    master.send(Datagram.at(DatagramCommand.FRMW, STATION, 0x0910, bytes(8)))
    away = differences(master, 2)[1]
    assert 0.9 * 500 * 50 < away * drift_ppb / 50_000 < 1.1 * 500 * 50


def test_the_loop_forgets_when_the_speed_counter_is_written(master: Any) -> None:
    master.write(0x0910, (10**6).to_bytes(8, "little"))
    assert master.number(0x092C, 4) != 0
    master.write(0x0930, b"\x00\x10")
    assert master.number(0x092C, 4) == 0


def arm(master: Any, cycle_ns: int, start: int) -> None:
    master.write(0x0990, start.to_bytes(8, "little"))
    master.write(0x09A0, cycle_ns.to_bytes(4, "little"))
    master.write(0x0981, b"\x03")


def test_sync0_begins_at_its_start_time_and_keeps_its_cycle(master: Any) -> None:
    application = master.line[0]
    master.write(0x0920, (10**18).to_bytes(8, "little"))
    now = master.number(0x0910, 8)
    start = now + 100_100_000
    arm(master, 1_000_000, start)
    assert master.number(0x0990, 8) == start
    master.advance(100.05)
    by_timer = application.cycles
    assert by_timer > 0
    master.advance(0.1)
    assert application.cycles == by_timer + 1
    assert master.number(0x0990, 8) == start + 1_000_000
    elapsed = application.elapsed_ns
    master.advance(10)
    assert application.elapsed_ns - elapsed == 10_000_000
    assert application.cycles == by_timer + 11


def test_a_start_time_in_the_past_never_fires(master: Any) -> None:
    master.advance(10)
    arm(master, 1_000_000, 1_000_000)
    assert master.number(0x0990, 8) == 1_000_000
    assert master.segment.slaves[0].esc.clock.sync0_due_ns is None


def test_when_sync0_is_switched_off_the_timer_goes_on(master: Any) -> None:
    application = master.line[0]
    arm(master, 2_000_000, 2_000_000)
    master.advance(10)
    master.write(0x0981, b"\x00")
    cycles = application.cycles
    master.advance(0.25)
    assert application.cycles == cycles + 1


def test_the_application_learns_its_cycle_when_it_enters_a_state(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(AlState.PREOP)
    arm(master, 4_000_000, 10**9)
    master.process_data()
    master.request(4)
    assert master.line[0].sync0_ns == 4_000_000


def test_a_drifting_slave_has_its_own_milliseconds(master: Any) -> None:
    master.segment.slaves[0].esc.clock.drift_ppb = 1_000_000  # 0.1 % fast
    arm(master, 1_000_000, 1_000_000)
    master.advance(2000)
    application = master.line[0]
    events = 1 + (2000 * 1_000_000 * 1001 // 1000 - 1_000_000) // 1_000_000
    assert application.cycles == pytest.approx(events, abs=4)  # and a few by timer before


def test_jitter_moves_receive_times_only(master: Any) -> None:
    clock = master.segment.slaves[0].esc.clock
    clock.jitter_ns = 50
    master.advance(1)
    seen = set()
    for _ in range(20):
        master.one(DatagramCommand.BWR, 0, 0x0900, bytes(4))
        seen.add(master.number(0x0900, 4) - 1_000_000 - clock.arrival_ns)
    assert len(seen) > 3
    assert max(map(abs, seen)) <= 50


@pytest.mark.parametrize("unit", [0, 1])
@pytest.mark.parametrize("rising", [True, False])
def test_a_latch_keeps_the_system_time_of_an_edge(master: Any, unit: int, rising: bool) -> None:
    esc = master.segment.slaves[0].esc
    bit = 1 if rising else 2
    address = 0x09B0 + 16 * unit + (0 if rising else 8)
    master.write(0x09A8 + unit, bytes((bit,)))  # single shot
    master.advance(3)
    esc.latch(unit, rising)
    master.advance(3)
    esc.latch(unit, rising)
    assert master.number(0x09AE + unit, 1) == bit
    assert master.number(0x0210, 2) & 1
    assert master.number(address, 8) == 3_000_000
    assert master.number(0x09AE + unit, 1) == 0  # released by reading
    assert not master.number(0x0210, 2) & 1
    esc.latch(unit, rising)
    assert master.number(address, 8) == 6_000_000


def test_continuous_latching_takes_each_edge(master: Any) -> None:
    esc = master.segment.slaves[0].esc
    for milliseconds in (1, 2):
        master.advance(1)
        esc.latch(0, rising=True)
        assert int.from_bytes(esc.memory[0x09B0:0x09B8], "little") == milliseconds * 1_000_000


def test_events_faster_than_the_local_cycle_are_missed(master: Any) -> None:
    arm(master, 7, 1_000_000)
    master.advance(1)
    cycles = master.line[0].cycles
    master.advance(1000)
    assert master.line[0].cycles - cycles == pytest.approx(4000, abs=2)


@pytest.mark.parametrize(
    ("delay_us", "expected_us"),
    [
        (0, [1000, 2000, 3000, 4000]),  # together with SYNC0
        (400, [1400, 2400, 3400, 4400]),  # behind each SYNC0
        (1000, [2000, 4000, 6000]),  # every second SYNC0
        (2500, [3500, 6500]),
    ],
)
def test_sync1_follows_sync0(master: Any, delay_us: int, expected_us: list[int]) -> None:
    master.write(0x0990, (1_000_000).to_bytes(8, "little"))
    master.write(0x09A0, (1_000_000).to_bytes(4, "little"))
    master.write(0x09A4, (1000 * delay_us).to_bytes(4, "little"))
    master.write(0x0981, b"\x07")
    seen = [master.number(0x0998, 8) // 1000]
    for _ in range(60):
        master.advance(0.1)
        if (event := master.number(0x0998, 8) // 1000) != seen[-1]:
            seen.append(event)
    assert seen[: len(expected_us)] == expected_us


def test_without_its_bit_there_is_no_sync1(master: Any) -> None:
    master.write(0x0990, (1_000_000).to_bytes(8, "little"))
    master.write(0x09A0, (1_000_000).to_bytes(4, "little"))
    master.write(0x0981, b"\x03")
    master.advance(5)
    assert master.number(0x0998, 8) == 0


@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(by_ns=st.integers(-900_000, 900_000), cycle_us=st.sampled_from((500, 1000, 2000)))
def test_a_clock_that_jumps_far_is_astray_until_it_is_back(
    line: Callable[..., Any], by_ns: int, cycle_us: int
) -> None:
    master = line(2)
    master.address()
    configure(master, 2)
    clock = master.segment.slaves[1].esc.clock
    start = master.number(0x0910, 8, STATION + 1) + 5_000_000
    master.write(0x0990, start.to_bytes(8, "little"), STATION + 1)
    master.write(0x09A0, (1000 * cycle_us).to_bytes(4, "little"), STATION + 1)
    master.write(0x0981, b"\x03", STATION + 1)
    for _ in range(20):
        cycle(master)
    assert clock.steady
    clock.jump(by_ns)
    assert not clock.steady, "a frame has to see it"
    now = clock.time.now_ns
    assert clock.sync0_due_ns is not None
    assert now <= clock.sync0_due_ns <= now + 1000 * cycle_us + abs(by_ns)
    cycle(master)
    assert clock.astray == (abs(by_ns) > 250 * cycle_us)
    for _ in range(1200):
        cycle(master)
    assert not clock.astray
    assert clock.steady or abs(differences(master, 2)[1]) < 100


DEEDS = st.tuples(
    st.sampled_from(
        ["cycle"] * 6 + ["jump", "offset", "drift", "delay", "time", "restart", "wait"]
    ),
    st.integers(0, 2),
    st.integers(-(10**6), 10**6),
)


def do(master: Any, deed: str, number: int, value: int) -> None:
    """Something that moves clock `number`, or a cycle."""
    clock = master.segment.slaves[number].esc.clock
    station = STATION + number
    match deed:
        case "cycle":
            cycle(master)
        case "jump":
            clock.jump(value)
        case "offset":
            clock.offset_ns = value
        case "drift":
            clock.drift_ppb = value // 1000
        case "delay":
            master.write(0x0928, abs(value).to_bytes(4, "little"), station)
        case "time":
            master.write(0x0910, abs(value).to_bytes(8, "little"), station)
        case "restart":
            master.write(0x0930, b"\0\x10", station)
        case "wait":
            master.advance(abs(value) // 10**5)


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(deeds=st.lists(DEEDS, max_size=30))
def test_clocks_in_step_are_not_compared_and_are_as_if_they_were(
    line: Callable[..., Any], deeds: list[tuple[str, int, int]]
) -> None:
    masters = [line(3), line(3)]
    for master in masters:
        master.address()
        configure(master, 3)
        for station in range(STATION, STATION + 3):
            master.write(0x0990, (10**18 + 10**9).to_bytes(8, "little"), station)
            master.write(0x09A0, (10**6).to_bytes(4, "little"), station)
            master.write(0x0981, b"\x03", station)
    for deed, number, value in [("cycle", 0, 0)] * 3 + deeds + [("cycle", 0, 0)] * 2:
        masters[1].segment._in_step = None  # compares always
        for master in masters:
            do(master, deed, number, value)
        first, second = ([each.esc.clock for each in m.segment.slaves] for m in masters)
        for one, other in zip(first, second, strict=True):
            assert one._difference == other._difference
            assert (one.sync0_due_ns, one.steady) == (other.sync0_due_ns, other.steady)
    assert differences(masters[0], 3) == differences(masters[1], 3)


def test_slave_without_clock_has_registers_of_zero() -> None:
    without = ControllerResources(features=RESOURCES.features & ~(1 << 2))
    segment = Segment([Slave(Loopback()), Slave(Loopback(), resources=without)])
    master = Master(segment)
    master.address()
    master.advance(7)
    reply = master.one(DatagramCommand.FRMW, STATION, 0x0910, bytes(8))
    assert (reply.counter, master.number(0x0910, 8, STATION)) == (2, 7_000_300)
    assert master.number(0x092C, 4, STATION + 1) == 0
    assert master.number(0x0910, 8, STATION + 1) == 0
    reply = master.one(DatagramCommand.FRMW, STATION + 1, 0x0910, b"\xff" * 8)
    assert (reply.counter, reply.data) == (2, bytes(8))
