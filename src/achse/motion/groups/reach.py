"""Reach of the axes of a path: places without an axis, soft limits at the end of a segment."""

from collections.abc import Sequence
from math import isfinite

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.path import PathArc, PathLine

_MAIN_AXES = 3
_NEAR = 1e-9
"""mm: a place without an axis has not moved."""


class PathReach:
    """`places` is the list of the group's axes: X, Y, Z, Q1..Q5, None for an empty place."""

    def __init__(self, places: Sequence[Axis | None]) -> None:
        self._places = places
        self.soft_limits = True

    def check(self, segment: PathLine | PathArc, start: Sequence[float]) -> int:
        """0, or why the segment cannot end there: 0x42BD for main axes, 0x42E4 for auxiliary ones
        beyond soft limits, 0x42C0 for a place without an axis."""
        if isinstance(segment, PathLine):
            end = list(segment.end)
        else:
            end = [*segment.geometry.end, *(segment.auxiliary or start[_MAIN_AXES:])]
        for place, (axis, position) in enumerate(zip(self._places, end, strict=False)):
            if axis is None:
                if abs(position - start[place]) > _NEAR:
                    return NcError.NCI_AXIS_TYPE
            elif isfinite(position) and self._beyond(axis, position, position):
                main = place < _MAIN_AXES
                return (
                    NcError.NCI_BLOCK_BEYOND_SOFT_LIMITS
                    if main
                    else NcError.NCI_AUXILIARY_BEYOND_SOFT_LIMITS
                )
        return OK

    def surely(self, ends: Sequence[Sequence[float]], start: Sequence[float]) -> bool:
        """Return True if the box around all of these points of X, Y, Z is within the limits.

        Lines to them may be permitted even if it is not.
        """
        for place, column in enumerate(zip(*ends, strict=True)):
            axis, low, high = self._places[place], min(column), max(column)
            if not (isfinite(low) and isfinite(high)):
                return False
            if not (low == high == start[place]) if axis is None else self._beyond(axis, low, high):
                return False
        return True

    def _beyond(self, axis: Axis, low: float, high: float) -> bool:
        encoder = axis.encoder
        if not self.soft_limits:
            return False
        below = encoder.soft_limit_min_enable and low < encoder.soft_limit_min
        return bool(below or (encoder.soft_limit_max_enable and high > encoder.soft_limit_max))
