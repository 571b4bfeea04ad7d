"""pyads builds a motion function point by point, couples a slave and compares with closed forms.

Everything is a documented service (002 §6.4.8, §6.4.4.3); numbers are from the manual.
"""

import struct
from collections.abc import Callable, Iterator
from math import pi, sin
from typing import Any

import pytest

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

TABLE, FUNCTION, STATE, CYCLIC, USERS = 0xA000, 0xA200, 0x4100, 0x4300, 0xA100
ID, MASTER, SLAVE = 41, 1, 2
POINT = struct.Struct("<IHHiI5d")


def write(nc: Any, group: int, offset: int, data: bytes = b"") -> None:
    nc.write(group, offset, list(data), pyads.PLCTYPE_BYTE * len(data) if data else None)


def accepts(nc: Any, group: int, offset: int, data: bytes) -> bool:
    """Write; return whether the station accepted it."""
    try:
        write(nc, group, offset, data)
    except pyads.ADSError:
        return False
    return True


def set_position(nc: Any, axis: int) -> float:
    data = bytes(nc.read(STATE + axis, 0, pyads.PLCTYPE_BYTE * 256))
    return float(struct.unpack_from("<d", data, 24)[0])


@pytest.fixture
def nc(
    station: Any, pyads_connection: Callable[..., Any], until: Callable[..., None]
) -> Iterator[Any]:
    """The NC, axes 1 and 2 enabled and at 0; uncoupled afterwards."""
    connection = pyads_connection(station, 501)
    for axis in (MASTER, SLAVE):
        write(connection, 0x4200 + axis, 0x01)
        connection.write(CYCLIC + axis, 0x01, 0b111, pyads.PLCTYPE_UDINT)
        connection.write(CYCLIC + axis, 0x21, 1_000_000, pyads.PLCTYPE_UDINT)
    for axis in (MASTER, SLAVE):
        go(connection, until, axis, 0.0)
    yield connection
    write(connection, 0x4200 + SLAVE, 0x41)
    write(connection, FUNCTION + ID, 0x20000)


def go(nc: Any, until: Callable[..., None], axis: int, place: float) -> None:
    """Move there, tried again while the axis is not ready."""

    move = struct.pack("<IIdd", 1, 0, place, 400.0)
    until(lambda: accepts(nc, 0x4200 + axis, 0x20, move))
    until(lambda: set_position(nc, axis) == place)


def bestehorn(z: float) -> float:
    return z - sin(2.0 * pi * z) / (2.0 * pi)


def poly5(z: float) -> float:
    return 10 * z**3 - 15 * z**4 + 6 * z**5


def expected(master: float) -> float:
    """0 … 60 → 0 … 30 by Bestehorn, straight to 45 at 90, POLY5 back to 0 at 150."""
    if master <= 60.0:
        return 30.0 * bestehorn(master / 60.0)
    if master <= 90.0:
        return 30.0 + 0.5 * (master - 60.0)
    return 45.0 * (1.0 - poly5((master - 90.0) / 60.0))


def test_a_slave_keeps_the_closed_form(nc: Any, until: Callable[..., None]) -> None:
    write(nc, FUNCTION + ID, 0x10010, struct.pack("<III", 3, 4, 1))
    rows = [(12, 0.0, 0.0), (1, 60.0, 30.0), (5, 90.0, 45.0), (0, 150.0, 0.0)]
    for row, (law, master, slave) in enumerate(rows):
        data = POINT.pack(row + 1, law, 0, 1, 0, master, slave, 0.0, 0.0, 0.0)
        write(nc, TABLE + ID, 0x05000000 + row, data)
    write(nc, FUNCTION + ID, 0x30000)
    solo = struct.pack(
        "<6I4d3I4xd2I", 13, MASTER, 0, 0, ID, 0, 0.0, 0.0, 1.0, 1.0, 1, 1, 0, 0.0, 0, 0
    )
    until(lambda: accepts(nc, 0x4200 + SLAVE, 0x4A, solo))  # its move may not be over
    assert nc.read(USERS + ID, 0x0A, pyads.PLCTYPE_DINT) == 1
    for master in (13.0, 60.0, 77.5, 101.25, 150.0, 42.0):
        go(nc, until, MASTER, master)
        until(lambda master=master: abs(set_position(nc, SLAVE) - expected(master)) < 1e-9)
    with pytest.raises(pyads.ADSError) as caught:
        write(nc, FUNCTION + ID, 0x20000)
    assert caught.value.err_code == 0x4259

    # a point ahead of the master, at once: nothing jumps
    write(nc, TABLE + ID, 0x05000002, POINT.pack(3, 5, 0, 1, 0, 90.0, 35.0, 0.0, 0.0, 0.0))
    assert abs(set_position(nc, SLAVE) - expected(42.0)) < 1e-9
    go(nc, until, MASTER, 75.0)
    until(lambda: abs(set_position(nc, SLAVE) - 32.5) < 1e-9)
