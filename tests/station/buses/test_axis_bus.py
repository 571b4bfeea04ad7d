"""Axes on the drives of a bus, as a station has them."""

import asyncio
import math
from typing import Any

import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

import achse
from achse.ams import NetId
from achse.client.nc.errors import AxisError
from achse.codes import AlState, AlStatus, NcError
from achse.codes.axis import StartType
from achse.drive.alarms import Alarm
from achse.motion import commands
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.station import Station
from tests.station.drive_stations import drive_station, enable_axes


@pytest.mark.parametrize("code", ["plain", "machine"])
def test_axes_in_each_mode_reach_their_targets(code: str) -> None:
    modes: list[dict[str, Any]] = [{"mode": mode} for mode in ("csp", "csv", "cst")]
    modes[1] |= {"inverted": True, "gear": [3, 1]}
    station = drive_station(*modes, nc={"code": code})
    enable_axes(station)
    assert station.nc is not None
    for axis in station.nc:
        assert commands.start(axis, StartType.ABSOLUTE, 33.0, 100.0) == 0
    station.advance(3.0)
    for axis in station.nc:
        assert axis.error_code == 0
        assert axis.actual_position == pytest.approx(33.0, abs=0.02)


def test_equal_histories_have_equal_digests_on_either_kernel() -> None:
    digests = set()
    for code in ("plain", "machine", "machine"):
        station = drive_station({"mode": "csp"}, {"mode": "cst"}, nc={"code": code})
        enable_axes(station)
        assert station.nc is not None
        for axis in station.nc:
            commands.start(axis, StartType.ABSOLUTE, 20.0, 100.0)
        station.advance(0.5)
        digests.add(station.digest())
    assert len(digests) == 1


def test_32_axes_move_together() -> None:
    station = drive_station(*[{} for _ in range(32)])
    enable_axes(station)
    assert station.nc is not None
    for axis in station.nc:
        assert commands.start(axis, StartType.ABSOLUTE, float(axis.axis_id), 100.0) == 0
    station.advance(2.0)
    for axis in station.nc:
        assert axis.actual_position == pytest.approx(axis.axis_id, abs=1e-3)


def test_a_fault_is_an_error_of_its_axis_alone() -> None:
    station = drive_station({}, {})
    enable_axes(station)
    assert station.nc is not None
    station.buses[0].bus.drives[0].faults.alarm(Alarm.OVER_VOLTAGE, lasting=False)
    for axis in station.nc:
        commands.start(axis, StartType.ABSOLUTE, 50.0, 50.0)
    station.advance(2.0)
    first, second = station.nc
    assert NcError.of(first.error_code) is NcError.DRIVE_NOT_READY
    assert (second.error_code, second.actual_position) == (0, pytest.approx(50.0, abs=1e-3))
    commands.reset(first)
    station.advance(0.5)
    assert first.loop_closed


@settings(max_examples=3, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(
    drift=st.floats(1.5, 50.0) | st.floats(-50.0, -1.5),
    cycle=st.sampled_from((1, 2, 4)),
    jump=st.booleans(),
    lasts=st.booleans(),
)
@example(drift=-2.0, cycle=2, jump=False, lasts=True)
def test_a_clock_that_leaves_the_others_ends_in_documented_errors_and_comes_back(
    drift: float, cycle: int, jump: bool, lasts: bool
) -> None:
    """What the manual promises: 0x001A and SafeOp, 0x4655 at the axis, all of it seen by ADS."""
    station = drive_station({}, {}, nc={"cycle": f"{cycle}ms", "code": "machine"})
    enable_axes(station)
    assert station.nc is not None
    other, axis = station.nc
    bus: Any = station.buses[0].bus
    for each in station.nc:
        commands.start(each, StartType.ABSOLUTE, 200.0, 10.0)
    # a drive follows a µs in each cycle
    kind, by = ("clock_jump", cycle * 0.4e-3) if jump else ("clock_drift", drift * 1000.0 / cycle)
    bus.faults.add(kind, by=by, drive=2, lasting=0.05 if jump else None)
    for _ in range(200):
        station.advance(0.1)
        if axis.error_code:
            break
    assert NcError.of(axis.error_code) is NcError.DRIVE_IO_INVALID
    assert other.error_code == 0
    assert bus.drives[1].get(0x1C32, 32) == 1
    if lasts:  # the master tries thrice, and leaves the slave where it is
        station.advance(3.0 if jump else 30.0)
    if lasts and not jump:
        asyncio.run(_given_up_as_clients_see_it(station))
    bus.faults.clear()

    async def recover() -> None:
        async with achse.connect(station.router, advance=station.advance) as client:
            master = client.at_port(0xFFFF, _bus_of(station))
            await master.write_raw(0x0009, 1002, (AlState.OP | 0).to_bytes(2, "little"))

    asyncio.run(recover())
    for _ in range(100):
        station.advance(0.1)
        if bus.slaves[1].operational:
            break
    assert bus.master.operational
    commands.reset(axis)
    station.advance(1.0)
    assert (axis.error_code, axis.loop_closed) == (0, 1)
    assert bus.drives[1].get(0x1C33, 32) == 0
    assert other.error_code == 0


def _bus_of(station: Station) -> NetId:
    return NetId(bytes(station.router.net_id[:4]) + b"\x02\x01")


async def _given_up_as_clients_see_it(station: Station) -> None:
    async with achse.connect(station.router, advance=station.advance) as client:
        master = client.at_port(0xFFFF, _bus_of(station))
        states = await master.read_raw(0x0009, 0, 4)
        assert (states[0], states[2] & 0x10) == (AlState.OP, 0x10)
        code = int.from_bytes(await master.read_raw(0xF302, 0xA001_0003, 2), "little")
        assert AlStatus.of(code) is AlStatus.SYNCHRONIZATION
        bits = int.from_bytes(await master.read_raw(0x0045, 0, 2), "little")
        assert bits & 0x1800 == 0x1800, "clocks apart, slaves with errors"
        clocks = await master.read_raw(0x0103, 0, 8)
        assert clocks[:4] == bytes(4)
        assert clocks[4:] != bytes(4)
        assert b"ynchronization was lost" in await master.read_raw(0x0104, 1002, 256)
        slave = client.at_port(1002, _bus_of(station))
        answer = asyncio.ensure_future(slave.read_raw(0xF302, 0x1C32_0020, 1))
        while not answer.done():  # the slave answers in a later cycle
            station.advance(0.01)
            await asyncio.sleep(0)
        assert await answer == b"\x01"


def test_a_clock_that_the_drive_can_follow_stops_nothing() -> None:
    station = drive_station({}, {})
    enable_axes(station)
    assert station.nc is not None
    bus: Any = station.buses[0].bus
    for ppm in (200.0, -400.0):
        bus.faults.clear()
        bus.faults.add("clock_drift", by=ppm, drive=2)
        station.advance(2.0)
    bus.faults.clear()
    bus.faults.add("clock_jump", by=100e-6, drive=2)
    bus.master.take_events()
    station.advance(1.0)
    kinds = [each.kind.name for each in bus.master.take_events()]
    assert kinds == ["CLOCK", "CLOCK_BACK"]
    assert all(axis.error_code == 0 and axis.loop_closed for axis in station.nc)


async def test_enabling_names_the_condition_that_a_drive_misses() -> None:
    station = drive_station({"remote_bit": False}, {"voltage_bit": True})
    station.advance(1.5)
    bus = next(iter(station.fieldbuses.values()))
    assert isinstance(bus, EthercatBus)
    for drive in bus.drives:
        drive.faults.main_power(False)
    async with (
        station.running("127.0.0.1", 0, udp_port=None, speed=math.inf) as running,
        achse.connect(f"127.0.0.1:{running.tcp_port}", port=500) as nc,
    ):
        with pytest.raises(AxisError) as first:
            await nc.nc.axis(1).enable(within=0.3)
        with pytest.raises(AxisError) as second:
            await nc.nc.axis(2).enable(within=0.3)
    for failure in (first, second):
        assert "its drive is in" in str(failure.value), failure.value
    assert station.missing_condition(3) == ""


def test_missing_condition_names_the_slave_that_is_not_in_op() -> None:
    station = drive_station({})
    bus = next(iter(station.fieldbuses.values()))
    station.advance(1.5)
    bus.master.request(AlState.PREOP)
    station.advance(0.5)
    assert "Drive 1 (axis 1) is not in Op" in station.missing_condition(1)
