"""Figures by matplotlib, which is imported when one is drawn, without pyplot and its state.

What is drawn is known by its shape alone: this is the ground, below recordings and axes.
"""

import io
import itertools
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from achse.extras import needs_extra

MOST_AREAS = 8
"""Areas above each other in a recording whose channels are not named."""

POINTS = 4000
"""Of one curve at most; of longer ones the least and the greatest of each stretch are drawn."""

_ENDINGS = ("png", "svg", "pdf")
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Colours of Okabe and Ito, which colour-blind people can distinguish too."""
_STYLES = ("-", "--", "-.", ":")
_WIDTH, _HEIGHT = 8.0, 1.8
"""Inches: of a picture, and of each of its areas."""
_VIEWS = {"xy": (0, 1), "zx": (2, 0), "yz": (1, 2)}


class PlotExtraMissing(ImportError):
    """There is nothing to draw with."""

    def __init__(self) -> None:
        super().__init__(needs_extra("drawing pictures", "plot"))


class PictureError(ValueError):
    """This cannot be drawn or written; says what was expected."""


class Recorded(Protocol):
    """Recording of a scope, as `achse.scope.data.ScopeData`."""

    @property
    def name(self) -> str: ...
    @property
    def tracks(self) -> Sequence[Any]: ...
    @property
    def trigger_time(self) -> float | None: ...
    def __getitem__(self, name: str) -> Any: ...


class Moment(Protocol):
    """A moment of an axis, as `achse.client.nc.AxisStatus`."""

    @property
    def time(self) -> float: ...
    @property
    def position(self) -> float: ...
    @property
    def set_position(self) -> float: ...
    @property
    def velocity(self) -> float: ...
    @property
    def set_velocity(self) -> float: ...
    @property
    def following_error(self) -> float: ...


class Demanded(Protocol):
    """Demand of a cam on its slave, as `achse.client.nc.TableValues`."""

    @property
    def position(self) -> float: ...
    @property
    def velocity(self) -> float: ...
    @property
    def acceleration(self) -> float: ...


class PathMoment(Protocol):
    """Position on a path, mm, and velocity there, as `achse.gcode.geometry.drawing.PathSample`."""

    @property
    def at(self) -> Any: ...
    @property
    def velocity(self) -> float: ...


class Picture:
    """A figure that a notebook shows."""

    def __init__(self, figure: Any) -> None:
        self.figure = figure
        """Figure of matplotlib, for further changes."""

    def __repr__(self) -> str:
        return f"<Picture of {len(self.figure.axes)} areas: show it in a notebook, or save it>"

    @cached_property
    def png(self) -> bytes:
        """The picture as a PNG file."""
        return self._file("png")

    @property
    def svg(self) -> str:
        return self._file("svg").decode()

    def save(self, file: str | Path) -> None:
        """Write it; the ending tells the form. Raises PictureError for others, OSError."""
        kind = Path(file).suffix.lower().removeprefix(".")
        if kind not in _ENDINGS:
            raise PictureError(f"{file}: expected a name that ends in .png, .svg or .pdf")
        Path(file).write_bytes(self._file(kind))

    def _file(self, kind: str) -> bytes:
        written = io.BytesIO()
        self.figure.savefig(written, format=kind, dpi=110)
        return written.getvalue()

    def _repr_png_(self) -> bytes:
        return self.png


def recording(data: Recorded, channels: Iterable[str] | None = None) -> Picture:
    """Channels of a recording above each other, over the time in s; a dotted line is the trigger.

    Without names the first eight. Raises KeyError for a channel that is not there, PictureError
    without any, PlotExtraMissing.
    """
    named = [channels] if isinstance(channels, str) else channels
    tracks = data.tracks[:MOST_AREAS] if named is None else [data[name] for name in named]
    figure, areas = _areas(len(tracks), "nothing was recorded: no channel")
    for track, area in zip(tracks, areas, strict=True):
        times, values = _thinned(track.time_array, track.array)
        _curve(area, times, values, 0)
        _title(area, track.channel.name, track.channel.unit)
        if data.trigger_time is not None:
            area.axvline(data.trigger_time, color="black", linestyle=":", linewidth=1.0)
    areas[-1].set_xlabel("time s")
    return Picture(figure)


def moves(samples: Iterable[Moment], unit: str = "") -> Picture:
    """Position, velocity and following error of an axis over its time in s; set points dashed.

    `samples` are those of `axis.trace(…)`, `unit` that of positions. Raises PictureError without
    any, PlotExtraMissing.
    """
    rows = list(samples)
    figure, areas = _areas(3 if rows else 0, "no sample")
    times = [row.time for row in rows]
    curves = (
        ("position", unit, [row.position for row in rows], [row.set_position for row in rows]),
        ("velocity", unit and f"{unit}/s", [row.velocity for row in rows],
         [row.set_velocity for row in rows]),
        ("following error", unit, [row.following_error for row in rows], None),
    )  # fmt: skip
    for (name, its_unit, actual, wanted), area in zip(curves, areas, strict=True):
        _curve(area, *_thinned(times, actual), 0, "actual")
        if wanted is not None:
            _curve(area, *_thinned(times, wanted), 1, "set")
            area.legend(loc="best", fontsize="small")
        _title(area, name, its_unit)
    areas[-1].set_xlabel("time s")
    return Picture(figure)


def cam(rows: Sequence[Sequence[float]], demands: Iterable[tuple[float, Demanded]] = ()) -> Picture:
    """Return a cam: the slave over the master by `rows`, as dots where they are few.

    `demands` are pairs of a master position and what `table.values` says there: with them velocity
    and acceleration are drawn too, per master. Raises PictureError without rows, PlotExtraMissing.
    """
    pairs = [(row[0], row[1]) for row in rows if len(row) >= 2]
    ordered = sorted(demands, key=lambda pair: pair[0])
    if len(pairs) != len(rows):
        raise PictureError("rows of a cam: expected a master and a slave position in each")
    figure, areas = _areas((3 if ordered else 1) if pairs else 0, "no row")
    dots = "o" if len(pairs) <= 100 else ""
    if ordered:
        names = ("position", "velocity", "acceleration")
        demanded = [
            Quantity(f"slave {name}", [getattr(each, name) for _, each in ordered])
            for name in names
        ]
        _draw(areas, [master for master, _ in ordered], demanded)
        areas[0].plot(*zip(*pairs, strict=True), "o", color=_COLOURS[1], markersize=3)
    else:
        areas[0].plot(*zip(*pairs, strict=True), "-" + dots, color=_COLOURS[0], markersize=3)
        _title(areas[0], "slave position", "")
    areas[-1].set_xlabel("master position")
    return Picture(figure)


class Quantity(NamedTuple):
    """Quantity that a cam demands of its slave: position, velocity or the like."""

    name: str
    values: Sequence[float]
    """At each master position."""
    unit: str = ""
    limits: Sequence[float] = ()
    beyond: Sequence[tuple[float, float]] = ()
    """Master positions from and to where a limit is broken."""


def cam_demands(
    masters: Sequence[float], quantities: Sequence[Quantity], title: str = ""
) -> Picture:
    """Quantities of a slave over the master position, below each other, limits in red.

    Raises PictureError without one, PlotExtraMissing.
    """
    figure, areas = _areas(len(quantities), "no quantity")
    _draw(areas, masters, quantities)
    areas[0].set_title(title)
    areas[-1].set_xlabel("master position")
    return Picture(figure)


def _draw(areas: list[Any], masters: Sequence[float], quantities: Sequence[Quantity]) -> None:
    for area, each in zip(areas, quantities, strict=True):
        _curve(area, masters, each.values, 0)
        _title(area, each.name, each.unit)
        for limit in each.limits:
            area.axhline(limit, color="red", linestyle="--", linewidth=0.8)
        for begin, end in each.beyond:
            area.axvspan(begin, end, color="red", alpha=0.2)


def path(samples: Iterable[PathMoment | Sequence[float]], view: str = "xy") -> Picture:
    """Return a path seen along an axis, in mm: `view` is xy, zx or yz.

    Of samples with a velocity (`at`, `velocity`) that is the colour, in mm/s; points (x, y, z)
    are one colour. Raises PictureError without two points or for another view, PlotExtraMissing.
    """
    if view not in _VIEWS:
        raise PictureError(f"view: expected xy, zx or yz, got {view!r}")
    across, up = _VIEWS[view]
    points: list[tuple[float, float]] = []
    speeds: list[float] = []
    for sample in samples:
        place: Any = getattr(sample, "at", sample)
        if len(place) != 3:
            raise PictureError(f"a point of a path: expected x, y and z, got {place!r:.80}")
        points.append((place[across], place[up]))
        speeds.append(getattr(sample, "velocity", 0.0))
    figure, areas = _areas(1 if len(points) > 1 else 0, "a path needs two points at least")
    figure.set_size_inches(_WIDTH, _WIDTH * 0.75)
    area = areas[0]
    if any(speeds):
        from matplotlib.collections import LineCollection

        lines = list(itertools.pairwise(points))
        drawn = LineCollection(lines, cmap="viridis", linewidths=1.5)
        drawn.set_array(speeds[1:])
        area.add_collection(drawn)
        area.autoscale()
        figure.colorbar(drawn, ax=area, label="velocity mm/s")
    else:
        area.plot(*zip(*points, strict=True), color=_COLOURS[0], linewidth=1.5)
    area.set_aspect("equal", adjustable="datalim")
    area.set_xlabel(f"{view[0]} mm")
    area.set_ylabel(f"{view[1]} mm")
    return Picture(figure)


def _areas(count: int, nothing: str) -> tuple[Any, list[Any]]:
    """Return a figure with so many areas above each other."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise PlotExtraMissing from None
    if not count:
        raise PictureError(nothing)
    figure: Any = Figure(figsize=(_WIDTH, 0.6 + _HEIGHT * count), layout="constrained")
    FigureCanvasAgg(figure)
    areas = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for area in areas:
        area.grid(visible=True, alpha=0.3)
    return figure, list(areas)


def _curve(area: Any, times: Any, values: Any, number: int, label: str | None = None) -> None:
    colour, style = _COLOURS[number % len(_COLOURS)], _STYLES[number % len(_STYLES)]
    area.plot(times, values, style, color=colour, linewidth=1.2, label=label)


def _title(area: Any, name: str, unit: str) -> None:
    """Set the title; `$` in a name of the user is a character, not a formula."""
    area.set_title(f"{name} {unit}".strip(), loc="left", fontsize="medium", parse_math=False)


def _thinned(times: Any, values: Any) -> tuple[Any, Any]:
    """Least and greatest of each stretch of a long curve; what is not finite is a gap."""
    import numpy

    xs, ys = numpy.asarray(times, float), numpy.asarray(values, float)
    ys = numpy.where(numpy.isfinite(ys), ys, numpy.nan)
    stride = -(-2 * len(ys) // POINTS)
    if stride <= 2:
        return xs, ys
    starts = numpy.arange(0, len(ys), stride)
    low, high = numpy.fmin.reduceat(ys, starts), numpy.fmax.reduceat(ys, starts)
    return numpy.repeat(xs[starts], 2), numpy.column_stack((low, high)).ravel()
