"""Curves: points joined by polynomials, span after span, in memory that the kernel reads.

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
class CurveSpan:
    """A polynomial of the way from where it begins; the last span of a curve is constant."""

    begin: float = 0.0
    value: float = 0.0
    slope: float = 0.0
    square: float = 0.0
    cube: float = 0.0


_HALVINGS = 50
"""Steps of a search within a span: to the last bits of a place."""

LAYOUT = lay_out("span", [CurveSpan], Slot)
"""One span in memory."""


def span_at(spans: Sequence[CurveSpan], first: int, count: int, place: float) -> int:
    """Index of the span that holds at `place`, of the curve of `count` spans from `first` on."""
    low = first
    high = first + count
    while high - low > 1:
        middle = (low + high) // 2
        if spans[middle].begin <= place:
            low = middle
        else:
            high = middle
    return low


def value_at(spans: Sequence[CurveSpan], first: int, count: int, place: float) -> float:
    """Value of that curve."""
    span = spans[span_at(spans, first, count, place)]
    way = place - span.begin
    if way <= 0.0:
        return span.value
    return span.value + way * (span.slope + way * (span.square + way * span.cube))


def place_of(spans: Sequence[CurveSpan], first: int, count: int, value: float) -> float:
    """Place where that curve, which rises, has a value; the nearest end for one beyond."""
    low = first
    high = first + count
    while high - low > 1:
        middle = (low + high) // 2
        if spans[middle].value <= value:
            low = middle
        else:
            high = middle
    span = spans[low]
    if low == first + count - 1 or value <= span.value:
        return span.begin
    way = spans[low + 1].begin - span.begin
    if span.square == 0.0 and span.cube == 0.0:
        return span.begin + (value - span.value) / span.slope
    near = 0.0
    for _ in range(_HALVINGS):
        middle_way = 0.5 * (near + way)
        rise = middle_way * (span.slope + middle_way * (span.square + middle_way * span.cube))
        if span.value + rise <= value:
            near = middle_way
        else:
            way = middle_way
    return span.begin + near


def linear(points: Points) -> list[CurveSpan]:
    """Straight lines from point to point."""
    spans = [
        CurveSpan(x, y, slope=(y_next - y) / (x_next - x))
        for (x, y), (x_next, y_next) in pairwise(points)
    ]
    return [*spans, CurveSpan(*points[-1])]


def spline(points: Points) -> list[CurveSpan]:
    """Return the cubic spline through all points that is straight at both ends (natural)."""
    lines = linear(points)[:-1]
    widths = [x_next - x for (x, _), (x_next, _) in pairwise(points)]
    bends = _bends(widths, [line.slope for line in lines])
    spans = [
        CurveSpan(
            line.begin,
            line.value,
            slope=line.slope - width * (2.0 * bend + bend_next) / 3.0,
            square=bend,
            cube=(bend_next - bend) / (3.0 * width),
        )
        for line, width, bend, bend_next in zip(lines, widths, bends[:-1], bends[1:], strict=True)
    ]
    return [*spans, CurveSpan(*points[-1])]


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
