"""Tables of the NC: numbers and points by id, and the curves that drives and slaves read from them.

`Tables` has them all, `Table` is one of them, `memory` is where cams lie for the kernel.
"""

from achse.motion.tables.errors import TableError
from achse.motion.tables.store import Tables
from achse.motion.tables.table import (
    HIGHEST_TABLE_ID,
    MOTION_POINT,
    Table,
    TableParameters,
)
from achse.motion.tables.users import TableUser

__all__ = [
    "HIGHEST_TABLE_ID",
    "MOTION_POINT",
    "Table",
    "TableError",
    "TableParameters",
    "TableUser",
    "Tables",
]
