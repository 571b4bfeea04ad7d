"""Cutter compensation: the path of the cutter's centre, to the left or right of the contour.

Each element is moved aside by the radius. At an outer corner an arc about the corner joins the
neighbours; at an inner one they end where they cross. The selecting line ends beside its own end;
before an inner corner, beside the begin of the next element. The last element before G40 ends
beside its own end. Elements are therefore delayed until the next one is known, with bottleneck
detection until so many behind it are known (channel parameter 0x51).
Source: tcnci, cutter radius compensation, bottleneck detection; corners are our choice, as
LinuxCNC does it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from math import atan2, cos, hypot, pi, sin, sqrt

from achse.codes import NcError
from achse.gcode.canon import BottleneckNotice, Canonical, Origin, PathPlane
from achse.gcode.errors import WordRefused
from achse.gcode.geometry.arcs import PlanePoint
from achse.gcode.geometry.contour import ContourElement
from achse.gcode.vectors import PathPoint

_NEAR = 1e-9
"""mm, and sine of an angle: below it two things are the same."""


class BottleneckMode(IntEnum):
    """Channel parameter 0x50: what happens when the cutter does not fit."""

    ABORT = 0
    REPAIR = 1
    NOTICE = 2


@dataclass(slots=True)
class Bottleneck:
    """Detection of places that are too narrow; `active` is CDON."""

    active: bool = False
    mode: BottleneckMode = BottleneckMode.ABORT
    look_ahead: int = 1
    """Elements that are looked at together, 1..24 (channel parameter 0x51)."""


class _Beside:
    """An element moved aside: a line from `start` by `way`, or an arc about `centre`.

    Places on it are lengths `u` from the untrimmed start; it runs from `begin` to `finish`.
    """

    __slots__ = (
        "begin", "centre", "corner", "element", "entry", "finish", "full", "radius",
        "sense", "start", "way",
    )  # fmt: skip

    def __init__(self, element: ContourElement) -> None:
        self.element = element
        self.start: PlanePoint = (0.0, 0.0)
        self.way: PlanePoint = (1.0, 0.0)
        self.centre: PlanePoint = (0.0, 0.0)
        self.radius = 0.0
        self.sense = 0.0
        """1 for a counter-clockwise arc, -1 for a clockwise one, 0 for a line."""
        self.full = 0.0
        """Untrimmed length."""
        self.begin = 0.0
        self.finish = 0.0
        self.entry = False
        self.corner = False

    def at(self, place: float) -> PlanePoint:
        """Return the point at this length."""
        if not self.sense:
            return (self.start[0] + place * self.way[0], self.start[1] + place * self.way[1])
        angle = self.sense * place / self.radius
        x, y = self.start[0] - self.centre[0], self.start[1] - self.centre[1]
        c, s = cos(angle), sin(angle)
        return (self.centre[0] + x * c - y * s, self.centre[1] + x * s + y * c)

    def place(self, point: PlanePoint) -> float:
        """Return the length at which the point is; arcs prefer what is near to their middle."""
        x, y = point[0] - self.start[0], point[1] - self.start[1]
        if not self.sense:
            return x * self.way[0] + y * self.way[1]
        a, b = self.start[0] - self.centre[0], self.start[1] - self.centre[1]
        c, d = point[0] - self.centre[0], point[1] - self.centre[1]
        angle = self.sense * atan2(a * d - b * c, a * c + b * d)
        middle = self.full / self.radius / 2.0
        if angle < middle - pi:
            angle += 2.0 * pi
        elif angle > middle + pi:
            angle -= 2.0 * pi
        return angle * self.radius

    def tangent(self, place: float) -> PlanePoint:
        """Direction at this length, a unit vector."""
        if not self.sense:
            return self.way
        x, y = self.at(place)
        return (
            -self.sense * (y - self.centre[1]) / self.radius,
            self.sense * (x - self.centre[0]) / self.radius,
        )

    @property
    def reversed(self) -> bool:
        """True if nothing of the element is left: it ends before it begins."""
        return self.finish < self.begin - _NEAR


class CutterCompensation:
    """Takes the elements of a contour and gives those of the cutter's centre."""

    def __init__(
        self,
        radius: float,
        left: bool,
        plane: PathPlane,
        feed_mode: str,
        bottleneck: Bottleneck,
    ) -> None:
        self.radius = radius
        self.side = 1.0 if left else -1.0
        self.first, self.second, self.third = plane.axes
        self.feed_mode = feed_mode
        self.bottleneck = bottleneck
        self.pending: list[_Beside | ContourElement | Canonical] = []
        """In the order of the path: moved elements, moves of other axes, other commands."""
        self.at: PlanePoint | None = None
        """Position of the cutter's centre after all elements passed on."""
        self.moved = False
        """True if an element came behind the selecting line."""

    @property
    def delayed_origin(self) -> Origin | None:
        """First block whose move is delayed."""
        for item in self.pending:
            if isinstance(item, _Beside):
                return item.element.facts.origin
            if isinstance(item, ContourElement):
                return item.facts.origin
        return None

    def other(self, command: Canonical) -> Iterator[ContourElement | Canonical]:
        """A command other than a move keeps its place."""
        if self._last() is None:
            yield command
        else:
            self.pending.append(command)

    def feed(self, element: ContourElement) -> Iterator[ContourElement | Canonical]:
        """Yield the next element of the contour; gives those that are final now."""
        last = self._last()
        way = hypot(
            element.end[self.first] - element.start[self.first],
            element.end[self.second] - element.start[self.second],
        )
        if element.normal is None and way <= _NEAR:
            if last is None:
                raise WordRefused(
                    NcError.TOOL_COMPENSATION_GEOMETRY,
                    "the line that selects G41 or G42 has to move the axes of the plane",
                )
            self.pending.append(element)
            return
        beside = self._beside(element)
        if last is None:
            if element.normal is not None:
                raise WordRefused(
                    NcError.TOOL_COMPENSATION_GEOMETRY,
                    "G41 and G42 are selected with a line (G00, G01), not with an arc",
                )
            self._enter(beside)
        else:
            self.moved = True
            yield from self._join(last, beside)
        self.pending.append(beside)
        yield from self._release()

    def finish(self) -> Iterator[ContourElement | Canonical]:
        """Yield the end of the contour: all delayed elements."""
        yield from self._check(None)
        yield from self._release(everything=True)

    # corners

    def _enter(self, line: _Beside) -> None:
        """Start the selecting line where the cutter is; it ends beside its own end."""
        begin = self._plane(line.element.start)
        end = line.at(line.full)
        x, y = end[0] - begin[0], end[1] - begin[1]
        length = hypot(x, y)
        line.start, line.full, line.finish = begin, length, length
        line.way = (x / length, y / length) if length > _NEAR else line.way
        line.entry = True

    def _join(self, last: _Beside, following: _Beside) -> Iterator[ContourElement | Canonical]:
        corner = self._plane(following.element.start)
        a = self._contour_tangent(last, at_end=True)
        b = self._contour_tangent(following, at_end=False)
        turn = self.side * (a[0] * b[1] - a[1] * b[0])
        ahead = a[0] * b[0] + a[1] * b[1]
        if abs(turn) <= _NEAR and ahead > 0.0:
            if last.entry:
                self._aim(last, following.at(0.0))
        elif turn < 0.0 or abs(turn) <= _NEAR:
            self.pending.append(self._corner(last, following, corner, turn, ahead))
        elif last.entry:
            self._aim(last, following.at(0.0))
        else:
            yield from self._cross(last, following, corner)

    @staticmethod
    def _aim(line: _Beside, end: PlanePoint) -> None:
        """Let the selecting line end here."""
        x, y = end[0] - line.start[0], end[1] - line.start[1]
        length = hypot(x, y)
        line.full = line.finish = length
        if length > _NEAR:
            line.way = (x / length, y / length)

    def _corner(
        self, last: _Beside, following: _Beside, corner: PlanePoint, turn: float, ahead: float
    ) -> _Beside:
        """Return the arc about an outer corner."""
        facts = last.element.facts
        arc = _Beside(ContourElement(facts, last.element.end, last.element.end))
        arc.centre, arc.radius, arc.sense = corner, self.radius, -self.side
        arc.start = last.at(last.finish)
        angle = atan2(-turn, ahead) if abs(turn) > _NEAR else pi
        arc.full = arc.finish = angle * self.radius
        arc.corner = True
        return arc

    def _cross(
        self, last: _Beside, following: _Beside, corner: PlanePoint
    ) -> Iterator[ContourElement | Canonical]:
        """Yield an inner corner: both end where they cross."""
        while True:
            points = _crossings(last, following)
            if points:
                nearest = min(points, key=lambda at: hypot(at[0] - corner[0], at[1] - corner[1]))
                finish, begin = last.place(nearest), following.place(nearest)
                fits = finish >= last.begin - _NEAR and begin <= following.full + _NEAR
                if fits or not self.bottleneck.active:
                    if not fits and (last.sense or following.sense):
                        raise self._narrow("the cutter does not fit between these elements")
                    last.finish, following.begin = finish, begin
                    return
            elif not self.bottleneck.active:
                raise WordRefused(
                    NcError.TOOL_COMPENSATION_NOT_COMPUTABLE,
                    "the elements beside the contour do not cross: the cutter is too large",
                )
            yield self._notice(last)
            if self.bottleneck.mode is BottleneckMode.NOTICE:
                if points:
                    following.begin = min(following.place(nearest), following.full)
                last.finish = max(last.begin, min(last.finish, last.full))
                self._bridge(last, following)
                return
            before = self._drop(last)
            if before is None:
                raise self._narrow("nothing of the contour is left beside this element")
            last = before
            if last.entry:
                self._aim(last, following.at(following.begin))
                return

    def _bridge(self, last: _Beside, following: _Beside) -> None:
        """Add a straight line to the next element, damage and all, with a notice only."""
        begin, end = last.at(last.finish), following.at(following.begin)
        length = hypot(end[0] - begin[0], end[1] - begin[1])
        if length <= _NEAR:
            return
        facts = last.element.facts
        line = _Beside(ContourElement(facts, last.element.end, last.element.end))
        line.start, line.full, line.finish = begin, length, length
        line.way = ((end[0] - begin[0]) / length, (end[1] - begin[1]) / length)
        line.corner = True
        self.pending.append(line)

    def _drop(self, last: _Beside) -> _Beside | None:
        """Leave out an element that does not fit; what is before it, if it is still pending."""
        self.pending.remove(last)
        before = self._last()
        while before is not None and before.corner:
            self.pending.remove(before)
            before = self._last()
        if before is not None:
            before.finish = before.full
        return before

    def _notice(self, at: _Beside) -> BottleneckNotice:
        if self.bottleneck.mode is BottleneckMode.ABORT:
            raise self._narrow("the contour is too narrow for the cutter")
        return BottleneckNotice(
            at.element.facts.origin, self.bottleneck.mode is BottleneckMode.REPAIR
        )

    @staticmethod
    def _narrow(message: str) -> WordRefused:
        return WordRefused(NcError.TOOL_COMPENSATION_BOTTLENECK, message)

    def _check(self, following: _Beside | None) -> Iterator[ContourElement | Canonical]:
        """Detect bottlenecks: intersections of the last final element with an element before its
        neighbour."""
        if not self.bottleneck.active:
            return
        final = [item for item in self.pending if isinstance(item, _Beside)]
        if following is None and final:
            candidates, newest = final[:-2], final[-1]
        elif len(final) > 2:
            candidates, newest = final[:-3], final[-2]
        else:
            return
        for older in candidates:
            if older.entry:
                continue
            for point in _crossings(older, newest):
                a, b = older.place(point), newest.place(point)
                inside = older.begin + _NEAR < a < older.finish - _NEAR
                if inside and newest.begin + _NEAR < b < newest.finish - _NEAR:
                    yield self._notice(newest)
                    if self.bottleneck.mode is BottleneckMode.REPAIR:
                        older.finish, newest.begin = a, b
                        first, last = self.pending.index(older), self.pending.index(newest)
                        self.pending[first + 1 : last] = [
                            item
                            for item in self.pending[first + 1 : last]
                            if not isinstance(item, _Beside)
                        ]
                    return

    # what comes out

    def _release(self, everything: bool = False) -> Iterator[ContourElement | Canonical]:
        """Yield the final elements in their order; `look_ahead` elements stay with detection, else
        one."""
        if not everything:
            yield from self._check(self._last())
        keep = 0
        if not everything:
            keep = max(self.bottleneck.look_ahead, 1) + 1 if self.bottleneck.active else 1
        count = sum(isinstance(item, _Beside) for item in self.pending)
        while self.pending:
            item = self.pending[0]
            if isinstance(item, _Beside):
                if count <= keep:
                    return
                count -= 1
                del self.pending[0]
                yield self._final(item)
            elif isinstance(item, ContourElement):
                del self.pending[0]
                yield self._upright(item)
            else:
                del self.pending[0]
                yield item

    def _final(self, beside: _Beside) -> ContourElement:
        """The element between its trimmed ends."""
        element = beside.element
        begin, end = beside.at(beside.begin), beside.at(beside.finish)
        height = element.end[self.third]
        low = height if beside.corner else element.start[self.third]
        start = self._point(self.at or begin, low)
        self.at = end
        moved = ContourElement(element.facts, start, self._point(end, height))
        if beside.sense:
            normal = [0.0, 0.0, 0.0]
            normal[self.third] = beside.sense
            moved.normal = (normal[0], normal[1], normal[2])
            moved.centre = self._point(beside.centre, low)
            moved.angle = max(beside.finish - beside.begin, 0.0) / beside.radius
            moved.rise = beside.sense * (height - low)
            if not beside.corner:
                moved.scale = self._feed_scale(element, beside)
            if moved.angle <= 0.0:
                moved.normal = None
        return moved

    def _feed_scale(self, element: ContourElement, beside: _Beside) -> float:
        """CFC keeps the feed at the contour, CFIN only where the cutter would be too quick."""
        contour = hypot(
            element.start[self.first] - element.centre[self.first],
            element.start[self.second] - element.centre[self.second],
        )
        scale = beside.radius / contour
        if self.feed_mode == "CFTCP" or (self.feed_mode == "CFIN" and scale > 1.0):
            return 1.0
        return scale

    def _upright(self, element: ContourElement) -> ContourElement:
        """Return a move of the infeed axis or auxiliary axes, where the cutter is."""
        at = self.at or self._plane(element.start)
        return ContourElement(
            element.facts,
            self._point(at, element.start[self.third]),
            self._point(at, element.end[self.third]),
        )

    # geometry

    def _last(self) -> _Beside | None:
        for item in reversed(self.pending):
            if isinstance(item, _Beside):
                return item
        return None

    def _plane(self, point: PathPoint) -> PlanePoint:
        return (point[self.first], point[self.second])

    def _point(self, at: PlanePoint, height: float) -> PathPoint:
        values = [0.0, 0.0, 0.0]
        values[self.first], values[self.second], values[self.third] = at[0], at[1], height
        return (values[0], values[1], values[2])

    def _contour_tangent(self, beside: _Beside, at_end: bool) -> PlanePoint:
        """Direction of the programmed element at one of its ends."""
        element = beside.element
        if beside.entry:
            x, y = (
                b - a
                for a, b in zip(self._plane(element.start), self._plane(element.end), strict=True)
            )
            length = hypot(x, y)
            return (x / length, y / length)
        return beside.tangent(beside.full if at_end else 0.0)

    def _beside(self, element: ContourElement) -> _Beside:
        """Return the element moved aside, untrimmed."""
        beside = _Beside(element)
        start, end = self._plane(element.start), self._plane(element.end)
        offset = self.side * self.radius
        if element.normal is None:
            x, y = end[0] - start[0], end[1] - start[1]
            length = hypot(x, y)
            beside.way = (x / length, y / length)
            beside.start = (start[0] - offset * y / length, start[1] + offset * x / length)
            beside.full = beside.finish = length
            return beside
        if abs(element.normal[self.third]) != 1.0:
            raise WordRefused(
                NcError.TOOL_COMPENSATION_GEOMETRY, "an arc in space cannot be compensated", "CIP"
            )
        if element.angle >= 2.0 * pi:
            raise WordRefused(
                NcError.TOOL_COMPENSATION_GEOMETRY,
                "a full circle cannot be compensated: write two half circles",
            )
        sense = element.normal[self.third]
        centre = self._plane(element.centre)
        x, y = start[0] - centre[0], start[1] - centre[1]
        radius = hypot(x, y)
        moved = radius - sense * offset
        if moved <= _NEAR:
            raise WordRefused(
                NcError.TOOL_COMPENSATION_INNER_CIRCLE,
                f"the cutter's radius {self.radius:g} mm does not fit into an arc of {radius:g} mm",
            )
        beside.sense, beside.centre, beside.radius = sense, centre, moved
        beside.start = (centre[0] + x * moved / radius, centre[1] + y * moved / radius)
        beside.full = beside.finish = element.angle * moved
        return beside


def _crossings(a: _Beside, b: _Beside) -> list[PlanePoint]:
    """Return the intersections of two elements, both extended without end."""
    if not a.sense and not b.sense:
        turn = a.way[0] * b.way[1] - a.way[1] * b.way[0]
        if abs(turn) <= _NEAR:
            return []
        x, y = b.start[0] - a.start[0], b.start[1] - a.start[1]
        return [a.at((x * b.way[1] - y * b.way[0]) / turn)]
    if not a.sense or not b.sense:
        line, arc = (a, b) if not a.sense else (b, a)
        x, y = arc.centre[0] - line.start[0], arc.centre[1] - line.start[1]
        foot = x * line.way[0] + y * line.way[1]
        off = x * line.way[1] - y * line.way[0]
        square = arc.radius * arc.radius - off * off
        if square < -_NEAR * arc.radius:
            return []
        half = sqrt(max(square, 0.0))
        return [line.at(foot - half), line.at(foot + half)]
    x, y = b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]
    between = hypot(x, y)
    if between <= _NEAR:
        return []
    along = (between * between + a.radius * a.radius - b.radius * b.radius) / (2.0 * between)
    square = a.radius * a.radius - along * along
    if square < -_NEAR * a.radius:
        return []
    half = sqrt(max(square, 0.0))
    u, v = x / between, y / between
    px, py = a.centre[0] + along * u, a.centre[1] + along * v
    return [(px - half * v, py + half * u), (px + half * v, py - half * u)]
