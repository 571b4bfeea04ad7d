"""Controller parameters and states at 0x6000 and 0x6100 + ID."""

from typing import Any

import pytest

P, S = 0x6001, 0x6101
REAL, FLAG, NUMBER = "<d", "<H", "<I"

PARAMETERS = [
    # offset, type, a value, one out of range, error named after the parameter
    (0x0B, REAL, 0.5, 1.1, 0x4503),
    (0x10, FLAG, 0, 2, 0x4504),
    (0x11, FLAG, 1, 2, 0x4505),
    (0x12, REAL, 8.0, 1.1e6, 0x4506),
    (0x13, REAL, 0.5, 601.0, 0x4507),
    (0x14, REAL, 80.0, -1.0, 0x4508),
    (0x15, REAL, 0.5, -1.0, 0x4509),
    (0x0A, NUMBER, 1, 2, 0x4502),
    (0x100, REAL, 0.75, 1.5, 0x4003),
    (0x102, REAL, 40.0, 1000.1, 0x4510),
    (0x10D, REAL, 0.01, 10_001.0, 0x451D),
]


@pytest.mark.parametrize(("offset", "form", "good", "bad", "error"), PARAMETERS)
def test_a_parameter_is_read_back_and_keeps_its_range(
    bench: Any, refused: Any, offset: int, form: str, good: float, bad: float, error: int
) -> None:
    bench.put(P, offset, form, good)
    with refused(error):
        bench.put(P, offset, form, bad)
    assert bench.get(P, offset, form) == good


def test_id_and_name(bench: Any) -> None:
    assert bench.get(P, 0x01, NUMBER) == 1
    assert bench.read(0x6003, 0x02, 31) == b"C".ljust(31, b"\0")


@pytest.mark.parametrize("kv", [10.0, 20.0])
def test_without_feedforward_the_following_error_is_velocity_over_gain(
    bench: Any, kv: float
) -> None:
    bench.put(P, 0x0B, REAL, 0.0)
    bench.put(P, 0x102, REAL, kv)
    bench.put(P, 0x10, FLAG, 0)
    bench.start(0.0, 100.0, start_type=3)
    bench.run(3.0)
    expected = pytest.approx(100.0 / kv, rel=0.01)
    assert bench.get(S, 0x0F, REAL) == bench.get(S, 0x0D, REAL) == expected
    assert bench.get(S, 0x11, REAL) >= 100.0 / kv * 0.99  # peak
    assert bench.get(S, 0x10, REAL) <= 0.0
    assert bench.get(S, 0x02, REAL) == pytest.approx(100.0, rel=0.01)
    assert bench.get(S, 0x03, REAL) == pytest.approx(100 * 100.0 / 2200.0, rel=0.01)
    assert bench.get(S, 0x12, REAL) == pytest.approx(0.0, abs=0.5)


def test_a_following_error_above_its_window_cuts_the_output(make_bench: Any) -> None:
    bench = make_bench(simulation_blocked=1)
    bench.put(P, 0x12, REAL, 2.0)
    bench.put(P, 0x13, REAL, 0.1)
    bench.start(100.0, 100.0)
    bench.until(lambda: bench.axis.following_error > 2.0)
    took = bench.until(lambda: bench.axis.error_code)
    assert took == pytest.approx(0.1, abs=0.004)
    assert bench.get(0x4101, 0x01, NUMBER) == 0x4550
    bench.run(0.002)
    assert bench.get(0x7101, 0x02, REAL) == 0.0
    assert bench.get(0x4301, 0x89, FLAG) == 1


def test_a_velocity_following_error_is_its_own_error(make_bench: Any) -> None:
    bench = make_bench(simulation_blocked=1)
    bench.put(P, 0x10, FLAG, 0)
    bench.put(P, 0x14, REAL, 10.0)
    bench.put(P, 0x15, REAL, 0.05)
    bench.put(P, 0x11, FLAG, 1)
    bench.start(100.0, 100.0)
    bench.until(lambda: bench.axis.error_code)
    assert bench.get(0x4101, 0x01, NUMBER) == 0x4551


def test_an_unwatched_following_error_is_none(make_bench: Any) -> None:
    bench = make_bench(simulation_blocked=1)
    bench.put(P, 0x10, FLAG, 0)
    bench.start(10.0, 100.0)
    bench.until_rest()
    assert bench.get(0x4101, 0x01, NUMBER) == 0
    assert bench.get(S, 0x0F, REAL) == pytest.approx(10.0)


def test_the_controller_part_is_limited(make_bench: Any) -> None:
    bench = make_bench(simulation_blocked=1)
    bench.put(P, 0x10, FLAG, 0)
    bench.put(P, 0x100, REAL, 0.01)
    bench.start(100.0, 100.0)
    bench.until_rest()
    assert bench.get(S, 0x02, REAL) == pytest.approx(0.01 * 2200.0)
    assert bench.get(S, 0x03, REAL) == pytest.approx(1.0)


def test_errors_within_the_dead_band_are_left_alone(make_bench: Any) -> None:
    bench = make_bench(simulation_blocked=1)
    bench.put(P, 0x10D, REAL, 5.0)
    bench.start(4.0, 100.0)
    bench.until_rest()
    assert bench.get(S, 0x0F, REAL) == pytest.approx(4.0)
    assert bench.get(S, 0x02, REAL) == 0.0


def test_outputs_in_volts_and_the_velocity_part(bench: Any) -> None:
    bench.put(0x6001, 0x0B, "<d", 0.5)
    bench.put(0x6001, 0x10, "<H", 0)
    bench.start(1000.0, 400.0)
    bench.run(2.0)
    axis = bench.axis
    assert axis.set_velocity == 400.0
    assert bench.get(0x6101, 0x201, "<d") == pytest.approx(200.0)
    assert bench.get(0x6101, 0x202, "<d") == pytest.approx(100.0 * 200.0 / 2200.0)
    assert bench.get(0x6101, 0x203, "<d") == pytest.approx(10.0 * 200.0 / 2200.0)
    assert bench.get(0x6101, 0x04, "<d") == pytest.approx(axis.controller.output / 220.0)
    assert bench.get(0x7101, 0x04, "<d") == pytest.approx(axis.drive.output / 220.0)


def test_a_velocity_controller_shows_its_parts_there(make_bench: Any) -> None:
    bench = make_bench(
        controller_type=6, controller_velocity_kp=0.5, controller_velocity_tn=0.05,
        controller_velocity_i_limit=1.0, controller_output_limit=1.0,
    )  # fmt: skip
    bench.start(1000.0, 400.0)
    bench.run(2.0)
    axis = bench.axis
    assert bench.get(0x6101, 0x201, "<d") == axis.controller.velocity_p_part
    assert bench.get(0x4101, 0x2_0202, "<d") == axis.controller.velocity_i_part > 100.0
    assert bench.get(0x6101, 0x203, "<d") == axis.controller.velocity_d_part == 0.0


def test_the_gain_in_force(make_bench: Any) -> None:
    assert make_bench(controller_position_kv=12.0).get(0x6101, 0x111, "<d") == 12.0
    bench = make_bench(controller_type=2, controller_position_kv_fast=40.0)
    bench.start(1000.0, 400.0)
    bench.run(2.0)
    assert bench.get(0x6101, 0x111, "<d") == 40.0


@pytest.mark.parametrize("where", [(S, 0x110), (S, 0xA10), (0x4101, 0x2_0110), (0x4101, 0x2_0A10)])
def test_the_acceleration_feedforward_of_a_pid_controller(
    make_bench: Any, where: tuple[int, int]
) -> None:
    bench = make_bench(controller_type=3, controller_acceleration_feedforward_ka=0.01)
    bench.start(500.0, 100.0)
    bench.until(lambda: bench.axis.set_acceleration > 100.0)
    assert bench.get(*where, REAL) == pytest.approx(0.01 * bench.axis.set_acceleration)
