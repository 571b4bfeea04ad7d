"""The station in virtual time, through its front door: frames to the router, frames back."""

import math
import struct
from itertools import pairwise
from math import sqrt
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from achse.motion import commands
from achse.station import Station
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.station_file import parse
from achse.station.station import DEFAULT_EPOCH_NS
from achse.swarm.disk import MemoryDisk
from achse.transport.tcp.listener import TcpListener

CYCLE = 0.002
ACCELERATION, JERK = 1500.0, 2250.0
TIGHT = 1 + 1e-6
FILETIME_1970 = 116_444_736_000_000_000


class Sample(NamedTuple):
    """The documented beginning of the online structure, TwinCAT 3."""

    error: int
    actual_position: float
    actual_modulo: float
    position: float
    modulo: float
    actual_velocity: float
    velocity: float
    override: int
    lag: float
    lag_minimum: float
    lag_maximum: float
    controller_output: float
    total_output: float
    state: int
    control: int
    coupling: int
    loop: int
    actual_acceleration: float
    acceleration: float
    jerk: float


ONLINE = struct.Struct("<i4x6dI4x5d4I3d112x")


class Bench:
    """The demo station, a client of port 501, and a sample of one axis each cycle."""

    def __init__(self, client_of: Any, axis: int = 1) -> None:
        self.station = Station.demo()
        self.nc = client_of(self.station.router, 501)
        self.axis = axis
        self.nc.put(0x4300 + axis, 0x01, "<I", 7)
        self.override(1_000_000)
        self.station.advance(0.1)
        self.nc.subscribe(0x4100 + axis, 0, ONLINE.size, cycle_s=CYCLE)
        self.nc.samples()

    def override(self, value: int) -> None:
        self.nc.put(0x4300 + self.axis, 0x21, "<I", value)

    def start(self, kind: int, position: float, velocity: float) -> None:
        self.nc.put(0x4200 + self.axis, 0x20, "<I4xdd", kind, position, velocity)

    def universal_start(self, kind: int, position: float, velocity: float) -> None:
        request = struct.pack("<IIdddddI4xddd", kind, 0, position, velocity, 0, 0, 0, 0, 0, 0, 0)
        self.nc.exchange(0x4200 + self.axis, 0x16, 4, request)

    def stop(self) -> None:
        self.nc.write(0x4200 + self.axis, 0x02)

    def run(self, seconds: float) -> list[Sample]:
        """One sample per cycle."""
        self.station.advance(seconds)
        return [Sample(*ONLINE.unpack(data)) for _, data in self.nc.samples()]


@pytest.fixture
def bench(client_of: Any) -> Bench:
    return Bench(client_of)


@pytest.fixture
def make_bench(client_of: Any) -> Any:
    return lambda axis=1: Bench(client_of, axis)


def respect(samples: list[Sample], velocity: float) -> None:
    """No value and no difference of neighbours is beyond the limits."""
    for sample in samples:
        assert abs(sample.velocity) <= velocity * TIGHT
        assert abs(sample.acceleration) <= ACCELERATION * TIGHT
        assert abs(sample.jerk) <= JERK * TIGHT
    for one, two in pairwise(samples):
        # rounding: positions of 100 mm are exact to 1.4e-14
        assert abs(two.position - one.position) <= velocity * CYCLE * TIGHT + 1e-12
        assert abs(two.velocity - one.velocity) <= ACCELERATION * CYCLE * TIGHT + 1e-9
        assert abs(two.acceleration - one.acceleration) <= JERK * CYCLE * TIGHT + 1e-9


def test_a_move_of_100_mm_at_200_mm_s(bench: Bench) -> None:
    way, velocity = 100.0, 200.0
    # jerk alone on both ramps, and no part at constant velocity: each half is v·√(v/j)
    ramp = sqrt(velocity / JERK)
    assert 2 * velocity * ramp > way
    reached = (way / 2 * sqrt(JERK)) ** (2 / 3)
    bench.start(1, way, velocity)
    samples = bench.run(3.0)
    assert len(samples) == 1500
    respect(samples, velocity)
    assert max(sample.velocity for sample in samples) == pytest.approx(reached, rel=1e-3)
    moving = sum(sample.velocity != 0.0 for sample in samples)
    assert moving * CYCLE == pytest.approx(4 * sqrt(reached / JERK), abs=2 * CYCLE)
    last = samples[-1]
    assert last.position == way
    assert last.actual_position == pytest.approx(way, abs=0.01)
    assert (last.error, last.velocity, last.acceleration, last.jerk) == (0, 0.0, 0.0, 0.0)
    assert last.state & 1 << 4  # in target position


def test_a_long_move_keeps_its_limits_and_its_velocity(bench: Bench) -> None:
    bench.start(1, 2000.0, 1200.0)
    out = bench.run(5.0)
    respect(out, 1200.0)
    assert max(sample.velocity for sample in out) == pytest.approx(1200.0)
    assert max(sample.acceleration for sample in out) == pytest.approx(ACCELERATION)
    assert min(sample.acceleration for sample in out) == pytest.approx(-ACCELERATION)
    assert out[-1].actual_position == pytest.approx(2000.0, abs=0.01)
    bench.start(2, -2000.0, 1200.0)
    back = bench.run(5.0)
    respect(back, 1200.0)
    assert back[-1].position == pytest.approx(0.0, abs=1e-9)


def test_half_override_halves_the_velocity_without_a_jump(bench: Bench) -> None:
    bench.start(3, 0.0, 200.0)
    before = bench.run(2.0)
    assert before[-1].velocity == pytest.approx(200.0)
    bench.override(500_000)
    after = bench.run(2.0)
    assert after[-1].velocity == pytest.approx(100.0)
    assert after[-1].override == 500_000
    respect([*before[-1:], *after], 200.0)
    assert all(one.velocity >= two.velocity for one, two in pairwise(after))


def test_stop_comes_to_rest_with_the_configured_deceleration(bench: Bench) -> None:
    bench.start(3, 0.0, 1500.0)
    running = bench.run(3.0)
    assert running[-1].velocity == pytest.approx(1500.0)
    bench.stop()
    stopping = bench.run(3.0)
    respect([*running[-1:], *stopping], 1500.0)
    assert min(sample.acceleration for sample in stopping) == pytest.approx(-ACCELERATION)
    moving = [sample for sample in stopping if sample.velocity != 0.0]
    time = 1500.0 / ACCELERATION + ACCELERATION / JERK
    assert len(moving) * CYCLE == pytest.approx(time, abs=2 * CYCLE)
    way = stopping[-1].position - running[-1].position
    assert way == pytest.approx(1500.0 * time / 2, rel=1e-9)
    assert stopping[-1].state & 1 << 7  # has been stopped
    assert stopping[-1].actual_position == pytest.approx(stopping[-1].position, abs=0.01)


@pytest.mark.parametrize(
    ("kind", "target", "end"),
    [
        (261, 350.0, -10.0),  # shortest way
        (261, 100.0, 100.0),
        (517, 350.0, 350.0),  # positive direction
        (773, 350.0, -10.0),  # negative direction
        (773, 100.0, -260.0),
    ],
)
def test_the_modulo_axis_goes_the_way_requested(
    make_bench: Any, kind: int, target: float, end: float
) -> None:
    bench = make_bench(axis=3)
    bench.universal_start(kind, target, 720.0)
    samples = bench.run(3.0)
    last = samples[-1]
    assert last.position == pytest.approx(end)
    assert last.modulo == pytest.approx(target)
    assert last.actual_modulo == pytest.approx(target, abs=0.01)
    assert all(sample.velocity * end >= 0.0 for sample in samples)


def test_the_plc_and_the_axes_live_in_one_time(bench: Bench, client_of: Any) -> None:
    plc = client_of(bench.station.router, 851)
    handle = int.from_bytes(plc.exchange(0xF003, 0, 4, b"MAIN.nCounter\0"), "little")
    before = plc.get(0xF005, handle, "<I")
    cycles = bench.nc.get(0x4101, 0x09, "<I")
    bench.run(0.5)
    assert plc.get(0xF005, handle, "<I") == before + 50
    assert bench.nc.get(0x4101, 0x09, "<I") == cycles + 250


def test_samples_carry_station_time(bench: Bench) -> None:
    bench.station.advance(0.1)
    stamps = [stamp for stamp, _ in bench.nc.samples()]
    assert len(stamps) == 50
    unix_ns = (stamps[-1] - FILETIME_1970) * 100
    assert unix_ns == DEFAULT_EPOCH_NS + bench.station.time_ns
    assert {two - one for one, two in pairwise(stamps)} == {20_000}


# time --------------------------------------------------------------------------------------------


def test_time_that_is_no_whole_tick_is_kept() -> None:
    station = Station.demo()
    assert station.tick_ns == 2_000_000
    for _ in range(1000):
        station.advance(0.0005)
    assert station.time_ns == 500_000_000
    station.advance(0.001)
    assert station.time_ns == 500_000_000
    station.advance(0.001)
    assert station.time_ns == 502_000_000


@pytest.mark.parametrize("seconds", [-0.1, math.nan, math.inf])
def test_time_goes_forward_and_ends(seconds: float) -> None:
    station = Station.demo()
    with pytest.raises(ValueError, match="time goes forward"):
        station.advance(seconds)
    assert station.time_ns == 0


def test_the_epoch_is_where_the_clock_begins() -> None:
    station = Station.demo(epoch_ns=5)
    station.advance(0.01)
    assert station.clock() == 10_000_005


def test_the_net_id_can_be_given() -> None:
    assert str(Station.demo(net_id="5.1.2.3.1.1").router.net_id) == "5.1.2.3.1.1"


# state -------------------------------------------------------------------------------------------


def test_equal_histories_have_equal_digests(make_bench: Any) -> None:
    def history(bench: Bench) -> list[str]:
        digests = [bench.station.digest()]
        for position in (100.0, 30.0):
            bench.start(1, position, 200.0)
            bench.run(1.5)
            digests.append(bench.station.digest())
        return digests

    one, two = history(make_bench()), history(make_bench())
    assert one == two
    assert len(set(one)) == 3


def test_any_difference_shows_in_the_digest(client_of: Any) -> None:
    def after(group: int, offset: int, form: str, value: float) -> str:
        station = Station.demo()
        client_of(station.router, 501).put(group, offset, form, value)
        station.advance(0.1)
        return station.digest()

    untouched = Station.demo()
    untouched.advance(0.1)
    later = Station.demo()
    later.advance(0.102)
    variable = Station.demo()
    plc = client_of(variable.router, 851)
    handle = int.from_bytes(plc.exchange(0xF003, 0, 4, b"GVL.nSint\0"), "little")
    plc.put(0xF005, handle, "<b", 9)
    variable.advance(0.1)
    digests = [
        untouched.digest(),
        later.digest(),
        variable.digest(),
        after(0x4002, 0x10, "<d", 4.0),
        after(0x4003, 0x10, "<d", 4.0),
        after(0x4003, 0x10, "<d", math.nextafter(4.0, 5.0)),
    ]
    assert len(set(digests)) == len(digests)


def test_looking_changes_nothing(bench: Bench) -> None:
    before = bench.station.digest()
    bench.nc.read(0x4101, 0, 256)
    bench.nc.read(0x4301, 0x80, 128)
    assert bench.station.digest() == before


@pytest.mark.parametrize("code", ["plain", "machine"])
def test_time_in_one_go_is_time_tick_by_tick(client_of: Any, code: str) -> None:
    """What nobody is due for is passed over, and nobody sees a difference."""
    histories = []
    for leaps in (False, True):
        station = Station(
            parse(
                {
                    "nc": {"code": code},
                    "axis": [{"id": 1, "name": "A"}, {"id": 2, "name": "B"}],
                },
                "",
            )
        )
        nc = client_of(station.router, 501)
        system = client_of(station.router, 10_000)
        calls: list[int] = []
        mine = CyclicPhase(PhasePlace.INPUTS, "mine", 14_000_000, calls.append)
        station.cycle.add(mine)
        history: list[Any] = []

        def pass_time(ticks: int, station: Station = station, leaps: bool = leaps) -> None:
            if leaps:
                station.advance(ticks * station.tick_ns * 1e-9)
            else:
                for _ in range(ticks):
                    station.step()

        for axis in (1, 2):
            nc.put(0x4300 + axis, 0x01, "<I", 7)
            nc.put(0x4300 + axis, 0x21, "<I", 1_000_000)
            nc.put(0x4200 + axis, 0x20, "<I4xdd", 1, 150.0 * axis, 200.0)
        for cycle_s, ticks in ((0.01, 3), (0.006, 52), (0.25, 101), (1.5, 700), (0.0, 7)):
            nc.subscribe(0x4101, 0x0A, 8, cycle_s=cycle_s)
            pass_time(ticks)
            history.append((station.time_ns, station.digest(), nc.samples()))
            station.cycle.remove(mine)
        station.restart()
        pass_time(400)
        history.append((station.time_ns, station.digest(), nc.samples(), system.samples(), calls))
        histories.append(history)
    assert histories[0] == histories[1]


@pytest.mark.parametrize("through_config", [False, True])
def test_an_axis_with_persistent_data_knows_its_position_after_a_restart(
    through_config: bool,
) -> None:
    axes = [{"id": i, "name": f"{i}", "persistent_data_enable": 2 - i} for i in (1, 2)]
    station = Station(parse({"axis": axes}, ""))
    assert station.nc is not None
    for axis in station.nc:
        axis.control_dword = 7
        axis.velocity_override = 1_000_000
        commands.set_homed_flag(axis, 1)
        commands.start(axis, 1, 30.0, 200.0)
    station.advance(3.0)
    if through_config:
        station.configure()
        station.advance(1.0)
        assert station.nc is None
    station.restart()
    station.advance(1.0)
    assert station.nc is not None
    remembered, forgotten = station.nc
    assert remembered.actual_position == pytest.approx(30.0, abs=1e-3)
    assert (remembered.homed, forgotten.homed, forgotten.actual_position) == (1, 0, 0.0)


def test_admitted_listener_is_one_of_the_station_and_its_faults() -> None:
    station = Station.demo()
    listener = TcpListener(station.router)
    station.faults.add("refuse_links")
    station.admit(listener)
    assert list(station.listeners) == [listener]
    assert not listener.accepting
    station.faults.clear()
    assert listener.accepting


def test_persistent_data_are_on_the_disk_that_was_given(tmp_path: Path) -> None:
    disk = MemoryDisk()
    document = {
        "system": {"persistent_data": "kept.json"},
        "axis": [{"id": 1, "name": "X", "persistent_data_enable": 1}],
    }
    station = Station(parse(document, "test"), base=tmp_path, disk=disk)
    station.advance(0.1)
    assert station.save()
    assert list(disk.files) == [tmp_path / "kept.json"]
    assert not list(tmp_path.iterdir())
