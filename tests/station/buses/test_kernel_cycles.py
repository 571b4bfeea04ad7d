"""The shortcut leaves what frames leave: states, counters, events, whatever happens in between."""

import random
from typing import Any

import pytest

from achse.codes import AlStatus
from achse.codes.axis import StartType
from achse.ethercat import Disturbance
from achse.ethercat.ring_segment import RingSegment
from achse.ethercat.terminals import AnalogTerminal, DigitalTerminal, Terminal
from achse.motion import commands
from achse.native.backend import compiler_installed
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.buses.kernel_cycles import KernelCycles
from achse.station.buses.whole_cycle import KERNEL
from achse.station.configuration.station_file import parse
from achse.station.station import Station

pytestmark = pytest.mark.skipif(not compiler_installed(), reason="needs llvmlite")


@pytest.fixture(autouse=True, scope="module")
def _compiled() -> None:
    """The shortcut is taken where its machine code is there already."""
    if compiler_installed():
        _ = KERNEL.function


AXIS = {"max_velocity": 400.0, "default_acceleration": 2000.0, "default_deceleration": 2000.0,
        "default_jerk": 20_000.0}  # fmt: skip


def station_with(drives: list[dict[str, Any]], shortcut: bool, **more: Any) -> Station:
    document = {
        "nc": {"code": "machine"} | more.pop("nc", {}),
        "bus": [{}],
        "axis": [{"id": n, "name": f"A{n}"} | AXIS for n in range(1, len(drives) + 1)],
        "drive": [{"axis": n} | drive for n, drive in enumerate(drives, 1)],
    }
    station = Station(parse(document | more, "test"))
    if not shortcut:
        shortcut_of(station).allowed = False
    return station


def shortcut_of(station: Station) -> KernelCycles:
    shortcut = station.buses[0].shortcut
    assert shortcut is not None
    return shortcut


def bus_of(station: Station) -> EthercatBus:
    bus = station.buses[0].bus
    assert isinstance(bus, EthercatBus)
    return bus


def history(station: Station) -> dict[str, Any]:
    """All that one can see of a station, its bus and what happened on it."""
    bus = bus_of(station)
    traffic = bus.master.traffic
    assert station.nc is not None
    return {
        "digest": station.digest(),
        "nc": station.nc.digest(),
        "cycles": station.nc.cycle_count,
        "counters": repr(bus.master.cyclic.counters),
        "acyclic": (traffic.sent_frames, traffic.lost_frames, traffic.strays),
        "events": [(event.time_ns, event.kind, event.number) for event in bus.master.take_events()],
        "times": (bus.now_ns, bus.segment.time.now_ns, bus.master.now_ns,
                  bus.master.cyclic.reference_ns),
        "toggles": [slave.input_toggle for slave in bus.master.slaves],
        "due": [slave.due_ns for slave in bus.segment.slaves],
    }  # fmt: skip


def test_most_cycles_of_a_quiet_bus_need_no_frames() -> None:
    station = station_with([{}, {"mode": "csv"}], True)
    station.advance(5.0)
    assert shortcut_of(station).cycles > 0.7 * 2500
    assert bus_of(station).segment.counters.frames < 1500


def _digital(chance: random.Random, sizes: tuple[int, ...]) -> dict[str, int]:
    """Inputs and outputs, with or without each; those that are no bytes share theirs in a frame."""
    while True:
        inputs, outputs = (chance.choice(sizes) for _ in range(2))
        if inputs or outputs:
            return {"inputs": inputs, "outputs": outputs}


@pytest.mark.parametrize("seed", range(6))
def test_terminals_beside_drives_get_what_frames_bring(seed: int) -> None:
    chance = random.Random(seed)
    terminals: list[dict[str, Any]] = [
        {"name": f"T{n}"} | _digital(chance, (0, 8, 16) if seed % 3 else (0, 5, 8))
        if chance.random() < 0.7
        else {"name": f"T{n}", "kind": "analog", "inputs": chance.randint(1, 3)}
        for n in range(chance.randint(1, 3))
    ]
    both = [station_with([{}], shortcut, terminal=terminals) for shortcut in (True, False)]
    for station in both:
        assert station.nc is not None
        station.nc.axis(1).control_dword, station.nc.axis(1).velocity_override = 7, 1_000_000
        station.advance(1.3)
    for _ in range(12):
        seconds, volts = chance.choice((0.002, 0.004, 0.05, 0.7)), chance.uniform(-11, 11)
        number, bits = chance.randrange(len(terminals)), chance.randbytes(8)
        fall, move = chance.random() < 0.2, chance.uniform(-30.0, 30.0)
        seen = []
        for station in both:
            bus = bus_of(station)
            device, slave = bus.terminals[number], bus.terminal_slaves[number]
            if isinstance(device, AnalogTerminal):
                device.set_voltage(0, volts)
            elif isinstance(device, DigitalTerminal) and device.inputs:
                device.set_input(device.inputs - 1, volts > 0)
            slave.outputs[:] = bits[: len(slave.outputs)]
            if fall:
                bus.segment.slaves[slave.position].fail(AlStatus.WATCHDOG)
            elif station.nc is not None:
                commands.start(station.nc.axis(1), StartType.ABSOLUTE, move, 100.0)
            station.advance(seconds)
            seen.append(
                [
                    (bytes(slave.inputs), slave.input_toggle, each.output_image, slave.state)
                    for each, slave in zip(bus.terminals, bus.terminal_slaves, strict=True)
                    if isinstance(each, Terminal)
                ]
            )
        assert seen[0] == seen[1]
        assert history(both[0]) == history(both[1])
    sizes = [size for each in terminals if "kind" not in each
             for size in (each["inputs"], each["outputs"])]  # fmt: skip
    quick = shortcut_of(both[0])
    assert quick.allowed == all(size % 8 == 0 for size in sizes)
    assert (quick.cycles > 200) == quick.allowed


def test_an_open_ring_is_one_of_frames() -> None:
    station = station_with([{}, {}], True, bus=[{"redundant": True}])
    station.advance(3.0)
    quick, ring = shortcut_of(station), bus_of(station).segment
    assert quick.cycles > 0.5 * 1500
    assert isinstance(ring, RingSegment)
    for cable in range(3):
        ring.cut(cable)
        before = quick.cycles
        station.advance(0.1)
        assert quick.cycles == before
        ring.mend(cable)
        station.advance(1.0)
        assert quick.cycles > before


def test_frames_carry_requests() -> None:
    station = station_with([{}], False)
    station.advance(2.0)
    assert shortcut_of(station).cycles == 0


@pytest.mark.parametrize("seed", range(6))
def test_it_leaves_what_frames_leave(seed: int) -> None:
    chance = random.Random(seed)
    drives = [
        {
            "mode": chance.choice(["csp", "csv", "cst"]),
            "inverted": chance.random() < 0.5,
            "resolution": chance.choice([10_000, 131_072]),
            "homing": {"method": chance.choice([33, 34, 37])},
            "machine": {"probe": [2.0, 5.0]},
        }
        for _ in range(chance.randint(1, 3))
    ]
    cycle = chance.choice(["1ms", "2ms", "4ms"])
    line = [{"redundant": chance.random() < 0.5}]
    both = [
        station_with(drives, shortcut, nc={"cycle": cycle}, bus=line) for shortcut in (True, False)
    ]
    for station in both:
        assert station.nc is not None
        for axis in station.nc:
            axis.control_dword, axis.velocity_override = 7, 1_000_000
        station.advance(1.3)
    assert history(both[0]) == history(both[1])
    for _ in range(5):
        what = chance.choice(["move", "move", "home", "alarm", "reset", "cable", "probe",
                                     "lose", "fall", "disable"])  # fmt: skip
        number = chance.randint(1, len(drives))
        target, seconds = chance.uniform(-30.0, 30.0), chance.uniform(0.01, 0.5)
        cable = chance.randint(0, len(drives))
        for station in both:
            assert station.nc is not None
            axis, bus = station.nc.axis(number), bus_of(station)
            slave = bus.segment.slaves[number - 1]
            if what == "move":
                commands.start(axis, StartType.ABSOLUTE, target, 100.0)
            elif what == "home":
                commands.home(axis)
            elif what == "alarm":
                bus.drives[number - 1].record.alarm_request = 0xFF11
            elif what == "reset":
                commands.reset(axis)
            elif what == "probe":
                commands.activate_touch_probe(axis, 1, 0, 1, 0)
            elif what == "lose":
                bus.segment.disturbance = Disturbance(lose=3)
            elif what == "fall":
                slave.fail(AlStatus.WATCHDOG)
            elif what == "disable":
                axis.control_dword ^= 1
            elif isinstance(bus.segment, RingSegment):
                if bus.segment.whole:
                    bus.segment.cut(cable)
                else:
                    for each in range(len(drives) + 1):
                        bus.segment.mend(each)
            elif slave in bus.segment.reachable:
                bus.segment.break_link(slave)
            else:
                bus.segment.repair_link(slave)
            station.advance(seconds)
        assert history(both[0]) == history(both[1]), what
