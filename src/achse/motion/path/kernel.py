"""The kernel of the path: append pieces, and one cycle along them.

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
    PathAxis,
    PathJunction,
    PathPiece,
    PathState,
    PieceKind,
)
from achse.motion.path.smoothing import Smoothing, round_corner

_NO_LENGTH = 1e-9
"""A shorter segment is none, mm."""


class PathOperation(IntEnum):
    """Operation of the kernel."""

    CYCLE = 0
    APPEND = 1
    """The piece in the row behind the next one."""
    APPEND_LINES = 2
    """Lines to points, one behind the other in `numbers`, as many axes as there are."""
    SHOW = 3
    """Only the results, for the state as it is."""
    STOP_AT_END = 4
    """Single block: at which end of a segment, from piece `count` on, the path stops."""


class AppendOutcome(IntEnum):
    """Outcome of appending a piece."""

    FULL = -1
    NO_LENGTH = 0
    APPENDED = 1


def run(
    pieces: Sequence[PathPiece],
    junctions: Sequence[PathJunction],
    axes: Sequence[PathAxis],
    state: PathState,
    numbers: Sequence[float],
    operation: int,
    count: int,
) -> int:
    """One operation; `count` cycles, or points to append. How many were appended, or an outcome."""
    if operation == PathOperation.APPEND:
        return _append(pieces, junctions, axes, state)
    if operation == PathOperation.APPEND_LINES:
        return _append_lines(count, pieces, junctions, axes, state, numbers)
    if operation == PathOperation.STOP_AT_END:
        return 1 if stop_at_end(pieces, junctions, state, count) else 0
    if operation == PathOperation.CYCLE:
        for _ in range(count):
            _cycle(pieces, junctions, state)
    _show(pieces, state)
    return 0


def _cycle(
    pieces: Sequence[PathPiece], junctions: Sequence[PathJunction], state: PathState
) -> None:
    if state.current == state.following:
        state.velocity = state.acceleration = 0.0
        state.arrived = 1
        return
    if not state.fresh:
        build_junctions(pieces, junctions, state)
    move(pieces, junctions, state, state.cycle_time)
    _forget(state)


def _forget(state: PathState) -> None:
    """Pieces far behind make room."""
    if not state.backwards:
        state.oldest = max(state.oldest, state.current - state.history)


def _append_lines(
    count: int,
    pieces: Sequence[PathPiece],
    junctions: Sequence[PathJunction],
    axes: Sequence[PathAxis],
    state: PathState,
    numbers: Sequence[float],
) -> int:
    rows = len(pieces)
    # numbers: feed, first block number, then the points
    used = state.axis_count
    for n in range(count):
        piece = pieces[(state.following + 1) % rows]
        piece.kind = PieceKind.LINE
        piece.feed = piece.start_feed = numbers[0]
        piece.block = int(numbers[1]) + n
        piece.stops = 0
        piece.wait = 0.0
        for i in range(used):
            piece.end[i] = numbers[2 + n * used + i]
        if _append(pieces, junctions, axes, state) == AppendOutcome.FULL:
            return n
    return count


def _append(
    pieces: Sequence[PathPiece],
    junctions: Sequence[PathJunction],
    axes: Sequence[PathAxis],
    state: PathState,
) -> int:
    """Append the piece that is in the row behind the next one."""
    rows = len(pieces)
    number = state.following
    if state.appended - state.passed_segments >= state.table or number - state.oldest > rows - 3:
        return AppendOutcome.FULL
    piece = pieces[(number + 1) % rows]
    before = pieces[(number - 1) % rows]
    known = number > state.oldest
    way = before.first + before.length if known else state.way
    if piece.kind == PieceKind.LINE:
        for i in range(AXES):
            piece.begin[i] = before.end[i]
        if not _straighten(piece):
            if piece.stops and known:
                before.stops = 1
                state.fresh = 0
            return AppendOutcome.NO_LENGTH
    piece.block_after = piece.block
    piece.last = 1
    piece.junction = 0.0
    piece.whole = piece.length
    if piece.kind == PieceKind.WAIT:
        _to_row(piece, pieces[number % rows], way)
        bound(pieces[number % rows], axes, state)
        if state.keep_jerk and known:
            keep_jerk(pieces, number - 1, pieces[number % rows], state)
        state.following = number + 1
        state.appended += 1
        state.fresh = 0
        state.waiting = piece.wait if state.current == number else state.waiting
        return AppendOutcome.APPENDED
    bound(piece, axes, state)
    lost = 0.0
    joined = known and before.kind != PieceKind.WAIT and not before.stops
    if joined and before.kind != PieceKind.CURVE and state.smoothing != Smoothing.OFF:
        curve = pieces[number % rows]
        lost = round_corner(before, curve, piece, state, _spare(pieces, junctions, state))
        if lost > 0.0:
            entry = feed_at(before, before.length - lost)
            piece.start_feed += (piece.feed - piece.start_feed) * lost / piece.length
            _shorten(before, piece, lost)
            bound(piece, axes, state)
            curve.block = before.block
            curve.block_after = piece.block
            curve.feed = curve.start_feed = min(entry, piece.start_feed)
            curve.wait = 0.0
            curve.stops = 0
            curve.last = 0
            # its first half belongs to the segment before, which ends in it; it is counted there
            curve.first = before.first + before.length
            bound(curve, axes, state)
            before.junction = transition(before, curve, axes, state)
            curve.bend_jump = 0.0
            curve.junction = transition(curve, piece, axes, state)
            if state.keep_jerk:
                keep_jerk(pieces, number - 1, curve, state)
                keep_jerk(pieces, number, piece, state)
            piece.first = curve.first + curve.length
            state.following = number + 2
    if lost <= 0.0:
        if joined:
            before.junction = transition(before, piece, axes, state)
        if state.keep_jerk and known:
            keep_jerk(pieces, number - 1, piece, state)
        _to_row(piece, pieces[number % rows], way)
        state.following = number + 1
    state.appended += 1
    state.fresh = 0
    return AppendOutcome.APPENDED


def _spare(
    pieces: Sequence[PathPiece], junctions: Sequence[PathJunction], state: PathState
) -> float:
    """Return the length of the last piece that a rounded corner may still use."""
    if state.current == state.following:
        return 0.0
    last = pieces[(state.following - 1) % len(pieces)]
    room = last.first + last.length - max(state.way, last.first)
    if state.backwards:
        return room
    end = last.first + last.length
    return min(room, end - state.way - rest_ahead(pieces, junctions, state, last.first - state.way))


def _straighten(piece: PathPiece) -> bool:
    """The line from its begin to its end; False if there is none.

    Its length is that in X, Y, Z; if only auxiliary axes move, theirs.
    """
    square = 0.0
    for i in range(MAIN_AXES):
        d = piece.end[i] - piece.begin[i]
        square += d * d
    if square <= _NO_LENGTH * _NO_LENGTH:
        square = 0.0
        for i in range(AXES):
            d = piece.end[i] - piece.begin[i]
            square += d * d
    if square <= _NO_LENGTH * _NO_LENGTH:
        return False
    length = sqrt(square)
    piece.length = length
    for i in range(AXES):
        piece.slope[i] = (piece.end[i] - piece.begin[i]) / length
    return True


def _shorten(before: PathPiece, piece: PathPiece, lost: float) -> None:
    """Both neighbours of a curve lose a part."""
    before.length -= lost
    piece.length -= lost
    for i in range(AXES):
        piece.begin[i] += piece.slope[i] * lost
    if piece.kind == PieceKind.ARC:
        c, s = cos(piece.turn * lost), sin(piece.turn * lost)
        for i in range(MAIN_AXES):
            x, y = piece.first_radius[i], piece.second_radius[i]
            piece.first_radius[i] = x * c + y * s
            piece.second_radius[i] = y * c - x * s
            piece.centre[i] += piece.slope[i] * lost


def _to_row(source: PathPiece, row: PathPiece, way: float) -> None:
    """The piece with all that lines, arcs and waits have, in another row."""
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


def _show(pieces: Sequence[PathPiece], state: PathState) -> None:
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
    piece = pieces[number % len(pieces)]
    way = min(max(state.way - piece.first, 0.0), piece.length)
    point_at(piece, way, point)
    for i in range(state.axis_count):
        state.axis_velocity[i] = point.tangent[i] * v
        state.axis_acceleration[i] = point.tangent[i] * a + point.bend[i] * v * v
