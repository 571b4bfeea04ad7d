"""Paths at random: always on the contour, no axis beyond its limits, stopped and turned anywhere.

Every parameter is drawn: axes, limits, cycle time, dynamics, smoothing, transitions, segments,
feeds, commands. Where the curvature jumps (a C1 transition) the acceleration of an axis jumps; such
cycles count for its jerk with `keep_jerk` only.
"""

from dataclasses import dataclass, field
from math import atan2, cos, dist, hypot, pi, sin
from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.motion.path import (
    PLANE_XY,
    PLANE_YZ,
    PLANE_ZX,
    ArcGeometry,
    PathArc,
    PathDwell,
    PathLimits,
    PathLine,
    PathOverride,
    PathParameters,
    PathPlanner,
    PathTableFull,
    ReductionMethod,
    Smoothing,
    SmoothingSubtype,
    arc_through,
    plane_arc,
)
from achse.motion.path.compiled import KERNEL

Point = tuple[float, ...]
SLACK = 1.0001


@dataclass
class Contour:
    """What was programmed, to measure distances."""

    parts: list[tuple[Point, Point] | ArcGeometry] = field(default_factory=list)
    tangent: Point | None = None
    """Direction of the last segment, if it is a line."""

    def distance(self, point: Point, near: int) -> float:
        """To the parts around block `near`."""
        parts = self.parts[max(near - 2, 0) : near + 3] or [(point, point)]
        return min(self._to(part, point[:3]) for part in parts)

    def _to(self, part: tuple[Point, Point] | ArcGeometry, point: Point) -> float:
        if isinstance(part, ArcGeometry):
            return _to_arc(part, point)
        begin, end = part
        along = [b - a for a, b in zip(begin, end, strict=True)]
        square = sum(x * x for x in along)
        way = sum((p - a) * d for p, a, d in zip(point, begin, along, strict=True))
        share = min(max(way / square, 0.0), 1.0) if square else 0.0
        return dist(point, [a + share * d for a, d in zip(begin, along, strict=True)])


def _to_arc(arc: ArcGeometry, point: Point) -> float:
    def at(angle: float) -> Point:
        share = angle / arc.angle
        return tuple(
            c + x * cos(angle) + y * sin(angle) + r * share
            for c, x, y, r in zip(
                arc.centre, arc.first_radius, arc.second_radius, arc.rise, strict=True
            )
        )

    off = [p - c for p, c in zip(point, arc.centre, strict=True)]
    angle = atan2(
        sum(x * y for x, y in zip(off, arc.second_radius, strict=True)),
        sum(x * y for x, y in zip(off, arc.first_radius, strict=True)),
    ) % (2.0 * pi)
    nearest = min(dist(point, at(place)) for place in (0.0, angle, arc.angle) if place <= arc.angle)
    square = sum(x * x for x in arc.rise)
    if square <= 0.0:
        return nearest
    # of a helix the nearest place is between the one of this angle and the one of this height
    height = arc.angle * sum(x * y for x, y in zip(off, arc.rise, strict=True)) / square
    low, high = sorted(min(max(place, 0.0), arc.angle) for place in (angle, height))
    for _ in range(60):
        third = (high - low) / 3.0
        if dist(point, at(low + third)) < dist(point, at(high - third)):
            high -= third
        else:
            low += third
    return min(nearest, dist(point, at(low)))


def _draw_parameters(draw: Random) -> PathParameters:
    low = draw.uniform(0.0, 60.0)
    return PathParameters(
        method=draw.choice(list(ReductionMethod)),
        c0=0.0,
        c1=draw.choice([1.0, draw.random()]),
        c2=draw.choice([1.0, draw.random()]),
        angle_low=0.0,
        angle_high=draw.uniform(low + 1.0, 180.0),
        keep_jerk=draw.random() < 0.5,
        smoothing=draw.choice(list(Smoothing)),
        smoothing_subtype=draw.choice(list(SmoothingSubtype)),
        smoothing_radius=10 ** draw.uniform(-3, 1),
        acceleration=draw.choice([0.0, 10 ** draw.uniform(2, 4)]),
        deceleration=draw.choice([0.0, 10 ** draw.uniform(2, 4)]),
        jerk=draw.choice([0.0, 10 ** draw.uniform(3, 6)]),
        override_type=draw.choice(list(PathOverride)),
        most_override=draw.uniform(1.0, 2.0),
    )


def _draw_limits(draw: Random) -> PathLimits:
    return PathLimits(
        10 ** draw.uniform(1, 3),
        10 ** draw.uniform(2, 4),
        10 ** draw.uniform(3, 6),
        draw.choice([0.0, 10 ** draw.uniform(2, 4)]),
        velo_jump=0.0,
    )


def _tangential_arc(
    draw: Random, begin: Point, tangent: Point | None, size: float
) -> ArcGeometry | None:
    """Return an arc in X and Y that goes on in the direction of the path, if it has one there."""
    if tangent is None or hypot(tangent[0], tangent[1]) < 0.999999:
        return None
    clockwise = draw.random() < 0.5
    side = -size if clockwise else size
    centre = begin[0] - side * tangent[1], begin[1] + side * tangent[0]
    turn = draw.uniform(0.02, 3.0) * (-1.0 if clockwise else 1.0)
    x, y = begin[0] - centre[0], begin[1] - centre[1]
    end = centre[0] + x * cos(turn) - y * sin(turn), centre[1] + x * sin(turn) + y * cos(turn)
    return plane_arc(begin, (*end, begin[2]), clockwise=clockwise, centre=centre)


def _draw_segment(
    draw: Random, path: PathPlanner, contour: Contour, block: int, goes_on: bool
) -> None:
    start = path.programmed_position
    begin = start[:3]
    feed = 10 ** draw.uniform(0, 3)
    begun = draw.choice([None, None, 10 ** draw.uniform(0, 3)])
    size = 10 ** draw.uniform(-2, 2)
    auxiliary = [x + draw.choice([0.0, draw.uniform(-size, size)]) for x in start[3:]]
    kind = draw.random()
    onward = _tangential_arc(draw, begin, contour.tangent, size) if goes_on else None
    contour.tangent = None
    if onward is not None and kind < 0.8:
        path.append(PathArc(onward, feed, auxiliary, block, start_feed=begun))
        contour.parts.append(onward)
        return
    if kind < 0.6:
        end = [x + draw.choice([0.0, draw.uniform(-size, size)]) for x in begin]
        exact = draw.random() < 0.1
        path.append(PathLine([*end, *auxiliary], feed, block, exact_stop=exact, start_feed=begun))
        contour.parts.append((begin, tuple(end)))
        length = dist(begin, end)
        if length > 0.0:
            x, y, z = ((b - a) / length for a, b in zip(begin, end, strict=True))
            contour.tangent = x, y, z
        return
    if kind < 0.65:
        path.append(PathDwell(draw.uniform(0.0, 0.03), block))
        contour.parts.append((begin, begin))
        return
    if kind < 0.75:
        points = [[x + draw.uniform(-size, size) for x in begin] for _ in range(2)]
        arc = arc_through(begin, *points)
    else:
        plane = draw.choice([PLANE_XY, PLANE_YZ, PLANE_ZX])
        place, angle = draw.uniform(0, 2 * pi), draw.uniform(0.02, 2 * pi - 0.02)
        clockwise = draw.random() < 0.5
        centre = (
            begin[plane.first] - size * cos(place),
            begin[plane.second] - size * sin(place),
        )
        turned = place - angle if clockwise else place + angle
        end = list(begin)
        end[plane.first] = centre[0] + size * cos(turned)
        end[plane.second] = centre[1] + size * sin(turned)
        end[plane.normal] += draw.choice([0.0, draw.uniform(-size, size)])
        arc = plane_arc(begin, end, plane=plane, clockwise=clockwise, centre=centre)
    path.append(PathArc(arc, feed, auxiliary, block, start_feed=begun))
    contour.parts.append(arc)


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_paths_at_random(seed: int, turns: bool) -> None:
    draw = Random(seed)
    axes = [_draw_limits(draw) for _ in range(draw.randint(3, 8))]
    cycle_time = draw.choice([0.0005, 0.001, 0.002, 0.004, 0.01])
    parameters = _draw_parameters(draw)
    start = [draw.uniform(-100.0, 100.0) for _ in axes]
    path = PathPlanner(
        axes,
        start,
        cycle_time=cycle_time,
        parameters=parameters,
        table=draw.choice([4, 16, 128]),
        history=64,
        compiled=KERNEL.available,
    )
    contour = Contour()
    count = draw.randint(1, 16)
    smooth = parameters.smoothing != Smoothing.OFF
    tolerance = parameters.smoothing_radius if smooth else 0.0
    # of these no transition lets the acceleration jump beyond the jerk
    even = parameters.keep_jerk or parameters.smoothing in (Smoothing.OFF, Smoothing.QUINTIC)
    even = even and parameters.method != ReductionMethod.COSINE  # corners of small angles
    goes_on = parameters.keep_jerk and draw.random() < 0.5
    block, before, still = 0, path.axis_acceleration, 0
    for cycle in range(8_000):  # long enough to be anywhere; slow ones do not end
        while block < count:
            try:
                _draw_segment(draw, path, contour, block, goes_on)
            except PathTableFull:
                break
            block += 1
        if draw.random() < 0.01:
            _draw_command(draw, path, turns)
        if path.finished and block == count and not path.backwards:
            break
        still = still + 1 if path.standstill else 0
        if still > 40:
            path.step_on()
            path.backwards = False
            path.override = max(path.override, 0.3)
        crossed = path.state.current
        path.advance()
        velocity, acceleration = path.axis_velocity, path.axis_acceleration
        for n, axis in enumerate(axes):
            strongest = max(axis.acceleration, axis.deceleration)
            assert abs(velocity[n]) <= SLACK * axis.velocity
            assert abs(acceleration[n]) <= SLACK * strongest
            if even or path.state.current == crossed:
                rise = abs(acceleration[n] - before[n])
                assert rise <= SLACK * axis.jerk * cycle_time + 1e-6
        before = acceleration
        if cycle % 7 == 0:
            assert contour.distance(path.position, path.block) <= tolerance + 2e-7 * smooth + 1e-9


def _draw_command(draw: Random, path: PathPlanner, turns: bool) -> None:
    command = draw.randint(0, 5)
    if command == 0:
        path.override = draw.uniform(0.0, path.state.most_override)
    elif command == 1:
        path.hold()
    elif command == 2:
        path.step_on()
    elif command == 3:
        path.emergency_stop(10 ** draw.uniform(2, 5), 10 ** draw.uniform(3, 7))
    elif command == 4:
        path.single_block = draw.random() < 0.5
    elif turns and path.standstill:
        path.backwards = not path.backwards
    path.next_block()
