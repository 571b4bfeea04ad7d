"""Motion of a slave under a table: its curve, limits that it breaks, pictures of both."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from achse.cli.axes.table_files import Content
from achse.cli.failure import fail
from achse.cli.plot import Panel, plot
from achse.client.nc import FunctionPoint
from achse.codes.nc.choices import TableType
from achse.motion.states import CamInterpolation
from achse.motion.tables import MOTION_POINT, TableError, Tables
from achse.motion.tables.memory import BEGIN, PERIOD, cam_values
from achse.plot.figures import PictureError, PlotExtraMissing, Quantity, cam_demands

if TYPE_CHECKING:
    from rich.text import Text

QUANTITIES = ("position", "velocity", "acceleration", "jerk")
_UNITS = ("", "/s", "/s²", "/s³")
_SAMPLES = 720
_TABLE = 1
_LEAST, _GREATEST = (12, 14, 16, 18), (21, 23, 25, 27)
"""Positions of the extremes in the characteristic values."""


@dataclass(frozen=True)
class SlaveLimits:
    """Limits of the slave; None: not checked. Jerk and acceleration are limited in both
    directions."""

    min_position: float | None = None
    max_position: float | None = None
    max_velocity: float | None = None
    max_acceleration: float | None = None
    max_jerk: float | None = None

    def of(self, quantity: int) -> tuple[float | None, float | None]:
        """Least and greatest value of position, velocity, acceleration, jerk."""
        if quantity == 0:
            return self.min_position, self.max_position
        most = (self.max_velocity, self.max_acceleration, self.max_jerk)[quantity - 1]
        return None if most is None else -most, most


@dataclass(frozen=True)
class Violation:
    """A limit that a table breaks."""

    quantity: str
    value: float
    limit: float
    spans: list[tuple[float, float]]
    """Master positions from and to, as far as samples show it."""


@dataclass(frozen=True)
class Curve:
    """A table at a master velocity: samples, and the exact extremes of each quantity."""

    master: list[float]
    values: list[list[float]]
    """Position, velocity, acceleration, jerk."""
    extremes: list[tuple[float, float]]
    master_velocity: float

    def violations(self, limits: SlaveLimits) -> list[Violation]:
        """Return each limit that is broken, by how much, and where."""
        violations = []
        for quantity, name in enumerate(QUANTITIES):
            low, high = limits.of(quantity)
            least, most = self.extremes[quantity]
            for limit, value, sign in ((low, least, -1.0), (high, most, 1.0)):
                slack = 1e-9 * max(1.0, abs(limit or 0.0))
                if limit is not None and sign * (value - limit) > slack:
                    spans = self._spans(quantity, limit, sign)
                    violations.append(Violation(name, value, limit, spans))
        return violations

    def _spans(self, quantity: int, limit: float, sign: float) -> list[tuple[float, float]]:
        spans: list[tuple[float, float]] = []
        beyond = False
        for place, value in zip(self.master, self.values[quantity], strict=True):
            if sign * (value - limit) > 0.0:
                begin = spans.pop()[0] if beyond else place
                spans.append((begin, place))
                beyond = True
            else:
                beyond = False
        return spans

    def text(self, limits: SlaveLimits, unit: str, width: int) -> "Text":
        """Return the picture for a terminal; what breaks a limit is red."""
        from rich.text import Text

        panels = []
        broken = {each.quantity for each in self.violations(limits)}
        for quantity, name in enumerate(QUANTITIES):
            title = f"{name} {unit}{_UNITS[quantity]}".rstrip()
            if name in broken:
                title += "  beyond its limit"
            panels.append(Panel(title, self.values[quantity]))
        lines = plot(self.master, panels, width=width, height=6, unit="master")
        text = Text("\n".join(lines), no_wrap=True)
        text.highlight_regex(r"[│┤└─┬]+", "dim")
        text.highlight_regex(r"[⠁-⣿]+", "cyan")
        text.highlight_regex(r"beyond its limit", "bold red")
        return text

    def save(self, file: Path, limits: SlaveLimits, unit: str, title: str) -> None:
        """Write the picture as SVG, PNG or PDF, by the ending of the file."""
        broken = self.violations(limits)
        quantities = [
            Quantity(
                name,
                values,
                f"{unit}{suffix}",
                [limit for limit in limits.of(number) if limit is not None],
                [span for each in broken if each.quantity == name for span in each.spans],
            )
            for number, (name, values, suffix) in enumerate(
                zip(QUANTITIES, self.values, _UNITS, strict=True)
            )
        ]
        try:
            cam_demands(self.master, quantities, title).save(file)
        except PlotExtraMissing as missing:
            fail(str(missing), name="NOT_INSTALLED")
        except PictureError as refusal:
            fail(str(refusal), name="INVALID_FILE")
        except OSError as failure:
            fail(f"{file}: {failure.strerror}", name="CANNOT_WRITE")


def curve_of(
    content: Content, joined: CamInterpolation, cyclic: bool, master_velocity: float
) -> Curve:
    """Return the curve of rows or points as the NC joins them; ends the command where they are
    none."""
    tables = Tables(lambda: ())
    points = [each for each in content if isinstance(each, FunctionPoint)]
    kind = TableType.MOTION_FUNCTION if points else TableType.CAMMING
    try:
        table = tables.create(_TABLE, kind, 4 if cyclic else 3, len(content), 1 if points else 2)
        if points:
            tables.write_points(table, 0, _packed(points))
        else:
            tables.write(table, 0, (number for row in content for number in row[:2]))
        first = tables.cam(_TABLE, joined)
        demands = tables.characteristic_values(table, master_velocity)
    except TableError as fault:
        fail(str(fault), name=fault.error.name, code=fault.error.number)
    numbers = tables.cams.numbers
    begin, period = numbers[first + BEGIN], numbers[first + PERIOD]
    master = [begin + period * n / _SAMPLES for n in range(_SAMPLES + 1)]
    values: list[list[float]] = [[], [], [], []]
    near = -1
    for place in master:
        *slave_values, near = cam_values(numbers, first, near, place)
        for order, value in enumerate(slave_values):
            values[order].append(float(value) * master_velocity**order)
    extremes = [(demands[low], demands[high]) for low, high in zip(_LEAST, _GREATEST, strict=True)]
    return Curve(master, values, extremes, master_velocity)


def _packed(points: Sequence[FunctionPoint]) -> bytes:
    return b"".join(
        MOTION_POINT.pack(
            *(n + 1, p.law, p.point_type, 1, 0),
            *(p.master, p.slave, p.velocity, p.acceleration, p.jerk),
        )
        for n, p in enumerate(points)
    )
