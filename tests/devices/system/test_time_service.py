"""Time service: the time of day of the station."""

import struct
from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.devices.system.time_service import TimeService
from achse.server import IndexGroup


def group(unix_ns: int) -> IndexGroup:
    (result,) = TimeService(lambda: unix_ns).groups()
    return result


@given(st.datetimes(datetime(1970, 1, 1), datetime(2200, 1, 1)))
def test_the_time_of_day_is_utc(moment: datetime) -> None:
    moment = moment.replace(microsecond=0, tzinfo=UTC)
    data = group(int(moment.timestamp()) * 10**9 + 7_999_999).read(400, 1, 16, b"")
    year, month, weekday, day, *rest = struct.unpack("<8H", data)
    assert (year, month, day) == (moment.year, moment.month, moment.day)
    assert weekday == (moment.weekday() + 1) % 7
    assert rest == [moment.hour, moment.minute, moment.second, 7]


def test_the_zone_is_utc() -> None:
    data = group(0).read(400, 6, 200, b"")
    assert len(data) == 4 + 108
    assert struct.unpack_from("<Ii32s", data) == (0, 0, b"UTC".ljust(32, b"\0"))


def test_nothing_else_is_reported_and_nothing_is_set() -> None:
    with pytest.raises(DeviceError, match="time service 2"):
        group(0).read(400, 2, 16, b"")
    with pytest.raises(DeviceError, match="not set"):
        group(0).write(400, 1, bytes(16), b"")
