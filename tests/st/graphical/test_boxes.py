"""Boxes and targets: signs of operators, outputs of blocks, programs, conversions."""

import pytest

from achse.st.graphical.boxes import sign_of_operator
from tests.st.graphical.drawings import (
    NEGATED,
    RESET,
    SET,
    Drawn,
    assign,
    box,
    contact,
    fb,
    network,
    networks,
    unit,
)


def drawn(variables: str, *items: str, others: tuple[str, ...] = (), view: str = "Fbd") -> Drawn:
    head = f"PROGRAM MAIN\nVAR\n{variables}\nEND_VAR"
    return Drawn(unit(head, networks(*(network(one) for one in items), view=view)), *others)


def test_operators_have_signs_by_name_and_by_sign() -> None:
    names = ["Add", "MUL", "eq", "<=", "-", "Sel", "TO_INT"]
    assert [sign_of_operator(name) for name in names] == ["+", "*", "=", "<=", "-", "", ""]


@pytest.mark.parametrize(
    ("operator", "inputs", "expected"),
    [
        ("Sub", ["n", "2"], 5), ("Minus", ["n", "2"], 5), ("Mul", ["n", "2", "3"], 42),
        ("Div", ["n", "2"], 3), ("Mod", ["n", "4"], 3), ("Min", ["n", "4"], 4),
        ("Move", ["n"], 7), ("Abs", ["0 - n"], 7), ("Limit", ["0", "n", "5"], 5),
        ("Shl", ["n", "1"], 14), ("Sel", ["n > 3", "1", "2"], 2), ("Sizeof", ["n"], 2),
    ],
)  # fmt: skip
def test_operators_do_what_they_do_in_text(operator: str, inputs: list[str], expected: int) -> None:
    node = box(operator.upper(), *map(contact, inputs), call=operator)
    plc = drawn("n : INT := 7; q : INT;", assign(node, "q")).cycle()
    assert plc["q"] == expected


@pytest.mark.parametrize(
    ("operator", "expected"), [("Gt", 0), ("Ge", 1), ("Lt", 0), ("Le", 1), ("Eq", 1), ("Ne", 0)]
)
def test_comparisons_of_several_values_hold_from_each_to_the_next(
    operator: str, expected: int
) -> None:
    node = box(operator.upper(), contact("n"), contact("7"), contact("7"), call=operator)
    assert drawn("n : INT := 7; q : BOOL;", assign(node, "q")).cycle()["q"] == bool(expected)


@pytest.mark.parametrize(
    ("type", "call", "expected"),
    [("&", "Ampersand", 4), (">", "Greater", 1), ("<", "Less", 0), ("-", "X", 1), ("<>", "X", 1)],
)
def test_a_sign_as_the_type_of_a_box_counts_before_its_kind(
    type: str, call: str, expected: int
) -> None:
    node = box(type, contact("a"), contact("b"), call=call)
    result = "BOOL" if type in "<>" else "INT"
    plc = drawn(f"a : INT := 5; b : INT := 4; q : {result};", assign(node, "q"))
    assert plc.cycle()["q"] == expected


def test_outputs_of_a_block_go_to_plain_negated_set_and_reset_targets() -> None:
    block = """FUNCTION_BLOCK FB VAR_INPUT i : BOOL; k : INT := 5; END_VAR
    VAR_OUTPUT o, p, r, s : BOOL; m : INT; END_VAR
    o := p := r := s := i; m := k; END_FUNCTION_BLOCK"""
    slots: list[tuple[str, str | tuple[str, int] | None]]
    slots = [("o", "a"), ("p", ("b", NEGATED)), ("r", ("c", SET)), ("s", ("d", RESET)), ("m", "n")]
    node = fb("FB", "f", [("i", contact("x")), ("k", contact(""))], slots)
    plc = drawn("x, a, b, c : BOOL; d : BOOL := TRUE; n : INT; f : FB;", node, others=(block,))
    rows = ["0 | 0 1 0 1 5", "1 | 1 0 1 0 5", "0 | 0 1 1 0 5"]
    plc.rows("x", "a b c d n", rows)


def test_a_program_is_called_and_a_box_may_be_negated_as_a_whole() -> None:
    program = (
        "PROGRAM Other VAR_INPUT i : BOOL; END_VAR VAR n : INT; END_VAR n := n + 1; END_PROGRAM"
    )
    call = box("Other", contact("x"), call="Program", names=["i"], outputs=[("", "")])
    nand = box("AND", contact("x"), contact("Other.i"), number=NEGATED)
    plc = drawn("x, q : BOOL; n : INT;", call, assign(nand, "q"), assign(contact("Other.n"), "n"),
                others=(program,))  # fmt: skip
    plc.rows("x", "q n", ["0 | 1 1", "1 | 0 2"])


def test_a_value_is_stored_on_its_way_to_a_box() -> None:
    inner = assign(fb("R_TRIG", "t", [("CLK", contact("x"))]), "mid", ("off", NEGATED))
    plc = drawn("x, mid, off, q : BOOL; t : R_TRIG;", assign(box("NOT", inner), "q"))
    plc.rows("x", "mid off q", ["1 | 1 0 0", "1 | 0 1 1"])
