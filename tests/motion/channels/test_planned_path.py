"""The path of a program before it moves: the same that the axes take then."""

from itertools import pairwise
from math import dist, pi
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.text.program import PartProgram
from achse.motion.channels import planned_path
from achse.motion.channels.planned_path import PlannedPath, PlanState
from achse.motion.channels.states import InterpreterState as State

AUXILIARY = (0.0,) * 5
PLACES = st.floats(-100.0, 100.0).map(lambda place: round(place, 3))


def planned(text: str, data: MachineData | None = None) -> PlannedPath:
    path = PlannedPath(
        PartProgram(text, "part.nc"), data or MachineData(), (0.0, 0.0, 0.0), AUXILIARY
    )
    while path.state is PlanState.UNFINISHED:
        path.go_on()
    return path


@given(st.lists(st.tuples(st.booleans(), PLACES, PLACES, PLACES), min_size=1, max_size=300))
def test_every_move_is_a_point(moves: list[tuple[bool, float, float, float]]) -> None:
    lines = [f"G0{0 if rapid else 1} X{x} Y{y} Z{z} F600" for rapid, x, y, z in moves]
    path = planned("\n".join((*lines, "M30\n")))
    assert path.state is PlanState.WHOLE
    wanted = [(0.0, 0.0, 0.0)]
    for _, x, y, z in moves:
        if (x, y, z) != wanted[-1]:
            wanted.append((x, y, z))
    assert [point[:3] for point in path.points] == wanted
    blocks = [point.block for point in path.points]
    assert blocks == sorted(blocks)
    assert all(
        path.points[n].rapid == moves[path.points[n].block - 1][0] for n in range(1, len(wanted))
    )


def test_an_arc_is_as_long_as_it_is_driven() -> None:
    points = planned("G01 X10 F600\nG03 X10 Y20 I0 J10\nM30\n").points[1:]
    length = sum(dist(a[:3], b[:3]) for a, b in pairwise(points))
    assert abs(length - 10 * pi) < 0.02
    assert all(abs(dist(point[:2], (10, 10)) - 10) < 1e-9 for point in points)


def test_a_program_without_an_end_is_cut_and_a_wrong_one_ends_at_its_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert planned_path.MOST_POINTS == 10_000
    monkeypatch.setattr(planned_path, "MOST_POINTS", 700)
    monkeypatch.setattr(planned_path, "_MOST_LINES", 3_500)
    path = planned("N10 G91 G01 X1 F600\nN20 @100 K-10\nM30\n")
    assert path.state is PlanState.CUT
    assert len(path.points) == 700
    assert planned("N10 @100 K-10\nM30\n").state is PlanState.CUT
    path = planned("G01 X10 F600\n@100 K-99\nG01 X30\nM30\n")
    assert path.state is PlanState.FAULT
    assert path.points[-1][:3] == (10.0, 0.0, 0.0)


def test_planning_changes_nothing_of_the_channel() -> None:
    data = MachineData()
    path = planned("R1=5\nG01 X=R1 F600\n@714\nG01 X=R1*2\nM30\n", data)
    assert [point.x for point in path.points] == [0.0, 5.0, 10.0]
    assert data.registers[1] == 0.0


def test_a_loaded_program_is_planned_and_driven_so(program: Any) -> None:
    program.write("N10 G00 X5 Y5\nN20 G01 X20 F6000\nN30 G01 Y25\nM30\n")
    channel = program.channel
    assert channel.planned_path() is None
    assert channel.load("part.nc") == 0
    path = channel.planned_path()
    path.go_on()
    assert [point[:2] for point in path.points] == [(0, 0), (5, 5), (20, 5), (20, 25)]
    assert program.at() == [0.0, 0.0, 0.0]
    assert channel.start() == 0
    assert channel.planned_path() is path
    blocks = set()
    while channel.state is not State.READY:
        program.cycle()
        blocks.add(channel.path_block)
    assert blocks >= {0, 1, 2, 3}
    assert program.at() == [20.0, 25.0, 0.0]
    # once more it begins where the axes are now
    again = channel.planned_path()
    assert again is not path
    assert again.points[0][:2] == (20, 25)
    assert channel.plans == 2
    channel.reset()
    assert channel.planned_path() is None


def test_calls_of_an_empty_subroutine_are_given_up() -> None:
    empty = PartProgram("(nothing)\n", "L5.NC")
    path = planned(f"L5 P{10**15}\nM30", MachineData(subroutines=lambda _: empty))
    assert path.state is PlanState.CUT
