"""check_axis: our axes pass, and each rule that an axis breaks is told."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.testing import ConformanceError, LiveStation, check_axis


def _same(data: bytes) -> bytes:
    return data


class Reach:
    """An NC of this process, whose answers a test may change."""

    def __init__(self, station: Station, client_of: Any) -> None:
        self.station = station
        self.client = client_of(station.router, 501)
        self.reads: dict[tuple[int, int], Callable[[bytes], bytes]] = {}
        self.writes: dict[tuple[int, int], Callable[[bytes], bytes | None]] = {}
        self.forgiving = False

    def read_raw(self, group: int, offset: int, length: int) -> bytes:
        try:
            data = bytes(self.client.read(group, offset, length))
        except DeviceError:
            if self.forgiving:
                return bytes(length)
            raise
        return self.reads.get((group, offset), _same)(data)

    def write_raw(self, group: int, offset: int, data: bytes) -> None:
        changed = self.writes.get((group, offset), _same)(data)
        if changed is not None:
            try:
                self.client.write(group, offset, changed)
            except DeviceError:
                if not self.forgiving:
                    raise

    def read_write_raw(self, group: int, offset: int, read_length: int, data: bytes) -> bytes:
        changed = self.writes.get((group, offset), _same)(data)
        if changed is None:
            return bytes(read_length)
        return bytes(self.client.exchange(group, offset, read_length, changed))


@pytest.fixture
def reach(client_of: Any) -> Reach:
    axes = [{"id": 1, "name": "X"}, {"id": 2, "name": "Y", "max_velocity": 500.0}]
    return Reach(Station(parse({"axis": axes}, "")), client_of)


def _faults(reach: Reach, **settings: Any) -> str:
    with pytest.raises(ConformanceError) as caught:
        check_axis(reach, 1, wait=reach.station.advance, **settings)
    return str(caught.value)


@pytest.mark.parametrize("axis", [1, 2])
def test_our_axes_conform_and_end_as_they_were(reach: Reach, axis: int) -> None:
    reach.station.advance(0.1)
    nc = reach.station.nc
    assert nc is not None
    before = nc.axis(axis).set_position
    check_axis(reach, axis, wait=reach.station.advance)
    after = nc.axis(axis)
    assert after.set_position == pytest.approx(before, abs=1e-9)
    assert (after.control_dword, after.velocity_override) == (0, 0)


def test_over_a_connection() -> None:
    station = LiveStation(time=0.0)
    with station, station.connect(501) as nc:
        check_axis(nc, 1, wait=station.advance)


def test_without_motion_nothing_moves(reach: Reach) -> None:
    check_axis(reach, 1, motion=False)
    assert reach.station.time_ns == 0


def test_a_size_and_an_id_that_are_wrong_are_reported(reach: Reach) -> None:
    reach.reads[0x4101, 0x0A] = lambda data: data[:4]
    reach.reads[0x4001, 0x01] = lambda data: b"\7\0\0\0"
    faults = _faults(reach)
    assert "set_position (0x4101:0xA): has 4 bytes, expected 8" in faults
    assert "axis id: expected 1, got 7" in faults


def test_an_nc_that_refuses_nothing_is_reported(reach: Reach) -> None:
    reach.forgiving = True
    faults = _faults(reach)
    assert "offset 0xFFF, which does not exist, is answered" in faults
    assert "a velocity override of 3 bytes: expected 0x705, got 0x0" in faults
    assert "can be written, its row says read only" in faults


def test_an_axis_that_goes_too_fast_is_reported(reach: Reach) -> None:
    reach.reads[0x4101, 0x0E] = lambda data: _doubled(data)
    faults = _faults(reach)
    assert "a move by 10: the set velocity is up to 40, expected at most 20" in faults
    assert "at half the override the set velocity is 20, expected 10" in faults


def _doubled(data: bytes) -> bytes:
    return struct.pack("<d", 2 * struct.unpack("<d", data)[0])


def test_an_axis_that_does_not_move_is_reported(reach: Reach) -> None:
    reach.writes[0x4201, 0x16] = lambda data: None
    faults = _faults(reach)
    assert "a move by 10: the set position is 0, expected 10" in faults
    assert "a start of type 99" in faults


def test_a_stop_that_does_nothing_is_reported(reach: Reach) -> None:
    reach.writes[0x4201, 0x02] = lambda data: None
    assert "a stop on the way from 0 to 20 ends at 20" in _faults(reach)
