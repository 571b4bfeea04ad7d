"""Words of one block together."""

import pytest

from tests.gcode.programs import refused


@pytest.mark.parametrize(
    ("block", "word"),
    [
        ("G0 G1 X1", "G01"),
        ("G17 G18", "G18"),
        ("G41 G42 X1", "G42"),
        ("G90 G91", "G91"),
        ("CFC CFIN", "CFIN"),
        ("G09 G60", "G60"),
        ("CIP G2 X1", "G02"),
        ("G70 G71", "G71"),
    ],
)
def test_words_of_one_group_exclude_each_other(block: str, word: str) -> None:
    error = refused(block)
    assert error.word == word
    assert "exclude" in error.message
    assert error.column > 1


@pytest.mark.parametrize(
    "block",
    ["G54 X1", "G04 X1 M8", "G58 X1 G1", "ROT Z90 F600", "MIRROR X D1", "G74 X G90", "G04 X1 R1=5"],
)
def test_some_words_need_a_block_of_their_own(block: str) -> None:
    assert "of its own" in refused(block).message
