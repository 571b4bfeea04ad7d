"""All parameters of an axis in one answer: places, values, the short form."""

import struct
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.devices.nc.axes.parameter_set import PLACES, LongParameterSet, ShortParameterSet
from achse.devices.nc.axes.parameters import AXIS_PARAMETERS

P = 0x4001
OFFSETS = {row.name: row.offset for row in AXIS_PARAMETERS}


def test_the_head_of_both_forms(bench: Any) -> None:
    number, kind, name, seconds = struct.unpack("<II31sxd", bench.read(P, 0x00, 1024)[:48])
    assert (number, kind, name.rstrip(b"\0"), seconds) == (1, 1, b"X", 0.002)
    assert struct.unpack("<I31sI", bench.read(P, 0x00, 512)[:39])[2] == 1


@pytest.mark.parametrize("name", PLACES)
def test_each_place_has_the_value_of_its_row(bench: Any, name: str) -> None:
    """Places do not overlap: the next one begins where a value ends, or later."""
    data, place = bench.read(P, 0x00, 1024), PLACES[name]
    behind = min((each for each in PLACES.values() if each > place), default=648)
    sizes = (size for size in (31, 8, 4, 2) if size <= behind - place)
    size = next(size for size in sizes if _has(bench, name, size))
    assert data[place : place + size] == bench.read(P, OFFSETS[name], size)


def _has(bench: Any, name: str, size: int) -> bool:
    try:
        return len(bench.read(P, OFFSETS[name], size)) == size
    except DeviceError:
        return False


def test_a_parameter_that_is_written_is_in_the_answer(bench: Any) -> None:
    bench.write(P, OFFSETS["default_jerk"], struct.pack("<d", 4321.0))
    data = bench.read(P, 0x00, 1024)
    assert struct.unpack_from("<d", data, PLACES["default_jerk"]) == (4321.0,)


def test_what_clients_decode() -> None:
    data = struct.pack("<II31sxd", 7, 1, b"Lift", 0.002).ljust(1024, b"\0")
    head = {"axis_id": 7, "axis_name": "Lift", "axis_type": 1}
    rows = tuple(row for row in AXIS_PARAMETERS if row.name in PLACES)
    assert LongParameterSet(rows).decode(data) == head
    short = struct.pack("<I31sI", 7, b"Lift", 1).ljust(512, b"\0")
    assert ShortParameterSet(()).decode(short) == head
