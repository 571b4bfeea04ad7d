"""The error of a table carries the NC's."""

from achse.codes import NcError
from achse.motion.tables.errors import TableError


def test_it_has_code_and_words() -> None:
    fault = TableError(NcError.TABLE_NOT_MONOTONIC, "table 7: row 2 is before row 1")
    assert (fault.error, str(fault)) == (0x4A06, "table 7: row 2 is before row 1")
