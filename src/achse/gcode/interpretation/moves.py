"""From the words of a block to moves of the axes: positions, arcs, zero shifts, compensation."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isfinite, radians, tan

from achse.codes import NcError
from achse.gcode.canon import AUXILIARY_AXES, ArcMove, Canonical, LineMove, Moving, Origin
from achse.gcode.errors import WordRefused
from achse.gcode.geometry.arcs import (
    centre_of_radius,
    circle_in_space,
    corrected_centre,
    swept,
)
from achse.gcode.geometry.compensation import Bottleneck, CutterCompensation
from achse.gcode.geometry.contour import ContourElement, MoveFacts
from achse.gcode.geometry.frame import WorkFrame
from achse.gcode.interpretation.line_run import LineRun, read_points
from achse.gcode.state.modal import ModalState
from achse.gcode.text.program import PartProgram
from achse.gcode.vectors import PathPoint

AXIS_LETTERS = ("X", "Y", "Z")
_CENTRES = ("I", "J", "K")
_AXIS_OF = {name: axis for axis, name in enumerate(AXIS_LETTERS)}
_AUXILIARY = tuple(f"Q{number}" for number in range(1, AUXILIARY_AXES + 1))
_LIMIT = 1e12
"""mm: a position beyond is a mistake, and differences of such numbers lose microns."""


@dataclass(slots=True)
class MotionWords:
    """The words of one block that make its move; values in mm, positions as programmed."""

    values: Mapping[str, float | None]
    in_space: bool = False
    """True for CIP."""
    exact_stop: bool = False
    delete_distance: bool = False

    @property
    def moves(self) -> bool:
        """Return True if the block names an axis, or a centre."""
        return any(name in self.values for name in (*AXIS_LETTERS, *_AUXILIARY, *_CENTRES))


class PathMaker:
    """Positions of a running program. What it gives back are moves in their order."""

    def __init__(
        self,
        modal: ModalState,
        frame: WorkFrame,
        positions: PathPoint,
        auxiliary: tuple[float, ...],
        bottleneck: Bottleneck,
    ) -> None:
        self.modal = modal
        self.frame = frame
        self.axes = positions
        """Positions of the axes after all moves so far."""
        self.auxiliary = list(auxiliary)
        self.work = frame.to_work(positions)
        """The same in coordinates of the workpiece, without cutter compensation."""
        self.programmed = list(self.work)
        """The last programmed position; a bare axis letter goes there."""
        self.stale = [False, False, False]
        """Axes that a new frame has not moved yet: it does so when a block names them."""
        self.bottleneck = bottleneck
        self.compensation: CutterCompensation | None = None
        self.last_velocity = 0.0

    def set_frame(self, frame: WorkFrame) -> None:
        """Set a new frame: axes go there when a block names them. Not while the cutter is on."""
        if frame == self.frame:
            return
        if self.compensation is not None:
            raise WordRefused(
                NcError.TOOL_COMPENSATION_GEOMETRY,
                "zero shift, rotation, mirror and tool cannot change while G41 or G42 is active",
            )
        self.frame = frame
        self.work = frame.to_work(self.axes)
        for axis in range(3):
            if self.work[axis] != self.programmed[axis]:
                self.stale[axis] = True

    def rescan(self, positions: PathPoint, auxiliary: tuple[float, ...] | None) -> None:
        """Continue from where the axes are now."""
        if not all(map(isfinite, positions)) or len(positions) != 3:
            raise ValueError(f"expected three finite positions, got {positions}")
        self.axes = positions
        self.work = self.frame.to_work(positions)
        self.programmed[:] = self.work
        self.stale = [False, False, False]
        if auxiliary is not None:
            if len(auxiliary) != AUXILIARY_AXES or not all(map(isfinite, auxiliary)):
                raise ValueError(f"expected {AUXILIARY_AXES} finite positions, got {auxiliary}")
            self.auxiliary[:] = auxiliary

    def start_compensation(self, radius: float, left: bool) -> None:
        """Start G41 or G42 from the next line on."""
        self.compensation = CutterCompensation(
            radius, left, self.modal.plane, self.modal.feed_mode, self.bottleneck
        )

    @property
    def delayed_origin(self) -> Origin | None:
        """First block whose move cutter compensation delays; None without one."""
        return None if self.compensation is None else self.compensation.delayed_origin

    def end_compensation(self) -> Iterator[Canonical]:
        """G40 or the end of the program: delayed moves come out."""
        compensation, self.compensation = self.compensation, None
        if compensation is None:
            return
        yield from self._emit(compensation.finish())
        self.work = self.frame.to_work(self.axes)

    def other(self, command: Canonical) -> Iterator[Canonical]:
        """Yield a command other than a move, in its place among the delayed moves."""
        if self.compensation is None:
            yield command
        else:
            yield from self._emit(self.compensation.other(command))

    def move(self, origin: Origin, words: MotionWords, velocity: float) -> Iterator[Canonical]:
        """Yield the move of a block, or what becomes final by it. `velocity` in mm/s."""
        modal = self.modal
        values = words.values
        arc = modal.motion >= 2 or words.in_space
        target = self._target(values)
        for name, at in zip(_AUXILIARY, range(AUXILIARY_AXES), strict=True):
            value = values.get(name)
            if value is not None:
                base = self.auxiliary[at] if modal.incremental else 0.0
                self.auxiliary[at] = _position(base + value, name)
        rapid = modal.motion == 0 and not words.in_space
        if not rapid and not velocity > 0.0:
            raise WordRefused(
                NcError.NCI_VELOCITY_NOT_POSITIVE, "no feed (F) is programmed before this move"
            )
        start_velocity = velocity
        if modal.linear_feed and not rapid and self.last_velocity > 0.0:
            start_velocity = self.last_velocity
        facts = MoveFacts(
            origin,
            tuple(self.auxiliary),
            0.0 if rapid else velocity,
            0.0 if rapid else start_velocity,
            rapid,
            words.exact_stop,
            words.delete_distance,
        )
        if not rapid:
            self.last_velocity = velocity
        element = ContourElement(facts, self.work, target)
        if words.in_space:
            self._through_point(element, values)
        elif arc:
            self._arc(element, values)
        elif any(name in values for name in ("I", "J", "K", "B", "U")):
            raise WordRefused(
                NcError.PROGRAM_SYNTAX_RUNNING,
                "I, J, K, B and U belong to arcs (G02, G03, CIP)",
                next(name for name in ("I", "J", "K", "B", "U") if name in values),
            )
        self.work = target
        if self.compensation is not None:
            yield from self._emit(self.compensation.feed(element))
        else:
            yield self._moving(element)

    def bare_line(
        self, origin: Origin, values: Mapping[str, object], velocity: float
    ) -> LineMove | None:
        """Return the move of a line with numbers for X, Y, Z only; None if it has to go the long
        way.

        The same as `move`, for the state in which long programs are nearly all the time.
        """
        modal, frame = self.modal, self.frame
        if modal.motion > 1 or self.compensation is not None or not frame.is_translation:
            return None
        rapid = modal.motion == 0
        if True in self.stale or not (rapid or velocity > 0.0):
            return None
        target = list(self.programmed)
        for name, value in values.items():
            axis = _AXIS_OF[name]
            assert isinstance(value, float)
            target[axis] = target[axis] + value if modal.incremental else value
            if not -_LIMIT <= target[axis] <= _LIMIT:
                return None
        start_velocity = velocity
        if rapid:
            velocity = start_velocity = 0.0
        else:
            if modal.linear_feed and self.last_velocity > 0.0:
                start_velocity = self.last_velocity
            self.last_velocity = velocity
        start = self.axes
        x, y, z = self.programmed = target
        self.work = (x, y, z)
        (a, b, c), (d, e, f) = frame.shift, frame.tool
        self.axes = (x + a + d, y + b + e, z + c + f)
        return LineMove(
            origin,
            start,
            self.axes,
            tuple(self.auxiliary),
            velocity,
            start_velocity,
            rapid,
            modal.exact_stop,
        )

    def bare_lines(
        self, program: PartProgram, line: int, most: int, velocity: float
    ) -> LineRun | None:
        """Return the lines of a program from one on that `bare_line` would make the same moves of,
        as far as they are alike; None if there are none."""
        modal, frame = self.modal, self.frame
        line_motion = modal.motion == 1 and not (modal.exact_stop or modal.linear_feed)
        if (
            not (line_motion and velocity > 0.0 and frame.is_translation)
            or self.compensation is not None
        ):
            return None
        if True in self.stale:
            return None
        lines = program.lines[line : line + most]
        points = read_points(lines, self.programmed, modal.incremental, _LIMIT)
        if not points:
            return None
        self.last_velocity = velocity
        self.programmed[:] = self.work = points[-1]
        (a, b, c), (d, e, f) = frame.shift, frame.tool
        if any((a, b, c, d, e, f)):
            points = [(x + a + d, y + b + e, z + c + f) for x, y, z in points]
        start, self.axes = self.axes, points[-1]
        return LineRun(program, line, start, points, tuple(self.auxiliary), velocity)

    def _target(self, values: Mapping[str, float | None]) -> PathPoint:
        """Return the end of the block, in coordinates of the workpiece."""
        programmed, stale = self.programmed, self.stale
        target = list(self.work)
        if values.get("ANG") is not None:
            values = self._contour_line(values)
        for axis, name in enumerate(AXIS_LETTERS):
            if name in values:
                value = values[name]
                if value is not None:
                    base = programmed[axis] if self.modal.incremental else 0.0
                    programmed[axis] = _position(base + value, name)
                target[axis] = programmed[axis]
                stale[axis] = False
            elif not stale[axis]:
                target[axis] = programmed[axis]
        return (target[0], target[1], target[2])

    def _contour_line(self, values: Mapping[str, float | None]) -> Mapping[str, float | None]:
        """`X10 ANG=30`: the missing coordinate, from the angle to the plane's first axis."""
        first, second, _ = self.modal.plane.axes
        names = AXIS_LETTERS[first], AXIS_LETTERS[second]
        angle = values["ANG"]
        programmed = [name for name in names if values.get(name) is not None]
        if self.modal.motion > 1 or len(programmed) != 1 or angle is None:
            raise WordRefused(
                NcError.PROGRAM_SYNTAX_RUNNING,
                f"ANG needs a line (G00, G01) and one of {names[0]} and {names[1]}",
                "ANG",
            )
        at = names.index(programmed[0])
        known, missing = (first, second) if at == 0 else (second, first)
        value = values[programmed[0]]
        assert value is not None
        begin = self.work[known]
        way = value if self.modal.incremental else value - begin
        slope = tan(radians(angle)) if angle % 180.0 else 0.0
        vertical = angle % 180.0 == 90.0
        if (at == 0 and vertical) or (at == 1 and slope == 0.0):
            raise WordRefused(
                NcError.PROGRAM_SYNTAX_RUNNING, "this angle never gets to the coordinate", "ANG"
            )
        other = 0.0 if at == 1 and vertical else way * slope if at == 0 else way / slope
        if not self.modal.incremental:
            other += self.work[missing]
        return {**values, AXIS_LETTERS[missing]: other}

    def _arc(self, element: ContourElement, values: Mapping[str, float | None]) -> None:
        """Compute centre, normal and angle of G02 and G03."""
        first, second, third = self.modal.plane.axes
        start = element.start[first], element.start[second]
        end = element.end[first], element.end[second]
        clockwise = self.modal.motion == 2
        radius = values.get("B", values.get("U"))
        offsets = [values.get(_CENTRES[axis]) for axis in (first, second)]
        if values.get(_CENTRES[third]):
            raise WordRefused(
                NcError.CIRCLE_NOT_COMPUTABLE,
                f"{_CENTRES[third]} is not in plane {self.modal.plane.name}",
                _CENTRES[third],
            )
        if radius is not None:
            if any(offset is not None for offset in offsets) or ("B" in values and "U" in values):
                raise WordRefused(
                    NcError.CIRCLE_NOT_COMPUTABLE, "expected a radius or a centre, got both"
                )
            centre = centre_of_radius(start, end, radius, clockwise)
        elif all(offset is None for offset in offsets):
            raise WordRefused(
                NcError.CIRCLE_NOT_COMPUTABLE,
                f"an arc in plane {self.modal.plane.name} needs"
                f" {_CENTRES[first]}, {_CENTRES[second]} or a radius B, U",
                f"G{self.modal.motion:02d}",
            )
        else:
            centre = start[0] + (offsets[0] or 0.0), start[1] + (offsets[1] or 0.0)
            centre = corrected_centre(start, end, centre, self.modal.correct_centre)
        at = [0.0, 0.0, 0.0]
        at[first], at[second], at[third] = centre[0], centre[1], element.start[third]
        normal = [0.0, 0.0, 0.0]
        normal[third] = -1.0 if clockwise else 1.0
        element.centre = (at[0], at[1], at[2])
        element.normal = (normal[0], normal[1], normal[2])
        element.angle = swept(start, end, centre, clockwise)
        element.rise = normal[third] * (element.end[third] - element.start[third])

    @staticmethod
    def _through_point(element: ContourElement, values: Mapping[str, float | None]) -> None:
        """Compute the arc of CIP: the third point is relative to the start."""
        x, y, z = (
            begin + (values.get(name) or 0.0)
            for begin, name in zip(element.start, _CENTRES, strict=True)
        )
        element.centre, element.normal, element.angle = circle_in_space(
            element.start, (x, y, z), element.end
        )

    def _emit(self, items: "Iterator[ContourElement | Canonical]") -> Iterator[Canonical]:
        for item in items:
            yield self._moving(item) if isinstance(item, ContourElement) else item

    def _moving(self, element: ContourElement) -> Moving:
        """Return the move of the axes."""
        frame, facts = self.frame, element.facts
        start, self.axes = self.axes, frame.to_axes(element.end)
        velocity, start_velocity = facts.velocity, facts.start_velocity
        if element.scale != 1.0:
            velocity, start_velocity = velocity * element.scale, start_velocity * element.scale
        if element.normal is None:
            return LineMove(
                facts.origin,
                start,
                self.axes,
                facts.auxiliary,
                velocity,
                start_velocity,
                facts.rapid,
                facts.exact_stop,
                facts.delete_distance,
            )
        normal, rise = element.normal, element.rise
        if not frame.is_translation:
            x, y, z = frame.turned(normal)
            normal = (x, y, z)
            if frame.flips:
                normal, rise = (-x, -y, -z), -rise
        return ArcMove(
            facts.origin,
            start,
            self.axes,
            frame.to_axes(element.centre),
            normal,
            element.angle,
            rise,
            facts.auxiliary,
            velocity,
            start_velocity,
            False,
            facts.exact_stop,
            facts.delete_distance,
        )


def _position(value: float, name: str) -> float:
    if not -_LIMIT <= value <= _LIMIT:
        raise WordRefused(NcError.FLOATING_POINT_OPERATION, f"{value:g} mm is out of range", name)
    return value
