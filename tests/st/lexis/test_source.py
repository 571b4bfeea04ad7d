"""Places in sources, and how faults are shown."""

from unicodedata import category

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.errors import DeclarationError
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, Location, Source, SourceError, SourceSegment


def test_offsets_become_lines_and_columns() -> None:
    source = Source("ab\ncd\n\nx", "a.st")
    places = [source.locate(offset)[1:] for offset in range(len(source.text) + 1)]
    assert places == [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3), (3, 1), (4, 1), (4, 2)]
    assert str(source.locate(4)) == "a.st:2:2"
    assert source.locate(-5) == Location("a.st", 1, 1)
    assert source.locate(500) == Location("a.st", 4, 2)


def test_pieces_keep_their_own_places() -> None:
    source = Source("ab\ncd\nef\ngh", "x", [SourceSegment(0, 10, 5), SourceSegment(6, 20, 3)])
    assert source.locate(1) == Location("x", 10, 6)
    assert source.locate(3) == Location("x", 11, 1)
    assert source.locate(5) == Location("x", 11, 3)
    assert source.locate(6) == Location("x", 20, 3)
    assert source.locate(9) == Location("x", 21, 1)
    assert source.line_at(4) == "cd"
    assert source.line_at(6) == "ef"


def test_the_caret_stands_under_its_column() -> None:
    assert (
        str(Source("x := ;", "a.st").fault(5, "no", Code.UNEXPECTED_TOKEN))
        == "a.st:1:6: no\n    x := ;\n         ^"
    )
    assert (
        str(Source("\tx;", "a.st").fault(1, "no", Code.UNEXPECTED_TOKEN))
        == "a.st:1:2: no\n    \tx;\n    \t^"
    )


@given(
    path=st.text(st.characters(), max_size=9),
    text=st.text(st.characters(exclude_characters="\n"), min_size=1, max_size=20),
    column=st.integers(1, 21),
)
def test_a_finding_commands_no_terminal(path: str, text: str, column: int) -> None:
    text_of_finding = str(
        Diagnostic(Location(path, 1, column), f"got {text!r}", Code.UNEXPECTED_TOKEN, text)
    )
    head, line, caret = text_of_finding.split("\n")
    assert head.endswith(f":1:{column}: got {text!r}") or not repr(text).isprintable()
    assert len(line) == len(text) + 4
    assert caret.strip() == "^"
    text_of_finding.encode()
    assert not any(
        category(sign) in ("Cc", "Cf") and sign not in "\n\t" for sign in text_of_finding
    )


def test_a_line_that_does_not_help_is_left_out() -> None:
    assert str(Source("x" * 1000, "a").fault(5, "no", Code.UNEXPECTED_TOKEN)) == "a:1:6: no"
    assert str(Source("x\0", "a").fault(1, "no", Code.UNEXPECTED_TOKEN)) == "a:1:2: no"


def test_faults_come_in_order_and_not_without_end() -> None:
    faults = [
        Diagnostic(Location("b", line, 1), "no", Code.UNEXPECTED_TOKEN) for line in range(50, 0, -1)
    ]
    error = SourceError([*faults, Diagnostic(Location("a", 9, 9), "first", Code.UNEXPECTED_TOKEN)])
    assert isinstance(error, DeclarationError)
    assert error.faults[0].message == "first"
    assert [fault.location.line for fault in error.faults[1:]] == list(range(1, 51))
    assert str(error).endswith("… and 31 more")


def test_the_caret_stands_under_wide_signs_too() -> None:
    source = Source("x : 日本e\u0301 INT;")
    fault = source.fault(source.text.index("INT"), "here", Code.UNEXPECTED_TOKEN)
    assert str(fault).splitlines()[2] == "    " + " " * (4 + 4 + 1 + 1) + "^"


@pytest.mark.parametrize("text", ["", "\n", "a", "a\n\nbc\n", "\r\nx\r\n\n", "x" * 9 + "\ny"])
def test_a_place_is_what_counting_gives(text: str) -> None:
    source = Source(text, "a.st")
    for offset in range(len(text) + 1):
        before = text[:offset]
        column = offset - (before.rfind("\n") + 1) + 1
        assert source.locate(offset) == ("a.st", before.count("\n") + 1, column)


def test_a_place_ends_behind_its_word() -> None:
    source = Source("nCount := 16#FF;\n(* open\n'text", "a.st", [SourceSegment(0, 10, 5)])
    for word, last in (("nCount", (10, 11)), (":=", (10, 14)), ("16#FF", (10, 20))):
        fault = source.fault(source.text.index(word), "no", Code.UNEXPECTED_TOKEN)
        assert (fault.end_line, fault.end_column) == last
    assert (
        source.fault(source.text.index("(*"), "no", Code.UNEXPECTED_TOKEN).end_column
        == len("(* open") + 1
    )
    assert (
        source.fault(len(source.text), "no", Code.UNEXPECTED_TOKEN).end_column == len("'text") + 1
    )
    assert source.fault(0, "no", Code.UNEXPECTED_TOKEN, end=9).end_column == 14


@pytest.mark.parametrize("text", ["", "a b", "x := 1;\n\n y", "'a$'b' \"", "日本 e\u0301"])
def test_an_end_lies_behind_its_begin_and_in_the_text(text: str) -> None:
    source = Source(text, "a.st", [SourceSegment(0, 3, 7), SourceSegment(len(text) // 2, 9, 2)])
    for offset in range(len(text) + 1):
        fault = source.fault(offset, "no", Code.UNEXPECTED_TOKEN)
        first, last = fault.location[1:], (fault.end_line, fault.end_column)
        assert first <= last
        assert fault.end_line == fault.location.line


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        ("ab\ncd\n\nx", ()),
        ("ab\ncd\nef\ngh", (SourceSegment(0, 10, 5), SourceSegment(6, 20, 3))),
        ("a\nb\n\nc", (SourceSegment(0, 1, 9), SourceSegment(2, 1, 30), SourceSegment(5, 7, 1))),
    ],
)
def test_places_lead_back_to_their_offsets(text: str, pieces: tuple[SourceSegment, ...]) -> None:
    source = Source(text, "x", pieces)
    for offset in range(len(text) + 1):
        place = source.locate(offset)
        assert source.offset_at(place.line, place.column) == offset


def test_places_outside_of_the_pieces_have_no_offset() -> None:
    source = Source("ab\ncd\nef", "x", [SourceSegment(0, 10, 5), SourceSegment(6, 20, 3)])
    assert source.offset_at(10, 4) is None
    assert source.offset_at(9, 1) is None
    assert source.offset_at(11, 4) is None
    assert source.offset_at(10, 99) == 2
    assert source.offset_at(20, 6) is None
    assert Source("ab\ncd").offset_at(2, 99) == 5


def test_an_edited_source_is_adopted() -> None:
    source, edited = Source("a\nb", "x"), Source("\n\na\nb", "x")
    assert source.locate(2).line == 2
    source.adopt(edited)
    assert source.locate(4).line == 4
    assert source.digest == edited.digest
