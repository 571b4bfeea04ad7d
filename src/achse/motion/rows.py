"""Rows: all that a cycle of the NC sees, so that an axis can look at others.

A function of the kernel that needs more than its own axis gets `rows: NcRows`. Another axis is
`rows.axes[n]`, by its row (`Axis.index`). Axes have their turns in the order of `rows.order`; what
one reads of another that had its turn before is of this cycle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from achse.motion.control.curves import CurveSpan
from achse.motion.record import AxisFields, EncoderFields


@dataclass
class NcRows:
    """The records of an NC; machine code gets their addresses and numbers, in this order."""

    axes: Sequence[AxisFields]
    encoders: Sequence[EncoderFields]
    order: Sequence[int]
    """Rows of axes in the order of their turns (`achse.motion.order`)."""
    curve_spans: Sequence[CurveSpan]
    """Spans of all curves."""
    cams: Sequence[float]
    """Numbers of the tables that slaves follow (`achse.motion.tables.memory`)."""
