"""Moves of a program as segments of a path, its settings as parameters: one way for both users."""

from dataclasses import replace
from math import pi

import pytest

from achse.gcode.canon import ArcMove, LineMove, Origin, PathParameter, PathSetting
from achse.motion.channels.program_path import ProgramSettings, arc_geometry, segment_of
from achse.motion.path import (
    PathArc,
    PathError,
    PathLimits,
    PathLine,
    PathParameters,
    Smoothing,
    SmoothingSubtype,
)

HERE = Origin("a.nc", 1, 0, 10, 1)
NOWHERE = (0.0,) * 5
ARC = ArcMove(
    *(HERE, (0.0, 0.0, 0.0), (20.0, 0.0, 4.0), (10.0, 0.0, 0.0), (0.0, 0.0, -1.0), pi, -4.0),
    *(NOWHERE, 60.0, 10.0),
    exact_stop=True,
)


def line(velocity: float, begin: float, **kind: bool) -> LineMove:
    return LineMove(HERE, (0.0, 0.0, 0.0), (1.0, 2.0, 3.0), NOWHERE, velocity, begin, **kind)


def test_lines() -> None:
    end = (1.0, 2.0, 3.0, 0.5)
    assert segment_of(line(40.0, 40.0), end, 40.0) == PathLine(end, 40.0, start_feed=40.0)
    assert segment_of(line(40.0, 10.0), end, 40.0) == PathLine(end, 40.0, start_feed=10.0)
    rapid = segment_of(line(0.0, 0.0, rapid=True, exact_stop=True), end, 300.0)
    assert rapid == PathLine(end, 300.0, exact_stop=True, start_feed=300.0)


def test_arcs() -> None:
    shape = arc_geometry(ARC)
    assert shape.start == pytest.approx(ARC.start)
    assert shape.end == pytest.approx(ARC.end)
    assert shape.length == pytest.approx(ARC.length)
    segment = segment_of(ARC, (*ARC.end, 7.0), 60.0)
    assert segment == PathArc(shape, 60.0, (7.0,), exact_stop=True, start_feed=10.0)


def test_settings() -> None:
    settings = ProgramSettings(PathParameters())
    for parameter, values in (
        (PathParameter.VERTEX_SMOOTHING, (5.0, 2.0, 0.5)),
        (PathParameter.C1_REDUCTION_FACTOR, (0.5,)),
        (PathParameter.C2_REDUCTION_FACTOR, (0.25,)),
        (PathParameter.PATH_DYNAMICS, (100.0, 200.0, 3000.0)),
        (PathParameter.MINIMUM_VELOCITY, (2.0,)),
        (PathParameter.DEVIATION_ANGLE, (0.2, 5.0, 90.0)),
        (PathParameter.SKIP_VIRTUAL_MOVEMENTS, (3.0,)),
        (PathParameter.VELO_JUMP, (1.5, 2.5, 3.5)),
        (PathParameter.DYNAMIC_OVERRIDE, (0.5,)),
    ):
        settings = settings.changed(PathSetting(HERE, parameter, values))
    assert settings.path == PathParameters(
        smoothing=Smoothing.QUINTIC,
        smoothing_subtype=SmoothingSubtype.DISTANCE,
        smoothing_radius=0.5,
        c0=0.2,
        angle_low=5.0,
        angle_high=90.0,
        c1=0.5,
        c2=0.25,
        acceleration=100.0,
        deceleration=200.0,
        jerk=3000.0,
        least_velocity=2.0,
    )
    own = PathLimits(10.0, 100.0, 1000.0, 80.0, velo_jump=0.7)
    half = replace(own, acceleration=50.0, jerk=500.0, deceleration=40.0)
    assert settings.limits(own, 1) == replace(half, velo_jump=2.5)
    assert settings.limits(own, 3) == half


def test_values_that_cannot_be() -> None:
    settings = ProgramSettings(PathParameters())
    with pytest.raises(PathError, match=r"c1 2\.0, expected 0\.\.1"):
        settings.changed(PathSetting(HERE, PathParameter.C1_REDUCTION_FACTOR, (2.0,)))
    with pytest.raises(ValueError, match="9 is not a valid Smoothing"):
        settings.changed(PathSetting(HERE, PathParameter.VERTEX_SMOOTHING, (9.0, 1.0, 1.0)))
