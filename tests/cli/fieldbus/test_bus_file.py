"""How far a file of a slave is, as one line; `achse bus file` is in test_bus."""

import struct

import pytest

from achse.cli.fieldbus.bus_file import progress_line


@pytest.mark.parametrize(
    ("numbers", "words", "line"),
    [
        ((500, 0, 0, 0), b"", "500 bytes"),
        ((500, 1000, 0, 0), b"", "500 of 1000 bytes"),
        ((1000, 1000, 1, 4), b"programming", "1000 of 1000 bytes, programming 25 %"),
        ((1000, 1000, 0, 0), b"wait", "1000 of 1000 bytes, wait"),
        ((1000, 1000, 3, 4), b"", "1000 of 1000 bytes, busy 75 %"),
    ],
)
def test_progress_is_one_line(numbers: tuple[int, ...], words: bytes, line: str) -> None:
    assert progress_line(struct.pack("<4I", *numbers) + words + b"\0") == line
