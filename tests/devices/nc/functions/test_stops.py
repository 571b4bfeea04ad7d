"""Stops over ADS."""

from math import nan
from typing import Any

import pytest

F = 0x4201


REAL, FLAG, NUMBER = "<d", "<H", "<I"


def test_stop_takes_the_running_deceleration(bench: Any) -> None:
    bench.put(F, 0x21, "<I4xddI4xdI4xdI4xd", 3, 0.0, 600.0, 1, 0.0, 0, 800.0, 0, 8000.0)
    bench.until(lambda: bench.axis.set_velocity == 600.0)
    bench.write(F, 0x02)
    lowest = 0.0
    took = 0.0
    while bench.axis.set_motion_phase:
        bench.run(0.002)
        took += 0.002
        lowest = min(lowest, bench.axis.set_acceleration)
    assert lowest == pytest.approx(-800.0)
    assert took == pytest.approx(600.0 / 800.0 + 800.0 / 8000.0, abs=0.004)
    assert bench.get(0x4301, 0x8C, FLAG) == 1


@pytest.mark.parametrize("offset", [0x04, 0x05])
def test_stops_with_a_ramp_of_their_own(bench: Any, offset: int) -> None:
    bench.start(0.0, 600.0, start_type=3)
    bench.until(lambda: bench.axis.set_velocity == 600.0)
    bench.put(F, offset, "<dd", 6000.0, 60_000.0)
    assert bench.until_rest() == pytest.approx(600.0 / 6000.0 + 0.1, abs=0.004)


def test_stop_and_lock_holds_until_it_is_released(bench: Any, refused: Any) -> None:
    bench.start(0.0, 100.0, start_type=3)
    bench.run(1.0)
    bench.exchange(F, 0x16, 4, bench.universal(4096))
    assert bench.get(0x4301, 0x81, NUMBER) & 1 << 29
    bench.until_rest()
    with refused(0x42EF):
        bench.start(0.0, 10.0)
    bench.write(F, 0x18)
    bench.start(0.0, 10.0)


@pytest.mark.parametrize("values", [(1000.0, 1e6), (6000.0, 1000.0), (0.0, 0.0), (nan, 1e6)])
def test_an_emergency_stop_is_not_weaker_than_the_motion(
    bench: Any, refused: Any, values: tuple[float, float]
) -> None:
    bench.start(0.0, 100.0, start_type=3)
    bench.run(0.5)
    with refused(0x4226):
        bench.put(F, 0x04, "<dd", *values)


def test_clear(bench: Any) -> None:
    bench.start(1000.0, 200.0)
    bench.exchange(F, 0x16, 4, bench.universal(1, 2000.0, 200.0, mode=1))
    bench.run(1.0)
    bench.write(F, 0x03)
    bench.until_rest()
    assert bench.axis.set_position < 1000.0


def test_oriented_stop(bench: Any, refused: Any) -> None:
    with refused(0x4268):
        bench.put(F, 0x09, "<3d", 90.0, 1000.0, 10_000.0)
    bench.start(0.0, 200.0, start_type=3)
    bench.run(2.0)
    bench.put(F, 0x09, "<3d", 90.0, 1000.0, 10_000.0)
    bench.until_rest()
    assert bench.axis.set_position % 360.0 == pytest.approx(90.0, abs=1e-9)
    with refused(0x705):
        bench.put(F, 0x09, "<2d", 90.0, 1000.0)
