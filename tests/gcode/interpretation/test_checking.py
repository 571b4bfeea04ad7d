"""Checking a program: every wrong line, then what only a run shows."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.interpretation.checking import check_lines, check_program, dry_run
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.text.program import PartProgram

WRONG = """N10 G1 X1 F600
N20 G33
N30 @100 K-99
N40 L7
G0 G1
@111 R1 K1 K5 K2 K500
K3 K10
N5 X=R1000
@40 K5 R1
K7 K10"""


def test_every_wrong_line_is_reported_once() -> None:
    report = check_program(PartProgram(WRONG, "part.nc"))
    assert [error.line for error in report.errors] == [2, 3, 4, 5, 6, 7, 9, 10]
    assert [error.word for error in report.errors][:5] == ["G33", "K-99", "L7", "G01", "K500"]
    assert not report.ended
    assert report.blocks == 1


def test_what_only_a_run_shows() -> None:
    report = check_program(PartProgram("G1 X1 F600\nR1=1/R2\nX2", "part.nc"))
    assert [error.code for error in report.errors] == [NcError.DIVISION_BY_ZERO]
    assert len(report.commands) == 1


def test_a_good_program_ends() -> None:
    text = "F600\n@714\nX1\n@716\nX2\n#get PathAxesPos(R1;R2;R3)#\nG74 X\nL5\nM30\nL5\nX=R1+1\nM17"
    data = MachineData(single_block=True)
    report = check_program(PartProgram(text), data)
    assert report.errors == []
    assert report.ended
    assert data.registers[1] == 2.0


def test_an_endless_program_is_given_up() -> None:
    report = dry_run(PartProgram("N1 R1=R1+1\n@100 K-1"), MachineData(), blocks=5000)
    assert not report.ended
    assert report.errors == []
    assert 5000 <= report.blocks <= 6000
    assert (
        report.why_no_end
        == f"no end after {report.blocks} blocks: the program loops, or is too long"
    )
    moving = dry_run(PartProgram("N1 R1=R1+1 G0 X1\n@100 K-1"), MachineData(), blocks=5000)
    assert 5000 <= moving.blocks <= 6000


@pytest.mark.parametrize("repeats", [1, 9, 10**6, 10**15])
def test_calls_of_an_empty_subroutine_are_given_up(repeats: int) -> None:
    empty = PartProgram("(nothing)\n", "L5.NC")
    data = MachineData(subroutines=lambda _: empty)
    report = dry_run(PartProgram(f"L5 P{repeats}\nM30"), data, blocks=500)
    assert report.errors == []
    assert report.ended == (repeats < 10)
    assert bool(report.why_no_end) == (repeats > 10)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("N1 @100 K-1", (1, 1)),
        ("N1 G91 G1 X1 F600\nX2\n@100 K-1", (3, 1)),
        ("R1=1\nN5 R1=R1*-1\nX=R1\n@100 K-5", (4, 2)),
        ("N1 @717\nM40\nL5 P3\n@100 K-1\nM30\nL5\nN7 X1\n@714\nM17", (4, 1)),
        ("N1 X1\nN2 R1=R1+1\n@126 R1 K10 K4\n@100 K-2\nN4 R1=0\n@100 K-1", (4, 2)),
        ("L5\nM30\nL5\nN3 @100 K-3\nM17", (4, 4)),
    ],
)
def test_a_loop_that_cannot_end_is_reported_at_once(text: str, place: tuple[int, int]) -> None:
    report = check_program(PartProgram("F600\n" + text, "a.nc"))
    assert report.errors == []
    assert not report.ended
    line, target = place[0] + 1, place[1] + 1
    assert report.loop == ("a.nc", line, target)
    assert report.why_no_end == (
        f"a.nc:{line}: goes back to line {target} for ever: no R parameter changes on the way"
    )
    assert report.blocks <= 1000


def test_a_loop_that_reads_positions_may_end() -> None:
    text = "N1 G91 G1 X1 F600\n#get PathAxesPos(R1;R2;R3)#\n@125 R1 K50 K9\nR1=0\n@100 K-1\nN9 M30"
    report = check_program(PartProgram(text))
    assert report.errors == []
    assert report.ended


@given(st.integers(1, 300), st.integers(1, 5))
def test_loops_that_count_end(count: int, inner: int) -> None:
    text = f"""N1 R1=R1+1
R2=0
N2 R2=R2+1
@124 R2 K{inner} K-2
@124 R1 K{count} K-1
M30"""
    report = check_program(PartProgram(text))
    assert report.ended
    assert report.loop is None


def test_subroutines_in_files_are_known() -> None:
    shelf = {7: PartProgram("X1\nM17", "L7.NC")}
    data = MachineData(subroutines=shelf.get)
    assert check_lines(PartProgram("L7"), data) == []
    assert [error.word for error in check_lines(PartProgram("N1 L8"), data)] == ["L8"]
