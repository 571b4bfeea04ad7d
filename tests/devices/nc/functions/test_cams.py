"""Couplings by tables over ADS: every layout by its length, what is shown, refusals."""

import struct
from typing import Any

import pytest

F, G, S = 0x4203, 0x3203, 0x4103
"""Axis 3 is the slave; axis 1 its master."""
T, USERS, MAKE = 0xA000, 0xA100, 0xA200
ROWS = 0x0100_0000
LIFTING = (0.0, 0.0, 90.0, 30.0, 360.0, 100.0)

SOLO = {88: "<6I4d3I4xd2I", 84: "<6I4d3Id2I"}
CHANGE = {56: "<I4xd2I4d", 52: "<Id2I4d", 64: "<I4xd2I4d2I"}


@pytest.fixture
def tables(bench: Any) -> Any:
    """Table 7 lifts by 100 over 360, table 8 is a straight line; both cyclic."""
    bench.put(MAKE + 7, 0x10000, "<3I", 4, 3, 2)
    bench.write(T + 7, ROWS, struct.pack("<6d", *LIFTING))
    bench.put(MAKE + 8, 0x10000, "<3I", 2, 2, 2)
    bench.write(T + 8, ROWS, struct.pack("<4d", 0.0, 0.0, 100.0, 50.0))
    return bench


def couple(
    bench: Any, kind: int = 10, table: int = 7, absolute: int = 1, *, size: int = 88, when: int = 0
) -> None:
    head = kind, 1, 0, 0, table, 0, 0.0, 0.0, 1.0, 1.0
    bench.put(F, 0x4A, SOLO[size], *head, absolute, absolute, when, 0.0, 0, 0)


def add(bench: Any, table: int, operation: int, reference: int = 0) -> None:
    head = 11, 1, 0, 0, table, 0, 0.0, 0.0, 1.0, 1.0, 0, 1, 0, 0.0, 0, 0
    bench.put(F, 0x4A, "<6I4d3I4xd2I2I104x", *head, operation, reference)


def to(bench: Any, position: float) -> float:
    bench.start(position, 900.0)
    bench.until_rest()
    return float(bench.get(S, 0x0A, "<d"))


@pytest.mark.parametrize("size", SOLO)
def test_a_table_is_followed(tables: Any, size: int) -> None:
    couple(tables, size=size)
    tables.run(0.01)
    assert tables.get(S, 0x21, "<I") == tables.get(0x3103, 0x0A, "<I") == 7
    assert tables.get(USERS + 7, 0x0A, "<i") == 1
    assert to(tables, 450.0) == pytest.approx(130.0)


def test_a_table_in_use_stays(tables: Any, refused: Any) -> None:
    couple(tables)
    with refused(0x4259):
        tables.write(MAKE + 7, 0x20000)
    with refused(0x4A06):
        tables.put(T + 7, 0x20, "<IId", 1, 0, 400.0)
    tables.write(F, 0x41)
    assert tables.get(USERS + 7, 0x0A, "<i") == 0
    tables.write(MAKE + 7, 0x20000)
    with refused(0x4261):
        couple(tables)


def test_the_old_form(tables: Any, refused: Any) -> None:
    old = "<4I2d3I2H8I"
    with refused(0x4A21):
        tables.put(F, 0x45, old, 10, 1, 0, 0, 0.0, 0.0, 1, 1, 8, 2, 0, *[0] * 8)
    with refused(0x425B):
        tables.put(F, 0x45, old, 10, 1, 1, 0, 0.0, 0.0, 1, 1, 8, 0, 0, *[0] * 8)
    with refused(0x425C):
        tables.put(F, 0x45, old, 1, 1, 0, 0, 0.0, 0.0, 1, 1, 8, 0, 0, *[0] * 8)
    tables.put(F, 0x45, old, 10, 1, 0, 0, 0.0, 0.0, 1, 1, 7, 0, 0, *[0] * 8)
    assert to(tables, 45.0) == pytest.approx(15.0)


def test_corrections_and_profiles(tables: Any, refused: Any) -> None:
    old = "<4I2d3I2H8I"
    with refused(0x4261):
        tables.put(F, 0x45, old, 11, 1, 0, 0, 0.0, 0.0, 1, 1, 7, 1, 0, 9, *[0] * 7)
    with refused(0x425E):
        tables.put(F, 0x45, old, 11, 1, 0, 0, 0.0, 0.0, 1, 1, 7, 9, 0, *[8] * 8)
    tables.put(F, 0x45, old, 11, 1, 0, 0, 0.0, 0.0, 1, 1, 7, 1, 0, 8, *[0] * 7)
    with refused(0x4261):
        tables.exchange(F, 0x48, 4, struct.pack("<I", 8))
    tables.put(F, 0x46, "<I4xd", 8, 50.0)
    assert to(tables, 90.0) == pytest.approx(50.0)
    assert struct.unpack("<f", tables.exchange(F, 0x48, 4, struct.pack("<I", 8)))[0] == 20.0
    assert to(tables, 360.0) == pytest.approx(150.0)
    for form in ("<I", "<Id"):
        tables.put(F, 0x46, form, 8, *[400.0] * (form == "<Id"))
    to(tables, 420.0)
    tables.put(F, 0x47, "<I", 8)
    with refused(0x4261):
        tables.put(F, 0x47, "<I", 9)


def test_several_cams(tables: Any, refused: Any) -> None:
    couple(tables, 11)
    add(tables, 8, 1)
    assert to(tables, 50.0) == pytest.approx(50.0 / 3.0 + 25.0)
    info = struct.unpack("<4I9d8x", tables.exchange(S, 0x28, 96, struct.pack("<I", 8)))
    assert info[:4] == (8, 1, 1, 2)
    assert info[8:10] == pytest.approx((50.0, 25.0))
    add(tables, 7, 2, 8)
    tables.run(0.01)
    add(tables, 7, 3)
    with refused(0x4261):
        tables.exchange(S, 0x28, 96, struct.pack("<I", 9))
    with refused(0x4A1B):
        add(tables, 8, 4)


@pytest.mark.parametrize("size", CHANGE)
def test_the_master_comes_first_in_a_change(tables: Any, refused: Any, size: int) -> None:
    couple(tables)
    more = (7, 0) if size == 64 else ()
    tables.put(F, 0x4D, CHANGE[size], 0, 0.0, 0, 0, -90.0, -42.0, 2.0, 3.0, *more)
    tables.run(0.01)
    assert tables.get(S, 0x0A, "<d") == pytest.approx(-42.0 + 3.0 * 15.0)
    with refused(0x4A18):
        tables.put(F, 0x4D, CHANGE[size], 0, 0.0, 0, 0, -90.0, 4.0, 2.0, 3.0, *more)
    with refused(0x425F):
        tables.put(F, 0x4D, CHANGE[size], 0, 0.0, 3, 0, 0.0, 0.0, 1.0, 1.0, *more)
    with refused(0x4283):
        tables.put(F, 0x4D, CHANGE[size], 10, 0.0, 0, 0, 0.0, 0.0, 1.0, 1.0, *more)


def test_offsets_have_the_slave_first(tables: Any) -> None:
    couple(tables)
    tables.put(F, 0x43, "<2d", -13.0, -45.0)
    tables.run(0.01)
    assert tables.get(S, 0x0A, "<d") == pytest.approx(2.0)
    tables.put(F, 0x43, "<4d", 0.0, 0.0, 2.0, 3.0)
    tables.run(0.01)
    assert tables.get(S, 0x0A, "<d") == 0.0
    tables.put(F, 0x43, "<5d", 0.0, 0.0, 1.0, 1.0, 30.0)
    assert to(tables, 27.0) == pytest.approx(6.0)
    assert to(tables, 45.0) == pytest.approx(15.0)


@pytest.mark.parametrize(("group", "offset"), [(F, 0x49), (G, 0x149)])
def test_the_slave_is_scaled(tables: Any, refused: Any, group: int, offset: int) -> None:
    with refused(0x425C):
        tables.put(group, offset, "<d", 2.0)
    couple(tables)
    to(tables, 9.0)
    tables.put(group, offset, "<d", 2.0)
    tables.run(0.01)
    assert tables.get(S, 0x0A, "<d") == pytest.approx(6.0)
    with refused(0x4A18):
        tables.put(group, offset, "<d", 4.0)


def test_how_a_table_is_followed(tables: Any, refused: Any) -> None:
    form = "<6I6d2I10dI92x"
    with refused(0x425C):
        tables.exchange(S, 0x27, 256, b"")
    couple(tables)
    to(tables, 450.0)
    info = struct.unpack(form, tables.exchange(S, 0x27, 256, b""))
    assert info[:6] == (7, 1, 4, 0, 3, 2)
    assert info[6:12] == (0.0, 0.0, 360.0, 100.0, 0.0, 0.0)
    assert info[12:18] == (1, 1, 0.0, 0.0, 1.0, 1.0)
    assert info[18:24] == pytest.approx((100.0, 0.0, 450.0, 130.0, 90.0, 30.0))
    there = tables.exchange(S, 0x27, 256, struct.pack("<d", -315.0))
    assert struct.unpack(form, there)[18:24] == pytest.approx(
        (-100.0, 0.0, -315.0, -85.0, 45.0, 15.0)
    )
    there = tables.exchange(S, 0x27, 256, struct.pack("<IId", 7, 0, 45.0))
    assert struct.unpack(form, there)[23] == pytest.approx(15.0)
    for wrong in (b"1234", struct.pack("<d", float("nan"))):
        with refused(0x705 if len(wrong) == 4 else 0x706):
            tables.exchange(S, 0x27, 256, wrong)
    with refused(0x4261):
        tables.exchange(S, 0x27, 256, struct.pack("<IId", 8, 0, 45.0))


def test_what_is_superposed_shows(tables: Any) -> None:
    """002 §6.4.9: the sum of superposition distances, and the slave's position with it."""
    form = "<6I6d2I10dI92x"
    couple(tables)
    to(tables, 90.0)
    slave = tables.nc.axis(3)
    slave.coupling.offset = 2.5
    tables.run(0.01)
    info = struct.unpack(form, tables.exchange(S, 0x27, 256, b""))
    assert (info[19], info[21]) == pytest.approx((2.5, 32.5))
    there = struct.unpack(form, tables.exchange(S, 0x27, 256, struct.pack("<d", 45.0)))
    assert (there[19], there[21]) == pytest.approx((2.5, 17.5))


@pytest.mark.parametrize("wrong", [float("nan"), float("inf")])
def test_numbers_that_are_none_have_one_code(tables: Any, refused: Any, wrong: float) -> None:
    head = 10, 1, 0, 0, 7, 0, wrong, 0.0, 1.0, 1.0
    with refused(0x425B):
        tables.put(F, 0x4A, SOLO[88], *head, 1, 1, 0, 0.0, 0, 0)
    with refused(0x425B):
        tables.put(F, 0x45, "<4I2d3I2H8I", 10, 1, 0, 0, 0.0, wrong, 1, 1, 7, 0, 0, *[0] * 8)
    with refused(0x425B):
        tables.put(F, 0x40, "<4I4d", 1, 1, 0, 0, wrong, 0.0, 0.0, 0.0)
    couple(tables, 11)
    for offset, form, values in (
        (0x43, "<2d", (wrong, 0.0)),
        (0x43, "<5d", (0.0, 0.0, 1.0, 1.0, wrong)),
        (0x46, "<I4xd", (8, wrong)),
        (0x49, "<d", (wrong,)),
        (0x4D, CHANGE[56], (0, 0.0, 0, 0, 0.0, wrong, 1.0, 1.0)),
    ):
        with refused(0x425B):
            tables.put(F, offset, form, *values)


def test_tables_that_0x45_names_are_held(tables: Any, refused: Any) -> None:
    ask = 11, 1, 0, 0, 0.0, 0.0, 1, 1, 7
    with refused(0x4261):
        tables.put(F, 0x45, "<4I2d3I2H8I", *ask, 2, 0, 8, 99, *[0] * 6)
    tables.put(F, 0x45, "<4I2d3I2H8I", *ask, 1, 1, 8, *[0] * 7)
    assert tables.get(USERS + 8, 0x0A, "<i") == 1
    with refused(0x4259):
        tables.write(MAKE + 8, 0x20000)
    tables.write(F, 0x41)
    tables.write(MAKE + 8, 0x20000)
