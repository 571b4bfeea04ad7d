"""A program's lines, block numbers, labels and files."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.errors import GcodeError
from achse.gcode.text.blocks import HashCall
from achse.gcode.text.program import LONGEST_BLOCK, PartProgram, search_folders

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
    ends = re.sub("\r+\n", "\n", text.rstrip("\0\x1a")).replace("\r", "\n")
    assert len(program) == ends.count("\n") + 1
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


@pytest.mark.parametrize(
    "end", ["\n", "\r\n", "\r", "\r\r\n"], ids=["LF", "CR LF", "CR", "CR CR LF"]
)
def test_lines_end_in_any_way(end: str) -> None:
    text = f"N1 X1{end}N2 Y2{end}N3 Z3{end}"
    program = PartProgram(text)
    assert program.lines == ["N1 X1", "N2 Y2", "N3 Z3", ""]
    assert [text[at : at + 5] for at in program.starts[:3]] == ["N1 X1", "N2 Y2", "N3 Z3"]
    assert program.find_block(3, 0, "+") == 2
    labelled = PartProgram(f"L7{end}M30{end}L7{end}X1{end}M17")
    assert labelled.labels == {7: 2}


@given(st.lists(st.tuples(st.integers(0, 99), st.sampled_from(["\n", "\r\n", "\r"])), min_size=1))
def test_mixed_ends_of_lines(lines: list[tuple[int, str]]) -> None:
    """A CR and an LF that come together are one end."""
    text = "".join(f"X{number}{end}" for number, end in lines)
    program = PartProgram(text)
    assert program.lines == [*(f"X{number}" for number, _ in lines), ""]
    for line, start in enumerate(program.starts[:-1]):
        assert text[start:].startswith(program.lines[line])


def test_a_mark_of_utf_8_is_passed_over() -> None:
    program = PartProgram(
        b"\xef\xbb\xbfN1 X1\n#MSG(NCI; ENTRY; Gr\xc3\xb6\xc3\x9fe)#\n(\xc3\xa4) Y2"
    )
    assert (program.block(0).number, program.block(0).values) == (1, {"X": 1.0})
    call = program.block(1).call
    assert isinstance(call, HashCall)
    assert call.text == "Größe"
    assert program.block(2).values == {"Y": 2.0}
    assert program.starts[1] == 9
    latin = PartProgram("#MSG(NCI; ENTRY; Größe)#".encode("latin-1")).block(0).call
    assert isinstance(latin, HashCall)
    assert latin.text == "Größe"


@pytest.mark.parametrize("form", ["utf-16", "utf-16-le", "utf-16-be", "utf-32-le", "utf-32-be"])
@pytest.mark.parametrize("text", ["N10 G1 X1\n", "%1\n" + "N1 X1\n" * 99])
def test_wide_characters_are_refused(tmp_path: Path, form: str, text: str) -> None:
    path = tmp_path / "wide.nc"
    path.write_bytes(text.encode(form))
    with pytest.raises(GcodeError, match="UTF-16 or UTF-32, expected ASCII") as refused:
        PartProgram.load(path)
    assert refused.value.code is NcError.PROGRAM_SYNTAX_LOADING


@pytest.mark.parametrize("count", [1, 2, 3, 63, 64, 65])
def test_nul_bytes_around_blocks_are_blanks(count: int, tmp_path: Path) -> None:
    """Leader and trailer of a tape, what fills a file, the end of file of DOS."""
    path = tmp_path / "tape.nc"
    padding = b"\0" * count
    path.write_bytes(
        padding + b"N1 X1\r\n" + padding + b"N2 Y2" + padding + b"\r\nM30\r\n\x1a" + padding
    )
    program = PartProgram.load(path)
    assert [program.block(line).number for line in range(len(program))] == [1, 2, 0, 0]
    assert program.block(1).values == {"Y": 2.0}
    assert program.find_block(2, 0, "+") == 1


def test_a_nul_byte_inside_a_block_is_an_error() -> None:
    program = PartProgram(b"N1 X1\nN2 X1\x000\n", "a.nc")
    with pytest.raises(GcodeError, match="a NUL byte inside a block") as refused:
        program.block(1)
    assert (refused.value.line, refused.value.column) == (2, 6)
    assert "\0" not in f"{refused.value}\n{refused.value.caret()}"


@pytest.mark.parametrize("filler", ["\r", "\0", "\0\r", " \r", "\x1a"])
def test_long_runs_of_fillers_are_read_at_once(filler: str) -> None:
    """Time grows with the length, not with its square: a channel loads up to 16 MiB."""
    program = PartProgram("X1" + filler * 200_000 + "X2")
    assert program.lines[0].startswith("X1")
    assert program.lines[-1].endswith("X2")


def test_lines_with_a_percent_sign_are_names() -> None:
    program = PartProgram("%\n%PART 1 (any text, G99)\nN1 X1\n%")
    assert [bool(program.block(line)) for line in range(4)] == [False, False, True, False]
    with pytest.raises(GcodeError, match="begins no word"):
        PartProgram("X1 %").block(0)
