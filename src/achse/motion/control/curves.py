"""Curves: points joined by polynomials, piece behind piece, in memory that the kernel reads.

`linear` and `spline` join points, `value_at` and `place_of` read. Places outside the points have
the value of the nearest.

Kernel source: `value_at` and `place_of` are compiled as they stand, see `compiled`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

from achse.native.declare import Slot, lay_out

Points: TypeAlias = Sequence[tuple[float, float]]
"""Places, strictly rising, and the value at each; two at least, a spline takes three."""


@dataclass(frozen=True)
class Piece:
    """A polynomial of the way from where it begins; the last piece of a curve is constant."""

    begin: float = 0.0
    value: float = 0.0
    slope: float = 0.0
    square: float = 0.0
    cube: float = 0.0


_HALVINGS = 50
"""Steps of a search within a piece: to the last bits of a place."""

LAYOUT = lay_out("piece", [Piece], Slot)
"""One piece in memory."""


def piece_at(pieces: Sequence[Piece], first: int, count: int, place: float) -> int:
    """Index of the piece that holds at `place`, of the curve of `count` pieces from `first` on."""
    low = first
    high = first + count
    while high - low > 1:
        middle = (low + high) // 2
        if pieces[middle].begin <= place:
            low = middle
        else:
            high = middle
    return low


def value_at(pieces: Sequence[Piece], first: int, count: int, place: float) -> float:
    """Value of that curve."""
    piece = pieces[piece_at(pieces, first, count, place)]
    way = place - piece.begin
    if way <= 0.0:
        return piece.value
    return piece.value + way * (piece.slope + way * (piece.square + way * piece.cube))


def place_of(pieces: Sequence[Piece], first: int, count: int, value: float) -> float:
    """Place where that curve, which rises, has a value; the nearest end for one beyond."""
    low = first
    high = first + count
    while high - low > 1:
        middle = (low + high) // 2
        if pieces[middle].value <= value:
            low = middle
        else:
            high = middle
    piece = pieces[low]
    if low == first + count - 1 or value <= piece.value:
        return piece.begin
    way = pieces[low + 1].begin - piece.begin
    if piece.square == 0.0 and piece.cube == 0.0:
        return piece.begin + (value - piece.value) / piece.slope
    near = 0.0
    for _ in range(_HALVINGS):
        middle_way = 0.5 * (near + way)
        rise = middle_way * (piece.slope + middle_way * (piece.square + middle_way * piece.cube))
        if piece.value + rise <= value:
            near = middle_way
        else:
            way = middle_way
    return piece.begin + near


def linear(points: Points) -> list[Piece]:
    """Straight lines from point to point."""
    pieces = [
        Piece(x, y, slope=(y_next - y) / (x_next - x))
        for (x, y), (x_next, y_next) in pairwise(points)
    ]
    return [*pieces, Piece(*points[-1])]


def spline(points: Points) -> list[Piece]:
    """The cubic spline through all points that is straight at both ends (natural)."""
    lines = linear(points)[:-1]
    widths = [x_next - x for (x, _), (x_next, _) in pairwise(points)]
    bends = _bends(widths, [line.slope for line in lines])
    pieces = [
        Piece(
            line.begin,
            line.value,
            slope=line.slope - width * (2.0 * bend + bend_next) / 3.0,
            square=bend,
            cube=(bend_next - bend) / (3.0 * width),
        )
        for line, width, bend, bend_next in zip(lines, widths, bends[:-1], bends[1:], strict=True)
    ]
    return [*pieces, Piece(*points[-1])]


def _bends(widths: Sequence[float], slopes: Sequence[float]) -> list[float]:
    """Half the second derivative at each point: slopes and bends of neighbours meet there."""
    ratios, parts = [0.0], [0.0]  # what elimination leaves of each equation, from the first on
    for i in range(1, len(widths)):
        before, after = widths[i - 1], widths[i]
        pivot = 2.0 * (before + after) - before * ratios[-1]
        ratios.append(after / pivot)
        parts.append((3.0 * (slopes[i] - slopes[i - 1]) - before * parts[-1]) / pivot)
    bends = [0.0]
    for ratio, part in zip(reversed(ratios), reversed(parts), strict=True):
        bends.append(part - ratio * bends[-1])
    return bends[::-1]
