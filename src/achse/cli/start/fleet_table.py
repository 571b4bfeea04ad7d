"""The stations of a fleet as a table, once or live."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table

_COLUMNS = (
    "name", "NetId", "pid", "core", "state", "cycle", "late", "memory", "axes", "errors",
    "partners", "restarts",
)  # fmt: skip
NUMBERS = frozenset({2, 3, 5, 6, 7, 8, 9, 10, 11})
_BAD = {"failed", "silent", "again", "STOP", "ERROR"}
_NOTHING = "-"

Row = Mapping[str, Any]


def fleet_cells(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    """Head and cells. `cycle` is its length and the time that computing takes of it."""
    return [_COLUMNS, *map(_cells, rows)]


def _cells(row: Row) -> tuple[str, ...]:
    tick, cycle, memory = row["tick_s"], row["cycle_s"], row["memory_bytes"]
    length = _NOTHING if tick is None else f"{tick * 1e3:g} ms"
    if cycle is not None:
        length += f", {cycle * 1e6:.0f} µs"
    return (
        row["name"],
        row["net_id"],
        _or_nothing(row["pid"]),
        _or_nothing(row["core"]),
        row["state"] if row["online"] or row["state"] != "RUN" else "RUN, no broker",
        length,
        _or_nothing(row["late"]),
        _NOTHING if memory is None else f"{memory / 1e6:.0f} MB",
        _or_nothing(row["axes"]),
        _or_nothing(row["errors"]),
        _or_nothing(row["partners"]),
        str(row["restarts"]),
    )


def _or_nothing(value: Any) -> str:
    return _NOTHING if value is None else str(value)


def fleet_summary(name: str, rows: Sequence[Row]) -> str:
    """`press: 8 of 8 stations run, 96 MB, …`; memory counts each process once."""
    running = sum(row["state"] == "RUN" for row in rows)
    memory = {row["pid"]: row["memory_bytes"] for row in rows if row["memory_bytes"]}
    axes = sum(row["axes"] or 0 for row in rows)
    errors = sum(row["errors"] or 0 for row in rows)
    late = sum(row["late"] or 0 for row in rows)
    return (
        f"{name}: {running} of {len(rows)} stations run, {len(memory)} processes,"
        f" {sum(memory.values()) / 1e6:.0f} MB, {axes} axes, {errors} in error,"
        f" {late} late cycles"
    )


def fleet_table(name: str, rows: Sequence[Row]) -> "Table":
    """Return the same for a terminal, in colours."""
    from rich.table import Table
    from rich.text import Text

    table = Table(title=fleet_summary(name, rows), title_justify="left")
    for place, column in enumerate(_COLUMNS):
        table.add_column(column, justify="right" if place in NUMBERS else "left", no_wrap=True)
    for row, cells in zip(rows, map(_cells, rows), strict=True):
        bad = row["state"] in _BAD or bool(row["errors"])
        style = "red" if bad else "green" if row["state"] == "RUN" else "yellow"
        table.add_row(*(Text(cell) for cell in cells), style=style)
    return table
