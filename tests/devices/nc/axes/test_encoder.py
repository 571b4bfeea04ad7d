"""Encoder parameters and states at 0x5000 and 0x5100 + ID."""

import struct
from math import inf, nan
from typing import Any

import pytest

P, S = 0x5001, 0x5101
REAL, FLAG, NUMBER = "<d", "<H", "<I"

PARAMETERS = [
    # offset, type, a value, one out of range, error named after the parameter
    (0x06, REAL, 1e-3, 0.0, 0x4406),
    (0x07, REAL, -12.5, 1.1e9, 0x4407),
    (0x08, FLAG, 1, 2, 0x4403),
    (0x09, REAL, 180.0, 0.0009, 0x4408),
    (0x0B, FLAG, 1, 2, 0x4420),
    (0x0C, FLAG, 1, 2, 0x4421),
    (0x0D, REAL, -100.0, nan, 0x4423),
    (0x0E, REAL, 100.0, inf, 0x4424),
    (0x10, REAL, 0.02, 60.1, 0x4409),
    (0x11, REAL, 0.02, -0.1, 0x440A),
    (0x12, REAL, 0.2, 61.0, 0x440B),
    (0x1B, REAL, 1.0, -1.0, 0x4417),
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


@pytest.mark.parametrize(("offset", "form"), [(0x06, REAL), (0x07, REAL), (0x08, FLAG)])
def test_what_scales_the_position_is_locked_while_enabled(
    bench: Any, refused: Any, offset: int, form: str
) -> None:
    before = bench.get(P, offset, form)
    for group, start in ((P, 0), (0x4001, 0x10000)):
        with refused(0x4257):
            bench.put(group, start + offset, form, 1)
    assert bench.get(P, offset, form) == before


def test_scaling_direction_and_offset_act(bench: Any) -> None:
    bench.start(100.0, 200.0)
    bench.until_rest()
    bench.run(0.5)
    count = bench.get(S, 0x08, "<q")
    assert bench.get(S, 0x07, "<i") == count
    assert bench.get(S, 0x02, REAL) == pytest.approx(count * bench.get(P, 0x06, REAL))
    bench.put(0x4301, 0x01, NUMBER, 0)
    bench.run(0.01)
    bench.put(P, 0x06, REAL, 2e-4)
    bench.put(P, 0x07, REAL, 3.0)
    bench.put(P, 0x08, FLAG, 1)
    bench.run(0.01)
    assert bench.get(S, 0x02, REAL) == pytest.approx(3.0 - count * 2e-4)
    assert bench.get(0x4101, 0x0A, REAL) == bench.get(S, 0x02, REAL)  # the set point follows


@pytest.mark.parametrize(
    ("enable", "limit", "value", "beyond", "inside", "error"),
    [(0x0B, 0x0D, -10.0, -10.5, -9.5, 0x4460), (0x0C, 0x0E, 10.0, 10.5, 9.5, 0x4461)],
)
def test_soft_limits_bound_targets(
    bench: Any,
    refused: Any,
    enable: int,
    limit: int,
    value: float,
    beyond: float,
    inside: float,
    error: int,
) -> None:
    bench.put(P, limit, REAL, value)
    bench.put(P, enable, FLAG, 1)
    with refused(error):
        bench.start(beyond, 100.0)
    bench.start(inside, 100.0)
    bench.until_rest()
    with refused(error):
        bench.start(beyond - inside, 100.0, start_type=2)
    bench.put(P, enable, FLAG, 0)
    bench.start(beyond, 100.0)


@pytest.mark.parametrize(
    ("enable", "limit", "value", "start_type", "error", "bit"),
    [(0x0B, 0x0D, -50.0, 4, 0x4462, 26), (0x0C, 0x0E, 50.0, 3, 0x4463, 27)],
)
def test_soft_limits_stop_an_endless_move(
    bench: Any, refused: Any, enable: int, limit: int, value: float, start_type: int, error: int,
    bit: int,
) -> None:  # fmt: skip
    bench.put(P, limit, REAL, value)
    bench.put(P, enable, FLAG, 1)
    bench.start(0.0, 100.0, start_type=start_type)
    bench.until(lambda: bench.axis.error_code)
    bench.until_rest()
    assert bench.get(0x4101, 0x01, NUMBER) == error
    assert abs(bench.axis.actual_position) > 50.0
    assert bench.get(0x4301, 0x81, NUMBER) >> bit & 1
    bench.write(0x4201, 0x01)
    with refused(0x4460 if error == 0x4462 else 0x4461):  # not further out
        bench.start(0.0, 100.0, start_type=start_type)
    bench.start(0.0, 100.0)


def test_the_modulo_factor_is_the_period(bench: Any) -> None:
    bench.put(P, 0x09, REAL, 30.0)
    bench.start(100.0, 200.0)
    bench.until_rest()
    bench.run(0.5)
    position = bench.get(S, 0x02, REAL)
    assert bench.get(S, 0x04, "<i") == 3
    assert bench.get(S, 0x03, REAL) == pytest.approx(position - 90.0)
    bench.start(-40.0, 200.0)
    bench.until_rest()
    bench.run(0.5)
    assert bench.get(S, 0x04, "<i") == -2
    assert bench.get(S, 0x03, REAL) == pytest.approx(bench.get(S, 0x02, REAL) + 60.0)


@pytest.mark.parametrize("offset", [0x05, 0x10, 0x15])
def test_actual_velocity(bench: Any, offset: int) -> None:
    bench.start(0.0, 100.0, start_type=4)
    bench.run(2.0)
    assert bench.get(S, offset, REAL) == pytest.approx(-100.0, abs=0.1)


def test_actual_acceleration_is_that_of_the_ramp(bench: Any) -> None:
    bench.put(P, 0x12, REAL, 0.0)
    bench.put(P, 0x11, REAL, 0.01)
    bench.start(0.0, 2000.0, start_type=3)
    bench.run(1.0)  # from 0.67 s on the ramp has its full 1500 mm/s²
    assert bench.axis.set_acceleration == 1500.0
    assert bench.get(S, 0x06, REAL) == pytest.approx(1500.0, rel=0.05)


def test_a_position_filter_lags(bench: Any) -> None:
    """A PT1 filter follows a ramp of v by v·T."""
    bench.put(0x6001, 0x10, FLAG, 0)
    bench.put(0x6001, 0x102, REAL, 0.0)
    bench.put(P, 0x10, REAL, 0.1)
    bench.start(0.0, 100.0, start_type=3)
    bench.run(3.0)
    lag = bench.get(S, 0x12, REAL) - bench.get(S, 0x02, REAL)
    assert lag == pytest.approx(100.0 * 0.1, rel=0.01)


def test_the_homed_flag_is_written_here_and_only_shown_by_the_axis(
    bench: Any, refused: Any
) -> None:
    bench.put(S, 0x09, FLAG, 1)
    assert bench.get(0x4101, 0x10009, FLAG) == 1
    bench.run(0.002)
    assert bench.get(0x4301, 0x83, FLAG) == 1
    with refused(0x704):
        bench.put(0x4101, 0x10009, FLAG, 0)
    with refused(0x4404):
        bench.put(S, 0x09, FLAG, 2)


def test_id_name_and_kind(bench: Any) -> None:
    assert bench.get(P, 0x01, NUMBER) == 1
    assert bench.read(P, 0x02, 31) == b"X".ljust(31, b"\0")
    assert bench.get(P, 0x1D, FLAG) == 0


def test_the_shift_of_set_actual_position_is_shown(bench: Any) -> None:
    bench.put(0x4201, 0x1A, "<I4xd", 1, 25.0)
    bench.run(0.002)
    assert bench.get(S, 0x17, REAL) == pytest.approx(25.0)
    assert bench.get(S, 0x0B, REAL) == bench.get(S, 0x02, REAL) == pytest.approx(25.0)


def test_the_scaling_has_two_components(make_bench: Any, refused: Any) -> None:
    bench = make_bench(control_dword=0)
    bench.put(0x5001, 0x23, "<d", 10.0)
    bench.put(0x5001, 0x24, "<d", 4096.0)
    assert bench.get(0x5001, 0x06, "<d") == 10.0 / 4096.0
    assert bench.get(0x5001, 0x25, "<dd") == (10.0, 4096.0)
    bench.put(0x5001, 0x25, "<dd", 1.0, 8.0)
    assert bench.get(0x4001, 0x1_0006, "<d") == 0.125
    bench.put(0x5001, 0x06, "<d", 0.5)
    assert bench.get(0x5001, 0x25, "<dd") == (0.5, 1.0)
    bench.axis.machine.position = 100.0 * bench.axis.sensor.way
    bench.run(0.002)
    assert bench.get(0x5101, 0x02, "<d") == 50.0
    for data in ((0.0, 1.0), (1.0, -1.0), (1e-12, 1e30), (1.0, nan)):
        with refused(0x4406):
            bench.put(0x5001, 0x25, "<dd", *data)
    assert bench.get(0x5001, 0x06, "<d") == 0.5


@pytest.mark.parametrize(
    ("sub_mask", "code"),
    [(0xF, 0), (0xFFFF, 0), (0xFFFFF, 0), (0xFFFE, 0x4426), (7, 0x4426), (0x1FFFFF, 0x4426)],
)
def test_the_sub_mask_fits_into_the_mask(
    make_bench: Any, refused: Any, sub_mask: int, code: int
) -> None:
    bench = make_bench(control_dword=0)
    bench.put(0x5001, 0x15, "<I", 0xFFFFF)
    if code:
        with refused(code):
            bench.put(0x5001, 0x108, "<I", sub_mask)
    else:
        bench.put(0x5001, 0x108, "<I", sub_mask)
        assert bench.get(0x4001, 0x1_0108, "<I") == sub_mask


def test_the_tolerance_window_is_half_a_period_at_most(bench: Any, refused: Any) -> None:
    bench.put(0x5001, 0x1B, "<d", 180.0)
    with refused(0x4417):
        bench.put(0x5001, 0x1B, "<d", 180.1)
    assert bench.get(0x5001, 0x1B, "<d") == 180.0


def test_positions_with_their_times(bench: Any) -> None:
    bench.start(100.0, 200.0)
    trace = {}
    for _ in range(40):
        bench.run(0.002)
        trace[bench.axis.set_cycle_counter * 2_000_000] = bench.axis.actual_position
    data = bench.read(0x5101, 0x16, 1024)
    entries = list(struct.iter_unpack("<I4xd", data))
    assert len(entries) == 16
    assert entries == list(trace.items())[-16:]


def test_dead_time_as_the_encoder_shows_it(bench: Any) -> None:
    bench.put(0x5001, 0x22, "<i", 4_000_000)
    assert bench.get(0x5101, 0x0D, "<d") == 0.0
    bench.put(0x5001, 0x20, "<I", 1)
    bench.start(500.0, 200.0)
    bench.run(1.0)
    assert bench.get(0x5101, 0x0D, "<d") == pytest.approx(0.004)
    way = bench.get(0x5101, 0x0C, "<d")
    assert way == pytest.approx(0.004 * bench.get(0x5101, 0x05, "<d"))
    filtered = bench.get(0x5101, 0x13, "<d")
    assert bench.get(0x5101, 0x02, "<d") == pytest.approx(filtered + way)
    compensated, plain = bench.get(0x6101, 0x0F, "<d"), bench.get(0x6101, 0x0D, "<d")
    assert plain - compensated == pytest.approx(way)


def test_the_modulo_reduction(bench: Any) -> None:
    bench.axis.control_dword = 0
    bench.axis.machine.position = 800e4 * bench.axis.sensor.way
    bench.run(0.002)
    assert bench.get(0x5101, 0x0E, "<d") == pytest.approx(-720.0)


def test_the_drive_knows_its_velocity_without_increments(bench: Any) -> None:
    bench.start(500.0, 200.0)
    bench.run(1.0)
    assert bench.get(0x5101, 0x14, "<d") == pytest.approx(200.0, abs=0.01)


def test_an_error_is_shown_by_the_part_it_belongs_to(bench: Any) -> None:
    for code, group in ((0x4464, 0x5101), (0x4550, 0x6101), (0x4650, 0x7101)):
        bench.axis.error_code = code
        assert bench.get(group, 0x01, "<i") == code
        for other in {0x5101, 0x6101, 0x7101} - {group}:
            assert bench.get(other, 0x01, "<i") == 0


def test_a_reference_mode_may_be_undefined(bench: Any, refused: Any) -> None:
    """002: 0 is the default of a set that is written back; homing then is refused."""
    bench.put(P, 0x107, NUMBER, 0)
    assert bench.get(P, 0x107, NUMBER) == 0
    with refused(0x4418):
        bench.write(0x4201, 0x10, b"")
    with refused(0x4418):
        bench.put(P, 0x107, NUMBER, 8)
