"""Motion functions over ADS: made, filled point by point, read, looked at, searched."""

import struct
from typing import Any

import pytest

P, F = 0xA000 + 7, 0xA200 + 7
POINTS = 0x0500_0000
COLUMNS = 0x0600_0000
POINT = struct.Struct("<IHHiI5d")
PACKED = struct.Struct("<IHHi5d")
BESTEHORN, POLYNOMIAL_5, STRAIGHT = 12, 15, 1
LINEAR, CYCLIC = 3, 4


def point(index: int, law: int, master: float, slave: float, velocity: float = 0.0) -> bytes:
    return POINT.pack(index, law, 0, 1, 0, master, slave, velocity, 0.0, 0.0)


@pytest.fixture
def stroke(bench: Any) -> Any:
    """0 … 180 → 0 … 100 by a quintic, and straight back to 0 at 360: cyclic."""
    bench.put(F, 0x10010, "<III", CYCLIC, 3, 1)
    rows = [
        point(1, POLYNOMIAL_5, 0.0, 0.0),
        point(2, STRAIGHT, 180.0, 100.0),
        point(3, 0, 360.0, 0.0),
    ]
    bench.write(P, POINTS, b"".join(rows))
    return bench


def values(bench: Any, offset: int, size: int, *requested: float) -> tuple[float, ...]:
    data = bench.exchange(P, offset, size, struct.pack(f"<{len(requested)}d", *requested))
    return struct.unpack(f"<{len(data) // 8}d", data)


def test_what_it_says_of_itself(stroke: Any) -> None:
    assert [stroke.get(P, n, "<I") for n in (0x03, 0x04, 0x10, 0x11, 0x12)] == [4, 16, 3, 1, 3]
    assert stroke.get(P, 0x14, "<d") == 360.0
    assert stroke.get(P, 0x15, "<d") == 0.0


def test_slave_values_at_a_master_position(stroke: Any) -> None:
    assert values(stroke, 0x23, 24, 45.0) == pytest.approx((10.3515625, 0.5859375, 0.017361111111))
    assert values(stroke, 0x21, 8, 270.0) == pytest.approx((50.0,))
    assert values(stroke, 0x21, 8, 360.0 + 90.0) == pytest.approx((50.0,))


def test_a_linear_one_has_ends(bench: Any, refused: Any) -> None:
    bench.put(F, 0x10010, "<III", LINEAR, 2, 1)
    bench.write(P, POINTS, point(1, BESTEHORN, 10.0, 0.0) + point(2, 0, 20.0, 5.0))
    assert values(bench, 0x21, 8, 20.0) == (5.0,)
    with refused(0x4A19):
        values(bench, 0x21, 8, 9.9)
    with refused(0x4A1A):
        values(bench, 0x21, 8, 20.1)
    with refused(0x4A12):
        bench.get(P, 0x14, "<d")


def cloud(bench: Any, mask: int, start: float, step: float, size: int = 1 << 16) -> list[float]:
    data = bench.exchange(P, 0x22, size, struct.pack("<HHIdd", 1, mask, 0, start, step))
    return list(struct.unpack(f"<{len(data) // 8}d", data))


def test_a_cloud_of_points(stroke: Any) -> None:
    """Each row: master position, then a column for each bit of the mask."""
    assert cloud(stroke, 1, 0.0, 90.0) == pytest.approx(
        [0.0, 0.0, 90.0, 50.0, 180.0, 100.0, 270.0, 50.0, 360.0, 0.0]
    )
    assert cloud(stroke, 0xF, 45.0, 1000.0) == pytest.approx(
        [45.0, 10.3515625, 0.5859375, 0.017361111111, -1.28600823e-4]
    )
    assert cloud(stroke, 2, 45.0, 45.0, 32) == pytest.approx([45.0, 0.5859375, 90.0, 1.041666667])
    packed = stroke.exchange(P, 0x22, 16, struct.pack("<HHdd", 0, 1, 90.0, 400.0))
    assert struct.unpack("<2d", packed) == pytest.approx((90.0, 50.0))


def test_a_cloud_is_bounded(stroke: Any, refused: Any) -> None:
    assert len(cloud(stroke, 1, 0.0, 1e-9, 1 << 20)) == 2 * 4096
    for mask, step, error in ((1, 0.0, 0x4A04), (1, -1.0, 0x4A04), (0, 1.0, 0x4A1C)):
        with refused(error):
            cloud(stroke, mask, 0.0, step)
    with refused(0x4A1C):
        cloud(stroke, 0x10, 0.0, 1.0)


def test_points_are_read_as_they_were_written(stroke: Any) -> None:
    one = POINT.pack(77, STRAIGHT, 0x2008, 1, 0, 180.0, 90.0, 0.5, 0.25, 0.125)
    stroke.write(P, POINTS + 1, one)
    assert stroke.read(P, POINTS + 1, 56) == one
    assert stroke.read(P, COLUMNS, 168)[56:112] == one
    stroke.write(P, POINTS + 1, PACKED.pack(5, STRAIGHT, 0, 1, 200.0, 80.0, 0.0, 0.0, 0.0))
    assert values(stroke, 0x21, 8, 280.0) == pytest.approx((40.0,))


@pytest.mark.parametrize(
    ("row", "error"),
    [
        (point(2, 16, 180.0, 0.0), 0x4A08),
        (point(2, STRAIGHT, 0.0, 0.0), 0x4A06),
        (POINT.pack(2, STRAIGHT, 0, 9, 0, 180.0, 0.0, 0.0, 0.0, 0.0), 0x4A1F),
        (point(2, STRAIGHT, 180.0, 1e12), 0x4A1C),
    ],
)
def test_what_is_no_function_is_reported_where_it_is_used(
    stroke: Any, refused: Any, row: bytes, error: int
) -> None:
    """A table that nobody uses takes any point: points are written one after the other."""
    stroke.write(P, POINTS + 1, row)
    for service in (lambda: values(stroke, 0x21, 8, 45.0), lambda: cloud(stroke, 1, 0.0, 1.0)):
        with refused(error):
            service()
    with refused(error):
        stroke.write(F, 0x30000)
    with refused(error):
        stroke.read(P, 0x50, 512)


def test_characteristic_values_at_a_master_velocity(bench: Any) -> None:
    """Worked numbers of the quintic 0 … 180 → 0 … 100 at 720."""
    bench.put(F, 0x10010, "<III", LINEAR, 2, 1)
    bench.write(P, POINTS, point(1, POLYNOMIAL_5, 0.0, 0.0) + point(2, 0, 180.0, 100.0))
    data = bench.exchange(P, 0x50, 512, struct.pack("<d504x", 720.0))
    result = struct.unpack_from("<31d", data)
    assert result[23] == pytest.approx(750.0)
    assert result[25] == pytest.approx(9237.604307034)
    assert result[27] == pytest.approx(384000.0)
    assert struct.unpack_from("<3I2H", data, 376) == (7, 2, 1, 22, 0)


def search(bench: Any, slave: float, start: float) -> tuple[float, ...]:
    data = bench.exchange(
        P, 0x24, 96, struct.pack("<12d", slave, start, 0.0, 1.0, 0.0, 1.0, 1e-3, *[0.0] * 5)
    )
    return struct.unpack_from("<2I6d", data)


def test_master_positions_of_a_slave_position(bench: Any) -> None:
    bench.put(F, 0x10010, "<III", LINEAR, 2, 1)
    bench.write(P, POINTS, point(1, POLYNOMIAL_5, 0.0, 0.0) + point(2, 0, 180.0, 100.0))
    assert search(bench, 50.0, 0.0)[:4] == pytest.approx((0, 1, 0.0, 90.0))
    assert search(bench, 10.3515625, 0.0)[3] == pytest.approx(45.0)
    assert search(bench, 120.0, 0.0)[:2] == (0, 0)


def test_a_cyclic_search_goes_both_ways(stroke: Any) -> None:
    match = search(stroke, 50.0, 180.0)
    assert match[:4] == pytest.approx((1, 1, 90.0, 270.0))
    assert search(stroke, 50.0, 10.0)[:4] == pytest.approx((1, 1, -90.0, 90.0))


def test_online_change_is_stored_and_checked(stroke: Any, refused: Any) -> None:
    aligned = struct.pack("<IIdII", 1, 0, 90.0, 1, 2)
    stroke.write(P, 0x1A, aligned)
    assert stroke.read(P, 0x1A, 24) == aligned
    stroke.write(P, 0x1A, struct.pack("<IdII", 3, 45.0, 0, 0))
    assert stroke.read(P, 0x1A, 20) == struct.pack("<IdII", 3, 45.0, 0, 0)
    for change, error in (
        ((10, 0.0, 0, 0), 0x4A1B),
        ((0, 0.0, 3, 0), 0x4A17),
        ((0, 0.0, 0, 9), 0x4A17),
    ):
        with refused(error):
            stroke.write(P, 0x1A, struct.pack("<IdII", *change))
    stroke.put(0xA208, 0x10000, "<III", LINEAR, 2, 2)
    with refused(0x4262):
        stroke.read(0xA008, 0x1A, 24)
    with refused(0x4262):
        stroke.exchange(0xA008, 0x22, 16, struct.pack("<HHIdd", 0, 1, 0, 0.0, 1.0))
