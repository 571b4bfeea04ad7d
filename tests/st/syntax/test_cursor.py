"""The cursor: what comes next, what was expected in which place, and where reading goes on."""

import pytest

from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import END, NAME
from achse.st.lexis.source import Source
from achse.st.syntax.cursor import DEEPEST, MOST_FAULTS, Cursor, Unexpected
from achse.st.syntax.tree import NO_NOTE, Name, Note


def cursor(text: str) -> Cursor:
    return Cursor(Source(text))


def messages(cursor: Cursor) -> list[tuple[int, int, str]]:
    return [(fault.location.line, fault.location.column, fault.message) for fault in cursor.faults]


def test_a_token_is_passed_if_it_is_of_the_kind() -> None:
    tokens = cursor("a ; b")
    assert not tokens.take(";")
    assert tokens.take(NAME)
    assert tokens.at == 2
    assert tokens.take(";")
    assert tokens.expect(NAME) == 4
    assert tokens.kinds[tokens.position] == END


def test_what_is_expected_has_a_place_and_says_what_came() -> None:
    tokens = cursor("a ; b")
    with pytest.raises(Unexpected) as caught:
        tokens.expect(";")
    assert (caught.value.at, caught.value.message) == (0, "expected ';', got 'a'")
    assert tokens.position == 0


def test_long_token_is_reported_by_its_beginning() -> None:
    assert cursor("x" * 100).unexpected("1").message == f"expected 1, got '{'x' * 40}'"


@pytest.mark.parametrize(
    ("text", "at", "came"),
    [
        ("ab cd", 3, "'cd'"),
        ("ab // why\ncd", 2, "'cd'"),
        ("ab   ", 2, "the end"),
    ],
    ids=["same line", "next line", "end"],
)
def test_what_is_missing_at_the_end_of_a_line_is_missing_there(
    text: str, at: int, came: str
) -> None:
    tokens = cursor(text)
    tokens.take(NAME)
    fault = tokens.unexpected("';'")
    assert (fault.at, fault.message) == (at, f"expected ';', got {came}")


def test_words_with_a_meaning_in_their_place_are_known_without_case() -> None:
    tokens = cursor("Public get THEN")
    assert tokens.is_word("PUBLIC")
    assert tokens.is_word("GET", 1)
    assert not tokens.is_word("GET")
    assert not tokens.is_word("THEN", 2)
    assert not tokens.is_word("GET", 99)


def test_names_and_paths() -> None:
    tokens = cursor("  Tc2_MC2 . AXIS_REF nCount . 5")
    path = tokens.path()
    assert (path, path.at) == (Name("Tc2_MC2.AXIS_REF"), 2)
    assert tokens.name() == Name("nCount")
    tokens = cursor("a. ;")
    with pytest.raises(Unexpected, match=r"^expected a name, got ';'$"):
        tokens.path()
    with pytest.raises(Unexpected, match=r"^expected a type, got ';'$"):
        tokens.name("a type")


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("a : INT;", NO_NOTE),
        ("a : INT; // unit: mm", Note(" unit: mm")),
        ("/// of the axis\n(* two\n lines *) a : INT;", Note(" of the axis\n two\n lines ")),
        ("// before\na : INT; // after", Note(" after")),
        ("{attribute 'x' := '1'}\n{attribute 'y'}\na : INT;", Note("", (("x", "1"), ("y", "")))),
        ("{region 'r'}\na : INT;", Note()),
    ],
    ids=["none", "after", "before", "after wins", "attributes", "other pragma"],
)
def test_notes_stand_before_a_declaration_or_after_it(text: str, note: Note) -> None:
    tokens = cursor(text)
    assert tokens.note(0, tokens.words.index(";")) == note


def test_of_faults_in_one_place_the_first_is_kept_and_all_come_in_order() -> None:
    tokens = cursor("ab\ncd")
    tokens.report(Unexpected(3, "later", Code.UNEXPECTED_TOKEN))
    tokens.report(Unexpected(0, "first", Code.UNEXPECTED_TOKEN))
    tokens.report(Unexpected(0, "again", Code.UNEXPECTED_TOKEN))
    assert messages(tokens) == [(1, 1, "first"), (2, 1, "later")]


def test_what_the_lexer_finds_is_a_fault_too() -> None:
    assert messages(cursor("a ? b")) == [(1, 3, "expected Structured Text, got '?'")]


def test_faults_are_limited() -> None:
    tokens = cursor("x" * 50 * MOST_FAULTS)
    for at in range(20 * MOST_FAULTS):
        tokens.report(Unexpected(at, "wrong", Code.UNEXPECTED_TOKEN))
    assert len(tokens.faults) == MOST_FAULTS


def test_nesting_is_limited() -> None:
    tokens = cursor("a")
    for _ in range(DEEPEST):
        tokens.deeper()
    with pytest.raises(Unexpected, match=f"deeper than {DEEPEST} levels"):
        tokens.deeper()


def test_an_end_left_out_before_a_line_break_costs_a_fault_but_no_token() -> None:
    tokens = cursor("a\nb")
    tokens.take(NAME)
    tokens.expect_end(";")
    assert messages(tokens) == [(1, 2, "expected ';', got 'b'")]
    assert tokens.name() == Name("b")


def test_an_end_left_out_in_the_line_is_unexpected() -> None:
    tokens = cursor("a b")
    tokens.take(NAME)
    with pytest.raises(Unexpected, match="expected ';', got 'b'"):
        tokens.expect_end(";")
    assert tokens.faults == []


@pytest.mark.parametrize(
    ("text", "next_word"),
    [
        ("a b ; c", "c"),
        ("a b IF c", "IF"),
        ("a b END_VAR c", "END_VAR"),
        ("IF b ; c", "c"),
        ("a b", ""),
        ("", ""),
    ],
    ids=["semicolon", "stop", "block", "past the first", "end", "nothing"],
)
def test_reading_goes_on_after_a_fault(text: str, next_word: str) -> None:
    tokens = cursor(text)
    tokens.skip_to({"IF"}, 0)
    assert tokens.words[tokens.position] == next_word


def test_a_part_of_a_source_is_walked_at_its_offsets() -> None:
    tokens = Cursor(Source("a := b;"), 5, 6)
    assert tokens.at == 5
    assert tokens.name() == Name("b")
    assert tokens.kinds[tokens.position] == END


def test_conditions_decide_which_tokens_there_are() -> None:
    text = "{IF defined (X)} a {ELSE} b {END_IF}"
    assert Cursor(Source(text)).name() == Name("b")
    assert Cursor(Source(text), defines=["X"]).name() == Name("a")
