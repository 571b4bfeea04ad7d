"""Formulas go strictly from left to right."""

from math import isfinite

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.errors import WordRefused
from achse.gcode.state.registers import Registers
from achse.gcode.text.formula import FUNCTIONS, parse_formula


def worked_out(text: str) -> float:
    registers = Registers()
    for number, value in ((2, 1.0), (3, 2.0), (9, 4.0), (5, 30.0), (7, 2.0)):
        registers[number] = value
    formula, end = parse_formula(text, 0)
    assert end == len(text)
    return formula.evaluate(registers)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("R2+R3-17.5*R9/2.5", -23.2),
        ("2+3*4", 20.0),
        ("-R9", -4.0),
        ("3*-R9", -12.0),
        ("SIN(R5)*2", 1.0),
        ("SIN R5 * 2", 1.0),
        ("SQRT[R3+7*R9]", 6.0),
        ("ABS(-R9)", 4.0),
        ("ASIN(0.5)", 30.0),
        ("ACOS(0.5)", 60.0),
        ("ATAN(1)", 45.0),
        ("COS(60)+TAN(45)", 1.5),
        ("INT(-2.7)", -2.0),
        ("7 MOD 4", 3.0),
        ("P7", 1.0),
        ("SQRT(ABS(-16))", 4.0),
        ("-SQRTR9", -2.0),
    ],
)
def test_values(text: str, value: float) -> None:
    assert worked_out(text) == pytest.approx(value)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("1/0", NcError.DIVISION_BY_ZERO),
        ("5 MOD 0", NcError.DIVISION_BY_ZERO),
        ("SQRT(-1)", NcError.FLOATING_POINT_OPERATION),
        ("ASIN(2)", NcError.FLOATING_POINT_OPERATION),
        ("R1000", NcError.R_PARAMETER_INDEX),
        ("P5000", NcError.R_PARAMETER_INDEX),
        ("FOO", NcError.PROGRAM_SYNTAX_RUNNING),
        ("1+", NcError.PROGRAM_SYNTAX_RUNNING),
        ("SIN(5", NcError.PROGRAM_SYNTAX_RUNNING),
        ("SIN(5]", NcError.PROGRAM_SYNTAX_RUNNING),
        ("ABS" * 40 + "5", NcError.ARITHMETIC_STACK_OVERFLOW),
        ("9" * 400, NcError.FLOATING_POINT_OPERATION),
        ("*".join(["9" * 300] * 3), NcError.FLOATING_POINT_OPERATION),
    ],
)
def test_refusals(text: str, code: NcError) -> None:
    with pytest.raises(WordRefused) as refused:
        worked_out(text)
    assert refused.value.code is code


NUMBERS = st.floats(-1e6, 1e6).map(lambda value: round(value, 3))


@given(NUMBERS, st.lists(st.tuples(st.sampled_from("+-*/"), NUMBERS), max_size=8))
def test_any_chain_is_worked_out_as_it_is_read(first: float, rest: list[tuple[str, float]]) -> None:
    text = f"{first:f}" + "".join(f"{sign}{value:f}" for sign, value in rest)
    expected: float | None = first
    for sign, value in rest:
        assert expected is not None
        if sign == "/" and value == 0.0:
            expected = None
            break
        expected = {
            "+": expected + value,
            "-": expected - value,
            "*": expected * value,
            "/": expected / (value or 1.0),
        }[sign]
        if not isfinite(expected):
            expected = None
            break
    formula, end = parse_formula(text, 0)
    assert end == len(text)
    if expected is None:
        with pytest.raises(WordRefused):
            formula.evaluate(Registers())
    else:
        assert formula.evaluate(Registers()) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@given(st.sampled_from(sorted(FUNCTIONS)), NUMBERS)
def test_functions_have_a_value_or_an_error(name: str, value: float) -> None:
    formula, _ = parse_formula(f"{name}({value:f})", 0)
    try:
        result = formula.evaluate(Registers())
    except WordRefused as refused:
        code = refused.code
    else:
        assert isfinite(result)
        return
    assert code is NcError.FLOATING_POINT_OPERATION
