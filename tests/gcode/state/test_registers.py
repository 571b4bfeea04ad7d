"""R parameters: own, shared, pointed at, saved."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.errors import WordRefused
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.state.registers import Registers, shared_registers
from tests.gcode.programs import refused


def test_the_last_hundred_are_shared() -> None:
    shared = shared_registers()
    first, second = Registers(shared), Registers(shared)
    first[899], first[900], first[999] = 1.0, 2.0, 3.0
    assert (second[899], second[900], second[999]) == (0.0, 2.0, 3.0)


@pytest.mark.parametrize("number", [-1, 1000, 10**9])
def test_others_are_refused(number: int) -> None:
    registers = Registers()
    with pytest.raises(WordRefused) as read:
        registers[number]
    with pytest.raises(WordRefused) as written:
        registers[number] = 1.0
    assert read.value.code is written.value.code is NcError.R_PARAMETER_INDEX


@pytest.mark.parametrize("value", [-1.0, 1000.0, 2.5, float("nan"), float("inf")])
def test_pointers_need_a_whole_number(value: float) -> None:
    registers = Registers()
    registers[1] = value
    with pytest.raises(WordRefused):
        registers.pointed(1)


def test_the_stack_gives_back_the_last_first() -> None:
    registers = Registers()
    registers[1], registers[2] = 1.0, 2.0
    registers.save([1, 2])
    registers.restore([5, 6])
    assert (registers[5], registers[6]) == (2.0, 1.0)
    with pytest.raises(WordRefused):
        registers.restore([5])


@given(
    st.sampled_from([math.nan, math.inf, -math.inf]),
    st.integers(0, 999),
    st.sampled_from(
        ("X=R{0} XR{0} F=R{0} H=R{0} S=R{0} T=R{0} D=R{0};ROT XR{0};AROT ZR{0};G58 X=R{0};"
         "G4 XR{0};L7 PR{0};R5=R{0};R5=SQRT R{0};@100 R{0};@111 R{0} K1 K-10;@121 R{0} K1 K-10;"
         "@132 R{0} K1 K-10;@622 R{0};@613 R5 R{0};@123 R5 R{0} K-10;DYNOVR=R{0};G2 IR{0} J5;"
         "#set paramRadiusPrec(R{0})#").replace(" ", "|").split(";")
    ),
)  # fmt: skip
def test_a_word_refuses_what_is_not_a_number(value: float, number: int, words: str) -> None:
    """A snapshot file may bring NaN into an R parameter: the block that uses it is refused."""
    for word in words.split("|") if words.startswith("X=") else [words.replace("|", " ")]:
        data = MachineData()
        data.registers[number] = value
        text = f"N10 {word.format(number)}\nM30\nL7\nM17"
        error = refused(text, data)
        assert error.code is NcError.FLOATING_POINT_OPERATION, error
        assert error.line == 1


def test_an_angle_beyond_all_numbers_is_refused() -> None:
    data = MachineData()
    data.registers[1] = 1e308
    error = refused("N10 ROT ZR1\nN20 AROT ZR1\nM30", data)
    assert (error.line, error.code) == (2, NcError.FLOATING_POINT_OPERATION)
