"""Pieces of Python source: parentheses where they must be, cuts where a number can be outside."""

from hypothesis import given
from hypothesis import strategies as st

from achse.iec.elementary import BYTE, DINT, INT, UDINT, ULINT, USINT
from achse.plc.code.source import CodeExpression, Precedence, SourceLines, exact, joined


def test_operands_get_parentheses_where_they_bind_less() -> None:
    total = joined(CodeExpression("a"), "+", CodeExpression("b"), Precedence.ADD, 0, 0)
    assert joined(total, "*", total, Precedence.MUL, 0, 0).text == "(a + b) * (a + b)"
    assert joined(total, "-", total, Precedence.ADD, 0, 0).text == "a + b - (a + b)"


def test_a_number_within_its_type_is_not_cut() -> None:
    assert exact(CodeExpression("x", low=0, high=255), BYTE).text == "x"


@given(st.integers(), st.sampled_from([BYTE, INT, DINT, UDINT, ULINT, USINT]))
def test_a_cut_gives_the_low_bits_with_their_sign(value, type) -> None:  # type: ignore[no-untyped-def]
    piece = exact(CodeExpression("x", low=-(1 << 80), high=1 << 80), type)
    result = eval(piece.text, {"x": value})
    assert type.low <= result <= type.high
    assert (result - value) % (1 << 8 * type.size) == 0


def test_a_number_that_grows_without_end_is_cut_on_the_way() -> None:
    piece = CodeExpression("x", low=-(1 << 63), high=(1 << 63) - 1)
    for _ in range(10):
        piece = joined(piece, "*", piece, Precedence.MUL, piece.low * piece.high, piece.high**2)
    assert piece.high < 1 << 600


def test_lines_know_where_they_come_from() -> None:
    lines = SourceLines(5)
    with lines.within("if a:"):
        lines.place(9)
        lines.add("b")
    lines.add("c")
    assert lines.lines == [("if a:", 5), ("    b", 9), ("c", 9)]
