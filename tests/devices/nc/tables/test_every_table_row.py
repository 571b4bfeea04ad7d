"""Every row of tables, on a table of every kind: access, lengths, codes, numbers that are none."""

import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode

SERVICES = Path(__file__).parents[3] / "data" / "nc_services.tsv"

ABSENT = 9
EQUIDISTANT_CAMS, MONOTONIC_CAMS = (1, 2), (3, 4)
CHARACTERISTIC, FUNCTION = 5, 6
CYCLIC = (2, 4, FUNCTION)
OF_NUMBERS = (*EQUIDISTANT_CAMS, *MONOTONIC_CAMS, CHARACTERISTIC)
"""Ids of the tables; 1 … 4 have their number as sub-type."""

TABLES = (*OF_NUMBERS, FUNCTION)

WRONG_KIND, UNAVAILABLE = NcError.TABLE_WRONG_KIND, NcError.TABLE_FUNCTION_NOT_AVAILABLE
POINT = struct.Struct("<IHHiI5d")


@dataclass(frozen=True)
class Row:
    """What a row takes and answers; `only` has the tables that have it, else `code`."""

    takes: bytes = b""
    """A request that is right."""
    answers: int = 0
    """Bytes of the answer, at most; 0: none."""
    sizes: tuple[int, ...] = ()
    """Lengths of requests, beside that of `takes`."""
    only: tuple[int, ...] = TABLES
    code: NcError = UNAVAILABLE
    multiple: int = 0
    """Requests are as many times this as make whole rows or columns."""


def doubles(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *numbers)


CURVE = ((0.0, 0.0), (0.25, 0.5), (0.5, 0.25), (0.75, 0.125), (1.0, 0.0))
SEARCH = doubles(0.25, 0.0, 0.0, 1.0, 0.0, 1.0, 1e-3, *[0.0] * 5)
FIVE_BY_TWO = struct.pack("<3I", 3, 5, 2)
POINTS = tuple(
    POINT.pack(n + 1, 5, 0, 1, 0, *place, 0.0, 0.0, 0.0) for n, place in enumerate(CURVE)
)

FACTS = {
    "table_id": Row(answers=4),
    "table_name": Row(answers=31),
    "table_sub_type": Row(answers=4),
    "table_main_type": Row(answers=4),
    "row_count": Row(answers=4),
    "column_count": Row(answers=4),
    "element_count": Row(answers=4),
    "step_width": Row(answers=8, only=EQUIDISTANT_CAMS),
    "master_period": Row(answers=8, only=CYCLIC),
    "slave_stroke": Row(answers=8, only=CYCLIC),
    "online_change_activation": Row(
        struct.pack("<I4xdII", 2, 0.5, 0, 1), 24, (20,), (FUNCTION,), WRONG_KIND
    ),
    "single_value": Row(struct.pack("<IId", 2, 1, 0.75), 16, (), OF_NUMBERS, WRONG_KIND),
    "slave_position_at_master": Row(doubles(0.5), 8),
    "motion_function_points": Row(
        struct.pack("<HH4xdd", 1, 15, 0.0, 0.25), 200, (20,), (FUNCTION,), WRONG_KIND
    ),
    "slave_values_at_master": Row(doubles(0.5), 24),
    "master_position_at_slave": Row(SEARCH, 96),
    "characteristic_values": Row(doubles(2.0).ljust(512, b"\0"), 512),
    "characteristic_values_at_velocity": Row(doubles(2.0).ljust(512, b"\0"), 512),
    "set_scaling": Row(
        doubles(1.0, 0.0, 1.0, 0.0, 0.5, 0.0, 0.0), only=(*MONOTONIC_CAMS, CHARACTERISTIC)
    ),
    "rows": Row(doubles(*CURVE[0], *CURVE[1]), 80, (16, 80), OF_NUMBERS, WRONG_KIND, 8),
    "columns": Row(
        doubles(*(place for place, _ in CURVE)), 80, (40, 80), OF_NUMBERS, WRONG_KIND, 8
    ),
    "motion_function_rows": Row(
        b"".join(POINTS[:2]), 280, (52, 56, 260, 280), (FUNCTION,), WRONG_KIND, 4
    ),
    "motion_function_columns": Row(b"".join(POINTS), 280, (260,), (FUNCTION,), WRONG_KIND, 4),
    "user_count": Row(answers=4),
    "create_cam_table": Row(FIVE_BY_TWO, only=(), code=NcError.TABLE_EXISTS),
    "create_characteristic_table": Row(FIVE_BY_TWO, only=(), code=NcError.TABLE_EXISTS),
    "create_motion_function_table": Row(FIVE_BY_TWO, only=(), code=NcError.TABLE_EXISTS),
    "delete_table": Row(),
    "initialize_table": Row(),
}


def of_the_manual() -> list[tuple[int, int, str, str]]:
    """Group, offset, access and name of each row of tables."""
    results = []
    for line in SERVICES.read_text(encoding="utf-8").splitlines():
        kind, _, group, offset, access, name = line.split("\t")[:6]
        if kind == "table":
            results.append((int(group, 16), int(offset, 16), access, name))
    return results


ROWS = of_the_manual()
NAMES = [row[3] for row in ROWS]


@pytest.fixture
def tables(bench: Any) -> Any:
    """A table of each kind."""
    for number in (*EQUIDISTANT_CAMS, *MONOTONIC_CAMS):
        bench.put(0xA200 + number, 0x10000, "<III", number, len(CURVE), 2)
    bench.put(0xA200 + CHARACTERISTIC, 0x10001, "<III", 3, len(CURVE), 2)
    bench.put(0xA200 + FUNCTION, 0x10010, "<III", 4, len(CURVE), 1)
    for number in OF_NUMBERS:
        bench.write(0xA000 + number, 0x0100_0000, doubles(*(x for row in CURVE for x in row)))
    bench.write(0xA000 + FUNCTION, 0x0500_0000, b"".join(POINTS))
    return bench


def states(bench: Any) -> list[object]:
    """All that tables are."""
    results: list[object] = []
    for table in bench.nc.tables:
        facts = table.table_id, bytes(table.values), bytes(table.motion), table.scaling
        results.append((*facts, table.online, table.nominal_velocity, table.last_written))
    return results


def ask(bench: Any, access: str, group: int, offset: int, row: Row, data: bytes) -> None:
    """Use a row in each way that its access allows."""
    if "W" in access and access != "R&W":
        bench.write(group, offset, data)
    if access in ("R", "RW"):
        assert len(bench.read(group, offset, 4096)) <= row.answers
    if access == "R&W":
        assert 0 < len(bench.exchange(group, offset, 4096, data)) <= row.answers


def test_facts_are_those_of_the_manual() -> None:
    assert set(FACTS) == set(NAMES)


@pytest.mark.parametrize(("base", "offset", "access", "name"), ROWS, ids=NAMES)
def test_tables_answer_as_they_are(
    tables: Any, refused: Any, base: int, offset: int, access: str, name: str
) -> None:
    row = FACTS[name]
    for number in TABLES:
        if number in row.only:
            ask(tables, access, base + number, offset, row, row.takes)
        else:
            with refused(row.code.number):
                ask(tables, access, base + number, offset, row, row.takes)
    if not name.startswith("create"):
        with refused(NcError.TABLE_ID.number):
            ask(tables, access, base + ABSENT, offset, row, row.takes)


@pytest.mark.parametrize(("base", "offset", "access", "name"), ROWS, ids=NAMES)
def test_access_that_a_row_has_not_is_refused(
    tables: Any, refused: Any, base: int, offset: int, access: str, name: str
) -> None:
    row, allowed = FACTS[name], {each for _, place, each, _ in ROWS if place == offset}
    before = states(tables)
    for number in (*TABLES, ABSENT):
        if not any(each in ("R", "RW") for each in allowed):
            with refused(ReturnCode.INVALID_ACCESS.number):
                tables.read(base + number, offset, 8)
        if not any(each in ("W", "RW") for each in allowed):
            with refused(ReturnCode.INVALID_ACCESS.number):
                tables.write(base + number, offset, row.takes)
        if "R&W" not in allowed:
            with refused(ReturnCode.INVALID_ACCESS.number):
                tables.exchange(base + number, offset, 8, row.takes)
    assert states(tables) == before


@pytest.mark.parametrize(("base", "offset", "access", "name"), ROWS, ids=NAMES)
def test_other_lengths_are_refused_and_change_nothing(
    tables: Any, refused: Any, base: int, offset: int, access: str, name: str
) -> None:
    row = FACTS[name]
    if not row.takes:  # to read alone, or without data: whatever comes with it is not looked at
        return
    sizes = {len(row.takes), *row.sizes}
    before = states(tables)
    for number in row.only or (ABSENT,):
        for size in {
            0,
            1,
            4,
            8,
            12,
            600,
            *(size + n for size in sizes for n in (-8, -4, -1, 1, 4, 8)),
        }:
            if size < 0 or size in sizes or (size and row.multiple and size % row.multiple == 0):
                continue  # of whole numbers or points: the codes of rows and columns
            data = (row.takes * 3)[:size].ljust(size, b"\0")
            with refused(ReturnCode.INVALID_SIZE.number):
                if access == "R&W":
                    tables.exchange(base + number, offset, 512, data)
                else:
                    tables.write(base + number, offset, data)
    assert states(tables) == before


@pytest.mark.parametrize(("base", "offset", "access", "name"), ROWS, ids=NAMES)
def test_numbers_that_are_none_harm_no_client(
    tables: Any, base: int, offset: int, access: str, name: str
) -> None:
    """NaN, infinite and huge numbers anywhere: a code of tables, and a table that still answers."""
    row = FACTS[name]
    if access == "R" or len(row.takes) < 8:
        return
    codes = set()
    for number in row.only or (ABSENT,):
        for at in range(0, min(len(row.takes), 120) - 7, 4):
            for wrong in (math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324):
                data = row.takes[:at] + doubles(wrong) + row.takes[at + 8 :]
                try:
                    if access == "R&W":
                        tables.exchange(base + number, offset, 4096, data)
                    else:
                        tables.write(base + number, offset, data)
                except DeviceError as refusal:
                    codes.add(refusal.code)
        tables.nc.cycle()
    allowed = {error.number for error in NcError} | {ReturnCode.INVALID_DATA.number}
    assert {hex(code) for code in codes if code not in allowed} == set()
    for number in TABLES:
        assert tables.get(0xA000 + number, 0x01, "<I") == number
        for table in tables.nc.tables:
            assert all(map(math.isfinite, table.values))
            assert all(math.isfinite(x) for p in POINT.iter_unpack(table.motion) for x in p)


@pytest.mark.parametrize(
    ("name", "code", "beyond"),
    [
        ("rows", NcError.TABLE_ACCESS_ROWS, NcError.TABLE_ROW_INDEX),
        ("columns", NcError.TABLE_ACCESS_COLUMNS, NcError.TABLE_COLUMN_INDEX),
        ("motion_function_rows", NcError.TABLE_ACCESS_ROWS, NcError.TABLE_ROW_INDEX),
        ("motion_function_columns", NcError.TABLE_ACCESS_COLUMNS, NcError.TABLE_COLUMN_INDEX),
    ],
)
def test_rows_and_columns_are_whole_and_there(
    tables: Any, refused: Any, name: str, code: NcError, beyond: NcError
) -> None:
    row, offset = FACTS[name], next(each[1] for each in ROWS if each[3] == name)
    for number in row.only:
        unit = POINT.size if number == FUNCTION else 8
        count = len(CURVE) * (1 if number == FUNCTION else 2)
        whole = len(CURVE) if "columns" in name else count // len(CURVE)
        for numbers in {1, whole - 1, whole + 1, count + whole, count + 1} - {0}:
            if numbers % whole == 0 and numbers <= count:
                continue
            with refused(code.number):
                tables.write(0xA000 + number, offset, bytes(unit * numbers))
        last = (count // len(CURVE) if "columns" in name else len(CURVE)) - 1
        assert tables.read(0xA000 + number, offset + last, 4096)
        for there in (last + 1, 0xFF_FFFF):
            with refused(beyond.number):
                tables.read(0xA000 + number, offset + there, 4096)
            with refused(beyond.number):
                tables.write(0xA000 + number, offset + there, bytes(unit * whole))
