"""Curves over time in a terminal: braille dots in a frame, two columns and four rows per character.

A panel shows one curve with its own scale; panels above each other share the time axis.
"""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

_DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))
"""Bit of a dot in its character, by column and row (U+2800 + bits)."""

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)


class Panel(NamedTuple):
    """A curve: its title, and a value for each moment of the plot."""

    title: str
    values: Sequence[float]


def braille(points: Iterable[tuple[float, float]], width: int, height: int) -> list[str]:
    """Return a line through `points` on a canvas of `width` x `height` characters.

    Points are in dots: x from 0 at the left to 2 * width - 1, y from 0 at the bottom to
    4 * height - 1; points outside are drawn on the border.
    """
    columns, rows = 2 * width, 4 * height
    cells = [[0] * width for _ in range(height)]
    before: tuple[float, float] | None = None
    for point in points:
        for x, y in _line(before or point, point):
            column = min(max(x, 0), columns - 1)
            row = rows - 1 - min(max(y, 0), rows - 1)
            cells[row // 4][column // 2] |= _DOTS[column % 2][row % 4]
        before = point
    return ["".join(chr(0x2800 + bits) if bits else " " for bits in line) for line in cells]


def _line(begin: tuple[float, float], end: tuple[float, float]) -> Iterable[tuple[int, int]]:
    (x0, y0), (x1, y1) = begin, end
    steps = max(1, math.ceil(max(abs(x1 - x0), abs(y1 - y0))))
    for n in range(steps + 1):
        part = n / steps
        yield math.floor(x0 + part * (x1 - x0) + 0.5), math.floor(y0 + part * (y1 - y0) + 0.5)


def ticks(low: float, high: float, most: int) -> list[float]:
    """At most `most` (2 or more) round numbers with equal steps.

    The range between first and last holds `low` and `high`, give or take 1 % of it: an overshoot
    that nobody sees costs no scale. A single value gets some room around it.
    """
    if not high - low > 1e-9 * max(abs(low), abs(high), 1e-9):
        half = max(abs(low) * 1e-3, 0.5)
        low, high = low - half, high + half
    slack = 0.01 * (high - low)
    rough = (high - low) / (most - 1)
    power = 10.0 ** math.floor(math.log10(rough))
    while True:
        for factor in _STEPS:
            step = factor * power
            first, last = math.floor((low + slack) / step), math.ceil((high - slack) / step)
            if last - first < most:
                return [n * step for n in range(first, last + 1)]
        power *= 10.0


def plot(
    times: Sequence[float],
    panels: Sequence[Panel],
    *,
    width: int = 72,
    height: int = 9,
    unit: str = "s",
) -> list[str]:
    """Lines of text: each panel `height` lines high below its title, then the axis of times (or of
    whatever it is, in `unit`).

    `width` counts everything. Without two moments there is nothing to show.
    """
    if len(times) < 2 or not times[-1] > times[0]:
        return []
    scales = [ticks(min(panel.values), max(panel.values), 1 + height // 2) for panel in panels]
    labels = [_labels(scale) for scale in scales]
    margin = max(len(label) for texts in labels for label in texts)
    inner = max(10, width - margin - 2)
    begin, end = times[0], times[-1]
    across = (2 * inner - 1) / (end - begin)
    lines: list[str] = []
    for panel, scale, texts in zip(panels, scales, labels, strict=True):
        up = (4 * height - 1) / (scale[-1] - scale[0])
        points = (
            ((time - begin) * across, (value - scale[0]) * up)
            for time, value in zip(times, panel.values, strict=True)
        )
        at = {
            height - 1 - math.floor((tick - scale[0]) * up + 0.5) // 4: text
            for tick, text in zip(scale, texts, strict=True)
        }
        lines.append(f"{'':{margin}} {panel.title}")
        for row, curve in enumerate(braille(points, inner, height)):
            label = at.get(row)
            frame = f"{'':{margin}} │" if label is None else f"{label:>{margin}} ┤"
            lines.append((frame + curve).rstrip())
    return lines + _time_axis(begin, end, margin, inner, unit)


def _labels(scale: Sequence[float]) -> list[str]:
    """Return the numbers of a scale with as many decimals as its step needs."""
    step = scale[1] - scale[0]
    decimals = next(
        (n for n in range(12) if abs(step * 10**n - round(step * 10**n)) < 1e-6 * step * 10**n),
        12,
    )
    return [f"{tick + 0.0:.{decimals}f}" for tick in scale]


def _time_axis(begin: float, end: float, margin: int, inner: int, unit: str) -> list[str]:
    inside = [
        tick for tick in ticks(begin, end, max(3, inner // 8)) if begin <= tick <= end + 1e-12
    ]
    axis = ["─"] * inner
    text = [" "] * (inner + margin)
    for tick, label in zip(inside, _labels(inside) if len(inside) > 1 else [], strict=False):
        column = math.floor((tick - begin) / (end - begin) * (2 * inner - 1) + 0.5) // 2
        axis[column] = "┬"
        place = margin + 2 + column - len(label) // 2
        if place + len(label) <= len(text):  # the unit comes behind
            text[place : place + len(label)] = label
    return [f"{'':{margin}} └{''.join(axis)}", f"{''.join(text).rstrip()} {unit}"]
