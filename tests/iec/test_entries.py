"""The parts of table entries never reach beyond the bytes that are there."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.entries import (
    EntryReader,
    attribute_bytes,
    open_entry,
    padded_entry,
    short_text,
    text_bytes,
)
from achse.iec.errors import IecDecodeError, IecValueError

ATTRIBUTES = st.lists(
    st.tuples(st.text("abcä", max_size=255), st.text("xyz€", max_size=255)), max_size=5
)


@given(ATTRIBUTES)
def test_attributes_come_back(attributes: list[tuple[str, str]]) -> None:
    data = attribute_bytes(attributes, "cp1252")
    cursor = EntryReader(data, 0, len(data), "thing")
    assert cursor.attributes(len(attributes)) == tuple(attributes)
    assert cursor.left == 0


def test_an_attribute_as_bytes() -> None:
    assert attribute_bytes([("pack_mode", "1")], "cp1252") == b"\x09\x01pack_mode\x001\x00"


@given(st.binary(max_size=40), st.binary(min_size=1, max_size=9))
def test_entries_give_back_body_and_tail(body: bytes, tail: bytes) -> None:
    for entry, rest in ((padded_entry(body), b""), (open_entry(body, tail), tail)):
        cursor = EntryReader.entry(entry, 0, len(entry), "thing", "cp1252")
        assert cursor.take(len(body)) == body
        if rest == b"" or any(rest):
            assert cursor.tail() == rest
    assert len(padded_entry(body)) % 8 == 0


@pytest.mark.parametrize(
    "data", [b"", b"\5\0\0", b"\3\0\0\0", b"\xff\xff\xff\xff", b"\x09\0\0\0abcd"]
)
def test_an_announced_length_must_be_there(data: bytes) -> None:
    with pytest.raises(IecDecodeError, match=r"a thing (announces|ends)"):
        EntryReader.entry(data, 0, len(data), "thing", "cp1252")


def test_reading_beyond_the_end_is_refused() -> None:
    cursor = EntryReader(b"abc", 0, 3, "thing")
    with pytest.raises(IecDecodeError, match="a thing ends 4294967292 bytes too early"):
        cursor.take(0xFFFF_FFFF)
    with pytest.raises(IecDecodeError, match="a thing ends 1 bytes too early"):
        cursor.u32()
    with pytest.raises(IecDecodeError, match="no NUL after 2 bytes"):
        cursor.text(2)


def test_texts_must_fit_their_length_field() -> None:
    assert text_bytes("x" * 300, "cp1252", "a name") == b"x" * 300
    with pytest.raises(IecValueError, match="a name takes a text of at most 65535 bytes"):
        text_bytes("x" * 65_536, "cp1252", "a name")
    with pytest.raises(IecValueError, match="a name takes a text of at most 255 bytes"):
        short_text("x" * 256, "cp1252", "a name")
    with pytest.raises(IecValueError, match="a name takes a text in cp1252, got 'Ω'"):
        text_bytes("Ω", "cp1252", "a name")
    assert text_bytes("Ω", "utf-8", "a name") == b"\xce\xa9"
