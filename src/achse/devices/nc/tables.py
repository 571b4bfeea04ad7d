"""Table services, 0xA000, 0xA100 and 0xA200 + ID. Source: 002 §6.4.8.

Ids above 255 are at the group 0x000nA000 + low byte, n being id // 256.
"""

import struct
from array import array
from collections import namedtuple
from collections.abc import Callable, Iterator, Sequence
from enum import IntEnum
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.layouts import INT32, NO_DATA, REAL64, UINT32, Text, request
from achse.devices.nc.motion_functions import MOTION_FUNCTIONS
from achse.devices.nc.table_places import (
    Numbers,
    TablePlace,
    answered,
    check_column,
    check_row,
    check_whole,
)
from achse.motion import Nc
from achse.motion.states import TableSubType, TableType
from achse.motion.tables import HIGHEST_TABLE_ID, Table
from achse.motion.tables.search import Crossing
from achse.motion.tables.survey import VALUES
from achse.motion.tables.table import TableScaling
from achse.server import READ, READ_WRITE, WRITE, IndexGroup, Layout, ObjectGroup, Service

__all__ = [
    "TABLE_FUNCTIONS",
    "TABLE_PARAMETERS",
    "TABLE_STATES",
    "table_groups",
]


def _step_width(place: TablePlace) -> float:
    table = place.table
    if not table.equidistant:
        raise DeviceError(
            NcError.TABLE_FUNCTION_NOT_AVAILABLE.number, f"{table!r} has no equal steps"
        )
    return table.step_width


def _cyclic(place: TablePlace) -> Table:
    table = place.table
    if not table.cyclic:
        raise DeviceError(NcError.TABLE_FUNCTION_NOT_AVAILABLE.number, f"{table!r} is not cyclic")
    return table


def _master_period(place: TablePlace) -> float:
    with answered():
        return _cyclic(place).master_period


def _slave_stroke(place: TablePlace) -> float:
    with answered():
        return _cyclic(place).slave_stroke


def _of_numbers(place: TablePlace) -> Table:
    table = place.table
    if table.of_points:
        raise DeviceError(NcError.TABLE_WRONG_KIND.number, f"{table!r} is of points")
    return table


def _read_value(place: TablePlace) -> tuple[int, int, float]:
    """The number that was written last, as it is now: a read names none."""
    table = _of_numbers(place)
    row, column = divmod(table.last_written, table.column_count)
    return row, column, table.values[table.last_written]


def _write_value(place: TablePlace, access: tuple[int, int, float]) -> None:
    row, column, value = access
    table = _of_numbers(place)
    check_row(table, row)
    check_column(table, column)
    with answered():
        place.tables.write(table, row * table.column_count + column, [value])


def _read_rows(place: TablePlace, row: int) -> "array[float]":
    table = _of_numbers(place)
    check_row(table, row)
    return table.values[row * table.column_count :]


def _write_rows(place: TablePlace, row: int, numbers: "array[float]") -> None:
    table = _of_numbers(place)
    check_row(table, row)
    columns, most = table.column_count, table.row_count - row
    check_whole(NcError.TABLE_ACCESS_ROWS, len(numbers), columns, most, "rows")
    with answered():
        place.tables.write(table, row * columns, numbers)


def _read_columns(place: TablePlace, column: int) -> "array[float]":
    table = _of_numbers(place)
    check_column(table, column)
    numbers = array("d")
    for number in range(column, table.column_count):
        numbers += table.values[number :: table.column_count]
    return numbers


def _write_columns(place: TablePlace, column: int, numbers: "array[float]") -> None:
    table = _of_numbers(place)
    check_column(table, column)
    rows, columns = table.row_count, table.column_count
    check_whole(NcError.TABLE_ACCESS_COLUMNS, len(numbers), rows, columns - column, "columns")
    last = len(numbers) // rows - 1
    with answered():
        if last == 0:
            place.tables.write(table, column, numbers, columns)
            return
        values = table.values[:]
        for n in range(last + 1):
            values[column + n :: columns] = numbers[n * rows : (n + 1) * rows]
        place.tables.write(table, 0, values)  # all or none
        table.last_written = (rows - 1) * columns + column + last


def _value(place: TablePlace, position: float) -> float:
    with answered():
        return place.table.read(position)[0]


def _values(place: TablePlace, position: float) -> tuple[float, float, float]:
    with answered():
        return place.table.read(position)


def _creates(main_type: TableType) -> Callable[[TablePlace, tuple[int, int, int]], None]:
    def create(place: TablePlace, dimensions: tuple[int, int, int]) -> None:
        with answered():
            place.tables.create(place.table_id, main_type, *dimensions)

    return create


def _delete(place: TablePlace, _: None) -> None:
    with answered():
        place.tables.delete(place.table.table_id)


def _initialise(place: TablePlace, _: None) -> None:
    with answered():
        place.table.checked()


class _Characteristic:
    """The structure of characteristic values: 31 REAL64, zeros up to byte 376, what the table is,
    zeros up to byte 512. Where the fields behind the numbers lie is our choice: no manual says."""

    name = "REAL64[64]"
    size = 512

    def encode(self, values: Sequence[float]) -> bytes:
        *numbers, table_id, rows, columns, kind, periodic = values
        tail = int(table_id), int(rows), int(columns), int(kind), int(periodic)
        return _CHARACTERISTIC.pack(*numbers, *tail)

    def decode(self, data: bytes) -> float:
        (velocity,) = struct.unpack_from("<d", data)
        if not 0.0 <= velocity <= _FASTEST:
            raise DeviceError(
                NcError.TABLE_PARAMETER.number,
                f"master velocity {velocity:g}, expected 0..{_FASTEST:g}",
            )
        return float(velocity)


_CHARACTERISTIC = struct.Struct(f"<{VALUES}d128x3I2H120x")
_FASTEST = 1e10


class _CamKind(IntEnum):
    """Kind of a table as characteristic values show it."""

    EQUIDISTANT = 10
    MONOTONIC = 11
    MOTION_FUNCTION = 22
    CHARACTERISTIC = 23


def _kind(table: Table) -> int:
    match table.table_main_type:
        case TableType.CHARACTERISTIC:
            return _CamKind.CHARACTERISTIC
        case TableType.MOTION_FUNCTION:
            return _CamKind.MOTION_FUNCTION
    return _CamKind.EQUIDISTANT if table.equidistant else _CamKind.MONOTONIC


def _characteristic_values(place: TablePlace, velocity: float) -> tuple[float, ...]:
    table = place.table
    with answered():
        values = place.tables.characteristic_values(table, velocity)
    about = table.table_id, table.row_count, table.column_count, _kind(table), table.cyclic
    return *values, *about


def _nominal_values(place: TablePlace) -> tuple[float, ...]:
    return _characteristic_values(place, place.table.nominal_velocity)


def _set_nominal_velocity(place: TablePlace, velocity: float) -> None:
    place.table.nominal_velocity = velocity


def _scale(place: TablePlace, scaling: tuple[float, ...]) -> None:
    if max(map(abs, scaling)) > _LARGEST_SCALING:
        raise DeviceError(
            NcError.TABLE_SCALING.number, f"numbers up to {_LARGEST_SCALING:g}, got {scaling}"
        )
    with answered():
        place.tables.scale(place.table, TableScaling(*scaling))


def _search(place: TablePlace, asked: Any) -> tuple[float, ...]:
    """Both solutions of a slave position around a master position, through offsets and scalings."""
    if asked.master_scaling == 0.0 or asked.slave_scaling == 0.0:
        raise DeviceError(NcError.TABLE_SCALING.number, "scalings, expected other than 0")
    table = place.table
    value = (asked.slave_position - asked.slave_offset) / asked.slave_scaling
    start = (asked.master_start_position - asked.master_offset) / asked.master_scaling
    if max(abs(value), abs(start)) > _FARTHEST:
        raise DeviceError(NcError.TABLE_PARAMETER.number, f"positions up to {_FARTHEST:g}")
    with answered():
        found = place.tables.nearest(table, value, start)
    if asked.master_scaling < 0.0:
        found = found[::-1]
    shown = [each or Crossing(0.0, 0.0, 0.0) for each in found]
    axis = [
        0.0 if each is None else asked.master_offset + asked.master_scaling * each.position
        for each in found
    ]
    cam = [each.cam_position for each in shown]
    lift = [asked.slave_scaling * each.lift for each in shown]
    return *(each is not None for each in found), *axis, *cam, *lift


_FARTHEST = 1e12
_LARGEST_SCALING = 1e6

_ANY_START = 0x0100_0000
"""Offsets of rows and columns: the first is added."""

TABLE_PARAMETERS = (
    *MOTION_FUNCTIONS,
    Service(0x01, "table_id", READ, UINT32, "id of the table", "1", field="table.table_id"),
    Service(0x02, "table_name", READ, Text(31), "name", field="table.table_name"),
    Service(
        0x03, "table_sub_type", READ, UINT32, "distances of the places", "1",
        field="table.table_sub_type", choices=TableSubType,
    ),
    Service(
        0x04, "table_main_type", READ, UINT32, "what the table is for", "1",
        field="table.table_main_type", choices=TableType,
    ),
    Service(0x10, "row_count", READ, UINT32, "rows", "1", field="table.row_count"),
    Service(0x11, "column_count", READ, UINT32, "columns", "1", field="table.column_count"),
    Service(0x12, "element_count", READ, UINT32, "numbers", "1", field="table.element_count"),
    Service(
        0x13, "step_width", READ, REAL64, "distance of places in an equidistant table",
        read=_step_width,
    ),
    Service(
        0x14, "master_period", READ, REAL64, "from the first place to the last of a cyclic table",
        read=_master_period,
    ),
    Service(
        0x15, "slave_stroke", READ, REAL64, "from the first value to the last of a cyclic table",
        read=_slave_stroke,
    ),
    Service(
        0x20, "single_value", READ | WRITE, request(row="I", column="I", value="d"),
        "one number, row and column counted from 0; a read gives that written last",
        read=_read_value, write=_write_value,
        code=NcError.TABLE_PARAMETER.number,
    ),
    Service(
        0x21, "slave_position_at_master", READ_WRITE, REAL64,
        "value at a place, points joined by straight lines", exchange=_value, response=REAL64,
    ),
    Service(
        0x23, "slave_values_at_master", READ_WRITE, REAL64,
        "value at a place, and its first two derivatives", exchange=_values,
        response=Layout("<ddd"),
    ),
    Service(
        0x24, "master_position_at_slave", READ_WRITE,
        Layout(
            "<12d",
            namedtuple(
                "Request",
                "slave_position master_start_position slave_offset slave_scaling master_offset "
                "master_scaling master_accuracy reserved1 reserved2 reserved3 reserved4 reserved5",
            ),
        ),
        "the nearest master positions where the slave is at a position: below and above the start",
        exchange=_search, response=Layout("<2I6d40x"),
    ),
    Service(
        0x50, "characteristic_values", READ | WRITE, _Characteristic(),
        "extremes and means of the slave's motion at the master velocity that was written, else 1",
        read=_nominal_values, write=_set_nominal_velocity,
    ),
    Service(
        0x50, "characteristic_values_at_velocity", READ_WRITE, _Characteristic(),
        "the same at a master velocity, the first number of the request",
        exchange=_characteristic_values, response=_Characteristic(),
    ),
    Service(
        0x115, "set_scaling", WRITE,
        request(
            original_weight="d", master_offset="d", master_scaling="d", slave_offset="d",
            slave_scaling="d", range_low="d", range_high="d",
        ),
        "read a monotonic table by offset + scaling · number, within a range of its places",
        write=_scale,
    ),
    Service(
        _ANY_START, "rows", READ | WRITE, Numbers(), "whole rows from one on, counted from 0",
        read=_read_rows, write=_write_rows, count=_ANY_START,
    ),
    Service(
        2 * _ANY_START, "columns", READ | WRITE, Numbers(),
        "whole columns from one on, counted from 0",
        read=_read_columns, write=_write_columns, count=_ANY_START,
    ),
)  # fmt: skip

TABLE_STATES = (
    Service(
        0x0A,
        "user_count",
        READ,
        INT32,
        "drives and slaves that use the table",
        "1",
        field="user_count",
    ),
)

_DIMENSIONS = request(table_type="I", row_count="I", column_count="I")

TABLE_FUNCTIONS = (
    Service(
        0x1_0000, "create_cam_table", WRITE, _DIMENSIONS,
        "make a cam table, types 1..4: master positions, slave positions",
        write=_creates(TableType.CAMMING),
    ),
    Service(
        0x1_0010, "create_motion_function_table", WRITE, _DIMENSIONS,
        "make the table of a motion function, types 3 and 4: points and laws between them",
        write=_creates(TableType.MOTION_FUNCTION),
    ),
    Service(
        0x1_0001, "create_characteristic_table", WRITE,
        _DIMENSIONS,
        "make a table of a characteristic, types 1 and 3: velocity, output, each of the full one",
        write=_creates(TableType.CHARACTERISTIC),
    ),
    Service(0x2_0000, "delete_table", WRITE, NO_DATA, "forget the table", write=_delete),
    Service(
        0x3_0000, "initialize_table", WRITE, NO_DATA,
        "see whether the points are a function, which is done where they are used too",
        write=_initialise,
    ),
)  # fmt: skip


def table_groups(nc: Nc) -> Iterator[IndexGroup]:
    """The groups of an NC's tables; an id without table is answered 0x4016."""

    def place(table_id: int) -> TablePlace:
        return TablePlace(nc.tables, table_id)

    for base, rows in (
        (0xA000, TABLE_PARAMETERS),
        (0xA100, TABLE_STATES),
        (0xA200, TABLE_FUNCTIONS),
    ):
        yield ObjectGroup(base, HIGHEST_TABLE_ID, place, rows, kind=TablePlace)
