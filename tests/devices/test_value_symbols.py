"""Symbols of devices whose values are named one by one."""

from collections.abc import Iterator

import pytest

from achse.ams import DeviceError
from achse.devices.value_symbols import ValueSymbol, ValueSymbols
from achse.iec import DINT, UINT
from achse.iec.symbols import decode_symbols


class Two(ValueSymbols):
    """A count that is read and a limit that is written."""

    def __init__(self) -> None:
        self.limit = bytes(2)

    def all_symbols(self) -> Iterator[ValueSymbol]:
        yield ValueSymbol("Line.Count", DINT, (0x4020, 0), lambda: b"\7\0\0\0", comment="parts")
        yield ValueSymbol("Line.Limit", UINT, (0x4020, 4), lambda: self.limit, self._write)

    def _write(self, data: bytes) -> None:
        self.limit = data


def test_a_symbol_is_found_in_any_case_and_reads_its_value() -> None:
    result = Two().resolve(" line.COUNT ")
    assert result is not None
    assert (result.index_group, result.index_offset, result.size) == (0x4020, 0, 4)
    assert result.read() == b"\7\0\0\0"
    assert Two().resolve("Line.Nothing") is None


def test_what_has_no_way_to_write_is_read_only() -> None:
    symbols = Two()
    count, limit = symbols.resolve("Line.Count"), symbols.resolve("Line.Limit")
    assert count is not None
    assert limit is not None
    with pytest.raises(DeviceError, match=r"Line\.Count is read only"):
        count.write(b"\0\0\0\0")
    limit.write(b"\1\2")
    assert limit.read() == b"\1\2"


def test_the_tables_have_every_symbol_and_type() -> None:
    symbols = Two()
    sizes = symbols.upload_info()
    entries = list(decode_symbols(symbols.symbol_table()))
    assert [each.name for each in entries] == ["Line.Count", "Line.Limit"]
    assert (sizes.symbol_count, sizes.type_count) == (2, 2)
    assert symbols.type_entry("uint") is not None
    assert symbols.type_entry("LREAL") is None
