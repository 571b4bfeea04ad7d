"""Time stamps agree with the wall clock: after a slow start, after dropped backlogs, everywhere."""

import struct
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import Command, DeviceError, Frame
from achse.ams.commands import AddNotificationRequest
from achse.ams.filetime import from_unix_ns
from achse.ams.notification import NotificationStream
from achse.station import Station
from achse.station.clocks.clock import StationClock
from achse.station.clocks.cycle import Cycle
from achse.station.clocks.pacing import REBASE_NS, Pace
from achse.station.configuration.station_file import parse
from achse.station.station import DEFAULT_EPOCH_NS

MS = 1_000_000
SECOND = 1_000_000_000
BEGIN = 1_900_000_000 * SECOND
"""Time of day at monotonic time 0."""


class Computer:
    """Its monotonic time, and its time of day, which may be set."""

    def __init__(self) -> None:
        self.now = 0
        self.offset = BEGIN

    def time_of_day(self) -> int:
        return self.now + self.offset


class Paced:
    """A cycle that follows the clocks of a computer; its stamps, and when each cycle was due."""

    def __init__(self, tick_ns: int, speed: float = 1.0, loading_ns: int = 0) -> None:
        self.computer = Computer()
        self.cycle = Cycle(tick_ns)
        self.clock = StationClock(self.cycle, BEGIN, self.computer.time_of_day)
        self.computer.now += loading_ns
        self.pace = Pace(tick_ns, speed, self.computer.now, self.clock)
        self.stamps: list[tuple[int, int]] = []

    def run(self, computing_ns: int = 0, shift_ns: int = 0, count: int = 1 << 30) -> int:
        """Run what is due, each cycle taking so long; how many cycles were run."""
        done, due = 0, self.pace.due
        while done < count and self.pace.take(self.computer.now):
            self.cycle.step()
            self.stamps.append((due, self.clock()))
            self.pace.shift(shift_ns)
            self.computer.now += computing_ns
            done, due = done + 1, self.pace.due
        return done


def test_virtual_time_goes_on_evenly_from_the_epoch() -> None:
    cycle = Cycle(2 * MS)
    clock = StationClock(cycle, 5, lambda: pytest.fail("virtual time has no wall clock"))
    cycle.go_to(8 * MS)
    assert (clock(), clock.time_ns, clock.epoch_at(3 * MS)) == (8 * MS + 5, 8 * MS, 5)


def test_first_stamp_is_the_due_moment_however_long_loading_took() -> None:
    paced = Paced(2 * MS, loading_ns=17 * SECOND)
    paced.computer.now += 2 * MS
    paced.run()
    assert paced.stamps == [(17 * SECOND + 2 * MS, BEGIN + 17 * SECOND + 2 * MS)]


def test_stamp_of_a_late_cycle_is_its_due_moment() -> None:
    paced = Paced(2 * MS)
    paced.computer.now += 900 * MS
    assert paced.run() == 450
    assert paced.stamps[0] == (2 * MS, BEGIN + 2 * MS)
    assert paced.clock.lag_ns == 0


def test_dropped_backlog_aligns_stamps_with_the_wall_clock() -> None:
    paced = Paced(2 * MS)
    paced.computer.now += 268 * SECOND
    assert paced.run() == 0
    assert paced.clock.lag_ns == 0
    paced.computer.now += 2 * MS
    paced.run()
    assert paced.stamps == [(268 * SECOND + 2 * MS, BEGIN + 268 * SECOND + 2 * MS)]
    assert paced.clock.time_ns == 2 * MS
    assert paced.pace.dropped_ns == 268 * SECOND - 2 * MS


@pytest.mark.parametrize("speed", [0.5, 2.0, 100.0])
def test_stamps_at_other_speeds_are_those_of_virtual_time(speed: float) -> None:
    paced = Paced(2 * MS, speed, loading_ns=SECOND)
    paced.computer.now += 5 * SECOND
    paced.run()
    paced.computer.now += SECOND
    paced.run(shift_ns=7)
    assert paced.clock() == BEGIN + paced.clock.time_ns


EVENTS = st.lists(
    st.tuples(
        st.integers(0, 3 * SECOND),  # the computer is busy
        st.integers(0, 3 * MS),  # computing time of a cycle
        st.integers(-2 * MS, 2 * MS),  # the reference clock of a bus moves the pace
        st.sampled_from((0, 0, 0, -3600 * SECOND, -5 * MS, 5 * MS, 3600 * SECOND)),  # NTP
    ),
    min_size=1,
    max_size=12,
)


@settings(deadline=None, max_examples=60)
@given(
    tick_ns=st.sampled_from((10_000, 250_000, MS, 2 * MS, 10 * MS)),
    loading_ns=st.integers(0, 20 * SECOND),
    events=EVENTS,
)
def test_stamps_increase_and_are_due_moments_whatever_happens(
    tick_ns: int, loading_ns: int, events: list[tuple[int, int, int, int]]
) -> None:
    paced = Paced(tick_ns, loading_ns=loading_ns)
    computer, pace, clock = paced.computer, paced.pace, paced.clock
    offset = BEGIN
    for busy_ns, computing_ns, shift_ns, step_ns in events:
        computer.offset += step_ns
        for wait_ns in (busy_ns, tick_ns, tick_ns):
            computer.now += wait_ns
            first, rebases = len(paced.stamps), pace.rebases
            paced.run(computing_ns, shift_ns, count=20)
            for due, stamp in paced.stamps[first:]:
                assert abs(stamp - due - offset) <= 1  # due moments are whole ns
            if pace.rebases > rebases:
                assert clock.lag_ns <= 0  # below 0: set back, and stamps do not go back
                offset = clock() + tick_ns - pace.due
    for (_, before), (_, after) in pairwise(paced.stamps):
        assert after - before >= tick_ns // 2


def test_wall_clock_set_back_shows_as_negative_lag() -> None:
    paced = Paced(2 * MS)
    paced.computer.offset -= 60 * SECOND
    paced.computer.now += 2 * MS
    paced.run()
    assert (paced.clock(), paced.clock.lag_ns) == (BEGIN + 2 * MS, -60 * SECOND)
    paced.computer.now += 2 * SECOND
    paced.run()  # drops the backlog
    assert paced.clock.lag_ns == -58 * SECOND


def test_history_keeps_the_epoch_of_earlier_times() -> None:
    paced = Paced(2 * MS)
    epochs = {}
    for number in range(1, 1200):
        paced.computer.now += 2 * MS
        paced.run()
        epochs[number * 2 * MS] = paced.clock.epoch_ns
        paced.computer.now += REBASE_NS + 3 * MS
        paced.run()
    known = {time_ns for time_ns in epochs if time_ns > 500 * MS}
    assert {time_ns: paced.clock.epoch_at(time_ns) for time_ns in known} == {
        time_ns: epochs[time_ns] for time_ns in known
    }
    assert paced.clock.epoch_at(0) == paced.clock.epoch_at(MS)


# a whole station ---------------------------------------------------------------------------------

SOURCE = """
PROGRAM MAIN
VAR now : ULINT; task, dc : ULINT; n : UDINT; END_VAR
now := F_GetSystemTime(); task := F_GetTaskTime(); dc := F_GetCurDcTaskTime64();
n := n + 1;
END_PROGRAM
"""
SYSTEM_SERVICE, PLC = 10_000, 851


class Live:
    """A station whose pace and time of day belong to the test; a client of its."""

    def __init__(self, folder: Path) -> None:
        (folder / "a.st").write_text(SOURCE)
        plc = {"sources": "a.st", "code": "plain"}
        self.station = station = Station(parse({"plc": [plc]}, "a.toml"), base=folder)
        self.computer = Computer()
        station.clock.time_of_day = self.computer.time_of_day
        self.frames: list[Frame] = []
        self.me = station.router.register(0, self)
        self.start(0)

    def start(self, loading_ns: int) -> None:
        """Let the pace begin after so much time."""
        self.computer.now += loading_ns
        station = self.station
        self.pace = station._operation.pace = Pace(
            station.tick_ns, 1.0, self.computer.now, station.clock
        )

    def deliver(self, frame: Frame) -> bool:
        if frame.command == Command.NOTIFICATION:
            self.frames.append(frame)
        return True

    def device(self, port: int) -> Any:
        [device] = [
            each
            for each in self.station.devices
            if port in [address.port for address in each.addresses]
        ]
        return device

    def subscribe(self, port: int, group: int, offset: int, size: int, mode: int) -> None:
        data = AddNotificationRequest(group, offset, size, mode, 0, 100_000).encode()
        device = self.device(port)
        device.deliver(Frame(device.address, self.me, Command.ADD_NOTIFICATION, data=data))

    @property
    def samples(self) -> list[tuple[int, bytes]]:
        """FILETIME and data of all samples so far."""
        return [
            (stamp.filetime, sample.data)
            for frame in self.frames
            for stamp in NotificationStream.decode(frame.data).stamps
            for sample in stamp.samples
        ]

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            self.computer.now = max(self.computer.now, self.pace.due)
            assert self.pace.take(self.computer.now)
            self.station.step()

    def drop(self, busy_ns: int) -> None:
        self.computer.now += busy_ns
        assert not self.pace.take(self.computer.now)


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Live:
    live = Live(tmp_path_factory.mktemp("station"))
    now = live.device(PLC).symbols.source.resolve("MAIN.now")
    live.subscribe(PLC, now.index_group, now.index_offset, now.size, 3)
    return live


@settings(deadline=None, max_examples=10)
@given(
    loading_ns=st.integers(0, 20 * SECOND),
    busy_ns=st.integers(REBASE_NS + 11 * MS, 300 * SECOND),
    before=st.integers(1, 9),
    after=st.integers(1, 9),
)
def test_all_stamps_of_a_station_are_those_of_its_clock(
    live: Live, loading_ns: int, busy_ns: int, before: int, after: int
) -> None:
    station = live.station
    live.start(loading_ns)
    live.frames.clear()
    begin_ns, time_ns = live.computer.time_of_day(), station.time_ns
    with station.scope(["MAIN.n"], length=1.0) as scope:
        live.run(before)
        stopped = scope.data()
        live.drop(busy_ns)
        live.run(after)
        going_on = scope.data()
        scope.stop()
        live.drop(busy_ns)
        live.run(1)
        assert scope.data().end_ns == going_on.end_ns
    dropped = [
        begin_ns + 10 * MS * count + (busy_ns if count > before else 0)
        for count in range(1, before + after + 1)
    ]
    stamps = live.samples[-before - after - 1 : -1]
    assert [filetime for filetime, _ in stamps] == [from_unix_ns(each) for each in dropped]
    assert [int.from_bytes(data, "little") for _, data in stamps] == [each for each, _ in stamps]
    main = station.plcs[PLC].instance("MAIN")
    since_2000 = from_unix_ns(946_684_800 * SECOND)
    assert main["now"] == main["task"] == main["dc"] // 100 + since_2000
    assert stopped.end_ns == dropped[before - 1]
    assert going_on.end_ns == dropped[-1]
    assert station.time_ns == time_ns + 10 * MS * (before + after + 1)


def test_time_service_and_lag_go_by_the_same_clock(tmp_path: Path) -> None:
    live = Live(tmp_path)
    live.start(3 * SECOND)
    live.run(2)
    live.drop(100 * SECOND)
    live.run(1)
    stamp = live.computer.time_of_day()
    assert live.station.clock() == stamp
    year, month, _, day, hour, minute, second, millisecond = struct.unpack(
        "<8H", live.device(SYSTEM_SERVICE).read(400, 1, 16)
    )
    there = datetime(year, month, day, hour, minute, second, millisecond * 1000, UTC)
    assert round(there.timestamp() * 1000) == stamp // MS
    assert live.station.statistics()["stamp_lag"] == 0.0
    live.computer.now += 4 * MS
    assert live.station.statistics()["stamp_lag"] == 0.004


def test_restart_reads_the_time_of_day(tmp_path: Path) -> None:
    live = Live(tmp_path)
    live.run(2)
    live.computer.offset += 60 * SECOND
    live.run(1)
    assert live.station.clock.lag_ns == 60 * SECOND
    live.station.restart()
    live.run(300)
    assert live.station.state.name == "RUN"
    assert live.station.clock.lag_ns == 0


def test_virtual_time_has_the_same_stamps_each_run(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text("PROGRAM MAIN VAR t : LTIME; END_VAR t := LTIME(); END_PROGRAM")
    config = parse({"plc": [{"sources": "a.st", "code": "plain"}]}, "a.toml")
    stations = [Station(config, base=tmp_path) for _ in range(2)]
    for station in stations:
        station.advance(1.0)
        assert station.clock() == DEFAULT_EPOCH_NS + SECOND
        assert station.statistics()["stamp_lag"] == 0.0
    assert stations[0].digest() == stations[1].digest()


def test_value_handle_from_before_a_restart_reaches_no_other_symbol(tmp_path: Path) -> None:
    """Both runs request their first handle; the second one begins a second later."""

    def first_handle(live: Live, name: bytes) -> int:
        return int.from_bytes(live.device(PLC).read_write(0xF003, 0, 4, name), "little")

    run = Live(tmp_path)
    old = first_handle(run, b"MAIN.n")
    again = Live(tmp_path)
    again.station.clock.shift(SECOND)
    new = first_handle(again, b"MAIN.n")
    assert again.device(PLC).read(0xF005, new, 4) == bytes(4)
    with pytest.raises(DeviceError, match="0x710"):
        again.device(PLC).read(0xF005, old, 4)
