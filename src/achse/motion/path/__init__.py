"""Paths: lines, arcs, helices and rounded corners that several axes follow together.

`PathPlanner` takes segments and gives set points, one cycle at a time. `segments` says what a path
is made of, `geometry` where its points are, `corners` and `smoothing` what is between segments,
`bounds` what the axes allow on an element, `lookahead` how fast it may be now. Units: mm and s.
"""

from achse.motion.path.corners import ReductionMethod
from achse.motion.path.parameters import PathLimits, PathOverride, PathParameters
from achse.motion.path.planner import LOOK_AHEAD, PathPlanner, PathTableFull
from achse.motion.path.segments import (
    PLANE_XY,
    PLANE_YZ,
    PLANE_ZX,
    ArcGeometry,
    PathArc,
    PathDwell,
    PathError,
    PathLine,
    PathSegment,
    Plane,
    arc_through,
    plane_arc,
    rapid_feed,
)
from achse.motion.path.smoothing import Smoothing, SmoothingSubtype

__all__ = [
    "LOOK_AHEAD",
    "PLANE_XY",
    "PLANE_YZ",
    "PLANE_ZX",
    "ArcGeometry",
    "PathArc",
    "PathDwell",
    "PathError",
    "PathLimits",
    "PathLine",
    "PathOverride",
    "PathParameters",
    "PathPlanner",
    "PathSegment",
    "PathTableFull",
    "Plane",
    "ReductionMethod",
    "Smoothing",
    "SmoothingSubtype",
    "arc_through",
    "plane_arc",
    "rapid_feed",
]
