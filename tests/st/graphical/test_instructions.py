"""Instruction lists: accumulator, brackets, calls, jumps; the worked example."""

import pytest

from achse.st.check import check
from achse.st.declare import declare
from tests.st.graphical.drawings import Drawn, instructions, line, networks, part, read, unit


def drawn(variables: str, *items: str, parts: str = "") -> Drawn:
    head = f"PROGRAM MAIN\nVAR\n{variables}\nEND_VAR"
    return Drawn(unit(head, networks(*items, view="Il"), parts))


def test_jumps_returns_set_and_reset_depend_on_the_accumulator() -> None:
    plc = drawn(
        "a, b, q : BOOL;",
        instructions(
            line("LD", "a"), line("ANDN", "b"), line("JMPC", "on"),
            line("LDN", "a"), line("R", "q"), line("RET"),
        ),
        instructions(line("LD", "TRUE"), line("S", "q"), label="On"),
    )  # fmt: skip
    plc.rows("a b", "q", ["1 0 | 1", "1 1 | 1", "0 1 | 0", "1 1 | 0", "1 0 | 1"])


def test_brackets_functions_and_arithmetic() -> None:
    plc = drawn(
        "a, b, q : BOOL; n, m : INT;",
        instructions(
            line("LD", "a"), line("OR(", "b"), line("AND", "n > 1"), line(")"), line("ST", "q"),
            line("LD", "n"), line("ADD", "3"), line("MUL", "2"), line("MAX", "0, 20"),
            line("ST", "m"), line("GT", "20"), line("STN", "b"), line(""),
        ),
    )  # fmt: skip
    plc.rows("a n", "q m b", ["0 0 | 0 20 1", "0 2 | 1 20 1", "0 9 | 1 24 0", "1 0 | 1 20 1"])


def test_a_call_takes_a_line_for_each_parameter() -> None:
    plc = drawn(
        "a, q : BOOL; t : R_TRIG;",
        instructions(
            line("LD", "a"),
            line("CAL", "t", postfix="("),
            line("CLK", "a", prefix=":=", postfix=","),
            line("Q", "q", prefix="=>", postfix=")"),
        ),
    )
    plc.rows("a", "q", ["1 | 1", "1 | 0", "0 | 0", "1 | 1"])


def test_the_accumulator_at_the_end_is_the_result_of_a_transition() -> None:
    body = networks(instructions(line("LD", "n"), line("GT", "7")))
    plc = Drawn(
        unit(
            "PROGRAM MAIN VAR n : INT; q : BOOL; END_VAR",
            "<ST><![CDATA[q := TGo();]]></ST>",
            part("Transition", "TGo", body),
        )
    )
    plc.rows("n", "q", ["7 | 0", "8 | 1"])


@pytest.mark.parametrize(
    ("lines", "why"),
    [
        ([line("ST", "q")], "the accumulator is used before a value is loaded"),
        ([line("LD", "q"), line("AND("), line("LD", "q")], "a bracket is not closed"),
        ([line("LD", "q"), line(")")], "a bracket is closed that is not open"),
        ([line("CAL", "q", postfix="(")], "a call is not closed"),
    ],
)
def test_lists_that_do_not_work_out_are_refused(lines: list[str], why: str) -> None:
    body = networks(instructions(*lines))
    typed = check(declare([read(unit("PROGRAM MAIN VAR q : BOOL; END_VAR", body))]))
    assert any(why in str(one.message) for one in typed.warnings), typed.warnings
