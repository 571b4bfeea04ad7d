"""Requests of a part program to the path, in the path's terms: moves as segments, settings as
parameters.

The channel's feeder and `achse gcode --time` both go through here, so that a program has the same
path, feeds and limits in both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

from achse.gcode.canon import ArcMove, Moving, PathParameter, PathSetting
from achse.motion.path import (
    ArcGeometry,
    PathArc,
    PathLimits,
    PathLine,
    PathParameters,
    Smoothing,
    SmoothingSubtype,
)

_MAIN_AXES = 3


@dataclass(frozen=True, slots=True)
class ProgramSettings:
    """Parameters of the path as `#set`, `#skip` and DYNOVR have changed them."""

    path: PathParameters
    velo_jumps: tuple[float, ...] = (1.0, 1.0, 1.0)
    """Factors of velocity jumps of X, Y, Z (paramVeloJump)."""
    dynamic_override: float = 1.0
    """Part of acceleration, deceleration and jerk of all axes (DYNOVR)."""

    def changed(self, setting: PathSetting) -> Self:
        """With a setting; PathError or ValueError for values that cannot be."""
        values, path = setting.values, self.path
        match setting.parameter:
            case PathParameter.VERTEX_SMOOTHING:
                kind, subtype, radius = values
                path = replace(
                    path,
                    smoothing=Smoothing(int(kind)),
                    smoothing_subtype=SmoothingSubtype(int(subtype) or 1),
                    smoothing_radius=radius,
                )
            case PathParameter.SPLINE_SMOOTHING:
                path = replace(path, smoothing=Smoothing.BEZIER, smoothing_radius=values[0])
            case PathParameter.C1_REDUCTION_FACTOR:
                path = replace(path, c1=values[0])
            case PathParameter.C2_REDUCTION_FACTOR:
                path = replace(path, c2=values[0])
            case PathParameter.DEVIATION_ANGLE:
                path = replace(path, c0=values[0], angle_low=values[1], angle_high=values[2])
            case PathParameter.PATH_DYNAMICS | PathParameter.GROUP_DYNAMICS:
                acceleration, deceleration, jerk = values[-3:]
                path = replace(
                    path, acceleration=acceleration, deceleration=deceleration, jerk=jerk
                )
            case PathParameter.MINIMUM_VELOCITY:
                path = replace(path, least_velocity=values[0])
            case PathParameter.VELO_JUMP:
                return replace(self, velo_jumps=values)
            case PathParameter.DYNAMIC_OVERRIDE:
                return replace(self, dynamic_override=values[0])
            case PathParameter.SKIP_VIRTUAL_MOVEMENTS:
                pass  # a move without length never holds the path
        return replace(self, path=path)

    def limits(self, own: PathLimits, place: int) -> PathLimits:
        """Return the limits of an axis with them; places 0 to 2 are X, Y, Z."""
        part = self.dynamic_override
        return replace(
            own,
            acceleration=part * own.acceleration,
            deceleration=part * own.deceleration,
            jerk=part * own.jerk,
            velo_jump=self.velo_jumps[place] if place < _MAIN_AXES else own.velo_jump,
        )


def segment_of(move: Moving, end: Sequence[float], feed: float) -> PathLine | PathArc:
    """The segment of a move to `end`: X, Y, Z, then auxiliary axes, as many as the path has.

    `feed` in mm/s at its end; with FLIN it changes evenly from the one of the move's start.
    """
    begin = feed if move.rapid or move.start_velocity <= 0.0 else move.start_velocity
    if isinstance(move, ArcMove):
        return PathArc(
            arc_geometry(move),
            feed,
            end[_MAIN_AXES:],
            exact_stop=move.exact_stop,
            start_feed=begin,
        )
    return PathLine(end, feed, exact_stop=move.exact_stop, start_feed=begin)


def arc_geometry(move: ArcMove) -> ArcGeometry:
    """Return an arc of the interpreter as one of the path."""
    x, y, z = move.normal
    a, b, c = (at - centre for at, centre in zip(move.start, move.centre, strict=True))
    return ArcGeometry(
        move.centre,
        (a, b, c),
        (y * c - z * b, z * a - x * c, x * b - y * a),
        move.angle,
        (x * move.rise, y * move.rise, z * move.rise),
    )
