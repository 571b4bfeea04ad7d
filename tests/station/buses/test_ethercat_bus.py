"""Axes on drives behind our master: start-up, faults of the bus, and how they end."""

import struct
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Flags, Frame, NetId
from achse.codes import AlState, AlStatus, NcError
from achse.codes.axis import StartType
from achse.drive.alarms import Alarm
from achse.motion import commands
from achse.motion.servo import ServoMode
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.buses.plan import DEFAULT_INPUTS, DEFAULT_OUTPUTS, BusPlan
from achse.station.configuration.bus import BusConfig, DriveConfig
from achse.station.configuration.station_file import parse
from achse.station.station import Station
from achse.testing import check_axis

MS = 1_000_000


def station_with(
    *drives: dict[str, Any], axis: dict[str, float] | None = None, redundant: bool = False
) -> Station:
    dynamics = {"max_velocity": 400.0, "default_acceleration": 2000.0,
                "default_deceleration": 2000.0, "default_jerk": 20_000.0}  # fmt: skip
    document = {
        "bus": [{"redundant": redundant}],
        "axis": [
            {"id": n, "name": f"A{n}"} | dynamics | (axis or {}) for n in range(1, len(drives) + 1)
        ],
        "drive": [{"axis": n} | drive for n, drive in enumerate(drives, 1)],
    }
    station = Station(parse(document, "test"))
    assert station.nc is not None
    for each in station.nc:
        each.control_dword, each.velocity_override = 7, 1_000_000
    station.advance(1.5)
    return station


def made_of(drives: list[DriveConfig]) -> EthercatBus:
    return EthercatBus(BusPlan(BusConfig(), drives, (), 2 * MS))


def bus_of(station: Station) -> EthercatBus:
    bus = station.buses[0].bus
    assert isinstance(bus, EthercatBus)
    return bus


def test_drives_come_to_op_with_the_objects_that_an_axis_needs() -> None:
    bus = made_of([DriveConfig(axis=n) for n in (1, 2)])
    for _ in range(600):
        bus.exchange()
    assert bus.master.operational
    for slave, drive in zip(bus.slaves, bus.drives, strict=True):
        assert [index for index, _ in slave.input_entries] == list(DEFAULT_INPUTS)
        assert [index for index, _ in slave.output_entries] == list(DEFAULT_OUTPUTS)
        assert drive.state is AlState.OP
        assert (drive.get(0x60C2, 1), drive.get(0x60C2, 2)) == (2, -3)


def test_places_on_the_bus_and_axes_are_apart() -> None:
    configs = [DriveConfig(axis=1, position=2), DriveConfig(axis=2, position=1)]
    bus = made_of(configs)
    assert [slave.position for slave in bus.slaves] == [1, 0]
    assert bus.segment.slaves[0].application is bus.drives[1]


def test_homing_and_start_commands_are_written() -> None:
    config = DriveConfig.model_validate(
        {
            "axis": 1,
            "feed": 10.0,
            "resolution": 10_000,
            "homing": {"method": -3, "search_velocity": 20.0, "index_velocity": 2.0, "offset": 1.5},
            "start": [{"index": 0x6065, "value": 1234}],
        }
    )
    bus = made_of([config])
    for _ in range(600):
        bus.exchange()
    drive = bus.drives[0]
    assert drive.get(0x6098) == -3
    assert (drive.get(0x6099, 1), drive.get(0x6099, 2)) == (20_000, 2_000)
    assert (drive.get(0x609A), drive.get(0x607C)) == (500_000, 1_500)
    assert drive.get(0x6065) == 1234


@pytest.mark.parametrize("mode", ["csp", "csv", "cst"])
def test_an_axis_on_a_drive_keeps_what_an_axis_has_to_keep(mode: str, client_of: Any) -> None:
    station = station_with({"mode": mode})
    assert station.nc is not None
    station.nc.axis(1).control_dword = 0
    station.advance(0.1)
    client = client_of(station.router, 501)

    class Reach:
        read_raw = staticmethod(client.read)
        write_raw = staticmethod(client.write)

        @staticmethod
        def read_write_raw(group: int, offset: int, length: int, data: bytes) -> bytes:
            return bytes(client.exchange(group, offset, length, data))

    check_axis(Reach(), 1, tolerance=0.1, wait=station.advance)


def test_a_drive_has_its_address_on_the_bus(client_of: Any) -> None:
    station = station_with({}, {})
    client = client_of(station.router, 501)
    for number in (1, 2):
        net_id, port, channel = struct.unpack("<6sHH", client.read(0x4000 + number, 0x31, 10))
        assert net_id == bytes((127, 0, 0, 1, 2, 1))
        assert (port, channel) == (1000 + number, 0)


def moving(station: Station) -> Any:
    assert station.nc is not None
    for axis in station.nc:
        assert commands.start(axis, StartType.ABSOLUTE, 300.0, 50.0) == 0
    station.advance(1.0)
    return station.nc


def error_of(client: Any, axis: int) -> NcError | None:
    (code,) = struct.unpack("<I", client.read(0x4100 + axis, 0x01, 4))
    return NcError.of(code) if code else None


def recovers(station: Station, axis: Any) -> None:
    """MC_Reset and on: the documented steps."""
    station.advance(3.0)
    assert commands.reset(axis) == 0
    station.advance(1.0)
    assert axis.loop_closed, axis
    here = axis.actual_position
    assert commands.start(axis, StartType.ABSOLUTE, here - 5.0, 50.0) == 0
    station.advance(1.5)
    assert axis.error_code == 0
    assert axis.actual_position == pytest.approx(here - 5.0, abs=1e-2)


def test_a_cable_that_is_pulled_is_4655_behind_it_alone_and_recovers(client_of: Any) -> None:
    station = station_with({}, {})
    nc = moving(station)
    client = client_of(station.router, 501)
    segment = bus_of(station).segment
    segment.break_link(segment.slaves[1])
    station.advance(0.05)
    assert error_of(client, 1) is None
    assert error_of(client, 2) is NcError.DRIVE_IO_INVALID
    station.advance(2.0)
    assert nc.axis(1).set_velocity == 50.0
    segment.repair_link(segment.slaves[1])
    recovers(station, nc.axis(2))
    station.advance(3.0)
    assert nc.axis(1).actual_position == pytest.approx(300.0, abs=1e-2)


def test_a_slave_that_falls_to_safeop_is_4655_and_recovers(client_of: Any) -> None:
    station = station_with({}, {})
    nc = moving(station)
    client = client_of(station.router, 501)
    bus = bus_of(station)
    bus.segment.slaves[0].hang()  # and the master cannot lead it up again
    bus.segment.slaves[0].fail(AlStatus.WATCHDOG)
    station.advance(0.1)
    assert error_of(client, 1) is NcError.DRIVE_IO_INVALID
    assert error_of(client, 2) is None
    assert bus.slaves[0].state & 0x0F == AlState.SAFEOP
    bus.segment.slaves[0].hang(False)
    recovers(station, nc.axis(1))
    assert bus.slaves[0].state == AlState.OP


def test_a_drive_operated_at_its_panel_comes_back_when_op_is_requested(client_of: Any) -> None:
    station = station_with({}, {})
    nc = moving(station)
    client = client_of(station.router, 501)
    bus = bus_of(station)
    bus.drives[0].faults.local_control()
    station.advance(1.0)
    assert error_of(client, 1) is NcError.DRIVE_IO_INVALID
    assert bus.slaves[0].state & 0x0F < AlState.OP
    bus.drives[0].faults.local_control(False)
    bus.master.request(AlState.OP, bus.slaves[0])
    recovers(station, nc.axis(1))


def test_a_bus_that_is_cut_off_stops_all_axes_and_comes_back(client_of: Any) -> None:
    station = station_with({}, {})
    nc = moving(station)
    client = client_of(station.router, 501)
    segment = bus_of(station).segment
    segment.break_link(segment.slaves[0])
    station.advance(0.5)
    assert [error_of(client, n) for n in (1, 2)] == [NcError.DRIVE_IO_INVALID] * 2
    segment.repair_link(segment.slaves[0])
    for axis in nc:
        recovers(station, axis)


def test_drives_of_one_sync_unit_share_their_fate(client_of: Any) -> None:
    station = station_with({"sync_unit": "A"}, {"sync_unit": "A"}, {})
    moving(station)
    client = client_of(station.router, 501)
    bus_of(station).drives[0].faults.local_control()
    station.advance(0.1)
    errors = [error_of(client, n) for n in (1, 2, 3)]
    assert errors == [NcError.DRIVE_IO_INVALID, NcError.DRIVE_IO_INVALID, None]


def test_a_touch_probe_is_where_the_drive_saw_it() -> None:
    station = station_with({"machine": {"probe": [20.0, 30.0]}, "inverted": True})
    assert station.nc is not None
    axis = station.nc.axis(1)
    assert commands.activate_touch_probe(axis, 1, 0, 1, 0) == 0
    assert commands.start(axis, StartType.ABSOLUTE, 50.0, 100.0) == 0
    station.advance(2.0)
    assert axis.encoder.probe_valid[0]
    assert axis.encoder.probe_position[0] == pytest.approx(20.0, abs=1e-3)


@settings(max_examples=6)
@given(st.data())
def test_drawn_axes_reach_drawn_targets_or_say_why(data: st.DataObject) -> None:
    draw = data.draw
    resolution = draw(st.sampled_from([4096, 10_000, 131_072, 1 << 20]))
    gear = (draw(st.integers(1, 20)), draw(st.integers(1, 5)))
    feed = draw(st.sampled_from([1.0, 10.0, 360.0]))
    drive = {
        "mode": draw(st.sampled_from([mode.name.lower() for mode in ServoMode][1:])),
        "resolution": resolution,
        "gear": gear,
        "feed": feed,
        "inverted": draw(st.booleans()),
    }
    way = feed * gear[1] / gear[0]  # of a motor turn, which 50 a second are no trouble for
    dynamics = {
        "max_velocity": 60.0 * way,
        "drive_reference_velocity": 66.0 * way,
        "default_acceleration": draw(st.floats(50.0, 600.0)) * way,
        "default_deceleration": draw(st.floats(50.0, 600.0)) * way,
        "default_jerk": draw(st.floats(1000.0, 10_000.0)) * way,
        "controller_following_error_position_max": 2.0 * way,
    }
    station = station_with(drive, axis=dynamics)
    assert station.nc is not None
    axis = station.nc.axis(1)
    assert axis.loop_closed
    for _ in range(2):
        target = draw(st.floats(-10.0, 10.0)) * way
        velocity = draw(st.floats(1.0, 50.0)) * way
        assert commands.start(axis, StartType.ABSOLUTE, target, velocity) == 0
        fault = draw(st.sampled_from([None, None, "alarm", "cable"]))
        when = draw(st.floats(0.0, 0.5))
        station.advance(when)
        # what has next to no way left is at rest before the drive shows its alarm
        moves = axis.set_motion_phase != 0 and abs(target - axis.set_position) > 0.01 * way
        bus = bus_of(station)
        if fault == "alarm":
            bus.drives[0].record.alarm_request = 0xFF11
        elif fault == "cable":
            bus.segment.break_link(bus.segment.slaves[0])
        station.advance(0.1)
        if fault is not None:
            expected = NcError.DRIVE_NOT_READY if fault == "alarm" else NcError.DRIVE_IO_INVALID
            if moves or fault == "cable":
                assert NcError.of(axis.error_code) is expected
            bus.segment.repair_link(bus.segment.slaves[0])
            station.advance(3.0)
            assert commands.reset(axis) == 0
            station.advance(1.0)
            assert axis.loop_closed
            assert commands.start(axis, StartType.ABSOLUTE, target, velocity) == 0
        for _ in range(300):
            station.advance(0.1)
            if axis.set_motion_phase == 0:
                break
        station.advance(1.0)
        assert axis.error_code == 0
        assert axis.set_motion_phase == 0
        assert axis.actual_position == pytest.approx(target, abs=0.01 * way)


class Asking:
    """Reads by frames; answers of a bus come when station time has passed."""

    def __init__(self, station: Station) -> None:
        self.station = station
        self.answers: list[Frame] = []
        self.address = station.router.register(0, self)

    def deliver(self, frame: Frame) -> bool:
        self.answers.append(frame)
        return True

    def read(self, net_id: bytes, port: int, group: int, offset: int, length: int) -> bytes:
        target = AmsAddress.of(NetId(net_id), port)
        request = struct.pack("<III", group, offset, length)
        self.station.router.deliver(
            Frame(target, self.address, Command.READ, Flags.ADS_COMMAND, invoke_id=1, data=request)
        )
        for _ in range(200):
            if self.answers:
                break
            self.station.advance(0.002)
        answer = self.answers.pop()
        assert (answer.error, answer.data[:4]) == (0, bytes(4))
        return answer.data[8:]


def test_from_axis_to_drive_by_ads() -> None:
    """FB_GetAxisAmsAddr, then CoE to what it gives."""
    station = station_with({}, {})
    ask = Asking(station)
    own = bytes(station.router.net_id)
    for number, drive in enumerate(bus_of(station).drives, 1):
        net_id, port, _ = struct.unpack("<6sHH", ask.read(own, 501, 0x4000 + number, 0x31, 10))
        shown = ask.read(net_id, port, 0xF302, 0x6041 << 16, 2)
        assert int.from_bytes(shown, "little") == drive.record.statusword
    drive = bus_of(station).drives[1]
    drive.faults.alarm(Alarm.OVER_VOLTAGE, lasting=False)
    station.advance(0.2)
    assert struct.unpack("<H", ask.read(net_id, port, 0xF302, 0x603F << 16, 2)) == (0xFF11,)


def test_a_restart_brings_the_bus_and_its_devices_again() -> None:
    station = station_with({})
    before = bus_of(station)
    station.restart()
    station.advance(3.0)
    assert bus_of(station) is not before
    assert bus_of(station).master.operational
    ask = Asking(station)
    net_id, port, _ = struct.unpack(
        "<6sHH", ask.read(bytes(station.router.net_id), 501, 0x4001, 0x31, 10)
    )
    assert ask.read(net_id, port, 0xF302, 0x6061 << 16, 1) == b"\x08"
    station.configure()
    station.advance(2.0)
    assert not station.buses


@settings(max_examples=5)
@given(data=st.data(), count=st.integers(1, 4))
def test_a_cut_cable_of_a_ring_is_reported_and_stops_no_axis(
    data: st.DataObject, count: int
) -> None:
    station = station_with(*[{}] * count, redundant=True)
    bus, nc = bus_of(station), station.nc
    assert nc is not None
    for axis in nc:
        assert commands.start(axis, StartType.ABSOLUTE, 40.0, 30.0) == 0
    wrong = bus.master.cyclic.counters.wrong + bus.master.cyclic.counters.lost
    for place in data.draw(st.permutations(range(count + 1)), "cut in this order"):
        station.advance(data.draw(st.floats(0.0, 0.2), "closed for"))
        fault = bus.faults.add("link_break", drive=place + 1)
        station.advance(data.draw(st.floats(0.03, 0.3), "open for"))
        assert bus.master.supervision.opening
        assert bus.master.operational
        bus.faults.clear(fault.number)
        station.advance(0.02)
        assert not bus.master.supervision.opening
    station.advance(2.0)
    assert [axis.error_code for axis in nc] == [0] * count
    assert all(abs(axis.actual_position - 40.0) < 0.02 for axis in nc)
    assert bus.master.cyclic.counters.wrong + bus.master.cyclic.counters.lost == wrong


def test_an_open_ring_is_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    station = station_with({}, {}, redundant=True)
    bus_of(station).faults.add("link_break", drive=2, lasting=0.1)
    station.advance(0.2)
    messages = [each.getMessage() for each in caplog.records if "ring" in each.getMessage()]
    assert messages == ["ring is open: between Drive 1 (axis 1) and Drive 2 (axis 2)"]


def test_two_cuts_of_a_ring_are_an_error_of_the_axes_between() -> None:
    station = station_with({}, {}, {}, redundant=True)
    bus, nc = bus_of(station), station.nc
    assert nc is not None
    faults = [bus.faults.add("link_break", drive=place) for place in (2, 3)]
    station.advance(0.5)
    assert [axis.error_code for axis in nc] == [0, NcError.DRIVE_IO_INVALID, 0]
    bus.faults.clear(faults[0].number)
    station.advance(1.0)
    assert bus.master.operational
    assert commands.reset(nc.axis(2)) == 0
    station.advance(0.5)
    assert nc.axis(2).loop_closed
