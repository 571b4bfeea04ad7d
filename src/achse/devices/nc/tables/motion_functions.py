"""Services of motion functions, 0xA000 + ID: points, and what they make of them (002 §6.4.8)."""

import struct
from array import array
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.table import named_rows
from achse.devices.nc.rows import bound
from achse.devices.nc.tables.places import (
    Numbers,
    TablePlace,
    answered,
    check_column,
    check_row,
    check_whole,
)
from achse.motion.tables import MOTION_POINT, Table
from achse.motion.tables.function import values_at
from achse.motion.tables.table import PointActivation

_ROWS = named_rows(0xA000)


def _of_points(place: TablePlace) -> Table:
    table = place.table
    if not table.of_points:
        raise DeviceError(NcError.TABLE_WRONG_KIND.number, f"{table!r} has no points")
    return table


class _Points:
    """Whole points of a motion function, aligned (56 bytes) or packed (52, without reserve)."""

    name = "MotionPoint[n]"
    size = None

    def encode(self, points: bytes) -> bytes:
        return points

    def decode(self, data: bytes) -> bytes:
        if data and len(data) % MOTION_POINT.size == 0:
            return data
        if data and len(data) % _PACKED_POINT.size == 0:
            points = _PACKED_POINT.iter_unpack(data)
            return b"".join(MOTION_POINT.pack(*p[:4], 0, *p[4:]) for p in points)
        raise DeviceError(
            ReturnCode.INVALID_SIZE, f"points of 56 or 52 bytes, got {len(data)} bytes"
        )


_PACKED_POINT = struct.Struct("<IHHi5d")
_POINT = MOTION_POINT.size


def _read_point_rows(place: TablePlace, row: int) -> bytes:
    table = _of_points(place)
    check_row(table, row)
    return bytes(table.motion[_POINT * row * table.column_count :])


def _write_point_rows(place: TablePlace, row: int, points: bytes) -> None:
    table = _of_points(place)
    check_row(table, row)
    columns, most = table.column_count, table.row_count - row
    check_whole(NcError.TABLE_ACCESS_ROWS, len(points) // _POINT, columns, most, "rows")
    with answered():
        place.tables.write_points(table, row * columns, points)


def _read_point_columns(place: TablePlace, column: int) -> bytes:
    table = _of_points(place)
    check_column(table, column)
    count = table.column_count
    return b"".join(
        table.motion[_POINT * (row * count + n) : _POINT * (row * count + n + 1)]
        for n in range(column, count)
        for row in range(table.row_count)
    )


def _write_point_columns(place: TablePlace, column: int, points: bytes) -> None:
    table = _of_points(place)
    check_column(table, column)
    rows, columns = table.row_count, table.column_count
    check_whole(
        NcError.TABLE_ACCESS_COLUMNS, len(points) // _POINT, rows, columns - column, "columns"
    )
    with answered():
        for n in range(len(points) // _POINT // rows):
            of_column = points[_POINT * rows * n : _POINT * rows * (n + 1)]
            place.tables.write_points(table, column + n, of_column, columns)


def _read_online_change(place: TablePlace) -> PointActivation:
    return _of_points(place).online


def _write_online_change(place: TablePlace, change: tuple[int, float, int, int]) -> None:
    with answered():
        place.tables.change_online(_of_points(place), PointActivation(*change))


def _read_point_cloud(place: TablePlace, request: Any) -> "array[float]":
    """Rows of the master position and what the mask selects, as many as the function has."""
    table = _of_points(place)
    if not request.step_width > 0.0:
        raise DeviceError(NcError.TABLE_STEP_WIDTH.number, "step width, expected above 0")
    if not 0 < request.select_mask <= _ALL_SELECTED:
        raise DeviceError(
            NcError.TABLE_PARAMETER.number, f"mask {request.select_mask:#x}, expected 1..0xF"
        )
    with answered():
        elements = table.function()
        places = table.places()
    numbers = array("d")
    for n in range(_MOST_ROWS):
        master = request.start_position + n * request.step_width
        if master > places[-1] and n:
            break
        numbers.append(master)
        for bit, value in enumerate(values_at(elements, master)):
            if request.select_mask >> bit & 1:
                numbers.append(value)
    return numbers


_ALL_SELECTED = 0xF
"""Position, velocity, acceleration, jerk."""
_MOST_ROWS = 4096
"""Rows of one answer; a client requests further rows from there on."""


MOTION_FUNCTIONS = (
    bound(_ROWS["online_change_activation"], read=_read_online_change, write=_write_online_change),
    bound(_ROWS["motion_function_points"], exchange=_read_point_cloud, response=Numbers()),
    bound(
        _ROWS["motion_function_rows"],
        codec=_Points(),
        read=_read_point_rows,
        write=_write_point_rows,
    ),
    bound(
        _ROWS["motion_function_columns"],
        codec=_Points(),
        read=_read_point_columns,
        write=_write_point_columns,
    ),
)
