"""Axis states at 0x4100 + ID: online structure by length, set values, stop information."""

import struct
from math import sqrt
from typing import Any

import pytest

S = 0x4101
REAL, FLAG, NUMBER = "<d", "<H", "<I"


def moving(bench: Any, velocity: float = 100.0) -> None:
    """Endless at constant velocity."""
    bench.start(0.0, velocity, start_type=3)
    bench.until(lambda: bench.axis.set_velocity == velocity)
    bench.run(0.002)


def test_the_online_structure_has_the_form_of_its_length(bench: Any) -> None:
    moving(bench)
    position, velocity = bench.get(S, 0x0A, REAL), 100.0
    packed, aligned = bench.read(S, 0, 112), bench.read(S, 0, 256)
    assert (len(packed), len(aligned)) == (112, 256)
    assert struct.unpack_from("<dd", packed, 20) == (position, bench.get(S, 0x0B, REAL))
    assert struct.unpack_from("<dd", aligned, 24) == (position, bench.get(S, 0x0B, REAL))
    assert struct.unpack_from("<dI", packed, 44) == (velocity, 1_000_000)
    assert struct.unpack_from("<dI", aligned, 48) == (velocity, 1_000_000)
    state = bench.get(0x4301, 0x81, NUMBER)
    assert struct.unpack_from("<II", packed, 96) == (state, 7)
    assert struct.unpack_from("<II", aligned, 104) == (state, 7)


@pytest.mark.parametrize("length", [0, 4, 16, 111, 113, 120, 128, 144, 255])
def test_other_lengths_get_the_beginning_of_the_whole(bench: Any, length: int) -> None:
    moving(bench)
    assert bench.read(S, 0, length) == bench.read(S, 0, 256)[:length]


def test_more_than_there_is_gives_what_there_is(bench: Any) -> None:
    assert bench.read(S, 0, 1000) == bench.read(S, 0, 256)


def test_set_values_along_a_ramp(bench: Any) -> None:
    """From rest with jerk j: a = jt, v = jt²/2, s = jt³/6."""
    jerk, time = 2250.0, 0.2
    bench.start(1000.0, 500.0)
    bench.run(time)
    assert bench.get(S, 0x10, REAL) == jerk
    assert bench.get(S, 0x0F, REAL) == pytest.approx(jerk * time)
    assert bench.get(S, 0x0E, REAL) == pytest.approx(jerk * time**2 / 2)
    assert bench.get(S, 0x0A, REAL) == pytest.approx(jerk * time**3 / 6)
    assert bench.get(S, 0x0D, REAL) == 1.0
    assert bench.get(S, 0x13, REAL) == 1000.0
    assert bench.get(S, 0x50, NUMBER) == 1


def test_modulo_values_of_the_set_point(bench: Any) -> None:
    bench.start(-400.0, 1800.0, axis=3)
    axis = bench.nc.axis(3)
    bench.until(lambda: not axis.set_motion_phase)
    assert bench.get(0x4103, 0x0B, REAL) == pytest.approx(320.0)
    assert bench.get(0x4103, 0x0C, "<i") == -2
    assert bench.get(0x4103, 0x0A, REAL) == -400.0


def test_the_remaining_time_and_distance_run_out(bench: Any) -> None:
    bench.start(100.0, 100.0)
    bench.run(0.5)
    time, distance = bench.get(S, 0x14, "<dd")
    assert distance == pytest.approx(100.0 - bench.get(S, 0x0A, REAL))
    assert bench.until_rest() == pytest.approx(time, abs=0.004)
    assert bench.get(S, 0x14, "<dd") == (0.0, 0.0)


def test_the_positioning_time_ends_in_the_target_window(bench: Any) -> None:
    bench.start(100.0, 100.0)
    took = bench.until(lambda: bench.get(0x4301, 0x8F, FLAG) and not bench.axis.set_motion_phase)
    bench.run(0.01)
    assert bench.get(S, 0x16, REAL) == pytest.approx(took, abs=0.004)


def test_the_override_is_a_share_of_one(bench: Any) -> None:
    bench.put(0x4301, 0x21, NUMBER, 250_000)
    bench.run(0.002)
    assert bench.get(S, 0x17, REAL) == 0.25


@pytest.mark.parametrize(
    ("deceleration", "jerk"), [(1500.0, 2250.0), (400.0, 40_000.0), (0.0, 0.0)]
)
def test_stop_information_follows_the_equations(
    bench: Any, deceleration: float, jerk: float
) -> None:
    velocity = 300.0
    moving(bench, velocity)
    time, distance = 0.0, 0.0
    data = bench.exchange(S, 0x18, 16, struct.pack("<dd", deceleration, jerk))
    a, j = deceleration or 1500.0, jerk or 2250.0
    if velocity * j < a * a:  # the full deceleration is not reached
        time = 2 * sqrt(velocity / j)
    else:
        time = velocity / a + a / j
    distance = velocity * time / 2  # the ramp is symmetric
    assert struct.unpack("<dd", data) == pytest.approx((distance, time))


def test_stop_information_is_no_read_and_no_write(bench: Any, refused: Any) -> None:
    with refused(0x704):
        bench.read(S, 0x18, 16)
    with refused(0x704):
        bench.put(S, 0x18, "<dd", 1.0, 1.0)
    with refused(0x705):
        bench.exchange(S, 0x18, 16, bytes(8))


def test_errors_commands_and_resets_are_counted(bench: Any) -> None:
    assert bench.get(S, 0x15, NUMBER) == 0
    for number in (1, 2):
        bench.start(1.0 * number, 100.0)
        bench.run(0.002)
        assert bench.get(S, 0x15, NUMBER) == number
        bench.until_rest()
    bench.put(0x4201, 0x19, NUMBER, 0x4550)
    bench.run(0.002)
    assert bench.get(S, 0x01, NUMBER) == 0x4550
    resets = bench.get(S, 0x2E, NUMBER)
    bench.write(0x4201, 0x01)
    bench.run(0.002)
    assert (bench.get(S, 0x01, NUMBER), bench.get(S, 0x2E, NUMBER)) == (0, resets + 1)


def test_an_error_code_of_32_bits_fits_everywhere(bench: Any) -> None:
    bench.put(0x4201, 0x19, NUMBER, 0xFFFF_FFFF)
    bench.run(0.002)
    assert bench.get(S, 0x01, NUMBER) == 0xFFFF_FFFF
    for group, offset in ((S, 0), (S, 0), (0x4301, 0x80)):
        assert b"\xff" * 4 in bench.read(group, offset, 256)[:8]


def test_the_cycle_counter_counts(bench: Any) -> None:
    before = bench.get(S, 0x09, NUMBER)
    bench.run(0.1)
    assert bench.get(S, 0x09, NUMBER) == before + 50


def test_states_are_not_written(bench: Any, refused: Any) -> None:
    for offset in (0x00, 0x01, 0x0A, 0x20, 0x10002, 0x2000F, 0x30002):
        with refused(0x704):
            bench.write(S, offset, bytes(8))


def test_only_the_standard_element_is_there(bench: Any, refused: Any) -> None:
    for offset, error in (
        (0x0010_000A, 0x4012),
        (0x0011_0002, 0x4013),
        (0x0022_000F, 0x4014),
        (0x0093_0002, 0x4015),
    ):
        with refused(error):
            bench.get(S, offset, REAL)
    with refused(0x703):
        bench.get(S, 0x0010_0001, NUMBER)  # the manual gives the error code no element


def test_unknown_offsets(bench: Any, refused: Any) -> None:
    for offset in (0x02, 0xFF, 0x10001, 0x40000):
        with refused(0x703):
            bench.read(S, offset, 4)


S = 0x4101


def test_set_point_structures_in_all_their_forms(bench: Any) -> None:
    bench.axis.set_torque, bench.axis.set_torque_derivative = 40.0, 5.0
    bench.start(100.0, 200.0)
    bench.run(0.2)
    axis = bench.axis
    dynamics = (axis.set_velocity, axis.set_acceleration, axis.set_direction, axis.set_jerk)
    full = (axis.set_position, *dynamics, 40.0, 5.0)
    for count in (5, 6, 7):
        assert bench.get(S, 0x60, f"<{count}d") == full[:count]
    for count in (4, 5, 6):
        assert bench.get(S, 0x61, f"<{count}d") == full[1 : 1 + count]
    assert bench.get(S, 0x62, "<2d") == (40.0, 5.0)


def test_set_points_are_taken_while_the_external_generator_is_active(
    bench: Any, refused: Any
) -> None:
    with refused(0x42E3):
        bench.put(S, 0x60, "<5d", 1.0, 2.0, 3.0, 1.0, 4.0)
    axis = bench.axis
    axis.external_setpoint_active = 1
    bench.put(S, 0x60, "<7d", 1.0, 2.0, 3.0, -1.0, 4.0, 5.0, 6.0)
    assert (axis.external_set_position, axis.external_set_velocity) == (1.0, 2.0)
    assert (axis.external_set_acceleration, axis.external_set_direction) == (3.0, -1)
    assert (axis.external_set_jerk, axis.external_set_torque) == (4.0, 5.0)
    bench.put(S, 0x61, "<4d", 12.0, 13.0, 1.0, 14.0)
    assert (axis.external_set_position, axis.external_set_velocity) == (1.0, 12.0)
    bench.put(S, 0x62, "<2d", 21.0, 22.0)
    assert axis.external_set_torque_derivative == 22.0


def test_the_operation_mode_of_the_drive(bench: Any) -> None:
    bench.axis.drive_operation_mode = 5
    assert struct.unpack("<i4x", bench.exchange(S, 0x63, 8, bytes(8))) == (5,)


def test_the_torque_offset_can_be_written(bench: Any) -> None:
    bench.put(S, 0x31, "<d", 125.0)
    assert bench.axis.set_torque_offset == 125.0
    assert struct.unpack_from("<d", bench.read(S, 0x00, 256), 168)[0] == 125.0


def test_an_axis_of_its_own_is_not_coupled(bench: Any) -> None:
    for offset, form in ((0x20, "<I"), (0x21, "<I"), (0x12, "<d"), (0x2A, "<d"), (0x24, "<I")):
        assert bench.get(S, offset, form) == 0


def test_uncorrected_set_values_are_the_set_values(bench: Any) -> None:
    bench.start(100.0, 200.0)
    bench.run(0.2)
    for offset, uncorrected in ((0x0A, 0x1A), (0x0D, 0x1D), (0x0E, 0x1E), (0x0F, 0x1F)):
        assert bench.read(S, offset, 8) == bench.read(S, uncorrected, 8)
    assert bench.get(S, 0x1A, "<d") > 0.0
