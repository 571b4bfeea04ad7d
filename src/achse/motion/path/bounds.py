"""Bounds of a piece: velocity, acceleration and jerk along the path that keep every axis in limits.

On a path q(s) an axis has the velocity q' v, the acceleration q' a + q'' v², and the jerk
q' j + 3 q'' v a + q''' v³. A line leaves all of its limits to v, a and j. Where the path bends, v
takes a share of acceleration and jerk, and the rest is for a and j: the more the slower it is. What
is left falls no faster with v² (acceleration) and v³ (jerk) than in a straight line between its
values at rest and at the highest velocity; these two are kept, for each span of a piece.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from collections.abc import Sequence
from math import atan2, ceil, cos, fabs, floor, pi, sqrt

from achse.motion.path.geometry import curve_point
from achse.motion.path.record import (
    KNOTS,
    MAIN_AXES,
    SPANS,
    PathAxis,
    PathPiece,
    PathState,
    PieceKind,
)

ENDLESS = 1e12
"""A bound where there is none."""

_BEND_SHARE = 0.99
"""Share of the acceleration of an axis that the bend of the path may take."""
_TWIST_SHARE = 0.3
"""Share of the jerk of an axis that the bend of the path may take at full velocity."""
_MIXED_SHARE = 0.4
"""Share of the jerk that acceleration along a bend may take; the rest is for jerk along it."""
_SAMPLES = 4
_SAMPLE = 1.0 / _SAMPLES
"""Places of a curve that are looked at, in each part of it."""
_SPAN_ANGLE = pi / 36.0
"""Angle of one part of an arc, at least."""
_SPAN_LENGTH = 0.01
"""Length of a part whose feed is another than that of its neighbours, mm, at least."""
_FALL_SHARE = 0.6
_MARGIN = 1.01
"""For what is between them."""


def bound(piece: PathPiece, axes: Sequence[PathAxis], state: PathState) -> None:
    """Fill in what the piece allows."""
    piece.spans = 1
    piece.ends[0] = piece.length
    if piece.start_feed != piece.feed:
        piece.spans = min(max(floor(piece.length / _SPAN_LENGTH), 1), SPANS)
    if piece.kind == PieceKind.ARC:
        bends = min(max(ceil(piece.turn * piece.length / _SPAN_ANGLE), 1), SPANS)
        piece.spans = max(piece.spans, bends)
    if piece.kind == PieceKind.LINE or piece.kind == PieceKind.ARC:
        for k in range(piece.spans):
            piece.ends[k] = piece.length * (k + 1) / piece.spans
    elif piece.kind == PieceKind.CURVE:
        piece.spans = SPANS
        for k in range(SPANS):
            piece.ends[k] = piece.ways[(KNOTS - 1) // SPANS * (k + 1)]
    piece.path_acceleration = _asked(state.path_acceleration)
    piece.path_deceleration = _asked(state.path_deceleration)
    piece.path_jerk = _asked(state.path_jerk)
    piece.deceleration = piece.path_deceleration
    piece.jerk = piece.path_jerk
    for k in range(piece.spans):
        piece.caps[k] = span_feed(piece, k) * state.most_override
        piece.starts[k] = piece.accelerations[k] = ENDLESS
        piece.rests[k] = piece.decelerations[k] = piece.powers[k] = ENDLESS
        piece.first_jerks[k] = piece.jerks[k] = ENDLESS
        if piece.kind == PieceKind.WAIT:
            continue
        if piece.kind == PieceKind.LINE:
            for i in range(state.axis_count):
                _along(piece, k, axes[i], fabs(piece.slope[i]))
        else:
            if piece.kind == PieceKind.ARC:
                _bound_arc(piece, k, axes, state)
            else:
                _bound_curve(piece, k, axes, state)
            # falling with the square of the velocity takes at most 0.77 start² / cap of the jerk
            cap = piece.caps[k]
            fit = sqrt(_FALL_SHARE * piece.jerks[k] * cap)
            most = min(piece.starts[k], min(fit, piece.powers[k] / cap))
            piece.starts[k] = max(most, piece.accelerations[k])
        least = min(piece.decelerations[k], piece.powers[k] / piece.caps[k])
        piece.deceleration = min(piece.deceleration, least)
        piece.jerk = min(piece.jerk, piece.jerks[k])


def feed_at(piece: PathPiece, way: float) -> float:
    """Programmed velocity at a way from the beginning of a piece, mm/s."""
    if piece.start_feed == piece.feed:
        return piece.feed
    return piece.start_feed + (piece.feed - piece.start_feed) * way / piece.ends[piece.spans - 1]


def span_feed(piece: PathPiece, k: int) -> float:
    """Programmed velocity of a part of a piece: that of its middle, mm/s."""
    begin = piece.ends[k - 1] if k else 0.0
    return feed_at(piece, 0.5 * (begin + piece.ends[k]))


def _asked(value: float) -> float:
    return value if value > 0.0 else ENDLESS


def _along(piece: PathPiece, k: int, axis: PathAxis, slope: float) -> None:
    """The limits of an axis that has a constant share of the motion."""
    if slope * ENDLESS > axis.jerk:
        piece.caps[k] = min(piece.caps[k], axis.velocity / slope)
        piece.starts[k] = min(piece.starts[k], axis.acceleration / slope)
        piece.accelerations[k] = min(piece.accelerations[k], axis.acceleration / slope)
        piece.rests[k] = min(piece.rests[k], axis.deceleration / slope)
        piece.decelerations[k] = min(piece.decelerations[k], axis.deceleration / slope)
        piece.first_jerks[k] = min(piece.first_jerks[k], axis.jerk / slope)
        piece.jerks[k] = min(piece.jerks[k], axis.jerk / slope)


def _leave_jerk(
    piece: PathPiece, k: int, axis: PathAxis, slope: float, twist: float, mixed: float
) -> None:
    """The jerk that is left at rest and at the highest velocity, where the bend takes these."""
    if slope * ENDLESS > axis.jerk:
        piece.first_jerks[k] = min(piece.first_jerks[k], (axis.jerk - mixed) / slope)
        piece.jerks[k] = min(piece.jerks[k], (axis.jerk - mixed - twist) / slope)


def _largest_cosine(begin: float, end: float) -> float:
    """The largest |cos| of angles between two."""
    if ceil(min(begin, end) / pi) <= floor(max(begin, end) / pi):
        return 1.0
    return max(fabs(cos(begin)), fabs(cos(end)))


def _bound_arc(piece: PathPiece, k: int, axes: Sequence[PathAxis], state: PathState) -> None:
    turn = piece.turn
    for i in range(MAIN_AXES, state.axis_count):
        _along(piece, k, axes[i], fabs(piece.slope[i]))
    # velocity first, as the rest is what it leaves
    v = piece.caps[k]
    for i in range(min(MAIN_AXES, state.axis_count)):
        axis = axes[i]
        along, across = _arc_shares(piece, k, i)
        straight = fabs(piece.slope[i])
        if along * turn + straight > 0.0:
            v = min(v, axis.velocity / (along * turn + straight))
        if across > 0.0:
            weakest = min(axis.acceleration, axis.deceleration)
            v = min(v, sqrt(_BEND_SHARE * weakest / (across * turn * turn)))
        if along > 0.0:
            cube = _TWIST_SHARE * axis.jerk / (along * turn * turn * turn)
            v = min(v, cube ** (1.0 / 3.0))
    piece.caps[k] = v
    for i in range(min(MAIN_AXES, state.axis_count)):
        axis = axes[i]
        along, across = _arc_shares(piece, k, i)
        size = sqrt(_square(piece.first_radius[i]) + _square(piece.second_radius[i])) * turn
        straight = fabs(piece.slope[i])
        share = along * turn + straight
        if share <= 0.0:
            continue
        bend = turn * v * v
        piece.starts[k] = min(piece.starts[k], axis.acceleration / share)
        piece.rests[k] = min(piece.rests[k], axis.deceleration / share)
        if across > 0.0:
            power = _MIXED_SHARE * axis.jerk / (3.0 * across * turn * turn)
            piece.powers[k] = min(piece.powers[k], power)
        for n in range(2):
            limit = axis.deceleration if n else axis.acceleration
            # either estimate is safe: of the largest values apart, of the turning vector
            rest = (limit - across * turn * bend) / share
            square = limit * limit - _square(size * bend)
            if straight <= 0.0 and square > 0.0:
                rest = max(rest, sqrt(square) / size)
            if n:
                piece.decelerations[k] = min(piece.decelerations[k], rest)
            else:
                piece.accelerations[k] = min(piece.accelerations[k], rest)
    piece.accelerations[k] = min(piece.accelerations[k], piece.powers[k] / v)
    strongest = min(max(piece.starts[k], piece.rests[k]) * v, piece.powers[k])
    for i in range(min(MAIN_AXES, state.axis_count)):
        along, across = _arc_shares(piece, k, i)
        twist = along * turn * turn * turn * v * v * v
        mixed = 3.0 * across * turn * turn * strongest
        _leave_jerk(piece, k, axes[i], along * turn + fabs(piece.slope[i]), twist, mixed)


def _square(x: float) -> float:
    return x * x


def _arc_shares(piece: PathPiece, k: int, i: int) -> tuple[float, float]:
    """The largest share of an axis in the direction of an arc, and across it; both times radius."""
    x = piece.first_radius[i]
    y = piece.second_radius[i]
    size = sqrt(x * x + y * y)
    if size <= 0.0:
        return 0.0, 0.0
    # across: x cos + y sin = size cos(angle - start)
    begin = piece.turn * (piece.ends[k - 1] if k else 0.0) - atan2(y, x)
    end = piece.turn * piece.ends[k] - atan2(y, x)
    across = _largest_cosine(begin, end)
    along = _largest_cosine(begin - 0.5 * pi, end - 0.5 * pi)
    return size * along, size * across


def _bound_curve(piece: PathPiece, k: int, axes: Sequence[PathAxis], state: PathState) -> None:
    point = state.before
    v = piece.caps[k]
    for n in range(_SAMPLES + 1):
        curve_point(piece, (k + n * _SAMPLE) / SPANS, point)
        for i in range(state.axis_count):
            axis = axes[i]
            v = min(v, axis.velocity / (_MARGIN * fabs(point.tangent[i]) + 1.0 / ENDLESS))
            bend = _MARGIN * fabs(point.bend[i]) + 1.0 / ENDLESS
            weakest = min(axis.acceleration, axis.deceleration)
            v = min(v, sqrt(_BEND_SHARE * weakest / bend))
            twist = _MARGIN * fabs(point.twist[i]) + 1.0 / ENDLESS
            v = min(v, (_TWIST_SHARE * axis.jerk / twist) ** (1.0 / 3.0))
    piece.caps[k] = v
    for n in range(_SAMPLES + 1):
        curve_point(piece, (k + n * _SAMPLE) / SPANS, point)
        for i in range(state.axis_count):
            axis = axes[i]
            slope = _MARGIN * fabs(point.tangent[i]) + 1.0 / ENDLESS
            bend = _MARGIN * fabs(point.bend[i]) + 1.0 / ENDLESS
            piece.powers[k] = min(piece.powers[k], _MIXED_SHARE * axis.jerk / (3.0 * bend))
            up, down = axis.acceleration / slope, axis.deceleration / slope
            taken = bend * v * v / slope
            piece.starts[k] = min(piece.starts[k], up)
            piece.accelerations[k] = min(piece.accelerations[k], up - taken)
            piece.rests[k] = min(piece.rests[k], down)
            piece.decelerations[k] = min(piece.decelerations[k], down - taken)
    piece.accelerations[k] = min(piece.accelerations[k], piece.powers[k] / v)
    strongest = min(max(piece.starts[k], piece.rests[k]) * v, piece.powers[k])
    for n in range(_SAMPLES + 1):
        curve_point(piece, (k + n * _SAMPLE) / SPANS, point)
        for i in range(state.axis_count):
            twist = _MARGIN * fabs(point.twist[i]) * v * v * v
            mixed = 3.0 * _MARGIN * fabs(point.bend[i]) * strongest
            _leave_jerk(piece, k, axes[i], _MARGIN * fabs(point.tangent[i]), twist, mixed)
