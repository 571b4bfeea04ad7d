"""Margins for rounding: factors by which computed values may differ from what they should be.

A factor multiplies the larger side of a comparison, or the value that must stay on one side of a
bound; none of them is a tolerance of the axis.
"""

JUST_BELOW = 1.0 - 1e-9
"""Factor on a bound that a value shall not exceed when both are rounded."""

JUST_ABOVE = 1.0 + 1e-9
"""Factor on a bound up to which a rounded value still counts as within it."""

RAMP_MARGIN = 1.0 - 1e-6
"""Factor on the square of a deceleration that a jerk just ends at standstill."""

EXTERNAL_MARGIN = 1.0 + 1e-6
"""Factor on a limit up to which set points of a group or of an external source are accepted."""
