"""Rows with their behaviour: a row that names no value is an error."""

import pytest

from achse.codes.nc.table import named_rows
from achse.devices.nc.rows import shown


def test_row_without_a_field_is_an_error() -> None:
    with pytest.raises(ValueError, match="no such field"):
        shown(named_rows(0x4000)["axis_id"]._replace(name="nowhere"))
