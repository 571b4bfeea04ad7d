"""Tables over ADS: made, filled, read back, used by a drive, deleted."""

import struct
from typing import Any

import pytest

POINTS = [(-1.0, -1.0), (-0.1, -0.4), (0.0, 0.0), (0.1, 0.5), (1.0, 1.0)]
P, S, F = 0xA000, 0xA100, 0xA200
"""Index groups of table parameters, states and functions."""
ROWS, COLUMNS = 0x0100_0000, 0x0200_0000
EQUIDISTANT, MONOTONIC = 1, 3


def doubles(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *numbers)


def create(
    bench: Any, table_id: int = 7, kind: int = MONOTONIC, rows: int = 5, columns: int = 2
) -> None:
    bench.put(F + table_id, 0x10001, "<III", kind, rows, columns)


def fill(bench: Any, points: list[tuple[float, float]] = POINTS, table_id: int = 7) -> None:
    bench.write(P + table_id, ROWS, doubles(*(number for point in points for number in point)))


@pytest.fixture
def filled(bench: Any) -> Any:
    """Table 7 has the points; the axis is not enabled."""
    bench.put(0x4301, 0x01, "<I", 0)
    bench.run(0.01)
    create(bench)
    fill(bench)
    return bench


def test_a_table_that_was_made_says_what_it_is(filled: Any) -> None:
    facts = [filled.get(P + 7, offset, "<I") for offset in (1, 3, 4, 0x10, 0x11, 0x12)]
    assert facts == [7, MONOTONIC, 10, 5, 2, 10]
    assert filled.read(P + 7, 2, 31) == b"Table 7".ljust(31, b"\0")
    assert filled.get(S + 7, 0x0A, "<i") == 0
    assert filled.get(0x1100, 0x0A, "<I") == 1
    assert filled.read(0x1100, 0x3A, 40) == struct.pack("<I", 7)


def test_ids_above_255_have_a_page_of_their_own(bench: Any, refused: Any) -> None:
    bench.put(0x1A202, 0x10001, "<III", MONOTONIC, 2, 2)
    assert bench.get(0x1A002, 0x01, "<I") == 258
    with refused(0x4016):
        bench.get(0xA002, 0x01, "<I")


@pytest.mark.parametrize(
    ("dimensions", "error"),
    [
        ((2, 5, 2), 0x4A07),
        ((4, 5, 2), 0x4A07),
        ((3, 1, 2), 0x4A02),
        ((3, 2, 0), 0x4A03),
        ((3, 16777216, 16777216), 0x4A11),
    ],
)
def test_what_no_characteristic_can_be(
    bench: Any, refused: Any, dimensions: tuple[int, int, int], error: int
) -> None:
    with refused(error):
        bench.put(F + 7, 0x10001, "<III", *dimensions)
    with refused(0x4016):
        bench.get(P + 7, 0x10, "<I")


def test_an_id_is_taken_once_and_free_after_deletion(filled: Any, refused: Any) -> None:
    with refused(0x4063):
        create(filled)
    filled.write(F + 7, 0x20000)
    for offset, group in ((0x01, P), (0x0A, S), (ROWS, P)):
        with refused(0x4016):
            filled.read(group + 7, offset, 8)
    with refused(0x4016):
        filled.write(F + 7, 0x20000)
    create(filled)
    with refused(0x4A00):
        create(filled, 0)


def test_rows_are_read_and_written_whole(filled: Any, refused: Any) -> None:
    assert filled.read(P + 7, ROWS + 1, 32) == doubles(-0.1, -0.4, 0.0, 0.0)
    assert len(filled.read(P + 7, ROWS, 8000)) == 80
    filled.write(P + 7, ROWS + 3, doubles(0.2, 0.6))
    assert filled.read(P + 7, ROWS + 3, 16) == doubles(0.2, 0.6)
    for numbers in (3, 0, 12):
        with refused(0x4A15):
            filled.write(P + 7, ROWS, doubles(*[0.5] * numbers))
    with refused(0x705):
        filled.write(P + 7, ROWS, bytes(12))
    with refused(0x4A13):
        filled.read(P + 7, ROWS + 5, 16)
    with refused(0x4A1C):
        filled.write(P + 7, ROWS, doubles(0.0, float("nan")))


def test_columns_are_read_and_written_whole(filled: Any, refused: Any) -> None:
    places, values = zip(*POINTS, strict=True)
    assert filled.read(P + 7, COLUMNS + 1, 40) == doubles(*values)
    assert filled.read(P + 7, COLUMNS, 80) == doubles(*places, *values)
    filled.write(P + 7, COLUMNS + 1, doubles(-0.9, -0.3, 0.0, 0.4, 0.9))
    assert filled.read(P + 7, ROWS + 3, 16) == doubles(0.1, 0.4)
    with refused(0x4A16):
        filled.write(P + 7, COLUMNS + 1, doubles(*places, *values))
    with refused(0x4A14):
        filled.read(P + 7, COLUMNS + 2, 40)


def test_single_numbers_are_written(filled: Any, refused: Any) -> None:
    filled.put(P + 7, 0x20, "<IId", 3, 1, 0.7)
    assert filled.read(P + 7, ROWS + 3, 16) == doubles(0.1, 0.7)
    assert filled.read(P + 7, 0x20, 16) == struct.pack("<IId", 3, 1, 0.7)
    for row, column, error in ((5, 0, 0x4A13), (0, 2, 0x4A14)):
        with refused(error):
            filled.put(P + 7, 0x20, "<IId", row, column, 0.0)
    with refused(0x4A1C):
        filled.put(P + 7, 0x20, "<IId", 3, 1, float("inf"))


def test_a_table_is_read_at_any_place_in_it(filled: Any, refused: Any) -> None:
    def at(place: float, offset: int = 0x21, size: int = 8) -> bytes:
        answer: bytes = filled.exchange(P + 7, offset, size, doubles(place))
        return answer

    assert struct.unpack("<d", at(0.05)) == pytest.approx((0.25,))
    assert struct.unpack("<3d", at(0.05, 0x23, 24)) == pytest.approx((0.25, 5.0, 0.0))
    with refused(0x4A19):
        at(-1.1)
    with refused(0x4A1A):
        at(1.1)
    filled.write(F + 7, 0x30000)
    filled.put(P + 7, 0x20, "<IId", 0, 0, 2.0)
    for call in (lambda: at(0.0), lambda: filled.write(F + 7, 0x30000)):
        with refused(0x4A06):
            call()


def test_the_steps_of_equidistant_tables(bench: Any, refused: Any) -> None:
    create(bench, kind=EQUIDISTANT, rows=3)
    fill(bench, [(0.0, 0.0), (0.5, 0.2), (1.0, 1.0)])
    assert bench.get(P + 7, 0x13, "<d") == 0.5
    create(bench, 8)
    with refused(0x4A12):
        bench.get(P + 8, 0x13, "<d")


def test_a_drive_uses_a_table_until_it_is_removed(filled: Any, refused: Any) -> None:
    filled.put(0x7001, 0x120, "<I", 7)
    assert filled.get(0x4001, 0x30120, "<I") == 7
    assert filled.get(S + 7, 0x0A, "<i") == 1
    with refused(0x4259):
        filled.write(F + 7, 0x20000)
    with refused(0x4A06):
        filled.put(P + 7, 0x20, "<IId", 0, 0, 2.0)
    filled.axis.controller.position_kv = 0.0  # a linear valve gets five times as much
    filled.axis.controller.following_error_position_monitoring_enable = 0
    filled.put(0x4301, 0x01, "<I", 7)
    filled.run(0.01)
    filled.start(0.0, 110.0, start_type=3)
    filled.run(2.0)
    assert filled.get(0x7101, 0x03, "<d") == pytest.approx(5.0, abs=0.01)
    assert filled.get(0x7101, 0x13, "<d") == pytest.approx(25.0, abs=0.05)
    assert filled.get(0x7101, 0x14, "<d") == pytest.approx(2.5, abs=0.005)
    assert filled.get(0x7301, 0, "<i") == pytest.approx(0.25 * 0x7FFF_FFFF, rel=1e-3)
    with refused(0x4652):
        filled.put(0x7201, 0x102, "<I", 7)
    filled.write(0x4201, 0x02)
    filled.until_rest()
    filled.put(0x4301, 0x01, "<I", 0)
    filled.run(0.01)
    filled.put(0x7201, 0x102, "<I", 7)
    assert filled.get(0x7001, 0x120, "<I") == 0
    with refused(0x4016):
        filled.get(P + 7, 0x10, "<I")
