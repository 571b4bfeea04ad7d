"""`achse ads raw`: bytes and values by index group and offset."""

from collections.abc import Callable
from typing import Any

import pytest

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]

RAW = ("ads", "raw")


@pytest.fixture
def place(document: Callable[..., Any]) -> tuple[str, str]:
    """Group and offset of GVL.nDint."""
    [entry] = document("symbols", "GVL.nDint")
    return f"0x{entry['index_group']:X}", str(entry["index_offset"])


def test_a_value_is_written_and_read_by_type(lines: Lines, place: tuple[str, str]) -> None:
    assert lines(*RAW, *place, "-2", "--type", "DINT") == []
    assert lines(*RAW, *place, "--type", "DINT") == ["-2"]
    assert lines(*RAW, *place, "--length", "4") == ["fe ff ff ff"]


def test_bytes_are_written_in_hex(lines: Lines, place: tuple[str, str]) -> None:
    lines(*RAW, *place, "01 02 00 00")
    assert lines(*RAW, *place, "--type", "UDINT") == ["513"]


def test_json_has_bytes_and_value(
    document: Callable[..., Any], lines: Lines, place: tuple[str, str]
) -> None:
    lines(*RAW, *place, "0a000000")
    assert document(*RAW, *place, "-t", "DINT") == {"data": "0a000000", "value": 10}


def test_a_value_by_name_in_one_request(lines: Lines) -> None:
    name = ("GVL.nUdint", "--type", "STRING(20)")
    assert lines(*RAW, "0xF004", "0", *name, "--answer", "UDINT") == ["32"]
    assert lines(*RAW, "61444", "16#0", *name, "-l", "4") == ["20 00 00 00"]


def test_many_bytes_are_dumped(lines: Lines) -> None:
    dump = lines(*RAW, "0xF00F", "0", "-l", "64")
    assert [line[:4] for line in dump] == ["0000", "0010", "0020", "0030"]


def test_a_refusal_names_the_place(cli: Cli) -> None:
    result = cli(*RAW, "0x4101", "0xFFFF", "-l", "4", "--port", "501", exit_code=1)
    assert "0x4101:0xFFFF" in result.stderr
    assert "0x703 INVALID_OFFSET" in result.stderr


def test_fewer_bytes_than_the_type_has_are_no_value(cli: Cli, place: tuple[str, str]) -> None:
    result = cli(*RAW, *place, "--type", "LREAL", "-l", "4", exit_code=1)
    assert "LREAL has 8 bytes, got 4" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("12345678901", "0", "-l", "1"), "0..0xFFFFFFFF"),
        (("1", "0"), "--length or --type"),
        (("1", "0", "--type", "INT", "--answer", "INT"), "--answer goes with DATA"),
        (("1", "0", "--type", "FLOAT"), "FLOAT"),
        (("1", "0", "abc"), "pairs of hexadecimal digits"),
        (("1", "0", "300", "--type", "USINT"), "0..255"),
    ],
)
def test_bad_usage(cli: Cli, arguments: tuple[str, ...], complaint: str) -> None:
    assert complaint in cli(*RAW, *arguments, exit_code=2).stderr
