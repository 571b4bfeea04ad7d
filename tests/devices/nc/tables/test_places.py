"""Places of tables: whole rows and columns of numbers, and refusals that carry the NC's code."""

from array import array

import pytest

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.codes.nc.choices import TableType
from achse.devices.nc.tables.places import (
    Numbers,
    TablePlace,
    answered,
    check_column,
    check_row,
    check_whole,
)
from achse.motion.tables import TableError, Tables


def test_a_place_without_table_says_so_by_its_code() -> None:
    tables = Tables(lambda: ())
    place = TablePlace(tables, 7)
    with pytest.raises(DeviceError) as caught:
        _ = place.table
    assert caught.value.code == NcError.TABLE_ID.number
    result = tables.create(7, TableType.CAMMING, 3, 2, 2)
    assert place.table is result
    assert place.user_count == 0


def test_refusals_of_tables_are_answers() -> None:
    with pytest.raises(DeviceError, match="no such thing") as caught, answered():
        raise TableError(NcError.TABLE_NOT_MONOTONIC, "no such thing")
    assert caught.value.code == 0x4A06


def test_numbers_travel_whole() -> None:
    numbers = array("d", [1.0, -2.5])
    assert Numbers().decode(Numbers().encode(numbers)) == numbers
    with pytest.raises(DeviceError) as caught:
        Numbers().decode(bytes(9))
    assert caught.value.code == ReturnCode.INVALID_SIZE.number


def test_rows_and_columns_are_there_or_not() -> None:
    table = Tables(lambda: ()).create(7, TableType.CAMMING, 3, 3, 2)
    check_row(table, 2)
    check_column(table, 1)
    check_whole(NcError.TABLE_ACCESS_ROWS, 4, 2, 2, "rows")
    with pytest.raises(DeviceError):
        check_row(table, 3)
    with pytest.raises(DeviceError):
        check_column(table, 2)
    for count, most in ((5, 9), (0, 9), (6, 2)):
        with pytest.raises(DeviceError):
            check_whole(NcError.TABLE_ACCESS_ROWS, count, 2, most, "rows")
