"""Encoder, controller and simulated drive against their equations."""

from typing import Any

import pytest

from achse.motion import StartType, StateBit, commands

V = 200.0


def at_speed(rig: Any) -> None:
    commands.start(rig.axis, StartType.ENDLESS_POSITIVE, 0.0, V)
    rig.seconds(3.0)


def test_the_actual_position_settles_on_the_target(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.actual_position == pytest.approx(100.0, abs=0.51e-4)
    assert rig.axis.drive_output == 0.0


def test_within_a_hundredth_long_before_a_second(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.until_rest()
    rig.seconds(0.25)
    for _ in range(500):
        rig.run(1)
        assert abs(rig.axis.actual_position - 100.0) <= 0.01


def test_the_following_error_without_full_feedforward(make_rig: Any) -> None:
    rig = make_rig(
        controller_velocity_feedforward_weight=0.8,
        controller_position_kv=25.0,
        encoder_scaling_factor=1e-6,
    )
    at_speed(rig)
    assert rig.axis.following_error == pytest.approx(0.2 * V / 25.0, rel=1e-5)
    assert rig.axis.controller_output == pytest.approx(0.2 * V, rel=1e-5)
    assert rig.axis.drive_output == pytest.approx(V, rel=1e-5)
    assert rig.axis.controller_output_percent == pytest.approx(100.0 * 0.2 * V / 2200.0, rel=1e-5)
    assert rig.axis.drive_output_percent == pytest.approx(100.0 * V / 2200.0, rel=1e-5)
    assert rig.axis.actual_velocity == pytest.approx(V, rel=1e-5)
    assert rig.axis.actual_acceleration == pytest.approx(0.0, abs=1.0)


def test_peaks_are_held(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.following_error_peak_positive > 0.05
    assert rig.axis.following_error_peak_negative < -0.05
    assert rig.axis.drive_output_peak_positive == pytest.approx(177.8, rel=1e-2)


def test_dead_time_delays_the_drive(make_rig: Any) -> None:
    for dead_cycles in (0, 1, 5):
        rig = make_rig(
            simulation_dead_time=dead_cycles * 0.002,
            simulation_time_constant=0.0,
            controller_position_kv=0.0,
            encoder_scaling_factor=1e-9,
            encoder_velocity_filter_time=0.0,
        )
        commands.start(rig.axis, 3, 0.0, V)
        outputs, velocities = [], []
        for _ in range(200):
            rig.run(1)
            outputs.append(rig.axis.drive_output)
            velocities.append(rig.axis.actual_velocity)
        late = 1 + dead_cycles  # the encoder shows what the drive did until this cycle
        assert velocities[late:] == pytest.approx(outputs[:-late], abs=1e-5)


def test_the_velocity_follows_with_a_first_order_lag(make_rig: Any) -> None:
    constant = 0.05
    rig = make_rig(
        simulation_time_constant=constant,
        controller_position_kv=0.0,
        controller_following_error_position_monitoring_enable=0,
        encoder_scaling_factor=1e-9,
        encoder_velocity_filter_time=0.0,
        default_acceleration=1e4,
        default_jerk=1e9,
    )
    commands.start(rig.axis, 3, 0.0, V)
    rig.until(lambda axis: axis.set_velocity == V)
    missing = V - rig.axis.actual_velocity
    rig.run(25)
    factor = (constant / (constant + rig.dt)) ** 25
    assert V - rig.axis.actual_velocity == pytest.approx(missing * factor, rel=0.02)


def test_an_ideal_drive_has_no_following_error(make_rig: Any) -> None:
    rig = make_rig(simulation_ideal=1)
    commands.start(rig.axis, 1, 100.0, V)
    while rig.axis.set_motion_phase or rig.axis.set_position == 0.0:
        rig.run(1)
        assert abs(rig.axis.following_error) <= 0.5001e-4
    assert rig.axis.actual_position == pytest.approx(100.0, abs=1e-9)


def test_the_outputs_are_limited(make_rig: Any) -> None:
    rig = make_rig(
        controller_output_limit=0.01,
        drive_output_limit_max=0.05,
        controller_following_error_position_monitoring_enable=0,
    )
    assert not rig.has(StateBit.DRIVE_LIMIT_ACTIVE)
    at_speed(rig)
    assert rig.has(StateBit.DRIVE_LIMIT_ACTIVE)
    assert rig.axis.controller_output == pytest.approx(0.01 * 2200.0)
    assert rig.axis.drive_output == pytest.approx(0.05 * 2200.0)
    assert rig.axis.actual_velocity == pytest.approx(0.05 * 2200.0)


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
    count = rig.axis.encoder_software_increments
    assert count == (-5000 if direction else 5000)
    assert rig.axis.actual_position == pytest.approx(57.0)


def test_a_wrong_counting_direction_runs_away(make_rig: Any) -> None:
    rig = make_rig(encoder_count_direction=1)
    commands.start(rig.axis, 1, 50.0, V)
    rig.until(lambda axis: axis.error_code == 0x4550, 5.0)


def test_the_hardware_counter_wraps_at_32_bits(rig: Any) -> None:
    rig.axis.plant_position = float(2**31 + 5)
    rig.run(1)
    assert rig.axis.encoder_software_increments == 2**31 + 5
    assert rig.axis.encoder_hardware_increments == -(2**31) + 5


def test_the_position_filter_delays_and_arrives(make_rig: Any) -> None:
    rig = make_rig(encoder_position_filter_time=0.02, controller_position_kv=5.0)
    commands.start(rig.axis, 1, 10.0, V)
    rig.until(lambda axis: axis.set_velocity > 10.0)
    assert rig.axis.actual_position < rig.axis.encoder_actual_position_unfiltered
    rig.until_rest()
    rig.seconds(4.0)
    assert rig.axis.actual_position == rig.axis.encoder_actual_position_unfiltered
    assert rig.axis.actual_position == pytest.approx(10.0, abs=1e-3)


def test_the_dead_band_is_not_corrected(make_rig: Any) -> None:
    rig = make_rig(controller_position_dead_band=1.0, controller_velocity_feedforward_weight=0.99)
    commands.start(rig.axis, 1, 50.0, V)
    rig.until_rest()
    rig.seconds(2.0)
    assert 0.1 < abs(rig.axis.following_error) <= 1.0


def test_modulo_positions_count_turns_below_zero(rig: Any) -> None:
    commands.start(rig.axis, 1, -90.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.actual_modulo_turns == -1
    assert rig.axis.actual_position_modulo == pytest.approx(270.0, abs=1e-4)
    assert rig.axis.set_modulo_turns == -1
    assert rig.axis.set_position_modulo == pytest.approx(270.0)
