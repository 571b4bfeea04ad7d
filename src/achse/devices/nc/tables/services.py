"""Table services, 0xA000, 0xA100 and 0xA200 + ID. Source: 002 §6.4.8.

Ids above 255 are at the group 0x000nA000 + low byte, n being id // 256.
"""

import struct
from array import array
from collections.abc import Callable, Iterator, Sequence
from enum import IntEnum
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.nc.choices import TableType
from achse.codes.nc.table import named_rows
from achse.devices.nc.rows import bound
from achse.devices.nc.tables.motion_functions import MOTION_FUNCTIONS
from achse.devices.nc.tables.places import (
    Numbers,
    TablePlace,
    answered,
    check_column,
    check_row,
    check_whole,
)
from achse.motion import Nc
from achse.motion.tables import HIGHEST_TABLE_ID, Table
from achse.motion.tables.search import Crossing
from achse.motion.tables.survey import VALUES
from achse.motion.tables.table import TableScaling
from achse.server import IndexGroup, ObjectGroup

_PARAMETERS = named_rows(0xA000)
_STATES = named_rows(0xA100)
_FUNCTIONS = named_rows(0xA200)


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
    """Return the number that was written last, as it is now: a read names none."""
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
    zeros up to byte 512. The fields behind the numbers are our choice, of no manual."""

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


def _search(place: TablePlace, request: Any) -> tuple[float, ...]:
    """Return both solutions of a slave position around a master position, through offsets and
    scalings."""
    if request.master_scaling == 0.0 or request.slave_scaling == 0.0:
        raise DeviceError(NcError.TABLE_SCALING.number, "scalings, expected other than 0")
    table = place.table
    value = (request.slave_position - request.slave_offset) / request.slave_scaling
    start = (request.master_start_position - request.master_offset) / request.master_scaling
    if max(abs(value), abs(start)) > _FARTHEST:
        raise DeviceError(NcError.TABLE_PARAMETER.number, f"positions up to {_FARTHEST:g}")
    with answered():
        crossings = place.tables.nearest(table, value, start)
    if request.master_scaling < 0.0:
        crossings = crossings[::-1]
    shown = [each or Crossing(0.0, 0.0, 0.0) for each in crossings]
    axis = [
        0.0 if each is None else request.master_offset + request.master_scaling * each.position
        for each in crossings
    ]
    cam = [each.cam_position for each in shown]
    lift = [request.slave_scaling * each.lift for each in shown]
    return *(each is not None for each in crossings), *axis, *cam, *lift


_FARTHEST = 1e12
_LARGEST_SCALING = 1e6


TABLE_PARAMETERS = (
    *MOTION_FUNCTIONS,
    bound(_PARAMETERS["table_id"], field="table.table_id"),
    bound(_PARAMETERS["table_name"], field="table.table_name"),
    bound(_PARAMETERS["table_sub_type"], field="table.table_sub_type"),
    bound(_PARAMETERS["table_main_type"], field="table.table_main_type"),
    bound(_PARAMETERS["row_count"], field="table.row_count"),
    bound(_PARAMETERS["column_count"], field="table.column_count"),
    bound(_PARAMETERS["element_count"], field="table.element_count"),
    bound(_PARAMETERS["step_width"], read=_step_width),
    bound(_PARAMETERS["master_period"], read=_master_period),
    bound(_PARAMETERS["slave_stroke"], read=_slave_stroke),
    bound(
        _PARAMETERS["single_value"],
        read=_read_value,
        write=_write_value,
        code=NcError.TABLE_PARAMETER.number,
    ),
    bound(_PARAMETERS["slave_position_at_master"], exchange=_value),
    bound(_PARAMETERS["slave_values_at_master"], exchange=_values),
    bound(_PARAMETERS["master_position_at_slave"], exchange=_search),
    bound(
        _PARAMETERS["characteristic_values"],
        codec=_Characteristic(),
        read=_nominal_values,
        write=_set_nominal_velocity,
    ),
    bound(
        _PARAMETERS["characteristic_values_at_velocity"],
        codec=_Characteristic(),
        exchange=_characteristic_values,
        response=_Characteristic(),
    ),
    bound(_PARAMETERS["set_scaling"], write=_scale),
    bound(_PARAMETERS["rows"], codec=Numbers(), read=_read_rows, write=_write_rows),
    bound(_PARAMETERS["columns"], codec=Numbers(), read=_read_columns, write=_write_columns),
)

TABLE_STATES = (bound(_STATES["user_count"], field="user_count"),)


TABLE_FUNCTIONS = (
    bound(_FUNCTIONS["create_cam_table"], write=_creates(TableType.CAMMING)),
    bound(_FUNCTIONS["create_motion_function_table"], write=_creates(TableType.MOTION_FUNCTION)),
    bound(_FUNCTIONS["create_characteristic_table"], write=_creates(TableType.CHARACTERISTIC)),
    bound(_FUNCTIONS["delete_table"], write=_delete),
    bound(_FUNCTIONS["initialize_table"], write=_initialise),
)


TABLE_GROUPS = (
    (0xA000, TABLE_PARAMETERS),
    (0xA100, TABLE_STATES),
    (0xA200, TABLE_FUNCTIONS),
)
"""Index group + id, rows."""


def table_groups(nc: Nc) -> Iterator[IndexGroup]:
    """Yield the groups of an NC's tables; an id without table is answered 0x4016."""

    def place(table_id: int) -> TablePlace:
        return TablePlace(nc.tables, table_id)

    for base, rows in TABLE_GROUPS:
        yield ObjectGroup(base, HIGHEST_TABLE_ID, place, rows, kind=TablePlace)
