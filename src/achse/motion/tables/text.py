"""Tables as text: a line for each row, numbers with commas, semicolons, tabs or blanks between.

A cam has master and slave positions. A motion function has a line with names, or more columns:
master, slave, law, velocity, acceleration, jerk, type; those at the end may be missing. Lines that
begin with `#` and empty ones do not count. Where semicolons or tabs divide, a comma is a decimal
one.

The ASCII form of 004 §3.1.5 has the numbers of rows and columns in its first line, with blanks or
tabs between. Such a line is known by its two whole numbers, without sign or point, if as many rows
follow as the first one says, or if it is not a row: what follows has other columns, or does not
rise from it.
"""

import re
from math import isfinite

from achse.motion.tables.function import MotionPoint

NAMES = ("master", "slave", "law", "velocity", "acceleration", "jerk", "type")

TableContent = list[tuple[float, float]] | list[MotionPoint]
"""Rows of a cam, or points of a motion function."""

_REST_TO_REST = 5
"""The law of points for which none is given."""

_WORDS = range(1 << 16)

_SIZES = re.compile(r"(\d{1,9})[ \t]+(\d{1,9})")

_Row = tuple[int, list[float]]
"""Number of the line, and what it has."""


class TableTextError(ValueError):
    """A text is not a table: `line` says where, 0 for all of it."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(f"line {line}: {message}" if line else message)
        self.line = line
        self.message = message


def content_of(text: str) -> TableContent:
    """Return the rows of a cam, or the points of a motion function. Raises TableTextError."""
    lines = [
        (number, stripped)
        for number, line in enumerate(text.splitlines(), 1)
        if (stripped := line.strip()) and not stripped.startswith("#")
    ]
    names: list[str] | None = None
    if lines and lines[0][1][0].isalpha():
        names = _names(*lines.pop(0))
    sizes = _SIZES.fullmatch(lines[0][1]) if lines and names is None else None
    rows = [(number, _numbers(number, line)) for number, line in lines]
    if sizes and int(sizes[1]) > 1:
        rows = _without_sizes(rows, int(sizes[1]), int(sizes[2]))
    if len(rows) < 2:
        raise TableTextError(0, f"expected 2 rows or more, got {len(rows)}")
    columns = names or NAMES[: len(rows[0][1])]
    for number, row in rows:
        if len(row) != len(columns) or len(row) < 2:
            expected = len(columns) if len(columns) > 1 else 2
            raise TableTextError(number, f"expected {expected} numbers, got {len(row)}")
    if len(columns) == 2:
        place, value = columns.index("master"), columns.index("slave")
        return [(row[place], row[value]) for _, row in rows]
    return [_point(number, dict(zip(columns, row, strict=True))) for number, row in rows]


def _divided(line: str) -> list[str]:
    """Return the words of a line."""
    if ";" in line or "\t" in line:
        line = line.replace(",", ".")
        words = re.split(r"\s*[;\t]\s*", line)
    else:
        words = re.split(r"\s*,\s*|\s+", line)
    while len(words) > 1 and not words[-1]:
        words.pop()
    return words


def _names(number: int, line: str) -> list[str]:
    names = [word.lower() for word in _divided(line)]
    if not set(NAMES[:2]) <= set(names) <= set(NAMES) or len(set(names)) < len(names):
        raise TableTextError(number, f"expected columns of {', '.join(NAMES)}, got {line!r:.60}")
    return names


def _numbers(number: int, line: str) -> list[float]:
    try:
        numbers = [float(word) for word in _divided(line)]
    except ValueError:
        numbers = []
    # Python's floats know underscores, infinities and nan
    if not numbers or "_" in line or not all(map(isfinite, numbers)):
        raise TableTextError(number, f"expected numbers, got {line!r:.60}")
    if len(numbers) > len(NAMES):
        raise TableTextError(
            number, f"expected 2 numbers, or up to {len(NAMES)}, got {len(numbers)}"
        )
    return numbers


def _without_sizes(rows: list[_Row], count: int, columns: int) -> list[_Row]:
    """Return the rows behind a first line that may be one of sizes."""
    number, first = rows[0]
    others = rows[1:]
    if len(others) != count:
        if others and len(others[0][1]) == len(first) and others[0][1][0] > first[0]:
            return rows
        raise TableTextError(number, f"expected {count} rows as it says, got {len(others)}")
    for place, row in others:
        if len(row) != columns:
            raise TableTextError(place, f"expected {columns} numbers, got {len(row)}")
    return others


def _point(number: int, fields: dict[str, float]) -> MotionPoint:
    words = fields.get("law", float(_REST_TO_REST)), fields.get("type", 0.0)
    for name, word in zip(("law", "type"), words, strict=True):
        if word not in _WORDS:
            raise TableTextError(number, f"{name} {word:g}, expected 0..{_WORDS[-1]}")
    return MotionPoint(
        function_type=int(words[0]),
        point_type=int(words[1]),
        master_position=fields["master"],
        slave_position=fields["slave"],
        slave_velocity=fields.get("velocity", 0.0),
        slave_acceleration=fields.get("acceleration", 0.0),
        slave_jerk=fields.get("jerk", 0.0),
    )


def text_of(content: TableContent) -> str:
    """Return the text of a table: names, then a line for each row, exactly as the numbers are."""
    rows = [_row(each) for each in content]
    lines = [",".join(map(repr, row)) for row in rows]
    return "\n".join([",".join(NAMES[: len(rows[0]) if rows else 2]), *lines, ""])


def _row(row: MotionPoint | tuple[float, float]) -> tuple[float, ...]:
    if not isinstance(row, MotionPoint):
        return row
    return (
        *(row.master_position, row.slave_position, row.function_type),
        *(row.slave_velocity, row.slave_acceleration, row.slave_jerk, row.point_type),
    )
