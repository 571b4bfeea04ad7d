"""Transitions: the values of the printed rules."""

from math import cos, pi, radians, sin
from typing import Any

import pytest

from achse.motion.path import (
    PathArc,
    PathLine,
    PathPlanner,
    Smoothing,
    plane_arc,
)
from achse.motion.path.corners import ReductionMethod, angle_between, corner_factor, transition
from achse.motion.path.parameters import PathLimits, PathParameters
from achse.motion.path.record import (
    ElementKind,
    axis_record,
    element_record,
    state_record,
)


@pytest.mark.parametrize(
    ("degrees", "factor"),
    [
        (30, 1.931851653),
        (60, 1.316074013),
        (90, 1.0),
        (120, 0.759835686),
        (150, 0.517638090),
    ],
)
def test_coulomb(degrees: float, factor: float) -> None:
    corner = corner_factor(ReductionMethod.COULOMB, radians(degrees), 0.5, 0.0, pi)
    assert corner == pytest.approx(min(1.0, 0.5 * factor), abs=1e-9)


def test_coulomb_at_its_ends() -> None:
    assert corner_factor(ReductionMethod.COULOMB, pi, 0.3, 0.0, pi) == 0.3
    assert corner_factor(ReductionMethod.COULOMB, pi, 0.3, pi, pi) == 1.0
    assert corner_factor(ReductionMethod.COULOMB, 0.1, 0.0, 0.0, pi) == 0.0


@pytest.mark.parametrize(
    ("degrees", "factor"),
    [
        (5, 1.0),
        (10, 1.0),
        (30, 0.903508193),
        (50, 0.722162916),
        (70, 0.477837084),
        (90, 0.2),
        (170, 0.2),
    ],
)
def test_cosine(degrees: float, factor: float) -> None:
    low, high = radians(10), radians(90)
    corner = corner_factor(ReductionMethod.COSINE, radians(degrees), 0.2, low, high)
    assert corner == pytest.approx(factor, abs=1e-9)


@pytest.mark.parametrize(("degrees", "factor"), [(9, 1.0), (50, 0.4), (91, 0.0)])
def test_deviation_angle(degrees: float, factor: float) -> None:
    method = ReductionMethod.DEVIATION_ANGLE
    assert corner_factor(method, radians(degrees), 0.4, radians(10), radians(90)) == factor


@pytest.mark.parametrize(
    ("parameters", "off", "jump"),
    [
        ({}, 0.0, 6.0),  # 30 % of 10000 mm/s³ in 2 ms, mm/s²
        ({"c1": 0.0}, 0.0, 0.0),
        ({"jerk": 1000.0}, 0.0, 2.0),  # that of the path, all of it
        ({"least_velocity": 50.0}, 0.0, 6.0),
        ({"method": ReductionMethod.DEVIATION_ANGLE, "c0": 1.0}, 1e-4, 6.0),  # a rounded I or J
    ],
)
def test_kept_jerk_bounds_the_jump_of_acceleration(
    parameters: dict[str, Any], off: float, jump: float
) -> None:
    settings = PathParameters(keep_jerk=True, **parameters)
    axes = [PathLimits(1000.0, 1000.0, 10000.0)] * 3
    path = PathPlanner(axes, (0, 0, 0), parameters=settings)
    path.append(PathLine((40, 0, 0), 100))
    centre = 40 - 10 * sin(off), 10 * cos(off)
    end = centre[0], centre[1] + 10
    path.append(PathArc(plane_arc((40, 0, 0), (*end, 0), centre=centre, clockwise=False), 100))
    assert path.end_velocity**2 / 10.0 == pytest.approx(jump, rel=1e-6)


@pytest.mark.parametrize(("length", "least"), [(0.01, 0.14), (0.5, 0.35)])
def test_jumps_within_a_cycle_share_the_jerk(length: float, least: float) -> None:
    """Smoothing takes the whole of these lines, so that each has two jumps at one place."""
    settings = PathParameters(
        keep_jerk=True, smoothing=Smoothing.CUBIC, smoothing_radius=0.5 * length
    )
    cycle_time = 0.01
    axes = [PathLimits(1000.0, 1e4, 1e5)] * 3
    path = PathPlanner(axes, (0, 0, 0), parameters=settings, cycle_time=cycle_time)
    for n in range(40):
        path.append(PathLine((length * (n // 2 + n % 2), length * (n // 2), 0), 300))
    elements = [path._elements[n] for n in range(1, path.state.following - 3)]
    assert min(element.length for element in elements) < 1e-9
    shares = [element.bend_jump * element.junction**2 for element in elements]
    assert min(shares) > least - 1e-6
    for first in range(len(elements)):
        time, total = 0.0, shares[first]
        for share, element in zip(shares[first + 1 :], elements[first + 1 :], strict=True):
            time += element.length / element.junction
            if time >= cycle_time:
                break
            total += share
        assert total <= 1.0 + 1e-9


def test_a_jump_of_velocity_is_what_the_axis_can_do_in_a_cycle() -> None:
    """Corner of 90°, factor 1, 2000 mm/s², 2 ms: 4 mm/s."""
    state = state_record()
    state.cycle_time, state.axis_count = 0.002, 3
    PathParameters(method=ReductionMethod.VELO_JUMP).fill(state)
    axes = [axis_record() for _ in range(8)]
    for axis in axes:
        PathLimits(1000.0, 2000.0, 1e5).fill(axis, 0.002)
    before, after = element_record(), element_record()
    for element, direction in ((before, 0), (after, 1)):
        element.kind, element.length, element.whole = int(ElementKind.LINE), 10.0, 10.0
        element.feed = element.start_feed = element.caps[0] = 100.0
        element.spans = 1
        element.slope[direction] = 1.0
    assert transition(before, after, axes, state) == pytest.approx(4.0)
    assert angle_between(state.before, state.after) == pytest.approx(pi / 2)
    PathParameters(method=ReductionMethod.VELO_JUMP, least_velocity=7.0).fill(state)
    assert transition(before, after, axes, state) == 7.0
