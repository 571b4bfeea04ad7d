"""Texts and positions of a client."""

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
    document.edit(types.Range(*places), new)
    assert document.text == text[:start] + new + text[end:]
    document.edit(None, text)
    assert document.text == text


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
