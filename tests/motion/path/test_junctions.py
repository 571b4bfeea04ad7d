"""Junctions: what spans allow at a velocity, and safe velocities."""

from math import cos, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.motion.path import (
    ArcGeometry,
    PathArc,
    PathLimits,
    PathOverride,
    PathParameters,
    PathPlanner,
)
from achse.motion.path.junctions import (
    build_junctions,
    element_velocity,
    junction_acceleration,
    junction_deceleration,
    junction_jerk,
)
from achse.motion.path.record import element_record, junction_record, state_record


@pytest.mark.parametrize(
    ("kind", "override", "velocity"),
    [
        (PathOverride.REDUCED, 0.5, 40.0),
        (PathOverride.ORIGINAL, 0.5, 50.0),
        (PathOverride.ORIGINAL, 0.9, 80.0),
        (PathOverride.REDUCED_ABOVE, 1.2, 80.0),
    ],
)
def test_overrides(kind: PathOverride, override: float, velocity: float) -> None:
    """Programmed 100 mm/s, the axes allow 80."""
    element, state = element_record(), state_record()
    element.feed, element.start_feed, element.caps[0] = 100.0, 100.0, 80.0
    PathParameters(override_type=kind, most_override=1.5).fill(state)
    state.override = override
    assert element_velocity(element, 0, state) == pytest.approx(velocity)


def test_a_span_allows_more_the_slower_it_is() -> None:
    junction = junction_record()
    junction.cap, junction.start, junction.acceleration = 100.0, 1000.0, 200.0
    junction.rest, junction.deceleration, junction.power = 800.0, 0.0, 1e12
    junction.first_jerk, junction.jerk = 9000.0, 1000.0
    junction.most_acceleration, junction.most_deceleration, junction.most_jerk = 900.0, 1e12, 1e12
    assert junction_acceleration(junction, 0.0) == 900.0
    assert junction_acceleration(junction, 50.0) == 800.0
    assert junction_acceleration(junction, 200.0) == 200.0
    assert junction_deceleration(junction, 50.0) == 600.0
    assert junction_jerk(junction, 50.0) == 8000.0
    junction.power = 10_000.0
    assert junction_deceleration(junction, 50.0) == 200.0


@settings(max_examples=10)
@given(
    st.floats(50.0, 500.0),
    st.floats(100.0, 1e4),
    st.floats(1e3, 1e7),
    st.floats(1.0, 100.0),
    st.floats(0.1, 6.0),
    st.floats(1.0, 1000.0),
)
def test_what_is_safe_rises_when_more_is_known(  # type: ignore[no-untyped-def]
    velocity, acceleration, jerk, radius, angle, feed
) -> None:
    path = PathPlanner([PathLimits(velocity, acceleration, jerk)] * 3, (radius, 0, 0))
    first = ArcGeometry((0, 0, 0), (radius, 0, 0), (0, radius, 0), angle)
    c, s = radius * cos(angle), radius * sin(angle)
    second = ArcGeometry((0, 0, 0), (c, s, 0), (-s, c, 0), 0.5)
    junctions = [junction_record() for _ in range(64)]
    results = []
    for arc in (first, second):
        path.append(PathArc(arc, feed))
        build_junctions(path._elements, junctions, path.state)
        results.append([junction.safe for junction in junctions[: path._elements[0].spans]])
    # a ramp to rest may be shorter than one to a lower velocity
    assert all(more >= 0.6 * less for less, more in zip(*results, strict=True))
    assert results[0][-1] == 0.0
    assert results[1][-1] > 0.0
