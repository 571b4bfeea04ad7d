"""Margins for rounding."""

from hypothesis import given
from hypothesis import strategies as st

from achse.motion.rounding import EXTERNAL_MARGIN, JUST_ABOVE, JUST_BELOW, RAMP_MARGIN

sizes = st.floats(1e-200, 1e200)


@given(sizes)
def test_margins_are_wider_than_rounding(bound: float) -> None:
    """A value that eight operations rounded passes its bound by less than the margin."""
    rounded = bound
    for _ in range(8):
        rounded *= 1.0 + 2.0**-52
    assert rounded < bound * JUST_ABOVE < bound * EXTERNAL_MARGIN
    assert rounded * RAMP_MARGIN < rounded * JUST_BELOW < bound
