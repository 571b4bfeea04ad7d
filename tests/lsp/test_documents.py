"""Texts and positions of a client."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lsprotocol import types

from achse.lsp.documents import Document, Encoding, read_document

_TEXTS = st.text(st.sampled_from("ab\n\rä€😀\t\x0c\u2028\x85"), max_size=40)
_ENCODINGS = st.sampled_from(("utf-8", "utf-16", "utf-32"))
_CODECS = {"utf-8": ("utf-8", 1), "utf-16": ("utf-16-le", 2), "utf-32": ("utf-32-le", 4)}


@given(text=_TEXTS, kind=_ENCODINGS)
def test_offsets_go_there_and_back(text: str, kind: str) -> None:
    document = Document(text, Encoding(kind))
    for offset in range(len(text) + 1):
        if 0 < offset < len(text) and text[offset - 1 : offset + 1] == "\r\n":
            continue  # no position is inside of a line end
        position = document.position_at(offset)
        assert document.offset_at(position) == offset
        codec, width = _CODECS[kind]
        start = offset - len(document.line(position.line)[: _column(document, position)])
        assert position.character == len(text[start:offset].encode(codec)) // width


def _column(document: Document, position: types.Position) -> int:
    return document.place_of(position)[1] - 1


@given(text=_TEXTS, line=st.integers(0, 50), character=st.integers(0, 50), kind=_ENCODINGS)
def test_any_position_is_inside(text: str, line: int, character: int, kind: str) -> None:
    document = Document(text, Encoding(kind))
    assert 0 <= document.offset_at(types.Position(line, character)) <= len(text)


@given(text=_TEXTS, first=st.integers(0, 40), second=st.integers(0, 40), new=_TEXTS)
def test_edits_replace_a_range(text: str, first: int, second: int, new: str) -> None:
    document = Document(text)
    start, end = sorted((min(first, len(text)), min(second, len(text))))
    places = document.position_at(start), document.position_at(end)
    start, end = map(document.offset_at, places)
    document.edit([(types.Range(*places), new)])
    assert document.text == text[:start] + new + text[end:]
    document.edit([(None, text)])
    assert document.text == text


_PLACES = st.tuples(*[st.integers(0, 4)] * 4)


@given(
    text=_TEXTS,
    edits=st.lists(st.tuples(st.none() | _PLACES, _TEXTS), max_size=6),
    kind=_ENCODINGS,
)
def test_edits_at_once_are_made_one_after_the_other(
    text: str, edits: list[tuple[tuple[int, int, int, int] | None, str]], kind: str
) -> None:
    at_once, singly = Document(text, Encoding(kind)), Document(text, Encoding(kind))
    applied = []
    for place, new in edits:
        where = None
        if place is not None:
            where = types.Range(types.Position(*place[:2]), types.Position(*place[2:]))
        applied.append((where, new))
        start, end = (0, len(text)) if where is None else map(singly.offset_at, _ends(where))
        text = text[:start] + new + text[max(start, end) :]
        singly = Document(text, Encoding(kind))
    at_once.edit(applied)
    assert at_once.text == text


def _ends(place: types.Range) -> tuple[types.Position, types.Position]:
    return place.start, place.end


def test_a_replacement_everywhere_moves_lines_alone() -> None:
    count = 10_000
    document = Document("nSum := 1;\n" * count)
    document.edit(
        (types.Range(types.Position(line, 0), types.Position(line, 4)), "nAll")
        for line in range(count)
    )
    assert document.text == "nAll := 1;\n" * count


def test_a_position_inside_of_a_character_is_before_it() -> None:
    document = Document("a😀b")
    assert document.offset_at(types.Position(0, 2)) == 1
    assert document.offset_at(types.Position(0, 3)) == 2
    assert document.place_of(types.Position(0, 3)) == (1, 3)
    assert document.position_of(1, 3) == types.Position(0, 3)


@pytest.mark.parametrize("codec", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_files_in_any_encoding(tmp_path: Path, codec: str) -> None:
    file = tmp_path / "a.st"
    file.write_bytes("x : 'ä';\r\n".encode(codec))
    document = read_document(file, Encoding())
    assert document is not None
    assert document.text == "x : 'ä';\r\n"
    assert read_document(tmp_path / "b.st", Encoding()) is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_or_a_device_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.st")
    assert read_document(tmp_path / "pipe.st", Encoding()) is None
    assert read_document(Path(os.devnull), Encoding()) is None
