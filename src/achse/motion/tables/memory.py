"""Cams in memory: numbers that the plain kernel and machine code read alike.

A cam is a block: `HEADER` numbers that say what it is, and behind them spans of `SPAN` numbers,
one for each row: place, value, and the coefficients of the cubic that leads to the next row. The
last span is constant: its value is that at the end. A block of another form (`FORM`) has spans as
it likes; readers go by its form.

Blocks stay where they are while they are in use; free ones are used again.

Kernel source: `cam_values` and `row_at` are compiled as they stand, see `achse.motion.compiled`.
"""

from array import array
from collections.abc import Collection, Sequence
from math import floor

from achse.motion.laws.element import ELEMENT, element_at, element_values

FORM = 0
"""0: cubics, as described here; `ELEMENTS`."""
ELEMENTS = 1
"""Form of a motion function: COUNT elements of `achse.motion.laws.element` behind the header."""
COUNT = 1
"""Spans, as many as the table has rows."""
BEGIN = 2
"""First master position."""
PERIOD = 3
"""From the first master position to the last."""
STROKE = 4
"""From the first slave position to the last: the lift of a cyclic cam."""
CYCLIC = 5
"""1: it goes on to both sides."""
STEP = 6
"""Distance of places where all are equal: spans are found by it. 0: they differ."""
RATE = 7
"""1 / STEP."""

HEADER = 8
SPAN = 5

_FIRST_BLOCK = HEADER
"""No block begins at 0: a layer without cam has 0."""

_ROOM = 1024
"""Numbers that there is room for at first."""


def row_at(cams: Sequence[float], first: int, near: int, place: float) -> int:
    """Number of the span that holds at a place, for cubics; `near` is where to look first.

    What it costs does not depend on how many rows there are, unless the place is far from `near`.
    """
    count = floor(cams[first + COUNT])
    step = cams[first + STEP]
    rows = first + HEADER
    if step > 0.0:
        ahead = (place - cams[first + BEGIN]) * cams[first + RATE]
        near = count - 1
        if ahead < near:
            near = floor(ahead) if ahead > 0.0 else 0
        # by a rounding it may be the neighbour
        if near > 0 and cams[rows + SPAN * near] > place:
            near -= 1
        elif near < count - 1 and cams[rows + SPAN * (near + 1)] <= place:
            near += 1
        return near
    if near >= count or near < 0:
        near = 0
    if cams[rows + SPAN * near] <= place:
        if near == count - 1 or place < cams[rows + SPAN * (near + 1)]:
            return near
        if near == count - 2 or place < cams[rows + SPAN * (near + 2)]:
            return near + 1
    elif near > 0 and cams[rows + SPAN * (near - 1)] <= place:
        return near - 1
    low = 0
    high = count
    while high - low > 1:
        middle = (low + high) // 2
        if cams[rows + SPAN * middle] <= place:
            low = middle
        else:
            high = middle
    return low


def cam_values(
    cams: Sequence[float], first: int, near: int, place: float
) -> tuple[float, float, float, float, int]:
    """Value at a place within the cam, its three derivatives, the number of the span.

    Outside a linear cam the value of the nearest end; derivatives are 0 there.
    """
    if cams[first + FORM] == ELEMENTS:
        number = element_at(cams, first + HEADER, floor(cams[first + COUNT]), near, place)
        s, v, a, j = element_values(cams, first + HEADER + ELEMENT * number, place)
        return s, v, a, j, number
    row = row_at(cams, first, near, place)
    at = first + HEADER + SPAN * row
    way = place - cams[at]
    if way < 0.0:
        return cams[at + 1], 0.0, 0.0, 0.0, row
    slope, square, cube = cams[at + 2], cams[at + 3], cams[at + 4]
    return (
        cams[at + 1] + way * (slope + way * (square + way * cube)),
        slope + way * (2.0 * square + 3.0 * way * cube),
        2.0 * square + 6.0 * way * cube,
        6.0 * cube,
        row,
    )


class CamMemory:
    """All blocks: `numbers` is what kernels read. Its address changes only as it grows."""

    def __init__(self) -> None:
        self.numbers = array("d", [0.0]) * _ROOM
        self._blocks: dict[int, int] = {}
        """Size of each block in use, by where it begins."""

    @property
    def arguments(self) -> tuple[int, int]:
        """Address and number, as machine code takes a row of numbers."""
        return self.numbers.buffer_info()

    def take(self, size: int) -> int:
        """Return the begin of a block of this many numbers; its content is undefined."""
        begin = _FIRST_BLOCK
        for taken in sorted(self._blocks):
            if taken - begin >= size:
                break
            begin = taken + self._blocks[taken]
        missing = begin + size - len(self.numbers)
        if missing > 0:
            self.numbers.extend(array("d", [0.0]) * max(missing, len(self.numbers)))
        self._blocks[begin] = size
        return begin

    def keep(self, blocks: Collection[int]) -> None:
        """Free all other blocks."""
        self._blocks = {begin: self._blocks[begin] for begin in blocks}
