"""Drive parameters and states at 0x7000 and 0x7100 + ID."""

from typing import Any

import pytest

P, S = 0x7001, 0x7101
REAL, FLAG, NUMBER = "<d", "<H", "<I"

PARAMETERS = [
    # offset, type, a value, one out of range, error named after the parameter
    (0x06, FLAG, 1, 2, 0x4603),
    (0x0B, REAL, -0.5, -1.1, 0x460A),
    (0x0C, REAL, 0.5, 1.1, 0x460A),
    (0x101, REAL, 1000.0, 0.0, 0x4605),
]


@pytest.mark.parametrize(("offset", "form", "good", "bad", "error"), PARAMETERS)
def test_a_parameter_is_read_back_and_keeps_its_range(
    bench: Any, refused: Any, offset: int, form: str, good: float, bad: float, error: int
) -> None:
    bench.put(0x4301, 0x01, NUMBER, 0)
    bench.run(0.01)
    bench.put(P, offset, form, good)
    with refused(error):
        bench.put(P, offset, form, bad)
    assert bench.get(P, offset, form) == good


def test_the_polarity_is_locked_while_enabled(bench: Any, refused: Any) -> None:
    with refused(0x4B42):
        bench.put(P, 0x06, FLAG, 1)


def test_a_wrong_polarity_runs_away(bench: Any) -> None:
    bench.put(0x4301, 0x01, NUMBER, 0)
    bench.run(0.01)
    bench.put(P, 0x06, FLAG, 1)
    bench.put(0x4301, 0x01, NUMBER, 7)
    bench.run(0.01)
    bench.start(100.0, 100.0)
    bench.until(lambda: bench.axis.error_code)
    assert bench.get(0x4101, 0x01, NUMBER) == 0x4550
    assert bench.axis.actual_position < 0.0


def test_above_the_reference_velocity_no_start(bench: Any, refused: Any) -> None:
    bench.put(P, 0x101, REAL, 150.0)
    assert bench.get(P, 0x103, REAL) == 150.0
    with refused(0x4221):
        bench.start(100.0, 150.1)
    bench.start(100.0, 150.0)


def test_the_output_is_the_share_of_the_reference_velocity(bench: Any) -> None:
    bench.start(0.0, 220.0, start_type=3)
    bench.run(2.0)
    assert bench.get(S, 0x02, REAL) == pytest.approx(220.0, rel=1e-3)
    assert bench.get(S, 0x03, REAL) == pytest.approx(10.0, rel=1e-3)
    assert bench.get(S, 0x06, REAL) >= 220.0 * 0.999
    bench.write(0x4201, 0x02)
    bench.until_rest()
    bench.start(0.0, 110.0, start_type=4)
    bench.run(2.0)
    assert bench.get(S, 0x05, REAL) <= -110.0 * 0.999


def test_output_limits_cap_the_velocity(bench: Any) -> None:
    bench.put(P, 0x0C, REAL, 0.05)
    bench.put(0x6001, 0x10, FLAG, 0)
    bench.start(0.0, 220.0, start_type=3)
    bench.run(2.0)
    assert bench.get(S, 0x02, REAL) == pytest.approx(0.05 * 2200.0)
    assert bench.axis.actual_velocity == pytest.approx(110.0, rel=0.01)


def test_velocity_at_full_output_is_shown_only(bench: Any, refused: Any) -> None:
    assert bench.get(P, 0x01, NUMBER) == 1
    with refused(0x704):
        bench.put(P, 0x103, REAL, 1.0)
