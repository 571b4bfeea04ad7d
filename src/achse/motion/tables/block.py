"""One table as a block of `memory`: its rows joined, or the elements of its points."""

from array import array

from achse.motion.laws.element import ELEMENT
from achse.motion.states import CamInterpolation
from achse.motion.tables.joining import JOINING, Boundary, join
from achse.motion.tables.memory import (
    BEGIN,
    COUNT,
    CYCLIC,
    ELEMENTS,
    FORM,
    HEADER,
    PERIOD,
    RATE,
    SPAN,
    STEP,
    STROKE,
)
from achse.motion.tables.table import Table

WORTH_MACHINE_CODE = 1000
"""Rows that the plain way takes some ms for."""

LEAST_ROWS = {
    CamInterpolation.FOUR_POINTS: 4,
    CamInterpolation.SPLINE: 3,
    CamInterpolation.LOCAL: 3,
}
"""Of the others 2."""

_REACH = 3
"""Rows on either side that a changed one changes the local cubics of."""


def block_size(table: Table) -> int:
    """Return numbers of its block."""
    if table.of_points:
        return HEADER + len(table.function())
    return HEADER + SPAN * table.row_count


def write_block(
    table: Table, interpolation: int, numbers: "array[float]", begin: int, low: int, high: int
) -> None:
    """Write the block of a table from `numbers[begin]` on; rows `low` … `high` - 1 have changed.

    Raises TableError if the table is not a function.
    """
    places, values = table.checked()
    rows = table.row_count
    numbers[begin : begin + HEADER] = array("d", HEADER * [0.0])
    numbers[begin + COUNT] = rows
    numbers[begin + BEGIN] = places[0]
    numbers[begin + PERIOD] = places[-1] - places[0]
    numbers[begin + STROKE] = values[-1] - values[0]
    numbers[begin + CYCLIC] = table.cyclic
    if table.of_points:
        elements = table.function()
        numbers[begin + FORM] = ELEMENTS
        numbers[begin + COUNT] = len(elements) // ELEMENT
        numbers[begin + HEADER : begin + HEADER + len(elements)] = elements
        return
    if table.equidistant:
        numbers[begin + STEP] = (places[-1] - places[0]) / (rows - 1)
        numbers[begin + RATE] = 1.0 / numbers[begin + STEP]
    low, high = low - _REACH, high + _REACH
    if low <= 0 or high >= rows:
        low, high = 0, rows
    boundary, begin_slope, end_slope = table.boundary
    if boundary == Boundary.BY_TYPE:
        boundary = Boundary.PERIODIC if table.cyclic else Boundary.SLOPES
    rest = begin, interpolation, boundary.value, begin_slope, end_slope, low, high
    if rows >= WORTH_MACHINE_CODE and JOINING.available:
        addresses = (each.buffer_info() for each in (places, values, numbers))
        JOINING.function(*(part for address in addresses for part in address), *rest)
    else:
        join(places, values, numbers, *rest)
