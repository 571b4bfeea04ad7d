"""The kernel of the path: append elements, and one cycle along them.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from collections.abc import Sequence
from enum import IntEnum
from math import cos, sin, sqrt

from achse.motion.path.bounds import bound, feed_at
from achse.motion.path.corners import keep_jerk, transition
from achse.motion.path.geometry import point_at
from achse.motion.path.junctions import build_junctions
from achse.motion.path.lookahead import move, rest_ahead, stop_at_end
from achse.motion.path.record import (
    AXES,
    MAIN_AXES,
    ElementKind,
    PathAxis,
    PathElement,
    PathJunction,
    PathState,
)
from achse.motion.path.smoothing import Smoothing, round_corner

_NO_LENGTH = 1e-9
"""A shorter segment is none, mm."""


class PathOperation(IntEnum):
    """Operation of the kernel."""

    CYCLE = 0
    APPEND = 1
    """The element in the row behind the next one."""
    APPEND_LINES = 2
    """Lines to points, one behind the other in `numbers`, as many axes as there are."""
    SHOW = 3
    """Only the results, for the state as it is."""
    STOP_AT_END = 4
    """Single block: at which end of a segment, from element `count` on, the path stops."""


class AppendOutcome(IntEnum):
    """Outcome of appending an element."""

    FULL = -1
    NO_LENGTH = 0
    APPENDED = 1


def run(
    elements: Sequence[PathElement],
    junctions: Sequence[PathJunction],
    axes: Sequence[PathAxis],
    state: PathState,
    numbers: Sequence[float],
    operation: int,
    count: int,
) -> int:
    """One operation; `count` cycles, or points to append. How many were appended, or an outcome."""
    if operation == PathOperation.APPEND:
        return _append(elements, junctions, axes, state)
    if operation == PathOperation.APPEND_LINES:
        return _append_lines(count, elements, junctions, axes, state, numbers)
    if operation == PathOperation.STOP_AT_END:
        return 1 if stop_at_end(elements, junctions, state, count) else 0
    if operation == PathOperation.CYCLE:
        for _ in range(count):
            _cycle(elements, junctions, state)
    _show(elements, state)
    return 0


def _cycle(
    elements: Sequence[PathElement], junctions: Sequence[PathJunction], state: PathState
) -> None:
    if state.current == state.following:
        state.velocity = state.acceleration = 0.0
        state.arrived = 1
        return
    if not state.fresh:
        build_junctions(elements, junctions, state)
    move(elements, junctions, state, state.cycle_time)
    _forget(state)


def _forget(state: PathState) -> None:
    """Forget elements far behind, to make room."""
    if not state.backwards:
        state.oldest = max(state.oldest, state.current - state.history)


def _append_lines(
    count: int,
    elements: Sequence[PathElement],
    junctions: Sequence[PathJunction],
    axes: Sequence[PathAxis],
    state: PathState,
    numbers: Sequence[float],
) -> int:
    rows = len(elements)
    # numbers: feed, first block number, then the points
    used = state.axis_count
    for n in range(count):
        element = elements[(state.following + 1) % rows]
        element.kind = ElementKind.LINE
        element.feed = element.start_feed = numbers[0]
        element.block = int(numbers[1]) + n
        element.stops = 0
        element.wait = 0.0
        for i in range(used):
            element.end[i] = numbers[2 + n * used + i]
        if _append(elements, junctions, axes, state) == AppendOutcome.FULL:
            return n
    return count


def _append(
    elements: Sequence[PathElement],
    junctions: Sequence[PathJunction],
    axes: Sequence[PathAxis],
    state: PathState,
) -> int:
    """Append the element that is in the row behind the next one."""
    rows = len(elements)
    number = state.following
    if state.appended - state.passed_segments >= state.table or number - state.oldest > rows - 3:
        return AppendOutcome.FULL
    element = elements[(number + 1) % rows]
    before = elements[(number - 1) % rows]
    known = number > state.oldest
    way = before.first + before.length if known else state.way
    if element.kind == ElementKind.LINE:
        for i in range(AXES):
            element.begin[i] = before.end[i]
        if not _straighten(element):
            if element.stops and known:
                before.stops = 1
                state.fresh = 0
            return AppendOutcome.NO_LENGTH
    element.block_after = element.block
    element.last = 1
    element.junction = 0.0
    element.whole = element.length
    if element.kind == ElementKind.WAIT:
        _to_row(element, elements[number % rows], way)
        bound(elements[number % rows], axes, state)
        if state.keep_jerk and known:
            keep_jerk(elements, number - 1, elements[number % rows], state)
        state.following = number + 1
        state.appended += 1
        state.fresh = 0
        state.waiting = element.wait if state.current == number else state.waiting
        return AppendOutcome.APPENDED
    bound(element, axes, state)
    lost = 0.0
    joined = known and before.kind != ElementKind.WAIT and not before.stops
    if joined and before.kind != ElementKind.CURVE and state.smoothing != Smoothing.OFF:
        curve = elements[number % rows]
        lost = round_corner(before, curve, element, state, _spare(elements, junctions, state))
        if lost > 0.0:
            entry = feed_at(before, before.length - lost)
            element.start_feed += (element.feed - element.start_feed) * lost / element.length
            _shorten(before, element, lost)
            bound(element, axes, state)
            curve.block = before.block
            curve.block_after = element.block
            curve.feed = curve.start_feed = min(entry, element.start_feed)
            curve.wait = 0.0
            curve.stops = 0
            curve.last = 0
            # its first half belongs to the segment before, which ends in it; it is counted there
            curve.first = before.first + before.length
            bound(curve, axes, state)
            before.junction = transition(before, curve, axes, state)
            curve.bend_jump = 0.0
            curve.junction = transition(curve, element, axes, state)
            if state.keep_jerk:
                keep_jerk(elements, number - 1, curve, state)
                keep_jerk(elements, number, element, state)
            element.first = curve.first + curve.length
            state.following = number + 2
    if lost <= 0.0:
        if joined:
            before.junction = transition(before, element, axes, state)
        if state.keep_jerk and known:
            keep_jerk(elements, number - 1, element, state)
        _to_row(element, elements[number % rows], way)
        state.following = number + 1
    state.appended += 1
    state.fresh = 0
    return AppendOutcome.APPENDED


def _spare(
    elements: Sequence[PathElement], junctions: Sequence[PathJunction], state: PathState
) -> float:
    """Return the length of the last element that a rounded corner may still use."""
    if state.current == state.following:
        return 0.0
    last = elements[(state.following - 1) % len(elements)]
    room = last.first + last.length - max(state.way, last.first)
    if state.backwards:
        return room
    end = last.first + last.length
    return min(
        room, end - state.way - rest_ahead(elements, junctions, state, last.first - state.way)
    )


def _straighten(element: PathElement) -> bool:
    """Return the line from its begin to its end; False if there is none.

    Its length is that in X, Y, Z; if only auxiliary axes move, theirs.
    """
    square = 0.0
    for i in range(MAIN_AXES):
        d = element.end[i] - element.begin[i]
        square += d * d
    if square <= _NO_LENGTH * _NO_LENGTH:
        square = 0.0
        for i in range(AXES):
            d = element.end[i] - element.begin[i]
            square += d * d
    if square <= _NO_LENGTH * _NO_LENGTH:
        return False
    length = sqrt(square)
    element.length = length
    for i in range(AXES):
        element.slope[i] = (element.end[i] - element.begin[i]) / length
    return True


def _shorten(before: PathElement, element: PathElement, lost: float) -> None:
    """Shorten both neighbours of a curve by what it takes."""
    before.length -= lost
    element.length -= lost
    for i in range(AXES):
        element.begin[i] += element.slope[i] * lost
    if element.kind == ElementKind.ARC:
        c, s = cos(element.turn * lost), sin(element.turn * lost)
        for i in range(MAIN_AXES):
            x, y = element.first_radius[i], element.second_radius[i]
            element.first_radius[i] = x * c + y * s
            element.second_radius[i] = y * c - x * s
            element.centre[i] += element.slope[i] * lost


def _to_row(source: PathElement, row: PathElement, way: float) -> None:
    """Copy what lines, arcs and waits have of an element to another row."""
    row.kind = source.kind
    row.block = source.block
    row.block_after = source.block_after
    row.last = source.last
    row.stops = source.stops
    row.first = way
    row.length = source.length
    row.whole = source.whole
    row.wait = source.wait
    row.feed = source.feed
    row.start_feed = source.start_feed
    row.deceleration = source.deceleration
    row.jerk = source.jerk
    row.spans = source.spans
    for k in range(source.spans):
        row.ends[k] = source.ends[k]
        row.caps[k] = source.caps[k]
        row.starts[k] = source.starts[k]
        row.accelerations[k] = source.accelerations[k]
        row.rests[k] = source.rests[k]
        row.decelerations[k] = source.decelerations[k]
        row.powers[k] = source.powers[k]
        row.first_jerks[k] = source.first_jerks[k]
        row.jerks[k] = source.jerks[k]
    row.path_acceleration = source.path_acceleration
    row.path_deceleration = source.path_deceleration
    row.path_jerk = source.path_jerk
    row.junction = source.junction
    row.bend_jump = 0.0
    row.turn = source.turn
    for i in range(AXES):
        row.begin[i] = source.begin[i]
        row.end[i] = source.end[i]
        row.slope[i] = source.slope[i]
    for i in range(MAIN_AXES):
        row.centre[i] = source.centre[i]
        row.first_radius[i] = source.first_radius[i]
        row.second_radius[i] = source.second_radius[i]


def _show(elements: Sequence[PathElement], state: PathState) -> None:
    """Set positions, velocities and accelerations of the axes."""
    point = state.point
    sign = -1.0 if state.backwards else 1.0
    v = sign * state.velocity
    a = sign * state.acceleration
    number = state.current
    if number == state.following:
        number -= 1
        if number < state.oldest:
            return
    element = elements[number % len(elements)]
    way = min(max(state.way - element.first, 0.0), element.length)
    point_at(element, way, point)
    for i in range(state.axis_count):
        state.axis_velocity[i] = point.tangent[i] * v
        state.axis_acceleration[i] = point.tangent[i] * a + point.bend[i] * v * v
