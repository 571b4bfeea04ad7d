"""Values: what is made of other operators, and what has to be kept or copied on the way."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.plc.lowering.nodes import (
    Check,
    Compute,
    Convert,
    Copy,
    Effects,
    External,
    Keep,
    LazyChoice,
    LoadValue,
    LoweredRoutine,
    LoweredValue,
    Sequence,
    StoreValue,
)
from achse.st.typed.expressions import Conversion, Known, Operator

Lower = Callable[..., LoweredRoutine]
Run = Callable[..., Any]

DECLARED = """
FUNCTION F : STRING(100) VAR_IN_OUT s : STRING(100); END_VAR s := 'y'; F := 'z'; END_FUNCTION
FUNCTION Next : INT VAR_IN_OUT v : INT; END_VAR v := v + 1; Next := v; END_FUNCTION
PROGRAM MAIN
VAR
    a, b, c : BOOL; i, k, n : INT; x, y, z : REAL; t : TIME; l : LTIME; d : DATE;
    dt : DATE_AND_TIME;
    s, u : STRING(100);
END_VAR
"""


@pytest.fixture(scope="session")
def value(lower: Lower) -> Callable[[str], LoweredValue]:
    """`value(text)`: what an assignment stores."""

    def stored(statement: str) -> LoweredValue:
        (effects,) = lower(f"{DECLARED}{statement}\nEND_PROGRAM").body
        assert isinstance(effects, Effects)
        (store,) = effects.values
        assert isinstance(store, StoreValue)
        return store.value

    return stored


def _computed(value: LoweredValue) -> Compute:
    while isinstance(value, Convert):
        value = value.operand
    assert isinstance(value, Compute)
    return value


def test_limit_is_a_minimum_of_a_maximum(value: Callable[[str], LoweredValue]) -> None:
    most = _computed(value("n := LIMIT(INT#0, i, INT#9);"))
    assert most.operator is Operator.MIN
    least = _computed(most.operands[0])
    assert least.operator is Operator.MAX
    assert isinstance(least.operands[1], Known)
    node = value("n := LIMIT(k, i, n);")
    assert isinstance(node, Convert)
    assert isinstance(node.operand, Sequence)
    (keep,) = node.operand.effects
    assert isinstance(keep, Keep)
    least = _computed(_computed(node.operand.value).operands[0])
    assert least.operands[1] == keep.temporary


def test_limits_are_evaluated_from_left_to_right(run: Run) -> None:
    ran = run(f"{DECLARED}k := LIMIT(Next(n), Next(n), Next(n)); i := 10 * n + k; END_PROGRAM")
    assert ran["i"] == 32


def test_choices_of_bools_are_logic(value: Callable[[str], LoweredValue]) -> None:
    assert _computed(value("a := MIN(b, c);")).operator is Operator.AND
    assert _computed(value("a := MAX(b, c);")).operator is Operator.OR


def test_shortcut_is_a_choice_with_a_constant(value: Callable[[str], LoweredValue]) -> None:
    both, either = value("a := b AND_THEN c;"), value("a := b OR_ELSE c;")
    assert isinstance(both, LazyChoice)
    assert both.no == Known(False, both.type)
    assert isinstance(either, LazyChoice)
    assert either.yes == Known(True, either.type)


def test_count_of_a_shift_is_within_the_width(value: Callable[[str], LoweredValue]) -> None:
    constant = _computed(value("n := SHL(i, 35);")).operands[1]
    assert isinstance(constant, Known)
    assert constant.value == 3
    counted = _computed(_computed(value("n := SHL(i, k);")).operands[1])
    assert counted.operator is Operator.AND


def test_times_are_rescaled_by_arithmetic(value: Callable[[str], LoweredValue]) -> None:
    for text in ("t := LTIME_TO_TIME(l);", "d := DT_TO_DATE(dt);", "t := TIME();"):
        node = value(text)
        assert isinstance(node, Convert)
        assert node.rule is Conversion.CUT
        assert _computed(node).operator is Operator.DIV


def test_sum_of_reals_keeps_its_numbers(value: Callable[[str], LoweredValue]) -> None:
    node = value("x := y + z * x;")
    assert isinstance(node, Check)
    assert len(node.operands) == 3
    assert not isinstance(value("x := y + 1.0;"), Check)


def test_text_is_copied_before_a_call_that_may_change_it(
    value: Callable[[str], LoweredValue],
) -> None:
    node = _computed(value("u := CONCAT(s, F(s));"))
    assert isinstance(node.operands[0], Copy)
    node = _computed(value("u := CONCAT(s, u);"))
    assert isinstance(node.operands[0], LoadValue)


def test_text_before_a_call_is_what_it_was(run: Run) -> None:
    ran = run(f"{DECLARED}s := 'x'; u := CONCAT(s, F(s)); END_PROGRAM")
    assert (ran["u"], ran["s"]) == ("xz", "y")


def test_number_as_text_is_left_to_the_runtime(value: Callable[[str], LoweredValue]) -> None:
    node = value("u := INT_TO_STRING(i);")
    while isinstance(node, Convert):
        node = node.operand
    assert isinstance(node, External)
