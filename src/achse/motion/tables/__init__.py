"""Tables of the NC: numbers and points by id, and the curves that drives and slaves read from them.

`Tables` (`store`) has them all, `Table` is one of them. `checking` and `errors` refuse a table,
`joining` puts curves between rows, `block` writes a table into `memory`, where the kernel reads
it. `function` has motion functions, `survey` the characteristic values of cams, `search` master
positions of slave positions, `users` the axes that use a table, `characteristics` the curves of
drives. `text` reads files, `limits` bounds the size of tables from clients.
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
