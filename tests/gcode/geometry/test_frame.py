"""From the workpiece to the axes and back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.gcode.geometry.frame import UNTURNED, WorkFrame, rotation
from tests.gcode.programs import ends, moves

LENGTHS = st.floats(-1e3, 1e3)
POINTS = st.tuples(LENGTHS, LENGTHS, LENGTHS)
ANGLES = st.tuples(*(st.floats(-720.0, 720.0),) * 3)
SIGNS = st.tuples(*(st.sampled_from((1.0, -1.0)),) * 3)


@given(POINTS, POINTS, ANGLES, SIGNS, POINTS)
def test_there_and_back(
    point: tuple[float, float, float],
    shift: tuple[float, float, float],
    angles: tuple[float, float, float],
    mirror: tuple[float, float, float],
    tool: tuple[float, float, float],
) -> None:
    frame = WorkFrame(shift, rotation(angles), mirror, tool)
    assert frame.to_work(frame.to_axes(point)) == pytest.approx(point, abs=1e-9)


def test_quarter_turns_are_exact() -> None:
    assert rotation((0.0, 0.0, 360.0)) == UNTURNED
    assert ends("ROT Z90\nG1 X10 F600") == [(0.0, 10.0, 0.0)]


def test_the_figure_of_the_facts() -> None:
    """ROT Z30, then X10."""
    (move,) = moves("ROT Z30\nG1 X10 F600")
    assert move.end == pytest.approx((8.660254038, 5.0, 0.0))


def test_rotations_are_about_axes_that_do_not_move() -> None:
    """First about Z, then Y, then X: X goes to Y by Z, stays there, and goes to Z by X."""
    assert ends("ROT X90 Z90\nG1 X10 F600") == [(0.0, 0.0, 10.0)]
    assert ends("ROT Y90 Z90\nG1 X10 F600") == [(0.0, 10.0, 0.0)]
    assert ends("ROT X90 Y90\nG1 X10 F600") == [(0.0, 10.0, 0.0)]


def test_a_mirror_turns_arcs_round() -> None:
    (arc,) = moves("MIRROR Y\nG2 X10 Y0 I5 J0 F600")
    assert arc.end == pytest.approx((10.0, 0.0, 0.0))
    assert not getattr(arc, "clockwise")  # noqa: B009
    assert WorkFrame(mirror=(1.0, -1.0, 1.0)).flips
    assert not WorkFrame(mirror=(-1.0, -1.0, 1.0)).flips
    assert WorkFrame().is_translation
