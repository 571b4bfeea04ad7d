"""Courses of slaves: extremes and means against closed forms and against many samples."""

from itertools import pairwise
from math import sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.motion.couplings.flying_saws.approach import quintic, weak_ramp
from achse.motion.couplings.flying_saws.course import (
    SlaveCourse,
    course_by_time,
    course_over_master,
)


def rest_to_rest(length: float, height: float, velocity: float) -> SlaveCourse:
    terms = [0.0] * 6
    quintic(terms, 0, length, 0.0, height, 0.0, 0.0, 0.0)
    return course_over_master(0.0, velocity, 0.0, [length], terms)


@pytest.mark.parametrize("velocity", [1.0, 720.0])
def test_the_fifth_degree_from_rest_to_rest(velocity: float) -> None:
    """Master 180, slave 100: worked numbers of the characteristic values, scaled by velocity."""
    course = rest_to_rest(180.0, 100.0, velocity)
    assert course.most(1).value == pytest.approx(1.041666666667 * velocity, rel=1e-9)
    assert course.most(1).time * velocity == pytest.approx(90.0, abs=1e-6)
    assert course.most(2).value == pytest.approx(0.017819452753 * velocity**2, rel=1e-9)
    assert course.most(2).time * velocity == pytest.approx(38.038475773, abs=1e-6)
    assert course.least(2).time * velocity == pytest.approx(141.961524227, abs=1e-6)
    assert course.most(3).value == pytest.approx(0.001028806584 * velocity**3, rel=1e-9)
    assert course.least(3).value == pytest.approx(-0.000514403292 * velocity**3, rel=1e-9)
    assert course.mean_speed() == pytest.approx(0.555555555556 * velocity, rel=1e-9)
    assert course.effective_acceleration() == pytest.approx(0.012778991840 * velocity**2, rel=1e-9)


def test_the_second_universal_saw() -> None:
    """Velocity at most at the end, 1.25; acceleration 0.010162451 per master unit."""
    terms = [0.0] * 6
    quintic(terms, 0, 160.0, 0.0, 130.0, 0.25, 0.0, 1.25)
    course = course_over_master(100.0, 1.0, 20.0, [160.0], terms)
    assert course.most(1) == pytest.approx((160.0, 1.25), abs=1e-9)
    assert course.most(2).value == pytest.approx(0.010162451, abs=5e-10)


@pytest.mark.parametrize(("smooth", "peak"), [(False, 400.0), (True, 600.0)])
def test_peaks_of_the_weak_saw(smooth: bool, peak: float) -> None:
    terms = [0.0] * 6
    weak_ramp(terms, 0, 50.0, 2.0, smooth)
    course = course_over_master(150.0, 100.0, 0.0, [50.0], terms)
    assert course.strongest() == pytest.approx((peak, 0.0), rel=1e-12)
    assert course.duration == pytest.approx(0.5)


def test_a_change_in_time_without_jerk() -> None:
    """Δv = 100, a = 500: 0.2 s and 10 of way."""
    course = course_by_time(0.0, 100.0, (0.0, 0.0, 0.0), 100.0, (500.0, 500.0, 1e12))
    assert course.duration == pytest.approx(0.2, abs=1e-8)
    assert course.end(0) == pytest.approx(10.0, abs=1e-7)


def test_a_change_in_time_with_jerk() -> None:
    course = course_by_time(0.0, 100.0, (5.0, 0.0, 0.0), 100.0, (500.0, 500.0, 5000.0))
    assert course.duration == pytest.approx(0.3)
    assert course.end(0) == pytest.approx(5.0 + 0.5 * 100.0 * 0.3)
    assert course.strongest() == pytest.approx((500.0, 0.0))


def test_no_change_at_all() -> None:
    course = course_by_time(0.0, 1.0, (3.0, 1.0, 0.0), 1.0, (1.0, 1.0, 1.0))
    assert (course.duration, course.begin(0), course.end(1)) == (0.0, 3.0, 1.0)
    assert (course.mean_speed(), course.effective_acceleration()) == (0.0, 0.0)


@settings(max_examples=15, deadline=None)
@given(
    st.floats(1.0, 500.0), st.floats(-500.0, 500.0), st.floats(-3.0, 3.0),
    st.floats(-0.05, 0.05), st.floats(-3.0, 3.0), st.floats(1.0, 300.0),
)  # fmt: skip
def test_extremes_are_those_of_many_samples(
    length: float, height: float, slope: float, bend: float, end: float, velocity: float
) -> None:
    terms = [0.0] * 6
    quintic(terms, 0, length, 0.0, height, slope, bend, end)
    course = course_over_master(0.0, velocity, 7.0, [length], terms)
    count = 500
    (stretch,) = course.stretches
    tracks = []
    for order in range(4):
        own = stretch.derived(order)
        tracks.append(
            [
                sum(term * (n / count * course.duration) ** k for k, term in enumerate(own))
                for n in range(count + 1)
            ]
        )
        most, least = max(tracks[order]), min(tracks[order])
        size = max(abs(most), abs(least), 1e-6)
        assert course.most(order).value >= most - 1e-9 * size
        assert course.least(order).value <= least + 1e-9 * size
        assert course.most(order).value == pytest.approx(most, abs=1e-2 * size)
        assert course.least(order).value == pytest.approx(least, abs=1e-2 * size)
    grows, shrinks = course.strongest()
    fastest = max(map(abs, tracks[1]))
    signed = [
        a if v >= 0.0 else -a
        for v, a in zip(tracks[1], tracks[2], strict=True)
        if abs(v) > 1e-9 * fastest
    ] or [0.0]
    size = max(map(abs, signed)) + 1e-6
    assert grows >= max(signed) - 1e-6 * size
    assert shrinks >= -min(signed) - 1e-6 * size
    way = sum(abs(b - a) for a, b in pairwise(tracks[0]))
    assert course.mean_speed() * course.duration == pytest.approx(way, rel=1e-2, abs=1e-6)
    square = sum(a * a for a in tracks[2]) / (count + 1)
    assert course.effective_acceleration() == pytest.approx(sqrt(square), rel=5e-2, abs=1e-6)
