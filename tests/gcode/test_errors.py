"""Errors name program, line, column, word and code."""

from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.interpretation.checking import check_lines
from achse.gcode.text.program import PartProgram
from tests.gcode.programs import refused


def test_an_error_names_its_place() -> None:
    error = refused("N10 G01 X10 F600\nN20 Y5\nN30 G33 X1")
    assert (error.line, error.column, error.index, error.word) == (3, 5, 24, "G33")
    assert error.code is NcError.PROGRAM_SYNTAX_RUNNING
    assert str(error) == (
        "part.nc:3:5: error: G33: this G code is unknown (0x4112 PROGRAM_SYNTAX_RUNNING)"
    )
    assert error.caret() == "N30 G33 X1\n    ^"


def test_a_word_is_found_however_it_is_written() -> None:
    assert refused("F6 X1\n  G41 X 5").word == "G41"
    assert refused("F6 X1\n   G0041 X5").column == 4
    assert refused("g4 X1 m8").column == 1


@given(st.text(st.characters(max_codepoint=255, exclude_characters="\n")))
def test_a_file_of_any_bytes_brings_no_control_characters(text: str) -> None:
    for error in check_lines(PartProgram(text, "part.nc")):
        assert str(error).isprintable()
        assert error.caret().replace("\n", "").isprintable()


def test_words_of_other_dialects_lead_to_ours() -> None:
    assert "this G code is unknown; millimetres are G71" in str(refused("G21"))
    assert "this G code is unknown; inches are G70" in str(refused("N5 G020 X1"))
