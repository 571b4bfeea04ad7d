"""The path of a part program as SVG, seen along an axis or from a corner of the room.

Without velocities: programmed moves, rapid ones dashed. With samples of a run: the velocity as
colour, from blue (slow) to red (the greatest).
"""

from collections.abc import Iterable, Sequence
from colorsys import hls_to_rgb
from dataclasses import dataclass
from html import escape
from math import ceil, cos, floor, log10, pi, radians, sin

from achse.gcode.canon import LineMove, Moving
from achse.gcode.vectors import PathPoint

VIEWS = ("xy", "zx", "yz", "iso")
"""The plane that is looked at; `iso` looks from a corner."""
WIDTH = 900.0
"""Pixels, of height too at most."""
_MARGIN = 40.0
_NARROWEST = 620.0
"""Title, colours and bar have room then."""
_STEP = radians(3.0)
"""Angle between two points of an arc."""
_COLOURS = 24
_TILT = radians(30.0)


@dataclass(frozen=True, slots=True)
class PathSample:
    """Position and velocity on the path at one moment."""

    at: PathPoint
    velocity: float
    """mm/s."""


_Flat = tuple[float, float]


def _flat(point: PathPoint, view: str) -> _Flat:
    x, y, z = point
    if view == "xy":
        return (x, y)
    if view == "zx":
        return (z, x)
    if view == "yz":
        return (y, z)
    return ((x - y) * cos(_TILT), (x + y) * sin(_TILT) + z)


def _points(move: Moving, view: str) -> list[_Flat]:
    if isinstance(move, LineMove):
        return [_flat(move.start, view), _flat(move.end, view)]
    count = max(2, ceil(move.angle / _STEP))
    return [_flat(move.at(step / count), view) for step in range(count + 1)]


class _Sheet:
    """Scale and lines of a picture."""

    def __init__(self, points: Iterable[_Flat]) -> None:
        xs, ys = [0.0], [0.0]
        for x, y in points:
            xs.append(x)
            ys.append(y)
        self.left, self.top = min(xs), max(ys)
        self.right, self.bottom = max(xs), min(ys)
        width, height = max(xs) - self.left, self.top - min(ys)
        self.scale = (WIDTH - 2 * _MARGIN) / (max(width, height) or 1.0)
        self.width = max(width * self.scale + 2 * _MARGIN, _NARROWEST)
        self.height = height * self.scale + 2 * _MARGIN
        self.lines: list[str] = []

    def place(self, point: _Flat) -> str:
        x = (point[0] - self.left) * self.scale + _MARGIN
        y = (self.top - point[1]) * self.scale + _MARGIN
        return f"{x:.2f},{y:.2f}"

    def polyline(self, points: Sequence[_Flat], style: str) -> None:
        text = " ".join(map(self.place, points))
        self.lines.append(f'<polyline points="{text}" {style}/>')

    def text(self, x: float, y: float, words: str) -> None:
        self.lines.append(f'<text x="{x:.1f}" y="{y:.1f}">{escape(words)}</text>')

    def _bar(self) -> None:
        """Draw a length to compare with, at the bottom right: 1, 2 or 5 of a power of ten, mm."""
        least = 60.0 / self.scale
        power = 10.0 ** floor(log10(least))
        length = power * next(each for each in (1.0, 2.0, 5.0, 10.0) if each * power >= least)
        end, y = self.width - _MARGIN, self.height - 10.0
        begin = end - length * self.scale
        bar = f"M{begin:.1f} {y - 4:.1f}v8m0 -4H{end:.1f}m0 -4v8"
        self.lines.append(f'<path d="{bar}" stroke="#222"/>')
        self.lines.append(
            f'<text x="{begin - 6:.1f}" y="{y + 4:.1f}" text-anchor="end">{length:g} mm</text>'
        )

    def svg(self, title: str, view: str) -> str:
        names = "from a corner"
        cross = self.place((0.0, 0.0)).split(",")
        x, y = float(cross[0]), float(cross[1])
        origin = f'<path d="M{x - 6:.2f} {y:.2f}h12M{x:.2f} {y - 6:.2f}v12" stroke="#888"/>'
        if view != "iso":
            first, second = view[0].upper(), view[1].upper()
            names = (
                f"{first} {self.left:.6g} … {self.right:.6g},"
                f" {second} {self.bottom:.6g} … {self.top:.6g} mm"
            )
        self.text(_MARGIN, 22.0, f"{title}: {names}" if title else names)
        self._bar()
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width:.0f}'
            f' {self.height:.0f}" width="{self.width:.0f}" height="{self.height:.0f}"'
            ' font-family="sans-serif" font-size="13" fill="none" stroke-linejoin="round">\n'
            '<rect width="100%" height="100%" fill="#fff"/>\n<g fill="#222" stroke="none">\n'
            + "\n".join(line for line in self.lines if line.startswith("<text"))
            + f"\n</g>\n{origin}\n"
            + "\n".join(line for line in self.lines if not line.startswith("<text"))
            + "\n</svg>\n"
        )


def draw_moves(moves: Sequence[Moving], *, view: str = "xy", title: str = "") -> str:
    """Return the programmed path: one colour, rapid moves dashed; arcs as chords of 3 degrees."""
    drawn = [(_points(move, view), move.rapid) for move in moves]
    sheet = _Sheet(point for points, _ in drawn for point in points)
    run: list[_Flat] = []
    before = False
    for points, rapid in drawn:
        if run and rapid is before and run[-1] == points[0]:
            run += points[1:]
            continue
        _stroke(sheet, run, before)
        run, before = list(points), rapid
    _stroke(sheet, run, before)
    return sheet.svg(title, view)


def _stroke(sheet: _Sheet, points: list[_Flat], rapid: bool) -> None:
    if points:
        dashed = 'stroke="#999" stroke-dasharray="5 4"'
        sheet.polyline(points, dashed if rapid else 'stroke="#1565c0" stroke-width="1.6"')


def draw_velocities(samples: Sequence[PathSample], *, view: str = "xy", title: str = "") -> str:
    """Return the path that was run, its velocity as colour, with a scale."""
    flat = [_flat(sample.at, view) for sample in samples]
    sheet = _Sheet(flat)
    top = max((sample.velocity for sample in samples), default=0.0)
    step = top / _COLOURS or 1.0
    levels = [min(int(sample.velocity / step), _COLOURS - 1) for sample in samples]
    begin = 0
    for at in range(1, len(flat)):
        if at + 1 < len(flat) and levels[at + 1] == levels[begin + 1]:
            continue
        style = f'stroke="{_colour(levels[min(begin + 1, at)])}" stroke-width="2"'
        sheet.polyline(flat[begin : at + 1], style)
        begin = at
    for level in range(_COLOURS):
        x = _MARGIN + level * 8
        y = sheet.height - 14
        sheet.lines.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="8" height="8" fill="{_colour(level)}"/>'
        )
    sheet.text(_MARGIN + _COLOURS * 8 + 8, sheet.height - 6, f"0 to {top:.4g} mm/s")
    return sheet.svg(title, view)


def _colour(level: int) -> str:
    """As #rrggbb, which every program that draws SVG knows."""
    share = level / (_COLOURS - 1)
    shades = hls_to_rgb((1.0 - share) * 2.0 / 3.0, 0.45 + 0.05 * sin(pi * share), 0.85)
    return "#" + "".join(f"{round(255 * shade):02x}" for shade in shades)
