"""Tables over ADS: made, filled, read back, used by a drive, deleted."""

import struct
from typing import Any

import pytest

from achse.motion.tables.limits import TableLimits

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
    for numbers in (3, 12):
        with refused(0x4A15):
            filled.write(P + 7, ROWS, doubles(*[0.5] * numbers))
    for size in (0, 12):
        with refused(0x705):
            filled.write(P + 7, ROWS, bytes(size))
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


def cam(bench: Any, kind: int = 4, *numbers: float) -> None:
    """Table 7: a cam."""
    numbers = numbers or (0.0, 0.0, 90.0, 30.0, 360.0, 100.0)
    bench.put(F + 7, 0x10000, "<III", kind, len(numbers) // 2, 2)
    bench.write(P + 7, ROWS, doubles(*numbers))


def test_a_cam_says_what_it_is(bench: Any, refused: Any) -> None:
    cam(bench)
    assert [bench.get(P + 7, offset, "<I") for offset in (3, 4)] == [4, 1]
    assert [bench.get(P + 7, offset, "<d") for offset in (0x14, 0x15)] == [360.0, 100.0]
    bench.put(F + 8, 0x10000, "<III", 3, 2, 2)
    for offset in (0x13, 0x14, 0x15):
        with refused(0x4A12):
            bench.get(P + 8, offset, "<d")
    for offset in (0x0500_0000, 0x0600_0000):
        with refused(0x4262):
            bench.read(P + 7, offset, 56)
    answer = bench.exchange(P + 7, 0x23, 24, doubles(450.0))
    assert struct.unpack("<3d", answer) == pytest.approx((130.0, 70.0 / 270.0, 0.0))


def test_points_of_motion_functions_are_kept(bench: Any, refused: Any) -> None:
    bench.put(F + 7, 0x10010, "<III", 3, 3, 1)
    assert [bench.get(P + 7, offset, "<I") for offset in (3, 4, 0x10)] == [3, 16, 3]
    aligned = struct.pack("<IHHiI5d", 2, 15, 0, 1, 0, 90.0, 5.0, 1.0, 2.0, 3.0)
    packed = struct.pack("<IHHi5d", 3, 1, 0, 0, 180.0, 9.0, 0.0, 0.0, 0.0)
    bench.write(P + 7, 0x0500_0001, aligned)
    bench.write(P + 7, 0x0500_0002, packed)
    both = bench.read(P + 7, 0x0500_0001, 112)
    assert both[:56] == aligned
    assert struct.unpack("<IHHiI5d", both[56:])[5:7] == (180.0, 9.0)
    column = bench.read(P + 7, 0x0600_0000, 168)
    assert column[56:] == both
    bench.write(P + 7, 0x0600_0000, column)
    for data, error in ((bytes(10), 0x705), (bytes(224), 0x4A15)):
        with refused(error):
            bench.write(P + 7, 0x0500_0000, data)
    with refused(0x4A13):
        bench.read(P + 7, 0x0500_0003, 56)
    with refused(0x4A14):
        bench.read(P + 7, 0x0600_0001, 56)
    with refused(0x4A16):
        bench.write(P + 7, 0x0600_0000, aligned)
    with refused(0x4A1C):
        bench.write(P + 7, 0x0500_0000, aligned[:16] + doubles(*[float("nan")] * 5))
    for offset in (0x20, ROWS, COLUMNS):
        with refused(0x4262):
            bench.read(P + 7, offset, 16)


def test_a_cam_is_scaled(bench: Any, refused: Any) -> None:
    cam(bench)
    bench.write(P + 7, 0x115, doubles(1.0, 10.0, 2.0, 5.0, 0.5, 0.0, 0.0))
    assert struct.unpack("<d", bench.exchange(P + 7, 0x21, 8, doubles(190.0)))[0] == 20.0
    assert bench.read(P + 7, ROWS + 1, 16) == doubles(90.0, 30.0)
    for wrong in ((1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), (1.0, 0.0, 1.0, 0.0, 1.0, 5.0, 0.0)):
        with refused(0x4A17):
            bench.write(P + 7, 0x115, doubles(*wrong))
    bench.put(F + 8, 0x10000, "<III", 1, 2, 2)
    with refused(0x4A12):
        bench.write(P + 8, 0x115, doubles(1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0))


def test_characteristic_values_of_a_cam(bench: Any, refused: Any) -> None:
    cam(bench, 3, 0.0, 0.0, 100.0, 50.0)
    numbers = struct.unpack("<31d", bench.read(P + 7, 0x50, 512)[:248])
    assert (numbers[0], numbers[23], numbers[29]) == (1.0, 0.5, 0.5)
    fast = bench.exchange(P + 7, 0x50, 512, doubles(4.0, *[0.0] * 63))
    numbers = struct.unpack("<31d", fast[:248])
    assert (numbers[0], numbers[6], numbers[23]) == (4.0, 100.0, 2.0)
    assert struct.unpack("<3I2H", fast[376:392]) == (7, 2, 2, 11, 0)
    bench.write(P + 7, 0x50, doubles(3.0, *[0.0] * 63))
    assert struct.unpack("<d", bench.read(P + 7, 0x50, 512)[184:192])[0] == 1.5
    with refused(0x4A1C):
        bench.write(P + 7, 0x50, doubles(-1.0, *[0.0] * 63))
    with refused(0x705):
        bench.exchange(P + 7, 0x50, 512, doubles(4.0))


def test_the_master_is_searched(bench: Any, refused: Any) -> None:
    cam(bench, 4, 0.0, 0.0, 135.0, 80.0, 180.0, 100.0, 225.0, 80.0, 360.0, 0.0)

    def search(slave: float, start: float, *more: float) -> tuple[float, ...]:
        values = doubles(slave, start, *(more or (0.0, 1.0, 0.0, 1.0)), 1e-3, *[0.0] * 5)
        return struct.unpack("<2I6d40x", bench.exchange(P + 7, 0x24, 96, values))

    assert search(80.0, 180.0)[:6] == (1, 1, 135.0, 225.0, 135.0, 225.0)
    assert search(80.0, 90.0)[:6] == (1, 1, -135.0, 135.0, 225.0, 135.0)
    assert search(120.0, 0.0)[:2] == (0, 0)
    assert search(170.0, 370.0, 10.0, 2.0, 10.0, 2.0)[2:4] == (280.0, 460.0)
    assert search(80.0, -180.0, 0.0, 1.0, 0.0, -1.0)[2:4] == (-225.0, -135.0)
    with refused(0x4A17):
        search(80.0, 180.0, 0.0, 0.0, 0.0, 1.0)
    with refused(0x4A1C):
        search(1e300, 180.0)


def test_tables_of_clients_have_a_size(bench: Any, refused: Any) -> None:
    bench.nc.tables.limits = TableLimits(1 << 18, 1 << 20)
    for rows, columns in ((1 << 17, 3), ((1 << 17) + 1, 1), (1 << 24, 2)):
        with refused(0x4A11):
            bench.put(F + 7, 0x10000, "<III", 1, rows, columns)
    for number in range(7, 11):
        bench.put(F + number, 0x10000, "<III", 1, 1 << 17, 2)
    with refused(0x4A11):
        bench.put(F + 11, 0x10000, "<III", 1, 2, 2)
    bench.write(F + 7, 0x20000)
    bench.put(F + 11, 0x10000, "<III", 1, 2, 2)
    for kind, rows in ((0x10001, 4097), (0x10010, 1171)):
        with refused(0x4A11):
            bench.put(F + 12, kind, "<III", 3, rows, 1)


def test_several_columns_at_once_all_or_none(filled: Any, refused: Any) -> None:
    places, values = (-1.0, -0.6, 0.0, 0.5, 1.0), (-0.9, -0.3, 0.0, 0.4, 0.9)
    filled.write(P + 7, COLUMNS, doubles(*places, *values))
    assert filled.read(P + 7, COLUMNS, 80) == doubles(*places, *values)
    with refused(0x4A1C):
        filled.write(P + 7, COLUMNS, doubles(*places, *values[:-1], float("nan")))
    assert filled.read(P + 7, COLUMNS, 80) == doubles(*places, *values)
