"""Transitions: the velocity with which the path may go from one element to the next.

C0 is a corner, C1 a tangent that goes on with another curvature, C2 a curvature that goes on too.
The rules are those of 002 §6.4.3.1, 0x3000+ID:0x500 to 0x505, and of the public pages on them;
`keep_jerk` is achse's own (decision 0123).

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from collections.abc import Sequence
from enum import IntEnum
from math import atan2, cos, fabs, pi, sqrt, tan

from achse.motion.path.bounds import ENDLESS, feed_at
from achse.motion.path.geometry import point_at
from achse.motion.path.record import (
    MAIN_AXES,
    ElementKind,
    PathAxis,
    PathElement,
    PathPlace,
    PathState,
)

_STRAIGHT = 1e-6
"""Angle up to which a tangent goes on, rad."""
_SAME_BEND = 1e-6
"""Difference of curvature up to which it goes on, relative."""
_NO_BEND = 1e-9
"""1/mm."""
_REVERSAL = 1e-9
_RESERVE = 0.7
"""Part of what may jump in a cycle that jumps may take at once which are not alone in it."""


class ReductionMethod(IntEnum):
    """Reduction of the velocity at a corner (0x3000+ID:0x500)."""

    COULOMB = 0
    COSINE = 1
    VELO_JUMP = 2
    DEVIATION_ANGLE = 3


def angle_between(a: PathPlace, b: PathPlace) -> float:
    """Angle of the tangents in X, Y, Z, 0..pi; pi where one of them does not move these."""
    product = 0.0
    first = 0.0
    second = 0.0
    difference = 0.0
    total = 0.0
    for i in range(MAIN_AXES):
        x = a.tangent[i]
        y = b.tangent[i]
        product += x * y
        first += x * x
        second += y * y
    if first < 0.5 or second < 0.5:
        return pi
    # accurate for small angles, where the cosine is not
    for i in range(MAIN_AXES):
        d = a.tangent[i] - b.tangent[i]
        s = a.tangent[i] + b.tangent[i]
        difference += d * d
        total += s * s
    return 2.0 * atan2(sqrt(difference), sqrt(total))


def corner_factor(method: int, angle: float, c0: float, low: float, high: float) -> float:
    """Factor on the velocity at a corner; angles in rad.

    Coulomb: c0 sqrt(tan((pi - angle) / 2)), at most 1, and c0 at a reversal, as printed. Cosine: 1
    up to the low angle, c0 from the high angle on. Deviation angle: c0 between them, 0 above.
    """
    if angle <= low:
        return 1.0
    if method == ReductionMethod.COULOMB:
        if angle >= pi - _REVERSAL:
            return c0
        return min(1.0, c0 * sqrt(tan(0.5 * (pi - angle))))
    if method == ReductionMethod.COSINE:
        if angle >= high:
            return c0
        return 1.0 - (1.0 - c0) * (cos(low) - cos(angle)) / (cos(low) - cos(high))
    if method == ReductionMethod.DEVIATION_ANGLE:
        return 0.0 if angle > high else c0
    return 1.0


def transition(
    element: PathElement, following: PathElement, axes: Sequence[PathAxis], state: PathState
) -> float:
    """Velocity allowed from the end of an element to the beginning of the following one, mm/s."""
    a, b = state.before, state.after
    point_at(element, element.length, a)
    point_at(following, 0.0, b)
    if state.keep_jerk:
        element.bend_jump = _bend_jump(a, b, axes, state)
    most = min(
        min(
            feed_at(element, element.length) * state.most_override, element.caps[element.spans - 1]
        ),
        min(feed_at(following, 0.0) * state.most_override, following.caps[0]),
    )
    angle = angle_between(a, b)
    jump = ENDLESS
    shorter = 0.5 * (element.whole + following.whole)
    for i in range(state.axis_count):
        axis = axes[i]
        step = fabs(a.tangent[i] - b.tangent[i])
        if step <= _STRAIGHT:
            continue
        if i >= MAIN_AXES or state.method == ReductionMethod.VELO_JUMP:
            jump = min(jump, axis.jump / step)
        # corners that follow faster than cycles add up to a bend: its acceleration is bounded too
        weakest = min(axis.acceleration, axis.deceleration)
        together = max(shorter / state.cycle_time, sqrt(weakest * shorter / step))
        jump = min(jump, together)
    if angle > _STRAIGHT:
        factor = corner_factor(state.method, angle, state.c0, state.angle_low, state.angle_high)
        return max(min(factor * most, jump), min(state.least_velocity, most))
    factor = state.c2
    for i in range(MAIN_AXES):
        step = fabs(a.bend[i] - b.bend[i])
        if step > _SAME_BEND * (fabs(a.bend[i]) + fabs(b.bend[i])) + _NO_BEND:
            factor = state.c1
    return max(min(factor * most, jump), min(state.least_velocity, most))


def _bend_jump(a: PathPlace, b: PathPlace, axes: Sequence[PathAxis], state: PathState) -> float:
    """Return the share of what may jump in a cycle by squared velocity, s²/mm²."""
    share = 0.0
    square = 0.0
    for i in range(state.axis_count):
        step = fabs(a.bend[i] - b.bend[i])
        share = max(share, step / axes[i].bend_jump)
        if i < MAIN_AXES:
            square += step * step
    if state.path_jerk > 0.0:
        share = max(share, sqrt(square) / (state.path_jerk * state.cycle_time))
    return share


def keep_jerk(
    elements: Sequence[PathElement], number: int, following: PathElement, state: PathState
) -> None:
    """Lower the velocity at the end of an element so that the axes keep their jerk there.

    Jumps of curvature that the path can pass within a cycle add up to what may jump in one. A jump
    that is alone in its cycle takes all of it. The others take from a reserve that fills up on the
    way, and leave as much for the next one.
    """
    rows = len(elements)
    element = elements[number % rows]
    before = elements[(number - 1) % rows]
    v = ENDLESS
    if element.bend_jump > 0.0:
        v = sqrt(1.0 / element.bend_jump)
    reserve = _RESERVE
    spent = 1.0
    if number > 0:
        spent = _least_cycles(element, element.length, min(v, before.junction), state)
        if spent < 1.0:
            reserve = min(_RESERVE, before.bend_reserve + (1.0 - _RESERVE) * spent)
    if element.bend_jump > 0.0:
        # rounding the corner at its end can take half of a segment
        room = following.length
        if following.kind != ElementKind.CURVE:
            room -= 0.5 * following.whole
        ahead = _least_cycles(following, room, v, state)
        if spent < 1.0 or ahead < 1.0:
            share = reserve
            if ahead < 1.0:
                share = min(reserve, 0.5 * (reserve + (1.0 - _RESERVE) * ahead))
            v = sqrt(share / element.bend_jump)
        element.junction = min(element.junction, v)
    element.bend_reserve = max(
        reserve - element.bend_jump * element.junction * element.junction, 0.0
    )


def _least_cycles(element: PathElement, length: float, v: float, state: PathState) -> float:
    """Return the least number of cycles, up to 1, for a part of an element with v at one end."""
    fastest = 0.0
    strongest = 0.0
    for k in range(element.spans):
        fastest = max(fastest, element.caps[k])
        strongest = max(strongest, max(element.starts[k], element.rests[k]))
    fastest = min(fastest, v + 0.5 * strongest * state.cycle_time)
    if length >= fastest * state.cycle_time:
        return 1.0
    return max(length, 0.0) / (fastest * state.cycle_time)
