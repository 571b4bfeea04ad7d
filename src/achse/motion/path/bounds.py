"""Bounds of an element: velocity, acceleration and jerk along the path within limits of all axes.

On a path q(s) an axis has the velocity q' v, the acceleration q' a + q'' v², and the jerk
q' j + 3 q'' v a + q''' v³. A line leaves all of its limits to v, a and j. Where the path bends, v
takes a share of acceleration and jerk, and the rest is for a and j: the more the slower it is. What
is left falls no faster with v² (acceleration) and v³ (jerk) than in a straight line between its
values at rest and at the highest velocity; these two are stored, for each span of an element.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from collections.abc import Sequence
from math import atan2, ceil, cos, fabs, floor, pi, sqrt

from achse.motion.path.geometry import curve_point
from achse.motion.path.record import (
    KNOTS,
    MAIN_AXES,
    SPANS,
    ElementKind,
    PathAxis,
    PathElement,
    PathState,
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


def bound(element: PathElement, axes: Sequence[PathAxis], state: PathState) -> None:
    """Fill in what the element allows."""
    element.spans = 1
    element.ends[0] = element.length
    if element.start_feed != element.feed:
        element.spans = min(max(floor(element.length / _SPAN_LENGTH), 1), SPANS)
    if element.kind == ElementKind.ARC:
        bends = min(max(ceil(element.turn * element.length / _SPAN_ANGLE), 1), SPANS)
        element.spans = max(element.spans, bends)
    if element.kind == ElementKind.LINE or element.kind == ElementKind.ARC:
        for k in range(element.spans):
            element.ends[k] = element.length * (k + 1) / element.spans
    elif element.kind == ElementKind.CURVE:
        element.spans = SPANS
        for k in range(SPANS):
            element.ends[k] = element.ways[(KNOTS - 1) // SPANS * (k + 1)]
    element.path_acceleration = _limit_of(state.path_acceleration)
    element.path_deceleration = _limit_of(state.path_deceleration)
    element.path_jerk = _limit_of(state.path_jerk)
    element.deceleration = element.path_deceleration
    element.jerk = element.path_jerk
    for k in range(element.spans):
        element.caps[k] = span_feed(element, k) * state.most_override
        element.starts[k] = element.accelerations[k] = ENDLESS
        element.rests[k] = element.decelerations[k] = element.powers[k] = ENDLESS
        element.first_jerks[k] = element.jerks[k] = ENDLESS
        if element.kind == ElementKind.WAIT:
            continue
        if element.kind == ElementKind.LINE:
            for i in range(state.axis_count):
                _along(element, k, axes[i], fabs(element.slope[i]))
        else:
            if element.kind == ElementKind.ARC:
                _bound_arc(element, k, axes, state)
            else:
                _bound_curve(element, k, axes, state)
            # falling with the square of the velocity takes at most 0.77 start² / cap of the jerk
            cap = element.caps[k]
            fit = sqrt(_FALL_SHARE * element.jerks[k] * cap)
            most = min(element.starts[k], min(fit, element.powers[k] / cap))
            element.starts[k] = max(most, element.accelerations[k])
        least = min(element.decelerations[k], element.powers[k] / element.caps[k])
        element.deceleration = min(element.deceleration, least)
        element.jerk = min(element.jerk, element.jerks[k])


def feed_at(element: PathElement, way: float) -> float:
    """Programmed velocity at a way from the beginning of an element, mm/s."""
    if element.start_feed == element.feed:
        return element.feed
    return (
        element.start_feed
        + (element.feed - element.start_feed) * way / element.ends[element.spans - 1]
    )


def span_feed(element: PathElement, k: int) -> float:
    """Programmed velocity of a part of an element: that of its middle, mm/s."""
    begin = element.ends[k - 1] if k else 0.0
    return feed_at(element, 0.5 * (begin + element.ends[k]))


def _limit_of(value: float) -> float:
    return value if value > 0.0 else ENDLESS


def _along(element: PathElement, k: int, axis: PathAxis, slope: float) -> None:
    """Bound an element by the limits of an axis that has a constant share of the motion."""
    if slope * ENDLESS > axis.jerk:
        element.caps[k] = min(element.caps[k], axis.velocity / slope)
        element.starts[k] = min(element.starts[k], axis.acceleration / slope)
        element.accelerations[k] = min(element.accelerations[k], axis.acceleration / slope)
        element.rests[k] = min(element.rests[k], axis.deceleration / slope)
        element.decelerations[k] = min(element.decelerations[k], axis.deceleration / slope)
        element.first_jerks[k] = min(element.first_jerks[k], axis.jerk / slope)
        element.jerks[k] = min(element.jerks[k], axis.jerk / slope)


def _leave_jerk(
    element: PathElement, k: int, axis: PathAxis, slope: float, twist: float, mixed: float
) -> None:
    """Bound the jerk left at rest and at the highest velocity by what the bend takes of these."""
    if slope * ENDLESS > axis.jerk:
        element.first_jerks[k] = min(element.first_jerks[k], (axis.jerk - mixed) / slope)
        element.jerks[k] = min(element.jerks[k], (axis.jerk - mixed - twist) / slope)


def _largest_cosine(begin: float, end: float) -> float:
    """Return the largest |cos| of angles between two."""
    if ceil(min(begin, end) / pi) <= floor(max(begin, end) / pi):
        return 1.0
    return max(fabs(cos(begin)), fabs(cos(end)))


def _bound_arc(element: PathElement, k: int, axes: Sequence[PathAxis], state: PathState) -> None:
    turn = element.turn
    for i in range(MAIN_AXES, state.axis_count):
        _along(element, k, axes[i], fabs(element.slope[i]))
    # velocity first, as the rest is what it leaves
    v = element.caps[k]
    for i in range(min(MAIN_AXES, state.axis_count)):
        axis = axes[i]
        along, across = _arc_shares(element, k, i)
        straight = fabs(element.slope[i])
        if along * turn + straight > 0.0:
            v = min(v, axis.velocity / (along * turn + straight))
        if across > 0.0:
            weakest = min(axis.acceleration, axis.deceleration)
            v = min(v, sqrt(_BEND_SHARE * weakest / (across * turn * turn)))
        if along > 0.0:
            cube = _TWIST_SHARE * axis.jerk / (along * turn * turn * turn)
            v = min(v, cube ** (1.0 / 3.0))
    element.caps[k] = v
    for i in range(min(MAIN_AXES, state.axis_count)):
        axis = axes[i]
        along, across = _arc_shares(element, k, i)
        size = sqrt(_square(element.first_radius[i]) + _square(element.second_radius[i])) * turn
        straight = fabs(element.slope[i])
        share = along * turn + straight
        if share <= 0.0:
            continue
        bend = turn * v * v
        element.starts[k] = min(element.starts[k], axis.acceleration / share)
        element.rests[k] = min(element.rests[k], axis.deceleration / share)
        if across > 0.0:
            power = _MIXED_SHARE * axis.jerk / (3.0 * across * turn * turn)
            element.powers[k] = min(element.powers[k], power)
        for n in range(2):
            limit = axis.deceleration if n else axis.acceleration
            # either estimate is safe: of the largest values apart, of the turning vector
            rest = (limit - across * turn * bend) / share
            square = limit * limit - _square(size * bend)
            if straight <= 0.0 and square > 0.0:
                rest = max(rest, sqrt(square) / size)
            if n:
                element.decelerations[k] = min(element.decelerations[k], rest)
            else:
                element.accelerations[k] = min(element.accelerations[k], rest)
    element.accelerations[k] = min(element.accelerations[k], element.powers[k] / v)
    strongest = min(max(element.starts[k], element.rests[k]) * v, element.powers[k])
    for i in range(min(MAIN_AXES, state.axis_count)):
        along, across = _arc_shares(element, k, i)
        twist = along * turn * turn * turn * v * v * v
        mixed = 3.0 * across * turn * turn * strongest
        _leave_jerk(element, k, axes[i], along * turn + fabs(element.slope[i]), twist, mixed)


def _square(x: float) -> float:
    return x * x


def _arc_shares(element: PathElement, k: int, i: int) -> tuple[float, float]:
    """Return the largest share of an axis in the direction of an arc, and across it; both times
    radius."""
    x = element.first_radius[i]
    y = element.second_radius[i]
    size = sqrt(x * x + y * y)
    if size <= 0.0:
        return 0.0, 0.0
    # across: x cos + y sin = size cos(angle - start)
    begin = element.turn * (element.ends[k - 1] if k else 0.0) - atan2(y, x)
    end = element.turn * element.ends[k] - atan2(y, x)
    across = _largest_cosine(begin, end)
    along = _largest_cosine(begin - 0.5 * pi, end - 0.5 * pi)
    return size * along, size * across


def _bound_curve(element: PathElement, k: int, axes: Sequence[PathAxis], state: PathState) -> None:
    point = state.before
    v = element.caps[k]
    for n in range(_SAMPLES + 1):
        curve_point(element, (k + n * _SAMPLE) / SPANS, point)
        for i in range(state.axis_count):
            axis = axes[i]
            v = min(v, axis.velocity / (_MARGIN * fabs(point.tangent[i]) + 1.0 / ENDLESS))
            bend = _MARGIN * fabs(point.bend[i]) + 1.0 / ENDLESS
            weakest = min(axis.acceleration, axis.deceleration)
            v = min(v, sqrt(_BEND_SHARE * weakest / bend))
            twist = _MARGIN * fabs(point.twist[i]) + 1.0 / ENDLESS
            v = min(v, (_TWIST_SHARE * axis.jerk / twist) ** (1.0 / 3.0))
    element.caps[k] = v
    for n in range(_SAMPLES + 1):
        curve_point(element, (k + n * _SAMPLE) / SPANS, point)
        for i in range(state.axis_count):
            axis = axes[i]
            slope = _MARGIN * fabs(point.tangent[i]) + 1.0 / ENDLESS
            bend = _MARGIN * fabs(point.bend[i]) + 1.0 / ENDLESS
            element.powers[k] = min(element.powers[k], _MIXED_SHARE * axis.jerk / (3.0 * bend))
            up, down = axis.acceleration / slope, axis.deceleration / slope
            taken = bend * v * v / slope
            element.starts[k] = min(element.starts[k], up)
            element.accelerations[k] = min(element.accelerations[k], up - taken)
            element.rests[k] = min(element.rests[k], down)
            element.decelerations[k] = min(element.decelerations[k], down - taken)
    element.accelerations[k] = min(element.accelerations[k], element.powers[k] / v)
    strongest = min(max(element.starts[k], element.rests[k]) * v, element.powers[k])
    for n in range(_SAMPLES + 1):
        curve_point(element, (k + n * _SAMPLE) / SPANS, point)
        for i in range(state.axis_count):
            twist = _MARGIN * fabs(point.twist[i]) * v * v * v
            mixed = 3.0 * _MARGIN * fabs(point.bend[i]) * strongest
            _leave_jerk(element, k, axes[i], _MARGIN * fabs(point.tangent[i]), twist, mixed)
