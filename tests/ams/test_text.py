"""Texts in data of ADS services."""

from hypothesis import given
from hypothesis import strategies as st

from achse.ams.text import terminated_text


@given(st.text(st.characters(codec="cp1252", exclude_characters="\0")), st.binary())
def test_text_ends_at_its_nul(text: str, rest: bytes) -> None:
    data = text.encode("cp1252")
    assert terminated_text(data) == terminated_text(data + b"\0" + rest) == text


@given(st.binary())
def test_any_bytes_are_a_text(data: bytes) -> None:
    assert "\0" not in terminated_text(data)


def test_names_are_cp1252() -> None:
    assert terminated_text(b"GVL.Gr\xf6\xdfe\0junk\0more") == "GVL.Größe"
