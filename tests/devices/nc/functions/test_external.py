"""External set points over ADS: both forms, fed by the cyclic interface, and the way out."""

import struct
from typing import Any

import pytest

F, CYCLIC, STATES = 0x4201, 0x4301, 0x4101

EXTERNAL_BIT = 1 << 14


def feed(bench: Any, velocity: float, cycles: int) -> None:
    """Feed a constant velocity, each cycle by one write of the cyclic interface."""
    position = bench.axis.external_set_position
    for _ in range(cycles):
        position += velocity * 0.002
        values = (position, velocity, 0.0, 0.0, 1 if velocity > 0 else -1)
        bench.write(CYCLIC, 0x27, struct.pack("<ddddi12x", *values))
        bench.run(0.002)


def universal(form: str, kind: int, velocity: float) -> bytes:
    return struct.pack(form, kind, 0, 0.0, velocity, 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("form", ["<Id", "<I4xd8x"], ids=["TwinCAT 2", "TwinCAT 3"])
def test_start_feed_and_stop(bench: Any, form: str) -> None:
    bench.put(F, 0x23, form, 2, 10.0)
    assert bench.get(STATES, 0x13, "<d") == pytest.approx(10.0)
    feed(bench, 50.0, 100)
    assert bench.get(STATES, 0x25, "<H") == 1
    assert bench.get(CYCLIC, 0x81, "<I") & EXTERNAL_BIT
    assert bench.get(CYCLIC, 0xB2, "<I") == 41
    assert bench.get(STATES, 0x0A, "<d") == pytest.approx(10.0)
    assert bench.get(STATES, 0x0E, "<d") == 50.0
    bench.write(F, 0x24, b"")
    bench.until_rest()
    bench.run(0.01)
    assert bench.get(STATES, 0x25, "<H") == 0
    assert not bench.get(CYCLIC, 0x81, "<I") & EXTERNAL_BIT
    assert bench.axis.error_code == 0


def test_the_set_point_structure_feeds_too(bench: Any, refused: Any) -> None:
    with refused(0x42E3):
        bench.put(STATES, 0x60, "<5d", 0.1, 50.0, 0.0, 1.0, 0.0)
    bench.put(F, 0x23, "<Id", 1, 0.0)
    bench.put(STATES, 0x60, "<5d", 0.1, 50.0, 0.0, 1.0, 0.0)
    bench.run(0.002)
    assert bench.axis.set_position == 0.1
    assert bench.axis.set_velocity == 50.0


@pytest.mark.parametrize("form", ["<IIdddddIddd", "<IIdddddI4xddd"], ids=["TC2", "TC3"])
def test_the_way_into_an_endless_move(bench: Any, form: str) -> None:
    bench.put(F, 0x23, "<Id", 1, 0.0)
    feed(bench, 50.0, 50)
    answer = bench.exchange(F, 0x2B, 4, universal(form, 3, 50.0))
    assert struct.unpack("<HH", answer) == (2, 1)  # the second command, active
    bench.run(0.5)
    assert bench.axis.set_velocity == 50.0
    assert bench.axis.set_position == pytest.approx(5.0 + 0.5 * 50.0)


def test_mistakes(bench: Any, refused: Any) -> None:
    with refused(0x4239):
        bench.put(F, 0x23, "<Id", 3, 0.0)
    with refused(0x42E3):
        bench.write(F, 0x24, b"")
    with refused(0x42E3):
        bench.exchange(F, 0x2B, 4, universal("<IIdddddIddd", 3, 50.0))
    bench.put(F, 0x23, "<Id", 1, 0.0)
    with refused(0x42E2):
        bench.put(F, 0x23, "<Id", 1, 0.0)
    with refused(0x42E2):
        bench.start(10.0, 100.0)


def test_the_consistency_check_counts_its_corrections(bench: Any) -> None:
    bench.put(0x1000, 0x20, "<H", 1)
    assert bench.get(0x1000, 0x20, "<H") == 1
    bench.put(F, 0x23, "<Id", 1, 0.0)
    bench.put(CYCLIC, 0x27, "<dddi", 0.1, 0.0, 0.0, 0)
    bench.run(0.002)
    assert bench.get(STATES, 0x40, "<I") == 1
    assert bench.get(STATES, 0x0E, "<d") == pytest.approx(50.0)


def test_a_jump_is_an_axis_error(bench: Any) -> None:
    bench.put(F, 0x23, "<Id", 1, 0.0)
    bench.put(CYCLIC, 0x27, "<dddi", 50.0, 0.0, 0.0, 0)
    bench.run(0.004)
    assert bench.get(STATES, 0x01, "<I") == 0x4359


def test_commands_on_top_once_allowed(bench: Any) -> None:
    bench.put(0x4001, 0x21, "<H", 1)
    bench.put(F, 0x23, "<Id", 1, 0.0)
    bench.start(10.0, 100.0, 2)
    bench.run(0.01)
    assert bench.get(CYCLIC, 0xB2, "<I") == 42
    bench.run(3.0)
    assert bench.axis.set_position == pytest.approx(10.0)
    assert bench.get(CYCLIC, 0xB2, "<I") == 41
