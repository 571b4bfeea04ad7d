"""PathPlanner: segments in, set points of the axes out, one cycle at a time.

Segments are appended while the path runs, `advance` goes on by one cycle, properties show where it
is. Commands take effect with the next cycle. Set positions are always on the path: override, stops
and reversing change only how fast it is followed.
"""

from array import array
from collections.abc import Sequence
from math import isfinite
from typing import Any

from achse.motion.path.bounds import feed_at
from achse.motion.path.compiled import KERNEL
from achse.motion.path.kernel import AppendOutcome, PathOperation
from achse.motion.path.parameters import PathLimits, PathParameters
from achse.motion.path.ramp import stretch
from achse.motion.path.record import (
    AXES,
    AXIS,
    ELEMENT,
    JUNCTION,
    MAIN_AXES,
    POINT,
    SPANS,
    STATE,
    ElementKind,
    PathElement,
    axis_record,
    element_record,
    junction_record,
    state_record,
)
from achse.motion.path.segments import PathArc, PathDwell, PathError, PathLine, PathSegment
from achse.native.declare import RecordLayout
from achse.native.memory import Rows, RowView, field_property

LOOK_AHEAD = 128
"""Segments of the table by default (0x3000+ID:0x50C, 128..1024)."""
HISTORY = 32
"""Segments behind the present one that the path can go back, by default."""
_MOST_LOOK_AHEAD = 1024
_POINTS = 256
"""Points that `append_lines` hands over at once."""
_SPARE_ROWS = 4
_NEAR = 1e-9
"""Of a place on the path, mm."""


class PathTableFull(Exception):
    """The segment did not fit; nothing has changed. Append it again when `free` is above 0."""


def _view(layout: RecordLayout[Any]) -> type[RowView]:
    fields = {
        name: field_property(slot) for name, slot in layout.fields.items() if slot.holds is None
    }
    return type("PathRecord", (RowView,), fields)


_ELEMENT, _JUNCTION, _AXIS, _STATE, _POINT = map(_view, (ELEMENT, JUNCTION, AXIS, STATE, POINT))


class PathPlanner:
    """The path of up to 8 axes: X, Y, Z, then auxiliary axes.

    `position`: where the axes are, mm. `cycle_time` in s. `table`: segments that may wait or
    be under way, the look-ahead. `history`: segments behind the present one that the path can go
    back.
    `compiled`: machine code (needs `achse[fast]`); results are the same to the last bit.

    `state` is the kernel's record (`achse.motion.path.record.PathState`), to read.
    """

    def __init__(
        self,
        axes: Sequence[PathLimits],
        position: Sequence[float],
        *,
        cycle_time: float = 0.002,
        parameters: PathParameters | None = None,
        table: int = LOOK_AHEAD,
        history: int = HISTORY,
        compiled: bool = False,
    ) -> None:
        if not 1 <= len(axes) <= AXES:
            raise PathError(f"path: {len(axes)} axes, expected 1..{AXES}")
        if not (isfinite(cycle_time) and cycle_time > 0.0):
            raise PathError(f"path: cycle time {cycle_time}, expected above 0")
        if not 1 <= table <= _MOST_LOOK_AHEAD:
            raise PathError(f"path: table of {table}, expected 1..{_MOST_LOOK_AHEAD}")
        self._numbers = array("d", bytes(8 * (2 + _POINTS * AXES)))
        rows = 2 * (table + history) + _SPARE_ROWS
        self._run: Any
        self.state: Any
        self._point: Any
        self._elements: list[Any]
        if compiled:
            elements, junctions = Rows(ELEMENT, rows), Rows(JUNCTION, rows * SPANS)
            limits, states = Rows(AXIS, AXES), Rows(STATE, 1)
            self._elements = [_ELEMENT(elements, n) for n in range(rows)]
            self._axes: list[Any] = [_AXIS(limits, n) for n in range(AXES)]
            self.state = _STATE(states, 0)
            self._point = _POINT(states.within(0, STATE.fields["point"]), 0)
            self._memory = elements, junctions, limits, states
            for name, slot in STATE.fields.items():
                if slot.holds is None and slot.default and not slot.length:
                    setattr(self.state, name, slot.default)
            self._run = KERNEL.bind(
                *(elements.address, rows, junctions.address, rows * SPANS, limits.address, AXES),
                *(states.address, *self._numbers.buffer_info()),
            )
        else:
            self._elements = [element_record() for _ in range(rows)]
            self._axes = [axis_record() for _ in range(AXES)]
            self.state = state_record()
            self._point = self.state.point
            junction_list = [junction_record() for _ in range(rows * SPANS)]
            plain = KERNEL.plain
            arguments = self._elements, junction_list, self._axes, self.state, self._numbers

            def run(operation: int, count: int) -> int:
                outcome: int = plain(*arguments, operation, count)
                return outcome

            self._run = run
        state = self.state
        state.table, state.history, state.axis_count = table, 2 * history, len(axes)
        state.cycle_time = cycle_time
        self._limits = tuple(axes)
        self._single_block = False
        self.parameters = parameters or PathParameters()
        self.reset(position)

    # -- segments ----------------------------------------------------------------------------

    @property
    def parameters(self) -> PathParameters:
        """Parameters of segments that are appended from now on; override type: at once."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: PathParameters) -> None:
        self._parameters = parameters
        parameters.fill(self.state)
        self.limits = self._limits

    @property
    def free(self) -> int:
        """Segments that fit into the table."""
        return int(self.state.table - self.entries)

    @property
    def entries(self) -> int:
        """Segments that wait or are under way."""
        return int(self.state.appended - self.state.passed_segments)

    @property
    def programmed_position(self) -> tuple[float, ...]:
        """End of the last segment and begin of the next one, mm, each axis."""
        last = self._elements[(self.state.following - 1) % len(self._elements)]
        return tuple(last.end[: self.state.axis_count])

    def append(self, segment: PathSegment) -> bool:
        """Append a segment; False if it has no length: of that only an exact stop counts.

        PathTableFull if it does not fit; PathError if a value cannot be.
        """
        state = self.state
        row = self._elements[(state.following + 1) % len(self._elements)]
        start = self.programmed_position
        row.block, row.stops, row.wait = segment.block, 0, 0.0
        row.length = 0.0
        if isinstance(segment, PathDwell):
            if not (isfinite(segment.time) and segment.time >= 0.0):
                raise PathError(f"dwell time {segment.time}, expected 0 or more")
            row.kind, row.wait = int(ElementKind.WAIT), float(segment.time)
            row.feed = row.start_feed = 0.0
            self._put(row.begin, start)
            self._put(row.end, start)
            self._put(row.slope, ())
        else:
            begin = segment.feed if segment.start_feed is None else segment.start_feed
            for feed in (begin, segment.feed):
                if not (isfinite(feed) and feed > 0.0):
                    raise PathError(f"feed {feed}, expected above 0")
            row.start_feed, row.feed = float(begin), float(segment.feed)
            row.stops = int(segment.exact_stop)
            if isinstance(segment, PathLine):
                self._check(segment.end, len(start), "line")
                row.kind = int(ElementKind.LINE)
                self._put(row.end, segment.end)
            else:
                self._put_arc(row, segment, start)
        outcome = self._run(PathOperation.APPEND, 0)
        if outcome == AppendOutcome.FULL:
            raise PathTableFull(f"the table of {state.table} segments is full")
        self._appended()
        return bool(outcome == AppendOutcome.APPENDED)

    def _appended(self) -> None:
        if self._single_block and self.state.barrier < 0:
            self._stop_at_end(self.state.current)

    def append_lines(self, points: Sequence[Sequence[float]], feed: float, block: int = 0) -> int:
        """Append lines from point to point, as many as fit; how many. Blocks count from `block` on.

        Much faster than one by one.
        """
        if not (isfinite(feed) and feed > 0.0):
            raise PathError(f"feed {feed}, expected above 0")
        used = self.state.axis_count
        done = 0
        while done < len(points):
            part = points[done : done + _POINTS]
            flat = array("d", [x for point in part for x in point])
            if len(flat) != used * len(part) or not all(map(isfinite, flat)):
                raise PathError(f"lines: expected points of {used} finite numbers")
            self._numbers[:2] = array("d", (feed, block + done))
            self._numbers[2 : 2 + len(flat)] = flat
            taken = self._run(PathOperation.APPEND_LINES, len(part))
            done += taken
            if taken < len(part):
                break
        self._appended()
        return done

    def _put_arc(self, row: Any, arc: PathArc, start: Sequence[float]) -> None:
        shape = arc.geometry
        if len(start) < MAIN_AXES:
            raise PathError(f"arc: {len(start)} axes, expected {MAIN_AXES} at least")
        gap = max(abs(a - b) for a, b in zip(shape.start, start, strict=False))
        if not gap <= 1e-6 * max(1.0, shape.radius):
            raise PathError(f"arc: begins {gap:g} mm from the end of the path")
        length = shape.length
        auxiliary = arc.auxiliary or start[MAIN_AXES:]
        self._check(auxiliary, len(start) - MAIN_AXES, "arc, auxiliary axes")
        steps = [to - begin for begin, to in zip(start[MAIN_AXES:], auxiliary, strict=True)]
        row.kind, row.length, row.turn = int(ElementKind.ARC), length, shape.angle / length
        self._put(row.begin, (*shape.start, *start[MAIN_AXES:]))
        self._put(row.end, (*shape.end, *auxiliary))
        self._put(row.slope, [step / length for step in (*shape.rise, *steps)])
        for name in ("centre", "first_radius", "second_radius"):
            self._put(getattr(row, name), getattr(shape, name))

    def _check(self, numbers: Sequence[float], count: int, what: str) -> None:
        if len(numbers) != count or not all(map(isfinite, numbers)):
            raise PathError(f"{what}: {list(numbers)}, expected {count} finite numbers")

    def _put(self, row: Any, values: Sequence[float]) -> None:
        for i in range(len(row)):
            row[i] = float(values[i]) if i < len(values) else 0.0

    # -- motion ------------------------------------------------------------------------------

    def advance(self, cycles: int = 1) -> None:
        """Go on by one cycle, or several."""
        state = self.state
        if state.stop_deceleration > 0.0 and not state.hold and self.standstill:
            state.stop_deceleration = state.stop_jerk = 0.0
            state.fresh = 0
        self._run(PathOperation.CYCLE, cycles)

    @property
    def position(self) -> tuple[float, ...]:
        """Set positions, mm, each axis."""
        return tuple(self._point.position[: self.state.axis_count])

    @property
    def axis_velocity(self) -> tuple[float, ...]:
        """Set velocities, mm/s, each axis."""
        return tuple(self.state.axis_velocity[: self.state.axis_count])

    @property
    def axis_acceleration(self) -> tuple[float, ...]:
        """Set accelerations, mm/s², each axis."""
        return tuple(self.state.axis_acceleration[: self.state.axis_count])

    @property
    def velocity(self) -> float:
        """Along the path, mm/s; 0 or more, backwards too."""
        return float(self.state.velocity)

    @property
    def acceleration(self) -> float:
        """Along the path in the direction of travel, mm/s²."""
        return float(self.state.acceleration)

    @property
    def standstill(self) -> bool:
        """No velocity, no acceleration."""
        return bool(self.state.velocity == 0.0 and self.state.acceleration == 0.0)

    @property
    def finished(self) -> bool:
        """At rest at the end of all that was appended."""
        state = self.state
        if not self.standstill or state.waiting > 0.0:
            return False
        return bool(state.current >= state.following - 1 and self.total_remaining <= 0.0)

    @property
    def block(self) -> int:
        """Block number of the present segment; 0 without one."""
        element = self.element
        if element is None:
            return 0
        half = self.state.way - element.first > 0.5 * element.length
        return int(element.block_after if half else element.block)

    @property
    def done(self) -> float:
        """Way since the beginning of the present element, mm."""
        element = self.element
        return 0.0 if element is None else float(self.state.way - element.first)

    @property
    def remaining(self) -> float:
        """Way to the end of the present element, mm."""
        element = self.element
        return 0.0 if element is None else float(element.first + element.length - self.state.way)

    @property
    def total_remaining(self) -> float:
        """Way to the end of the path, mm."""
        if self.state.following == self.state.oldest:
            return 0.0
        last = self._elements[(self.state.following - 1) % len(self._elements)]
        return float(last.first + last.length - self.state.way)

    @property
    def programmed_velocity(self) -> float:
        """Feed of the present segment, mm/s; where it changes evenly, that of this place."""
        element = self.element
        return 0.0 if element is None else float(feed_at(element, self.done))

    @property
    def element(self) -> PathElement | None:
        """The present element, to read; None before the first segment."""
        state = self.state
        if state.following == state.oldest:
            return None
        row: PathElement = self._elements[
            min(state.current, state.following - 1) % len(self._elements)
        ]
        return row

    @property
    def most_velocity(self) -> float:
        """Velocity that feed and axes permit on the present element, mm/s; 0 without an element."""
        element = self.element
        return (
            0.0
            if element is None
            else float(min(max(element.start_feed, element.feed), *element.caps[: element.spans]))
        )

    @property
    def end_velocity(self) -> float:
        """Velocity that the transition at the end of the present element permits, mm/s."""
        element = self.element
        return 0.0 if element is None else float(element.junction)

    @property
    def stop_way(self) -> float:
        """Way on which the path would come to rest with what this element allows, mm."""
        element, state = self.element, self.state
        if element is None or state.velocity == 0.0:
            return 0.0
        return stretch(state.velocity, state.acceleration, 0.0, element.deceleration, element.jerk)

    @property
    def tangent(self) -> tuple[float, ...]:
        """Direction of the path, X, Y, Z: a unit vector; then auxiliary axes by the way."""
        return tuple(self._point.tangent[: self.state.axis_count])

    @property
    def at_barrier(self) -> bool:
        """Single block: at rest at the end of the segment where it stops."""
        barrier = self.state.barrier
        if barrier < 0 or not self.standstill:
            return False
        element = self._elements[barrier % len(self._elements)]
        return bool(abs(element.first + element.length - self.state.way) < _NEAR)

    @property
    def limits(self) -> tuple[PathLimits, ...]:
        """Limits of the axes that hold for segments that are appended from now on."""
        return self._limits

    @limits.setter
    def limits(self, limits: Sequence[PathLimits]) -> None:
        if len(limits) != self.state.axis_count:
            raise PathError(f"path: limits of {len(limits)} axes, expected {self.state.axis_count}")
        self._limits = tuple(limits)
        for row, limit in zip(self._axes, self._limits, strict=False):
            limit.fill(row, self.state.cycle_time, keep_jerk=self._parameters.keep_jerk)

    # -- commands ----------------------------------------------------------------------------

    @property
    def override(self) -> float:
        """Factor on the velocity, 0..1, or up to `most_override` of the parameters."""
        return float(self.state.override)

    @override.setter
    def override(self, factor: float) -> None:
        most = self.state.most_override
        if not 0.0 <= factor <= most:
            raise PathError(f"override {factor}, expected 0..{most:g}")
        if factor != self.state.override:
            self.state.override = float(factor)
            self.state.fresh = 0
            self.state.out = min(self.state.out, 1)

    def hold(self) -> None:
        """Come to rest on the path with its dynamics (feed hold, stop); `step_on` goes on."""
        self.state.hold = 1

    def emergency_stop(self, deceleration: float, jerk: float) -> None:
        """Come to rest with these, mm/s² and mm/s³, where they exceed those of the path.

        The limits of the axes hold nevertheless. `step_on` goes on (0x3200+ID:0x4, 0x6).
        """
        for value in (deceleration, jerk):
            if not (isfinite(value) and value > 0.0):
                raise PathError(f"emergency stop: {value}, expected above 0")
        state = self.state
        state.hold = 1
        # while one is under way, another does not make it weaker
        state.stop_deceleration = max(state.stop_deceleration, float(deceleration))
        state.stop_jerk = max(state.stop_jerk, float(jerk))
        state.fresh = 0

    def step_on(self) -> None:
        """Go on after `hold` or `emergency_stop`; also before it has come to rest."""
        self.state.hold = 0

    @property
    def backwards(self) -> bool:
        """True if the path goes back; changes only at standstill, else PathError."""
        return bool(self.state.backwards)

    @backwards.setter
    def backwards(self, backwards: bool) -> None:
        state = self.state
        if bool(state.backwards) == backwards:
            return
        if not self.standstill:
            raise PathError("the path reverses only at standstill: hold it first")
        state.backwards = int(backwards)
        state.waiting = 0.0
        state.current = min(max(state.current, state.oldest), max(state.following - 1, 0))
        state.fresh = 0

    @property
    def at_first(self) -> bool:
        """Going back, it rests where the path begins that is still known."""
        state = self.state
        if not state.backwards or not self.standstill:
            return False
        first = self._elements[state.oldest % len(self._elements)]
        return bool(state.current <= state.oldest and state.way - first.first < _NEAR)

    @property
    def oldest_block(self) -> int:
        """Block number of the first segment that the path can go back to; 0 without one."""
        state = self.state
        if state.following == state.oldest:
            return 0
        return int(self._elements[state.oldest % len(self._elements)].block)

    def ahead(self, most: int) -> list[tuple[int, float]]:
        """Block number and length of the present segment and of those behind it, `most` at most.

        Of the present one, what is left of it. A rounded corner counts to the segment before it.
        """
        state, blocks = self.state, list[tuple[int, float]]()
        for n in range(state.current, state.following):
            element = self._elements[n % len(self._elements)]
            if element.kind == ElementKind.WAIT:
                continue
            done = max(0.0, state.way - element.first) if n == state.current else 0.0
            left = max(0.0, element.length - done)
            if blocks and blocks[-1][0] == element.block:
                blocks[-1] = (element.block, blocks[-1][1] + left)
            elif len(blocks) == most:
                break
            else:
                blocks.append((int(element.block), left))
        return blocks

    def delete_distance_to_go(self) -> None:
        """Drop all that is left of the path; PathError unless it is at rest.

        The next segment begins at `position`.
        """
        if not self.standstill:
            raise PathError("distance to go is deleted only at standstill: hold the path first")
        self.reset(self.position)

    def reset(self, position: Sequence[float]) -> None:
        """Forget all segments and commands; the axes are at `position`, mm, at rest."""
        state = self.state
        self._check(position, state.axis_count, "position")
        for name in (
            *("oldest", "current", "following", "appended", "passed_segments"),
            *("backwards", "arrived", "hold", "fresh", "junctions", "junction", "out"),
        ):
            setattr(state, name, 0)
        for name in (
            *("way", "velocity", "acceleration", "waiting", "stop_deceleration", "stop_jerk"),
        ):
            setattr(state, name, 0.0)
        state.barrier = -1
        self._put(self._elements[-1].end, position)
        self._put(self._point.position, position)
        self._put(state.axis_velocity, ())
        self._put(state.axis_acceleration, ())

    # -- single block ------------------------------------------------------------------------

    @property
    def single_block(self) -> bool:
        """Rest at the end of each segment until `next_block` (0x3000+ID:0x6).

        Once it rests there, only `next_block` goes on.
        """
        return self._single_block

    @single_block.setter
    def single_block(self, on: bool) -> None:
        if on == self._single_block:
            return
        self._single_block = on
        if self.at_barrier and not self.finished:
            return
        self._remove_barrier()
        if on:
            self._stop_at_end(self.state.current)

    def next_block(self) -> None:
        """Go on to the end of the next segment, or of the path if single block is off by now."""
        if not self.standstill:
            return
        if self._single_block:
            self._stop_at_end(max(self.state.barrier + 1, self.state.current))
        elif self.state.barrier >= 0:
            self._remove_barrier()

    def _remove_barrier(self) -> None:
        self.state.barrier = -1
        self.state.fresh = 0

    def _stop_at_end(self, first: int) -> None:
        """Stop at the first end of a segment, from an element on, where the path still can."""
        self._run(PathOperation.STOP_AT_END, first)
