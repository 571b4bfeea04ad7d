"""8-bit and UTF-16 text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.text import (
    decode_text,
    decode_wide,
    encode_name,
    encode_text,
    encode_wide,
    plain_name,
)


@given(st.binary())
def test_every_byte_is_a_cp1252_character_and_comes_back(data: bytes) -> None:
    assert encode_text(decode_text(data)) == data


def test_cp1252_is_no_latin_1() -> None:
    assert decode_text(b"\x80\xe4\x99") == "€ä™"
    assert encode_text("€") == b"\x80"
    with pytest.raises(UnicodeEncodeError):
        encode_text("Ω")


@given(st.text())
def test_utf_8_and_wide_texts_come_back(text: str) -> None:
    assert decode_text(encode_text(text, "utf-8"), "utf-8") == text
    assert decode_wide(encode_wide(text)) == text


def test_broken_text_is_marked_not_refused() -> None:
    assert decode_text(b"a\xff", "utf-8") == "a\ufffd"
    assert decode_wide(b"a\0\x00\xd8") == "a\ufffd"


@given(st.text(st.characters(exclude_characters="\\", exclude_categories=("Cs", "Cc"))))
def test_names_differ_in_cp1252_and_come_back(name: str) -> None:
    assert plain_name(encode_name(name).decode("cp1252")) == name


@given(st.text())
def test_any_text_is_a_name_or_stays(name: str) -> None:
    assert plain_name(name) == name or "\\" in name
