"""The watch over a channel: its states by drawn transitions, its path within the tolerance.

The contour is read from the part program by this module alone: lines and arcs in absolute
positions, as `achse.swarm.worlds.channels` draws them.
"""

import math
import re
from collections.abc import Callable
from functools import cache

from achse.codes.nc.choices import MotionPhase
from achse.motion import Axis, Nc
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.channels.states import (
    ACTIVE_STATES,
    TRANSITIONS,
    InterpreterEvent,
    InterpreterState,
)
from achse.motion.groups.path_group import PathGroup
from achse.swarm.worlds.channels import CHANNEL, GROUP, program_file
from achse.swarm.worlds.world import DrawnChannel

Point = tuple[float, float, float]
Report = Callable[[str, str], None]

_EVERY = 4
"""Cycles between two looks at the contour."""

_NEAR = 1e-6
"""Rounding of a place beside the contour, mm."""

_WORD = re.compile(r"([A-Z])(-?\d+(?:\.\d*)?)")
_SMOOTHING = re.compile(r"#set paramVertexSmoothing\(\d+;\d+;([^)]*)\)#")

_COMMANDED = frozenset(
    (
        InterpreterEvent.LOAD, InterpreterEvent.START, InterpreterEvent.SEARCH,
        InterpreterEvent.RETRY, InterpreterEvent.STOP, InterpreterEvent.RESET,
    )
)  # fmt: skip
"""Events that only a request brings."""

_AUTONOMOUS = frozenset(InterpreterEvent) - _COMMANDED


@cache
def reachable_states(state: InterpreterState) -> frozenset[InterpreterState]:
    """Return the states that a channel without a request may have in the next cycle."""
    states, before = {state}, set[InterpreterState]()
    while states != before:
        before = set(states)
        for (source, event), target in TRANSITIONS.items():
            if source in before and event in _AUTONOMOUS:
                states.add(target)
    return frozenset(states)


class Contour:
    """Lines and circles of a part program, from a start on."""

    def __init__(self, text: str, start: Point) -> None:
        self.lines: list[tuple[Point, Point]] = []
        self.circles: list[tuple[Point, float]] = []
        place = start
        for line in text.splitlines():
            words = dict(_WORD.findall(line))
            if line.startswith("#") or words.get("G") not in ("0", "1", "2", "3"):
                continue
            end = tuple(
                float(words.get(letter, value)) for letter, value in zip("XYZ", place, strict=True)
            )
            if words["G"] in "01":
                self.lines.append((place, end))  # type: ignore[arg-type]
            else:
                i, j = float(words["I"]), float(words["J"])
                centre = place[0] + i, place[1] + j, place[2]
                self.circles.append((centre, math.hypot(i, j)))
            place = end  # type: ignore[assignment]

    def distance(self, point: Point) -> float:
        """Return the distance of a point from the contour."""
        nearest = math.inf
        for begin, end in self.lines:
            nearest = min(nearest, _from_line(point, begin, end))
        for centre, radius in self.circles:
            off = math.hypot(point[0] - centre[0], point[1] - centre[1]) - radius
            nearest = min(nearest, math.hypot(off, point[2] - centre[2]))
        return nearest


def _from_line(point: Point, begin: Point, end: Point) -> float:
    along = [b - a for a, b in zip(begin, end, strict=True)]
    square = sum(x * x for x in along)
    way = sum((p - a) * d for p, a, d in zip(point, begin, along, strict=True))
    share = min(max(way / square, 0.0), 1.0) if square else 0.0
    return math.dist(point, [a + share * d for a, d in zip(begin, along, strict=True)])


class ChannelWatch:
    """Observations of the channel of a world."""

    def __init__(self, part: DrawnChannel, report: Report) -> None:
        self._texts = {program_file(number): text for number, text in enumerate(part.programs)}
        radii = [float(each) for text in part.programs for each in _SMOOTHING.findall(text)]
        self._tolerance = max(radii, default=0.0) + _NEAR
        """Smoothing holds for the programs to come too."""
        self._names = [axis.name for axis in part.axes]
        self._axes: list[Axis] = []
        self._report = report
        self._channel: ProgramChannel | None = None
        self._group: PathGroup | None = None
        self._state = InterpreterState.IDLE
        self._contour: Contour | None = None
        self._moved = False
        self._place: Point = (0.0, 0.0, 0.0)
        self._cycle = 0
        self.looks = 0
        """Places that were compared with the contour."""

    def bind(self, nc: Nc | None) -> None:
        """Look at the channel of another NC, after a restart."""
        self._channel = self._group = self._contour = None
        if nc is None:
            return
        channel, group = nc.channels.channel(CHANNEL), nc.groups.group(GROUP)
        if isinstance(channel, ProgramChannel) and isinstance(group, PathGroup):
            self._channel, self._group = channel, group
            self._axes = [axis for axis in nc if axis.name in self._names]
            self._state, self._moved = channel.state, group.moving
            self._place = self._position()

    def look(self, when: str, *, requested: bool) -> bool:
        """Take the values of this cycle in; return True while the channel is at work."""
        channel, group = self._channel, self._group
        if channel is None or group is None:
            return False
        state = channel.state
        if state is not self._state:
            if not requested and state not in reachable_states(self._state):
                self._report(
                    "channel-states",
                    f"channel at {when}: {self._state.name} -> {state.name} without a request",
                )
            self._state = state
        place = self._position()
        if group.moving:
            if not self._moved:
                self._contour = self._contour_of(channel)
            self._look_at_path(group, place, when)
        self._moved, self._place = group.moving, place
        return group.moving or state in ACTIVE_STATES or channel.running

    def _contour_of(self, channel: ProgramChannel) -> Contour | None:
        """A search begins anywhere on the path: its contour is not known."""
        text = self._texts.get(channel.program_name)
        if text is None or channel.state is InterpreterState.SEARCHING:
            return None
        return Contour(text, self._place)

    def _look_at_path(self, group: PathGroup, place: Point, when: str) -> None:
        self._cycle += 1
        if self._contour is None or self._cycle % _EVERY:
            return
        if any(axis.set_motion_phase != MotionPhase.GROUPED for axis in group.members):
            self._contour = None  # an axis brakes by itself: the common motion is over
            return
        self.looks += 1
        off = self._contour.distance(place) if self._contour.lines else 0.0
        if off > self._tolerance:
            self._report(
                "path-tolerance",
                f"channel at {when}: {place} is {off} mm beside the contour, expected"
                f" {self._tolerance} mm at most",
            )

    def _position(self) -> Point:
        """Return where the axes are, in the group or not."""
        x, y, z, *_ = (*(axis.set_position for axis in self._axes), 0.0)
        return x, y, z
