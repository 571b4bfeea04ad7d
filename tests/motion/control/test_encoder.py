"""Encoder: increments become position, velocity and acceleration."""

from typing import Any

import pytest

from achse.motion import AxisParameters, Nc, OperationModeBit, StateBit, commands
from achse.motion.fields.encoder import POSITION_HISTORY

V = 200.0


@pytest.mark.parametrize("direction", [0, 1])
def test_increments_scale_into_positions(make_rig: Any, direction: int) -> None:
    rig = make_rig(
        encoder_scaling_factor=0.01,
        encoder_position_offset=7.0,
        encoder_count_direction=direction,
        drive_motor_polarity=direction,
    )
    assert rig.axis.actual_position == 7.0
    commands.start(rig.axis, 1, 57.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    count = rig.axis.encoder.software_increments
    assert count == (-5000 if direction else 5000)
    assert rig.axis.actual_position == pytest.approx(57.0)


def test_the_hardware_counter_wraps_at_32_bits(make_rig: Any) -> None:
    rig = make_rig(control_dword=0)
    for count in (2.0**30, 2.0**31 + 5.0):
        place(rig, count)
    assert rig.axis.encoder.software_increments == 2**31 + 5
    assert rig.axis.encoder.hardware_increments == -(2**31) + 5


def test_the_position_filter_delays_and_arrives(make_rig: Any) -> None:
    rig = make_rig(encoder_position_filter_time=0.02, controller_position_kv=5.0)
    commands.start(rig.axis, 1, 10.0, V)
    rig.until(lambda axis: axis.set_velocity > 10.0)
    assert rig.axis.actual_position < rig.axis.encoder.actual_position_unfiltered
    rig.until_rest()
    rig.seconds(4.0)
    assert rig.axis.actual_position == rig.axis.encoder.actual_position_unfiltered
    assert rig.axis.actual_position == pytest.approx(10.0, abs=1e-3)


def test_modulo_positions_count_turns_below_zero(rig: Any) -> None:
    commands.start(rig.axis, 1, -90.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.actual_modulo_turns == -1
    assert rig.axis.actual_position_modulo == pytest.approx(270.0, abs=1e-4)
    assert rig.axis.set_modulo_turns == -1
    assert rig.axis.set_position_modulo == pytest.approx(270.0)


def place(rig: Any, counts: float) -> None:
    """Put the motor of a disabled axis somewhere and look at it for a cycle."""
    rig.axis.machine.position = counts * rig.axis.sensor.way
    rig.axis.resting = 0
    rig.run(1)


OFF = {"control_dword": 0}


def test_the_scaling_is_numerator_by_denominator(make_rig: Any) -> None:
    rig = make_rig(encoder_scaling_numerator=3.0, encoder_scaling_denominator=8.0, **OFF)
    assert rig.axis.encoder.scaling_factor == 3.0 / 8.0
    place(rig, 16.0)
    assert rig.axis.actual_position == 6.0
    rig = make_rig(encoder_scaling_factor=0.25)
    assert (rig.axis.encoder.scaling_numerator, rig.axis.encoder.scaling_denominator) == (0.25, 1.0)


def test_an_axis_reports_the_truth_before_its_first_cycle() -> None:
    nc = Nc(
        2_000_000,
        [
            AxisParameters(
                1,
                values={
                    "encoder_position_offset": 370.0,
                    "encoder_soft_limit_max_enable": 1,
                    "encoder_soft_limit_max": 300.0,
                    "unit_interpretation": 4,
                    "loop_enable": 1,
                },
            )
        ],
        compiled=False,
    )
    axis = nc.axis(1)
    assert (axis.set_position, axis.actual_position, axis.target_position) == (370.0,) * 3
    assert (axis.actual_position_modulo, axis.set_modulo_turns) == (10.0, 1)
    assert axis.state_dword & StateBit.SOFT_LIMIT_MAX_EXCEEDED
    assert axis.state_dword & StateBit.NOT_MOVING
    assert axis.operation_mode_state_dword & OperationModeBit.MODULO
    assert axis.operation_mode_state_dword & OperationModeBit.LOOP
    assert axis.set_cycle_counter == 0


@pytest.mark.parametrize("mask", [0xFFFF, 3_600_000])
def test_the_count_wraps_at_the_mask_and_the_position_goes_on(make_rig: Any, mask: int) -> None:
    rig = make_rig(encoder_mask=mask, encoder_scaling_factor=0.01, **OFF)
    seen = set()
    for count in range(0, 3 * mask, mask // 5):
        place(rig, float(count))
        assert rig.axis.encoder.hardware_increments == count % (mask + 1)
        assert rig.axis.actual_position == pytest.approx(count * 0.01)
        seen.add(count // (mask + 1))
    assert seen == {0, 1, 2}
    place(rig, -10.0 + 3 * mask)
    for count in range(3 * mask, -mask, -(mask // 5)):
        place(rig, float(count))
    assert rig.axis.actual_position == pytest.approx(count * 0.01)
    assert rig.axis.encoder.hardware_increments == count % (mask + 1)


def test_an_absolute_reference_system_does_not_count_on(make_rig: Any) -> None:
    rig = make_rig(
        encoder_mask=0xFFF, encoder_reference_system=1, encoder_scaling_factor=1.0, **OFF
    )
    place(rig, 4000.0)
    assert rig.axis.actual_position == 4000.0
    place(rig, 4100.0)
    assert rig.axis.actual_position == 4.0


def test_signed_increments(make_rig: Any) -> None:
    rig = make_rig(
        encoder_mask=0xFFFF,
        encoder_reference_system=1,
        encoder_sign_interpretation=2,
        encoder_scaling_factor=1.0,
        **OFF,
    )
    place(rig, 40_000.0)
    assert rig.axis.actual_position == 40_000.0 - 65_536.0


def test_masked_bits_of_the_count_are_not_seen(make_rig: Any) -> None:
    rig = make_rig(encoder_raw_value_filter_mask=0b111, encoder_scaling_factor=1.0, **OFF)
    for count in (5.0, 7.0, 8.0, 15.0, 23.0):
        place(rig, count)
        assert rig.axis.actual_position == float(int(count) // 8 * 8)


@pytest.mark.parametrize(
    ("direction", "there", "back"),
    [(0, 100.0, 40.0), (1, 100.0, 100.0), (2, 0.0, -60.0), (3, 0, 0)],
)
def test_evaluated_directions(make_rig: Any, direction: int, there: float, back: float) -> None:
    rig = make_rig(encoder_evaluation_direction=direction, encoder_scaling_factor=1.0, **OFF)
    place(rig, 100.0)
    assert rig.axis.actual_position == there
    place(rig, 40.0)
    assert rig.axis.actual_position == back
    rig.axis.encoder.evaluation_direction = 0
    rig.run(2)
    assert rig.axis.actual_position == back


def test_encoder_modes(make_rig: Any) -> None:
    for mode, velocity, acceleration in ((1, False, False), (2, True, False), (3, True, True)):
        rig = make_rig(encoder_mode=mode)
        commands.start(rig.axis, 1, 100.0, V)
        rig.seconds(0.1)
        assert rig.axis.actual_position > 0.1
        assert (rig.axis.actual_velocity > 1.0) is velocity
        assert (rig.axis.actual_acceleration > 1.0) is acceleration


def test_the_position_correction_is_added_with_its_filter(make_rig: Any) -> None:
    rig = make_rig(
        encoder_actual_position_correction_enable=1,
        encoder_actual_position_correction_filter_time=0.05,
        encoder_velocity_filter_time=0.0,
        **OFF,
    )
    rig.axis.actual_position_correction = 2.0
    for n in range(1, 30):
        rig.run(1)
        left = (0.05 / (0.05 + rig.dt)) ** n
        assert rig.axis.encoder.position_correction == pytest.approx(2.0 * (1.0 - left))
        assert rig.axis.actual_position == rig.axis.encoder.position_correction
        assert rig.axis.actual_position_uncorrected == 0.0
        assert rig.axis.actual_velocity > 0.0
        assert rig.axis.encoder.actual_velocity_uncorrected == 0.0
    rig.seconds(2.0)
    assert rig.axis.actual_position == pytest.approx(2.0, abs=1e-6)
    rig.axis.encoder.actual_position_correction_enable = 0
    rig.seconds(2.0)
    assert rig.axis.actual_position == pytest.approx(0.0, abs=1e-6)


def test_a_corrected_axis_stands_where_the_correction_says(make_rig: Any) -> None:
    rig = make_rig(encoder_actual_position_correction_enable=1, actual_position_correction=0.75)
    commands.start(rig.axis, 1, 20.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.actual_position == pytest.approx(20.0, abs=1e-4)
    assert rig.axis.encoder.software_increments == pytest.approx(19.25e4, abs=2)


def test_backlash_is_made_up_for_after_a_reversal(make_rig: Any) -> None:
    rig = make_rig(backlash_compensation_enable=1, backlash=0.3)
    for target, motor in ((10.0, 10.0), (5.0, 4.7), (2.0, 1.7), (3.0, 3.0)):
        commands.start(rig.axis, 1, target, V)
        rig.until_rest()
        rig.seconds(1.0)
        assert rig.axis.actual_position == pytest.approx(target, abs=1e-4)
        assert rig.axis.encoder.software_increments * 1e-4 == pytest.approx(motor, abs=1e-3)
    assert rig.axis.operation_mode_state_dword & OperationModeBit.BACKLASH_COMPENSATION


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_dead_time_is_extrapolated(make_rig: Any, mode: int) -> None:
    late = 0.005
    rig = make_rig(
        encoder_dead_time_compensation_mode=mode,
        encoder_dead_time_compensation_shift=round(late * 1e9),
        encoder_scaling_factor=1e-7,
    )
    commands.start(rig.axis, 1, 300.0, V)
    for _ in range(200):
        rig.run(1)
        axis = rig.axis
        way = (0.0, late * axis.actual_velocity, late * axis.actual_velocity)[mode]
        if mode == 2:
            way += 0.5 * late * late * axis.actual_acceleration
        assert axis.encoder.dead_time_position_correction == pytest.approx(way, abs=1e-12)
        assert axis.actual_position == pytest.approx(axis.encoder.actual_position_filtered + way)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.actual_position == pytest.approx(300.0, abs=1e-4)


def test_noise_is_bounded_and_the_same_in_each_run(make_rig: Any) -> None:
    traces = []
    for _ in range(2):
        rig = make_rig(encoder_simulation_noise_scaling=20.0, **OFF)
        counts = []
        for _ in range(500):
            rig.run(1)
            counts.append(rig.axis.encoder.hardware_increments)
        traces.append(counts)
    assert traces[0] == traces[1]
    assert max(map(abs, counts)) <= 20
    assert len(set(counts)) > 20
    assert abs(sum(counts) / len(counts)) < 2.0


def test_the_history_holds_the_last_positions(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    positions = []
    for _ in range(100):
        rig.run(1)
        positions.append(rig.axis.actual_position)
    now = rig.axis.set_cycle_counter
    remaining = [rig.axis.encoder.history[(now - age) % POSITION_HISTORY] for age in range(16)]
    assert remaining == positions[:-17:-1]
    rig.seconds(20.0)
    assert rig.axis.resting == 1
    assert set(rig.axis.encoder.history) == {rig.axis.actual_position}
