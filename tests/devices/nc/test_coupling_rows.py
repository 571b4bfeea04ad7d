"""Every row of couplings, walked: who may read or write it, which lengths, which values, when."""

import math
import struct
from collections.abc import Iterator
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.server import READ, READ_WRITE, WRITE, Service

FUNCTIONS = {
    0x40: (48, 64, 104), 0x41: (0, 44, 48), 0x42: (32,), 0x43: (16, 32, 40),
    0x44: tuple(range(230)), 0x45: (80,), 0x46: (4, 12, 16), 0x47: (4,), 0x49: (8,),
    0x4A: (84, 88, 196, 200), 0x4B: (76, 80), 0x4D: (52, 56, 60, 64),
}  # fmt: skip
"""Function of an axis, and its lengths: with the reserved words of 002, and without them (000).

0x44 takes no data and passes over any, as every stop does."""

OF_GROUPS = (0x40, 0x41, 0x42, 0x44, 0x49)

EXCHANGED = {(0x4201, 0x48): 4, (0x4101, 0x28): 4}
"""Rows with a request, and its length; 0x4100 + ID:0x27 takes 0, 8 or 16 bytes."""

STATES = {
    0x12: 8, 0x20: 4, 0x21: 4, 0x22: 32, 0x23: 8, 0x26: 512, 0x29: 4, 0x2A: 8, 0x2B: 8, 0x2C: 8,
    0x2_0021: 8, 0x2_0022: 8, 0x2_0023: 8,
}  # fmt: skip

PARAMETERS: dict[tuple[int, int], tuple[str, float, float]] = {
    (0x4001, 0x1A): ("<I", 0, 1),
    (0x4001, 0x1B): ("<d", 0.0, 1000.0),
    (0x4001, 0x1C): ("<H", 0, 1),
    (0x4001, 0x1D): ("<d", 0.0, 1e10),
    (0x4001, 0x20): ("<H", 0, 1),
    (0x4001, 0x2_010F): ("<d", 0.0, 1000.0),
    (0x6001, 0x10F): ("<d", 0.0, 1000.0),
    (0x6001, 0x21): ("<d", 0.0, 1e6),
}
"""Parameters of couplings: form, least and largest value (002)."""

NO_ACCESS, NO_LENGTH = 0x704, 0x705


def code_of(action: Any, *arguments: Any) -> int:
    """What a request is answered, 0 = done."""
    try:
        action(*arguments)
    except DeviceError as refused:
        return int(refused.code)
    return 0


def functions() -> Iterator[tuple[int, int, tuple[int, ...]]]:
    for offset, lengths in FUNCTIONS.items():
        yield 0x4201, offset, lengths
        if offset in OF_GROUPS:
            yield 0x3201, 0x100 + offset, lengths


@pytest.mark.parametrize(("group", "offset", "lengths"), list(functions()))
def test_functions(bench: Any, group: int, offset: int, lengths: tuple[int, ...]) -> None:
    """Written alone, in their lengths alone; an axis that follows nobody refuses zeros."""
    assert code_of(bench.read, group, offset, 8) == NO_ACCESS
    for length in range(230):
        code = code_of(bench.write, group, offset, bytes(length))
        if length in lengths:
            assert 0x4200 <= code < 0x4B00, (length, hex(code))
        else:
            assert code == NO_LENGTH, (length, hex(code))
    assert bench.get(0x4101, 0x20, "<I") == 0


@pytest.mark.parametrize(("group", "offset"), EXCHANGED)
def test_rows_of_read_write_take_one_length(bench: Any, group: int, offset: int) -> None:
    wanted = EXCHANGED[group, offset]
    for length in range(40):
        code = code_of(bench.exchange, group, offset, 96, bytes(length))
        assert (code == NO_LENGTH) == (length != wanted), (length, hex(code))


def test_the_table_coupling_info_takes_three_requests(bench: Any) -> None:
    for length in range(40):
        code = code_of(bench.exchange, 0x4101, 0x27, 256, bytes(length))
        assert (code == NO_LENGTH) == (length not in (0, 8, 16)), (length, hex(code))


@pytest.mark.parametrize("offset", STATES)
def test_states(bench: Any, offset: int) -> None:
    """Read alone, and all of it fits its length; of who does not synchronise 0x26 has no values."""
    size = STATES[offset]
    assert code_of(bench.write, 0x4101, offset, bytes(size)) == NO_ACCESS
    if offset == 0x26:
        bench.put(0x4201, 0x4B, "<4I7dI4x", 5, 3, 0, 0, 1.0, *[0.0] * 6, 0)
    assert len(bench.read(0x4101, offset, size)) == size


@pytest.mark.parametrize(("group", "offset"), PARAMETERS)
def test_parameters(bench: Any, group: int, offset: int) -> None:
    """Both bounds are kept, what is beyond is refused and changes nothing."""
    form, least, most = PARAMETERS[group, offset]
    size = struct.calcsize(form)
    for value in (least, most):
        bench.put(group, offset, form, value)
        assert bench.get(group, offset, form) == value
    beyond: list[float] = [most + 1] if form != "<d" else [-1.0, math.nan, math.inf]
    if form == "<d":
        beyond.append(math.nextafter(most, math.inf))
    for value in beyond:
        assert code_of(bench.put, group, offset, form, value) not in (0, NO_ACCESS, NO_LENGTH)
    for length in {0, 1, 2, 3, 4, 7, 8, 9, 16} - {size}:
        assert code_of(bench.write, group, offset, bytes(length)) == NO_LENGTH
    assert bench.get(group, offset, form) == most


def test_no_row_of_couplings_is_left_out(bench: Any) -> None:
    """What the device serves from 0x40 to 0x4D, for axes and groups, is what is walked here."""
    served: dict[int, set[int]] = {}
    for group in bench.device.services:
        base = getattr(group, "base", None)
        rows: tuple[Service, ...] = getattr(group, "rows", ())
        for row in rows:
            if base in (0x3200, 0x4200):
                assert row.access in (WRITE, READ | WRITE, READ_WRITE)
                served.setdefault(base, set()).add(row.offset)
    assert {n for n in served[0x4200] if 0x40 <= n < 0x50} == FUNCTIONS.keys() | {0x48}
    assert {n for n in served[0x3200] if 0x140 <= n < 0x150} == {0x100 + n for n in OF_GROUPS}
