"""A program's lines, block numbers, labels and files."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.errors import GcodeError
from achse.gcode.program import LONGEST_BLOCK, PartProgram, search_folders

TEXT = "%PART\r\nN10 G1 X1\r\n/2 N20 X2\r\n(N30)\r\nN10 M30\r\nL5\r\nM17\r\n(end)\r\nL6 (x)\r\nM17"


def test_a_text_index_is_the_offset_of_a_line() -> None:
    program = PartProgram(TEXT, "part.nc")
    for line, start in enumerate(program.starts):
        assert TEXT.encode("latin-1")[start:].startswith(program.original(line).encode("latin-1"))
        assert program.line_of(start) == line
        assert program.line_of(start + 1) == line


def test_blocks_are_found_in_both_directions() -> None:
    program = PartProgram(TEXT)
    assert program.find_block(10, 0, "+") == 1
    assert program.find_block(10, 1, "+") == 4
    assert program.find_block(10, 3, "-") == 1
    assert program.find_block(20, 0, "+") == 2
    assert program.find_block(20, 0, "-") is None
    assert program.find_block(30, 0, "+") is None
    assert program.find_block(10, 4, "-") == 4


def test_labels_are_behind_an_end() -> None:
    assert PartProgram(TEXT).labels == {5: 5, 6: 8}
    assert PartProgram("X1\nL5\nM30").labels == {}
    assert PartProgram("L5\nX1").labels == {}
    assert PartProgram("%A\n\nL5\nX1").begin(5) == 3
    assert PartProgram("L5\nX1").begin(6) == PartProgram("").begin(6) == 0


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(GcodeError) as refused:
        PartProgram.load(tmp_path / "nothing.nc")
    assert refused.value.code is NcError.PROGRAM_OPEN


def test_folders_are_searched_in_their_order(tmp_path: Path) -> None:
    first, second = tmp_path / "a", tmp_path / "b"
    for folder in (first, second):
        folder.mkdir()
        (folder / "l7.Nc").write_text(f"({folder.name})")
    (second / "L8.NC").write_text("(b)")
    find = search_folders([None, tmp_path / "none", first, second])
    seven, eight = find(7), find(8)
    assert seven is not None
    assert eight is not None
    assert (seven.text, eight.text) == ("(a)", "(b)")
    assert find(9) is None
    assert find(7) is seven


@given(st.text(max_size=80))
def test_any_text_is_a_program(text: str) -> None:
    program = PartProgram(text)
    assert len(program) == text.count("\n") + 1
    for line in range(len(program)):
        place = (line + 1, 1)
        try:
            program.block(line)
        except GcodeError as error:
            place = (error.line, error.column)
        assert place >= (line + 1, 1)
    _ = program.labels, program.find_block(1, 0, "+")


@given(st.integers(1, 1 << 16), st.sampled_from(["A", "1", "R1+", "(", "-", "X1 ", "\x1b"]))
def test_a_line_longer_than_a_block_is_refused_before_it_is_read(more: int, part: str) -> None:
    line = "N10 R1=" + part * (LONGEST_BLOCK // len(part) + more)
    program = PartProgram("N5 X1\n" + line, "part.nc")
    with pytest.raises(GcodeError) as refused:
        program.block(1)
    error = refused.value
    assert error.code is NcError.PROGRAM_SYNTAX_RUNNING
    assert (error.line, error.column, error.index) == (2, 1, 6)
    assert f"{len(line)} characters" in error.message
    assert len(error.caret()) < 100
    assert program.block(0).values == {"X": 1.0}


def test_a_block_of_the_greatest_length_is_read() -> None:
    line = "N10 X1 (" + "a" * (LONGEST_BLOCK - 9) + ")"
    assert len(line) == LONGEST_BLOCK
    assert PartProgram(line).block(0).values == {"X": 1.0}
