"""Edits of a text: operators, statements, conditions, operands and literals."""

import pytest

from achse.iec.elementary import DINT, LREAL, WORD
from achse.iec.times import TIME
from achse.st.lexis.source import Source
from achse.tcunit.mutation.edits import SourceEdits, TextEdit

TEXT = (
    "IF (a + 1) < b AND c THEN x := 16#1F; (* ; *) y := -5; END_IF "
    "WHILE d DO f(1, t := T#2S); END_WHILE"
)


def edited(edit: TextEdit | None) -> str:
    assert edit is not None
    return TEXT[: edit.start] + edit.text + TEXT[edit.end :]


@pytest.fixture
def edits() -> SourceEdits:
    return SourceEdits(Source(TEXT, "a.st"))


def test_operators(edits: SourceEdits) -> None:
    at = TEXT.index("<")
    assert edits.word(at) == "<"
    assert "1) <= b" in edited(edits.replaced_word(at, "<="))
    assert edits.word(at + 1) == ""
    assert edits.replaced_word(at + 1, "<=") is None


def test_statements_go_up_to_their_semicolon(edits: SourceEdits) -> None:
    assert "THEN ; (*" in edited(edits.without_statement(TEXT.index(":=")))
    assert "*) ; END_IF" in edited(edits.without_statement(TEXT.index(":= -5")))
    assert "DO ; END_WHILE" in edited(edits.without_statement(TEXT.index("f(")))


def test_conditions(edits: SourceEdits) -> None:
    assert edited(edits.replaced_condition(0, "TRUE")).startswith("IF TRUE THEN")
    assert edited(edits.negated_condition(TEXT.index("WHILE"))).endswith(
        "WHILE NOT (d) DO f(1, t := T#2S); END_WHILE"
    )
    assert edits.negated_condition(TEXT.index("END_IF")) is None


def test_operands_with_what_binds_more(edits: SourceEdits) -> None:
    places = edits.chain(TEXT.index("AND"), 1)
    for number, (text, gone) in enumerate(
        [("IF c THEN", "(a + 1) < b"), ("IF (a + 1) < b THEN", "c")]
    ):
        edit, name = edits.without_operand(places, number)
        assert edited(edit).startswith(text)
        assert name == gone
    assert edits.chain(TEXT.index("AND"), 2) == []
    assert edits.without_operand([], 0) == (None, "")


@pytest.mark.parametrize(
    ("literal", "old", "new", "type", "text"),
    [
        ("16#1F", 31, 32, WORD, "16#20"),
        ("-5", -5, -4, DINT, "-4"),
        ("-5", -5.0, -4.0, LREAL, "-4.0"),
        ("T#2S", 2000, 2001, TIME, "T#2001MS"),
        ("b AND", 1, 2, DINT, None),
        ("1,", 7, 8, DINT, None),
        ("16#1F", 0, -1, WORD, None),
    ],
)
def test_literals(
    edits: SourceEdits, literal: str, old: float, new: float, type: object, text: str | None
) -> None:
    edit = edits.replaced_literal(TEXT.index(literal), old, new, type)
    assert (None if edit is None else edit.text) == text
