"""Joining: cubics through the rows of a cam table, by every interpolation there is.

Straight lines; the parabola-like cubic through four rows; one spline through all rows (its bends
follow from all of them); local cubics whose slopes follow from neighbours, so that a changed row
changes four spans. The spline's ends are as `Boundary` says: a cyclic table goes on with the same
slope and bend, a linear one begins and ends with slope 0, because the slave rests outside it.

Kernel source: `join` is compiled as it stands where machine code is at hand; both write the same.
"""

from collections.abc import MutableSequence, Sequence
from enum import IntEnum

from achse.motion.tables.memory import HEADER, SPAN
from achse.native.compiled import Kernel


class Boundary(IntEnum):
    """Boundary condition of the spline of a cam table."""

    BY_TYPE = 0
    """Periodic in a cyclic table, slopes of 0 in a linear one."""
    NATURAL = 1
    """No bend."""
    SLOPES = 2
    """Slopes that are given."""
    PERIODIC = 3
    """The slope and the bend of the other end."""


LINES = 0
FOUR_ROWS = 1
SPLINE = 2
LOCAL = 3
"""As `CamInterpolation`."""


def join(
    places: Sequence[float],
    values: Sequence[float],
    cams: MutableSequence[float],
    first: int,
    method: int,
    boundary: int,
    begin_slope: float,
    end_slope: float,
    low: int,
    high: int,
) -> None:
    """Write the spans `low` … `high` - 1 of the block at `first`; a spline writes all.

    There are as many places as values, rising. A spline takes three, four rows take four.
    """
    rows = first + HEADER
    last = len(places) - 1
    begin = 0 if method == SPLINE else low
    end = last + 1 if method == SPLINE else high
    for i in range(begin, end):
        at = rows + SPAN * i
        cams[at] = places[i]
        cams[at + 1] = values[i]
        cams[at + 2] = 0.0
        cams[at + 3] = 0.0
        cams[at + 4] = 0.0
    if method == SPLINE:
        if boundary == Boundary.PERIODIC:
            _periodic(cams, rows, last)
        else:
            _open(cams, rows, last, boundary, begin_slope, end_slope)
        return
    for i in range(begin, min(end, last)):
        at = rows + SPAN * i
        if method == LINES:
            cams[at + 2] = (values[i + 1] - values[i]) / (places[i + 1] - places[i])
        elif method == FOUR_ROWS:
            _four_rows(places, values, cams, at, i)
        else:
            _local(places, values, cams, at, i, boundary)


def _chord(cams: Sequence[float], rows: int, i: int) -> float:
    """Slope of the straight line from row i to the next."""
    at = rows + SPAN * i
    return (cams[at + SPAN + 1] - cams[at + 1]) / (cams[at + SPAN] - cams[at])


def _width(cams: Sequence[float], rows: int, i: int) -> float:
    """From row i to the next."""
    at = rows + SPAN * i
    return cams[at + SPAN] - cams[at]


def _from_bends(cams: MutableSequence[float], rows: int, last: int, bend_at_end: float) -> None:
    """Compute slopes and cubes from half the second derivatives, which are in the squares."""
    for i in range(last):
        at = rows + SPAN * i
        width = cams[at + SPAN] - cams[at]
        bend = cams[at + 3]
        following = cams[at + SPAN + 3] if i < last - 1 else bend_at_end
        cams[at + 2] = (cams[at + SPAN + 1] - cams[at + 1]) / width - width * (
            2.0 * bend + following
        ) / 3.0
        cams[at + 4] = (following - bend) / (3.0 * width)
    at = rows + SPAN * last
    cams[at + 2] = 0.0
    cams[at + 3] = 0.0
    cams[at + 4] = 0.0


def _open(
    cams: MutableSequence[float],
    rows: int,
    last: int,
    boundary: int,
    begin_slope: float,
    end_slope: float,
) -> None:
    """Compute a spline with ends of its own, by elimination from the first row on: cubes hold the
    ratios."""
    natural = boundary == Boundary.NATURAL
    ratio = 0.0
    part = 0.0
    if not natural:
        width = _width(cams, rows, 0)
        ratio = 0.5
        part = 1.5 * (_chord(cams, rows, 0) - begin_slope) / width
    cams[rows + 3] = part
    cams[rows + 4] = ratio
    for i in range(1, last):
        before = _width(cams, rows, i - 1)
        after = _width(cams, rows, i)
        pivot = 2.0 * (before + after) - before * ratio
        ratio = after / pivot
        rise = 3.0 * (_chord(cams, rows, i) - _chord(cams, rows, i - 1))
        part = (rise - before * part) / pivot
        at = rows + SPAN * i
        cams[at + 3] = part
        cams[at + 4] = ratio
    bend = 0.0
    if not natural:
        width = _width(cams, rows, last - 1)
        rise = 3.0 * (end_slope - _chord(cams, rows, last - 1))
        bend = (rise - width * part) / (2.0 * width - width * ratio)
    bend_at_end = bend
    for n in range(last):
        at = rows + SPAN * (last - 1 - n)
        bend = cams[at + 3] - cams[at + 4] * bend
        cams[at + 3] = bend
    _from_bends(cams, rows, last, bend_at_end)


def _periodic(cams: MutableSequence[float], rows: int, last: int) -> None:
    """Compute a spline whose ends meet: bends are p + b·q with b the bend at the first row.

    Squares hold p, slopes q, cubes the ratios of the elimination.
    """
    first_width = _width(cams, rows, 0)
    last_width = _width(cams, rows, last - 1)
    ratio = 0.0
    part = 0.0
    share = 0.0
    for i in range(1, last):
        before = _width(cams, rows, i - 1)
        after = _width(cams, rows, i)
        pivot = 2.0 * (before + after) - before * ratio
        rise = 3.0 * (_chord(cams, rows, i) - _chord(cams, rows, i - 1))
        from_begin = 0.0
        if i == 1:
            from_begin -= first_width
        if i == last - 1:
            from_begin -= last_width
        part = (rise - before * part) / pivot
        share = (from_begin - before * share) / pivot
        ratio = after / pivot
        at = rows + SPAN * i
        cams[at + 2] = share
        cams[at + 3] = part
        cams[at + 4] = ratio
    part = 0.0
    share = 0.0
    for n in range(1, last):
        at = rows + SPAN * (last - n)
        part = cams[at + 3] - cams[at + 4] * part
        share = cams[at + 2] - cams[at + 4] * share
        cams[at + 3] = part
        cams[at + 2] = share
    at = rows + SPAN * (last - 1)
    rise = 3.0 * (_chord(cams, rows, 0) - _chord(cams, rows, last - 1))
    bend = (rise - last_width * cams[at + 3] - first_width * part) / (
        2.0 * (last_width + first_width) + last_width * cams[at + 2] + first_width * share
    )
    cams[rows + 3] = bend
    for i in range(1, last):
        at = rows + SPAN * i
        cams[at + 3] += bend * cams[at + 2]
    _from_bends(cams, rows, last, bend)


def _slope(places: Sequence[float], values: Sequence[float], i: int, periodic: bool) -> float:
    """Slope at row i of the parabola through it and its neighbours (Bessel)."""
    last = len(places) - 1
    middle = min(max(i, 1), last - 1)
    left = places[middle] - places[middle - 1]
    right = places[middle + 1] - places[middle]
    rise = values[middle] - values[middle - 1]
    rise_after = values[middle + 1] - values[middle]
    if i == middle:
        return (rise / left * right + rise_after / right * left) / (left + right)
    if periodic:
        left = places[last] - places[last - 1]
        right = places[1] - places[0]
        rise = values[last] - values[last - 1]
        rise_after = values[1] - values[0]
        return (rise / left * right + rise_after / right * left) / (left + right)
    bend = (rise_after / right - rise / left) / (left + right)
    if i < middle:
        return rise / left - left * bend
    return rise_after / right + right * bend


def _local(
    places: Sequence[float],
    values: Sequence[float],
    cams: MutableSequence[float],
    at: int,
    i: int,
    boundary: int,
) -> None:
    """Compute a cubic by the values and slopes of both its rows (Hermite)."""
    periodic = boundary == Boundary.PERIODIC
    width = places[i + 1] - places[i]
    chord = (values[i + 1] - values[i]) / width
    slope = _slope(places, values, i, periodic)
    following = _slope(places, values, i + 1, periodic)
    cams[at + 2] = slope
    cams[at + 3] = (3.0 * chord - 2.0 * slope - following) / width
    cams[at + 4] = (slope + following - 2.0 * chord) / (width * width)


def _four_rows(
    places: Sequence[float],
    values: Sequence[float],
    cams: MutableSequence[float],
    at: int,
    i: int,
) -> None:
    """Compute a cubic through the four nearest rows (Newton's form, counted from row i)."""
    n = min(max(i - 1, 0), len(places) - 4)
    begin = places[i]
    a, b, c = places[n] - begin, places[n + 1] - begin, places[n + 2] - begin
    d = places[n + 3] - begin
    ab = (values[n + 1] - values[n]) / (b - a)
    bc = (values[n + 2] - values[n + 1]) / (c - b)
    cd = (values[n + 3] - values[n + 2]) / (d - c)
    abc = (bc - ab) / (c - a)
    bcd = (cd - bc) / (d - b)
    cube = (bcd - abc) / (d - a)
    # f(w) = value + ab (w - a) + abc (w - a)(w - b) + cube (w - a)(w - b)(w - c), by powers of w
    cams[at + 2] = ab - abc * (a + b) + cube * (a * b + a * c + b * c)
    cams[at + 3] = abc - cube * (a + b + c)
    cams[at + 4] = cube


JOINING = Kernel("joining", join, {})
"""`join` as machine code, for tables of many rows."""
