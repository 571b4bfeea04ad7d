"""Drive parameters and states at 0x7000 and 0x7100 + ID."""

from typing import Any

import pytest

P, S = 0x7001, 0x7101
REAL, FLAG, NUMBER = "<d", "<H", "<I"

PARAMETERS = [
    # offset, type, a value, one out of range, error named after the parameter
    (0x06, FLAG, 1, 2, 0x4603),
    (0x0A, NUMBER, 1, 2, 0x4602),
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
    with refused(0x4257):
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


def test_times_beyond_the_reach_of_delays_are_refused(bench: Any, refused: Any) -> None:
    for offset in (0x10D, 0x111):
        bench.put(0x7001, offset, "<d", 0.128)
        with refused(0x4003):
            bench.put(0x7001, offset, "<d", 0.129)
        assert bench.get(0x7001, offset, "<d") == 0.128


def test_a_characteristic_table_is_chosen_while_the_loop_is_open(bench: Any, refused: Any) -> None:
    bench.put(0x7001, 0x120, "<I", 0)
    with refused(0x4652):
        bench.put(0x7001, 0x120, "<I", 1)
    bench.put(0x4301, 0x01, "<I", 0)
    bench.run(0.01)
    with refused(0x4261):
        bench.put(0x7001, 0x120, "<I", 1)
    for interpolation in (1, 3):
        with refused(0x4A08):
            bench.put(0x7001, 0x121, "<I", interpolation)
    bench.put(0x7001, 0x121, "<I", 2)
    assert bench.get(0x7001, 0x121, "<I") == 2


def test_the_output_after_the_characteristic(make_bench: Any) -> None:
    bench = make_bench()
    bench.start(1000.0, 220.0)
    bench.run(2.0)
    assert bench.get(0x7101, 0x13, "<d") == bench.get(0x7101, 0x03, "<d")
    bench = make_bench(
        drive_type=6, drive_velocity_reference_point=0.2, drive_output_reference_point=0.6
    )
    bench.start(1000.0, 220.0)
    bench.run(2.0)
    assert bench.get(0x7101, 0x13, "<d") == pytest.approx(30.0, rel=1e-3)
    assert bench.get(0x7101, 0x14, "<d") == pytest.approx(3.0, rel=1e-3)


def test_filtered_set_values_of_a_position_drive(make_bench: Any) -> None:
    bench = make_bench()
    bench.start(100.0, 200.0)
    bench.run(0.2)
    for offset, field in ((0x11A, "set_position"), (0x11E, "set_velocity")):
        assert bench.get(0x7101, offset, "<d") == getattr(bench.axis, field)
    assert bench.get(0x7101, 0x11F, "<d") == bench.axis.set_acceleration
    bench = make_bench(controller_type=9, drive_output_filter_type=1, drive_output_filter_time=0.02)
    bench.start(100.0, 200.0)
    bench.run(0.2)
    assert 0.0 < bench.get(0x7101, 0x11A, "<d") < bench.axis.set_position
    assert bench.get(0x7101, 0x11F, "<d") == bench.axis.drive.filtered_set_acceleration


def test_a_digital_input_that_is_not_there(bench: Any, refused: Any) -> None:
    for number in (0, 9):
        with refused(0x4003):
            bench.exchange(0x7101, 0x200, 4, number.to_bytes(4, "little"))


def test_the_reference_output_gives_the_velocity_at_full_output(bench: Any, refused: Any) -> None:
    bench.put(0x7001, 0x102, "<d", 0.8)
    assert bench.get(0x7001, 0x103, "<d") == pytest.approx(2200.0 / 0.8)
    with refused(0x4606):
        bench.put(0x7001, 0x102, "<d", 0.0)


def test_a_characteristic_table_that_cannot_be_removed(bench: Any, refused: Any) -> None:
    with refused(0x4261):
        bench.put(0x7201, 0x102, "<I", 7)
    with refused(0x4A00):
        bench.put(0x7201, 0x102, "<I", 0)
    with refused(0x4015):
        bench.put(0x7202, 0x102, "<I", 7)
