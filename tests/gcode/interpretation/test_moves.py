"""Moves of a program: figures of the facts, auxiliary axes, contour lines, refusals."""

from math import pi
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.canon import ArcMove, LineMove, PathPlane
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.offsets import ZeroShift
from achse.gcode.text.program import PartProgram
from tests.gcode.programs import commands, ends, moves, refused, with_tool

WITNESSED = """G1 X10 Y0 F600
G2 X20 Y10 I10 J0
G3 X10 Y20 B10
G2 X10 Y20 Z5 I5 J0
G18 G3 X20 Z15 I10 K0
G17 G91 G1 X5 Y-2
G90 G19 G2 Y28 Z15 J5 K0
"""


def test_the_runs_of_the_facts() -> None:
    """LinuxCNC's interpreter gave these for the translated program."""
    assert ends(WITNESSED) == [
        (10.0, 0.0, 0.0),
        (20.0, 10.0, 0.0),
        (10.0, 20.0, 0.0),
        (10.0, 20.0, 5.0),
        (20.0, 20.0, 15.0),
        (25.0, 18.0, 15.0),
        (25.0, 28.0, 15.0),
    ]
    arcs = [move for move in moves(WITNESSED) if isinstance(move, ArcMove)]
    assert [tuple(round(value, 6) for value in arc.centre) for arc in arcs] == [
        (20.0, 0.0, 0.0),
        (10.0, 10.0, 0.0),
        (15.0, 20.0, 0.0),
        (20.0, 20.0, 5.0),
        (25.0, 23.0, 15.0),
    ]
    assert [(arc.plane, arc.clockwise) for arc in arcs] == [
        (PathPlane.XY, True),
        (PathPlane.XY, False),
        (PathPlane.XY, True),
        (PathPlane.ZX, False),
        (PathPlane.YZ, True),
    ]
    assert arcs[2].angle == 2.0 * pi
    assert arcs[2].rise == -5.0


def test_velocities_are_mm_per_second() -> None:
    rapid, line = moves("G0 X10\nG1 X20 F600")
    assert isinstance(rapid, LineMove)
    assert (rapid.rapid, rapid.velocity) == (True, 0.0)
    assert (line.rapid, line.velocity) == (False, 10.0)


def test_auxiliary_axes_go_along() -> None:
    result = moves("X10 Q1=5 F600\nQ2=3\nG91 Q1=1 X1")
    assert [move.auxiliary[:2] for move in result] == [(5.0, 0.0), (5.0, 3.0), (6.0, 3.0)]
    assert result[1].length == 0.0


@pytest.mark.parametrize(
    ("block", "end"),
    [
        ("X10 ANG=30", (10.0, 5.773503, 0.0)),
        ("Y10 ANG=30", (17.320508, 10.0, 0.0)),
        ("Y10 ANG=90", (0.0, 10.0, 0.0)),
        ("G91 X10 ANG=-45", (10.0, -10.0, 0.0)),
        ("G18 Z10 ANG=45", (10.0, 0.0, 10.0)),
    ],
)
def test_contour_lines_by_their_angle(block: str, end: tuple[float, float, float]) -> None:
    assert ends(f"G1 F600\n{block}") == [end]


def test_a_circle_through_three_points() -> None:
    (arc,) = moves("CIP X10 Y0 Z0 I5 J5 K0 F600")
    assert isinstance(arc, ArcMove)
    assert arc.centre == pytest.approx((5.0, 0.0, 0.0))
    assert arc.angle == pytest.approx(pi)
    assert arc.at(0.5) == pytest.approx((5.0, 5.0, 0.0))


def test_exact_stop_and_delete_distance() -> None:
    result = moves("F600 G09 X1\nX2\nG60 X3\nX4 DelDTG\nG08 X5")
    assert [move.exact_stop for move in result] == [True, False, True, True, False]
    assert [move.delete_distance for move in result] == [False, False, False, True, False]


def test_a_block_without_axes_makes_no_move() -> None:
    assert len(commands("G1 F600\nG2\nG0\n")) == 1


@pytest.mark.parametrize(
    ("block", "code"),
    [
        ("G2 X10", NcError.CIRCLE_NOT_COMPUTABLE),
        ("G2 X10 B4", NcError.CIRCLE_NOT_COMPUTABLE),
        ("G2 X10 B10 I5", NcError.CIRCLE_NOT_COMPUTABLE),
        ("G2 X10 I5 K2", NcError.CIRCLE_NOT_COMPUTABLE),
        ("G2 X0 B5", NcError.CIRCLE_NOT_COMPUTABLE),
        ("CPCOF G2 X10 I6 J0", NcError.CIRCLE_NOT_COMPUTABLE),
        ("CIP X10 I5", NcError.CIRCLE_NOT_COMPUTABLE),
        ("CIP", NcError.PROGRAM_SYNTAX_RUNNING),
        ("G1 X10 I5", NcError.PROGRAM_SYNTAX_RUNNING),
        ("G1 X10 Y10 ANG=30", NcError.PROGRAM_SYNTAX_RUNNING),
        ("G1 X10 ANG=90", NcError.PROGRAM_SYNTAX_RUNNING),
        ("X99999999999999", NcError.FLOATING_POINT_OPERATION),
        ("X1 F0", NcError.NCI_VELOCITY_NOT_POSITIVE),
    ],
)
def test_refused_moves(block: str, code: NcError) -> None:
    assert refused(f"F600\n{block}").code is code


@given(
    st.lists(
        st.sampled_from(
            ["G90", "G91", "G0", "G1", "G60", "G54", "G53", "FLIN", "F{}", "D1", "D0", "ROT Z{}"]
            + ["X{}", "X{} Y{}", "Y{} Z{}", "X{} Y{} Z{}", "N5 Z{}"] * 4
        ),
        min_size=3,
        max_size=30,
    ),
    st.randoms(use_true_random=False),
)
def test_the_short_way_of_bare_lines_gives_the_same(shapes: list[str], draw: Random) -> None:
    """Single block keeps all lines on the long way."""
    text = "F600\n" + "\n".join(
        shape.format(*(round(draw.uniform(1, 99), 3) for _ in range(3))) for shape in shapes
    )
    results = []
    for quick in (True, False):
        data = with_tool(length=7.0)
        data.shifts[ZeroShift.G54_FINE, 1] = 3.0
        run = Interpreter(PartProgram(text), data)
        data.single_block = not quick
        lines: list[LineMove] = []
        while run.state is not RunState.ENDED:
            lines += [each for each in run if isinstance(each, LineMove)]
            if run.state is RunState.SINGLE_STOP:
                run.go_ahead()
        results.append(lines)
    assert results[0] == results[1]


def test_a_shift_that_a_client_changes_counts_at_once() -> None:
    data = MachineData()
    run = Interpreter(PartProgram("G54\nX1 F600\nX2\nX3\nX4"), data)
    ends_of = []
    for shift in (0.0, 10.0, 10.0, 20.0):
        data.shifts[ZeroShift.G54_COARSE, 0] = shift
        move = run.advance()
        assert isinstance(move, LineMove)
        ends_of.append(move.end[0])
    assert ends_of == [1.0, 12.0, 13.0, 24.0]


def test_a_move_needs_a_feed() -> None:
    error = refused("G0 X1\nG1 X2")
    assert (error.code, error.line) == (NcError.NCI_VELOCITY_NOT_POSITIVE, 2)
