"""The words of the language: each set means one thing, and the lexer goes by them."""

from collections.abc import Callable

import pytest

from achse.st.lexis import words
from achse.st.lexis.lexer import NAME, scan
from achse.st.lexis.words import (
    ACCESS,
    BLOCK_WORDS,
    INNER_ENDS,
    KEYWORDS,
    MODIFIERS,
    QUALIFIERS,
    SECTIONS,
    SIGNS,
    STATEMENT_WORDS,
)
from tests.public_names import public_names


@pytest.mark.parametrize("name", public_names(words))
def test_words_are_written_in_capitals_without_blanks(name: str) -> None:
    for word in getattr(words, name):
        assert word
        assert word == word.upper().strip()


@pytest.mark.parametrize("word", sorted(KEYWORDS))
@pytest.mark.parametrize("spelled", [str.upper, str.lower, str.capitalize])
def test_a_keyword_is_no_name_in_any_case(word: str, spelled: Callable[[str], str]) -> None:
    assert scan(spelled(word)).kinds[0] == word


@pytest.mark.parametrize("word", sorted(MODIFIERS | QUALIFIERS | {"GET", "SET"}))
def test_words_that_mean_something_in_their_place_only_are_names(word: str) -> None:
    assert scan(word).kinds[0] == NAME


@pytest.mark.parametrize("sign", sorted(SIGNS - {"&"}))
def test_a_sign_is_one_token(sign: str) -> None:
    tokens = scan(f"a{sign}b")
    assert tokens.kinds[:3] == [NAME, sign, NAME]
    assert tokens.words[1] == sign


def test_the_sign_for_and_is_the_word() -> None:
    assert scan("a & b").kinds == scan("a AND b").kinds


def test_a_word_begins_a_statement_ends_one_or_bounds_a_block() -> None:
    assert not STATEMENT_WORDS & INNER_ENDS
    assert not STATEMENT_WORDS & BLOCK_WORDS
    assert not INNER_ENDS & BLOCK_WORDS


@pytest.mark.parametrize("word", sorted(word for word in KEYWORDS if word.startswith("END_")))
def test_an_end_ends_a_word_that_begins(word: str) -> None:
    begins = word.removeprefix("END_")
    names = {"GET", "SET", "NAMESPACE"}  # Words only where they mean something.
    assert begins in KEYWORDS | names


def test_access_stands_before_units_and_before_variables() -> None:
    assert MODIFIERS & QUALIFIERS == ACCESS


def test_blocks_of_variables_are_blocks() -> None:
    assert SECTIONS < BLOCK_WORDS
    assert all(word.startswith("VAR") for word in SECTIONS)
