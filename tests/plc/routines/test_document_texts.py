"""Texts of PLC programs that documents are read from and written to."""

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.routines.builtin_memory import BuiltinMemory
from achse.plc.routines.document_texts import (
    LONGEST_TEXT,
    PendingFile,
    copy_part,
    copy_text,
    decoded,
    text_at,
)


class _Memory(BuiltinMemory):
    """Bytes from address 1 on."""

    def __init__(self) -> None:
        super().__init__(int)
        self.bytes = bytearray(200)

    def load_bytes(self, address: int, size: int) -> bytes:
        """Return the bytes, NUL behind the end."""
        return bytes(self.bytes[address - 1 : address - 1 + size]).ljust(size, b"\0")

    def store_bytes(self, address: int, data: bytes) -> None:
        """Replace the bytes."""
        self.bytes[address - 1 : address - 1 + len(data)] = data


@settings(max_examples=25, deadline=None)
@given(
    text=st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=30),
    offset=st.integers(0, 40),
    size=st.integers(0, 140),
)
def test_texts_are_copied_if_they_fit(text: str, offset: int, size: int) -> None:
    memory = _Memory()
    data = text.encode()
    written = copy_text(memory, text, 1, size)
    assert written == (len(data) + 1 if len(data) < size else 0)
    assert text_at(memory, 1) == (text if written else "")
    assert copy_text(memory, text, 0, 200) == 0
    assert copy_part(memory, text, offset, 1, size) == len(data[offset : offset + size])
    assert memory.load_bytes(1, size).startswith(data[offset : offset + size])


def test_text_that_is_not_utf_8_is_windows_1252() -> None:
    assert (decoded(b"\xc3\xa9"), decoded(b"\xe9")) == ("é", "é")


@settings(max_examples=20, deadline=None)
@given(st.lists(st.binary(max_size=9), min_size=1, max_size=5), st.integers(1, 3))
def test_files_are_collected_by_document(parts: list[bytes], document: int) -> None:
    pending = PendingFile()
    assert pending.add(9, b"other", False) is None
    for part in parts[:-1]:
        assert pending.add(document, part, False) is None
    assert pending.add(document, parts[-1], True) == decoded(b"".join(parts))
    assert pending.add(document, b"", True) == ""
    assert pending.add(9, b"!", True) == "other!"


def test_longer_files_are_cut() -> None:
    pending = PendingFile()
    assert len(pending.add(1, b"x" * (LONGEST_TEXT + 5), True) or "") == LONGEST_TEXT
