"""Instruction lists as text."""

from achse.st.files.exports import parse_export
from achse.st.graphical.instruction_text import read_instruction_text
from tests.st.graphical.drawings import Drawn


def program(variables: str, body: str) -> Drawn:
    head = f"PROGRAM MAIN\nVAR {variables} END_VAR\n(* @END_DECLARATION := '0' *)\n"
    return Drawn(parse_export(head + body + "END_PROGRAM\n", "MAIN.EXP", "MAIN"))


def test_jump_leads_to_a_label() -> None:
    body = "LD a\nANDN b\nJMPC on\nLDN a\nR q\nRET\non: (* here *)\nLD TRUE\nS q\n"
    plc = program("a, b, q : BOOL;", body)
    plc.rows("a b", "q", ["1 0 | 1", "1 1 | 1", "0 1 | 0", "1 1 | 0", "1 0 | 1"])


def test_brackets_nest() -> None:
    plc = program("a, b, c, q : BOOL;", "LD a\nAND( b\nOR c\n)\nST q\n")
    plc.rows("a b c", "q", ["1 0 0 | 0", "1 1 0 | 1", "1 0 1 | 1", "0 1 1 | 0"])


def test_call_has_its_parameters_on_several_lines() -> None:
    body = "CAL t(IN := a,\n  PT := T#20ms)\nLD t.Q\nST q\n"
    program("a, q : BOOL; t : TON;", body).rows("a", "q", ["1 | 0", "1 | 0", "1 | 1", "0 | 0"])


def test_function_takes_the_accumulator_first() -> None:
    program("a, q : INT;", "LD a\nMAX 3\nADD 1\nST q\n").rows("a", "q", ["1 | 4", "5 | 6"])


def test_lines_have_their_offsets() -> None:
    text = "_IL_BODY\n  LD a\nend:\nST b\n"
    first, second = read_instruction_text(text).networks
    assert [text[line.at :][:4] for line in (*first.lines, *second.lines)] == ["LD a", "ST b"]
    assert second.label == "end"


def test_label_goes_on_with_the_accumulator() -> None:
    body = "LD a\nJMPC on\nLD n\nADD 1\nJMP out\non:\nLD 5\nout:\nST n\n"
    plc = program("a : BOOL; n : INT;", body)
    plc.rows("a", "n", ["0 | 1", "0 | 2", "1 | 5", "0 | 6"])
