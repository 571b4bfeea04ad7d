"""STRING(n) and WSTRING(n)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.errors import DeclarationError, IecDecodeError, IecValueError
from achse.iec.strings import STRING, WSTRING
from achse.iec.text import decode_text

CP1252 = st.binary(max_size=20).map(lambda data: decode_text(data.replace(b"\0", b"")))
WIDE = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=10)


def test_sizes_and_names() -> None:
    assert (STRING().size, STRING().name) == (81, "STRING(80)")
    assert (WSTRING().size, WSTRING().name, WSTRING().alignment) == (162, "WSTRING(80)", 2)
    assert (STRING(5).adst, WSTRING(5).adst) == (30, 31)
    assert STRING(80).guid.hex() == "95190718000000000000000100000050"  # recorded
    assert STRING(5) is STRING(5)
    for length in (-1, 2**31):
        with pytest.raises(DeclarationError, match=r"STRING\(n\) needs n from 0"):
            STRING(length)


@given(CP1252)
def test_cp1252_texts_come_back(text: str) -> None:
    assert STRING(20).decode(STRING(20).encode(text)) == text


@given(WIDE)
def test_wide_and_utf_8_texts_come_back(text: str) -> None:
    assert WSTRING(20).decode(WSTRING(20).encode(text)) == text
    assert STRING(40, "utf-8").decode(STRING(40, "utf-8").encode(text)) == text


def test_the_text_is_padded_with_nul() -> None:
    assert STRING(4).encode("ab") == b"ab\0\0\0"
    assert STRING(4).encode("abcd") == b"abcd\0"
    assert STRING(4).short("ab") == b"ab\0"
    assert WSTRING(2).encode("a") == b"a\0\0\0\0\0"
    assert WSTRING(2).short("a") == b"a\0\0\0"


def test_the_text_ends_at_the_first_nul() -> None:
    assert STRING(6).decode(b"ab\0cdef") == "ab"
    assert STRING(6).decode(b"abcdefg") == "abcdef"
    assert STRING(6).decode(b"abc") == "abc"
    assert WSTRING(3).decode("äb\0c".encode("utf-16-le")) == "äb"
    # the bytes 61 00 00 01 hold two NULs side by side that are not a character
    assert WSTRING(3).decode(b"a\0\0\1\0\0") == "aĀ"
    assert WSTRING(3).decode(b"a\0") == "a"
    with pytest.raises(IecDecodeError, match="2 bytes per unit, got 3 bytes"):
        WSTRING(3).decode(b"a\0b")


@pytest.mark.parametrize("value", ["abcde", "a\0", "Ω", b"ab", 5, None])
def test_what_does_not_fit_is_refused(value: object) -> None:
    with pytest.raises(IecValueError, match=r"STRING\(4\) takes a str without NUL"):
        STRING(4).encode(value)


@pytest.mark.parametrize("value", ["abc", "😀a", "\ud800", "a\0", b"ab"])
def test_what_does_not_fit_wide_is_refused(value: object) -> None:
    with pytest.raises(IecValueError, match=r"WSTRING\(2\) takes a str without NUL"):
        WSTRING(2).encode(value)


def test_utf_8_counts_bytes() -> None:
    assert STRING(4, "utf-8").encode("ää") == "ää".encode() + b"\0"
    with pytest.raises(IecValueError, match="at most 4 bytes in utf-8"):
        STRING(4, "utf-8").encode("äää")


@given(st.binary(max_size=12))
def test_any_bytes_are_some_text(data: bytes) -> None:
    for type in (STRING(10), STRING(10, "utf-8")):
        assert isinstance(type.decode(data), str)
    if len(data) % 2 == 0:
        assert isinstance(WSTRING(10).decode(data), str)


def test_in_place() -> None:
    memory = bytearray(b"xxxxxxxx")
    STRING(3).write(memory, 2, "a")
    assert memory == b"xxa\0\0\0xx"
    assert STRING(3).read(memory, 2) == "a"
