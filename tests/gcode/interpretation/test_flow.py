"""Jumps, loops, subroutines: where a program goes on."""

import pytest

from achse.codes import NcError
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.text.program import PartProgram
from tests.gcode.programs import commands, ends, refused

COUNTED = """N10 R1=0 R2=0 F600
N20 {loop}
N30 R2=R2+R1
N40 @620 R1
N50 @100 K-20
N90 R3=1
M30"""


def registers(text: str) -> list[float]:
    data = MachineData()
    commands(text, data)
    return data.registers.own


@pytest.mark.parametrize(
    ("relation", "first", "jumps"),
    [
        *((121, value, value != 5) for value in (4, 5, 6)),
        *((122, value, value == 5) for value in (4, 5, 6)),
        *((123, value, value <= 5) for value in (4, 5, 6)),
        *((124, value, value < 5) for value in (4, 5, 6)),
        *((125, value, value >= 5) for value in (4, 5, 6)),
        *((126, value, value > 5) for value in (4, 5, 6)),
    ],
)
def test_jumps_by_condition(relation: int, first: int, jumps: bool) -> None:
    text = f"R1={first} R2=5 R9=2\n@{relation} R1 {{}} K100\nR3=1\nN100 M30"
    for second in ("K5", "R2", "P9"):
        assert registers(text.format(second))[3] == (0.0 if jumps else 1.0)


@pytest.mark.parametrize(
    ("relation", "holds"),
    [(0, {5}), (1, {4, 6}), (2, {6}), (3, {5, 6}), (4, {4}), (5, {4, 5})],
)
@pytest.mark.parametrize("kind", [131, 141])
def test_loops_go_on_while_their_condition_holds(kind: int, relation: int, holds: set[int]) -> None:
    """@131 … leave the loop when it fails; @141 … jump back until it holds: the same test."""
    for value in (4, 5, 6):
        text = f"R1={value}\n@{kind + relation} R1 K5 K100\nR3=1\nN100 M30"
        assert registers(text)[3] == float(value in holds)


def test_a_counted_loop_upwards_and_downwards() -> None:
    up = registers(COUNTED.format(loop="@151 R1 K4 K90"))
    assert (up[1], up[2], up[3]) == (5.0, 10.0, 1.0)
    down = COUNTED.format(loop="@161 R1 K1 K90").replace("R1=0", "R1=4").replace("@620", "@621")
    assert registers(down)[2] == 10.0


def test_a_repeat_loop_runs_once_at_least() -> None:
    result = registers("R1=0\nN20 @620 R1\nN30 @143 R1 K3 K-20\nM30")
    assert result[1] == 4.0


def test_a_case_goes_on_in_further_lines() -> None:
    text = (
        "N100 R2={}\nN200 @111 R2 K12 K300\nK13 K400\nK14 K500\nR0=1\nN250 @100 K5000\n"
        "N300 R0=300\nN310 @100 K5000\nN400 R0=400\nN410 @100 K5000\nN500 R0=500\nN5000 M30"
    )
    for value, expected in ((12, 300), (13, 400), (14, 500), (15, 1)):
        assert registers(text.format(value))[0] == expected
    assert refused("K13 K400").code is NcError.PROGRAM_SYNTAX_RUNNING


def test_a_jump_goes_to_the_nearest_block_in_its_direction() -> None:
    text = "R1=0\nN10 @620 R1\n@122 R1 K3 K30\n@100 K-10\nN10 R2=9\nN30 M30"
    assert registers(text)[1:3] == [3.0, 0.0]
    assert registers("@100 R5\nR1=1\nN0 M30".replace("R5", "K+0"))[1] == 0.0


def test_a_block_that_is_not_there() -> None:
    error = refused("N10 G1\nN20 @100 K+10")
    assert "no block N10 behind" in error.message
    assert (error.line, error.column) == (2, 10)


@pytest.mark.parametrize(
    "wrong",
    ["@121 R1 K5", "@100", "@111 R1 K5", "@40 K3 R1 R2", "@121 K1 K2 K3", "@714 R1", "@620 K5"],
)
def test_operands_are_checked(wrong: str) -> None:
    assert refused(wrong).code is NcError.PROGRAM_SYNTAX_RUNNING


def test_registers_are_saved_and_restored() -> None:
    result = registers(
        "R1=1 R2=2 R3=3\n@40 K2 R1 R3\n@41 R1 R3\nR1=7 R2=8 R3=9\n@43 R3 R1\n"
        "R5=R1+R2*10\n@42 K2 R3 R1\nM30"
    )
    assert result[1:4] == [1.0, 2.0, 3.0]
    assert result[5] == 30.0
    assert refused("@42 K1 R1").code is NcError.ARITHMETIC_STACK_UNDERFLOW
    assert refused("N1 @41 R0 R899\n@100 K-1").code is NcError.ARITHMETIC_STACK_OVERFLOW


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("@200 R1", 0.0),
        ("@202 R1 R2", -30.0),
        ("@610 R1 R2", 30.0),
        ("@613 R1 K16", 4.0),
        ("@614 R1 K3 K4", 5.0),
        ("@620 R1", 3.75),
        ("@621 R1", 1.75),
        ("@622 R1", 2.0),
        ("@630 R1 K30", 0.5),
        ("@631 R1 K60", 0.5),
        ("@632 R1 K45", 1.0),
        ("@634 R1 K0.5", 30.0),
        ("@635 R1 K0.5", 60.0),
        ("@636 R1 K1", 45.0),
        ("@620 P3", 3.75),
    ],
)
def test_arithmetic_of_at_commands(command: str, expected: float) -> None:
    result = registers(f"R1=2.75 R2=-30 R3=1\n{command}\nM30")
    assert result[1] == pytest.approx(expected)


def test_what_has_no_value_is_refused() -> None:
    assert refused("@613 R1 K-1").code is NcError.FLOATING_POINT_OPERATION
    assert refused("R1=-1\n@121 P1 K1 K1").code is NcError.R_PARAMETER_INDEX


CALLS = "F600\nN10 L20 P3\nN20 X0\nM02\nL20\nG91 X5\nG90 L30\nM17\nL30\nY1\nM17\n"


def test_subroutines_of_the_same_file() -> None:
    assert ends(CALLS) == [
        (5.0, 0.0, 0.0),
        (5.0, 1.0, 0.0),
        (10.0, 1.0, 0.0),
        (10.0, 1.0, 0.0),
        (15.0, 1.0, 0.0),
        (15.0, 1.0, 0.0),
        (0.0, 1.0, 0.0),
    ]


def test_subroutines_from_elsewhere() -> None:
    shelf = {7: PartProgram("L7\nX7\nM17", "L7.NC"), 8: PartProgram("X8", "L8.NC")}
    data = MachineData(subroutines=shelf.get)
    assert ends("F600\nL7\nL8\nY1\nM30", data) == [
        (7.0, 0.0, 0.0),
        (8.0, 0.0, 0.0),
        (8.0, 1.0, 0.0),
    ]
    error = refused("L9", data)
    assert error.code is NcError.SUBROUTINE_MISSING


def test_nesting_has_a_limit_and_m17_belongs_to_subroutines() -> None:
    assert refused("L1\nM02\nL1\nL1\nM17").code is NcError.SUBROUTINE_STACK_OVERFLOW
    assert refused("G0 X1\nM17").code is NcError.SUBROUTINE_STACK_UNDERFLOW


def test_a_program_ends_inside_a_subroutine() -> None:
    assert ends("F600\nL1\nX9\nM02\nL1\nX1\nM30\n") == [(1.0, 0.0, 0.0)]
