"""pyads walks the rows of couplings and tables: access, lengths, codes, with nothing of ours."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

NO_ACCESS, NO_LENGTH, NO_TABLE = 0x704, 0x705, 0x4016

FUNCTIONS = {
    0x40: (48, 64, 104), 0x41: (0, 44, 48), 0x42: (32,), 0x43: (16, 32, 40),
    0x45: (80,), 0x46: (4, 12, 16), 0x47: (4,), 0x49: (8,),
    0x4A: (84, 88, 196, 200), 0x4B: (76, 80), 0x4D: (52, 56, 60, 64),
}  # fmt: skip
"""Function of an axis, and its lengths: with and without reserved words."""
OF_GROUPS = (0x40, 0x41, 0x42, 0x49)
FACTS = {0x01: 4, 0x02: 31, 0x03: 4, 0x04: 4, 0x10: 4, 0x11: 4, 0x12: 4, 0x20: 16, 0x50: 512}
TABLE = 3000
PAGE, LOW = TABLE >> 8 << 16, TABLE & 0xFF
"""Ids above 255 have pages of their own."""


def code(action: Callable[..., object], *arguments: Any) -> int:
    try:
        action(*arguments)
    except pyads.ADSError as refused:
        return int(refused.err_code)
    return 0


def write(nc: Any, group: int, offset: int, data: bytes) -> int:
    kind = pyads.PLCTYPE_BYTE * len(data) if data else None
    return code(nc.write, group, offset, list(data), kind)


def read(nc: Any, group: int, offset: int, size: int) -> int:
    return code(nc.read, group, offset, pyads.PLCTYPE_BYTE * size)


@pytest.fixture
def nc(station: Any, pyads_connection: Callable[..., Any]) -> Any:
    return pyads_connection(station, 501)


def test_functions_in_their_lengths_alone(nc: Any) -> None:
    for offset, lengths in FUNCTIONS.items():
        for group, at in ((0x4202, offset), (0x3202, 0x100 + offset)):
            if group == 0x3202 and offset not in OF_GROUPS:
                continue
            assert read(nc, group, at, 8) == NO_ACCESS, hex(at)
            tried = {n for length in lengths for n in (length - 1, length, length + 1)}
            for length in sorted({0, 1, 3, 201, *tried} - {-1}):
                answer = write(nc, group, at, bytes(length))
                if length in lengths:
                    assert 0x4200 <= answer < 0x4B00, (hex(at), length, hex(answer))
                else:
                    assert answer == NO_LENGTH, (hex(at), length, hex(answer))


def test_tables_in_all_their_states(nc: Any) -> None:
    parameters, states, functions = (PAGE + base + LOW for base in (0xA000, 0xA100, 0xA200))
    write(nc, functions, 0x20000, b"")  # what an earlier try has left
    for offset, size in FACTS.items():
        assert read(nc, parameters, offset, size) == NO_TABLE, hex(offset)
    assert read(nc, states, 0x0A, 4) == NO_TABLE
    assert write(nc, functions, 0x20000, b"") == NO_TABLE
    content = struct.pack("<3I", 1, 4, 2)
    for length in (0, 4, 8, 11, 13, 16):
        assert write(nc, functions, 0x10000, content.ljust(16, b"\0")[:length]) == NO_LENGTH
    assert write(nc, functions, 0x10000, struct.pack("<3I", 1, 1 << 24, 2)) == 0x4A11
    assert write(nc, functions, 0x10000, content) == 0
    assert write(nc, functions, 0x10000, content) == 0x4063
    for offset, size in FACTS.items():
        if offset != 0x50:
            assert read(nc, parameters, offset, size) == 0, hex(offset)
            assert offset == 0x20 or write(nc, parameters, offset, bytes(size)) == NO_ACCESS
    assert write(nc, parameters, 0x0100_0000, bytes(24)) == 0x4A15
    numbers = struct.pack("<8d", 0.0, 0.0, 1.0, 5.0, 2.0, 7.0, 3.0, 0.0)
    assert write(nc, parameters, 0x0100_0000, numbers) == 0
    assert write(nc, parameters, 0x0100_0004, numbers[:16]) == 0x4A13
    assert write(nc, parameters, 0x0200_0002, numbers[:32]) == 0x4A14
    assert write(nc, functions, 0x30000, b"") == 0
    assert read(nc, parameters, 0x50, 512) == 0
    assert write(nc, parameters, 0x20, struct.pack("<2Id", 4, 0, 1.0)) == 0x4A13
    assert write(nc, parameters, 0x115, bytes(56)) == 0x4A12
    assert write(nc, functions, 0x20000, b"") == 0
    assert read(nc, states, 0x0A, 4) == NO_TABLE


def test_rings_of_two_and_of_one_are_refused(nc: Any) -> None:
    def couple(slave: int, master: int) -> int:
        data = struct.pack("<4I4d", 1, master, 0, 0, 1.0, 0.0, 0.0, 0.0)
        return write(nc, 0x4200 + slave, 0x40, data)

    for first, second in ((1, 2), (2, 1)):
        assert couple(first, second) == 0
        assert couple(second, first) != 0
        assert write(nc, 0x4200 + first, 0x41, b"") == 0
        assert couple(first, first) != 0
