"""Numbers, tables, dumps."""

import pytest

from achse.cli.output import decimal, hex_dump, print_table


def test_zero_has_no_sign() -> None:
    assert [decimal(value) for value in (-0.0, -0.00004, 1.23456)] == ["0.0000", "0.0000", "1.2346"]


def test_columns_are_aligned_and_end_without_blanks(capsys: pytest.CaptureFixture[str]) -> None:
    print_table([("a", "1", "x"), ("long", "20", "")], right=frozenset({1}))
    assert capsys.readouterr().out == "a      1  x\nlong  20\n"


def test_a_dump_shows_offset_bytes_and_text() -> None:
    first, second = hex_dump(bytes(range(16)) + b"achse")
    assert first == "0000  00 01 02 03 04 05 06 07 08 09 0a 0b 0c 0d 0e 0f  ................"
    assert second.split() == ["0010", "61", "63", "68", "73", "65", "achse"]


def test_what_others_wrote_commands_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    print_table([("\x1b[31mred\r\nnext\x9b", "größer"), ("\u202eb", "c")])
    out = capsys.readouterr().out
    first, second = out.splitlines()
    assert first == r"\x1b[31mred\r\nnext\x9b  größer"
    assert second.split() == [r"\u202eb", "c"]
