"""Simulated drive against its equations."""

from typing import Any

import pytest

from achse.motion import commands

V = 200.0


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


def test_a_wrong_counting_direction_runs_away(make_rig: Any) -> None:
    rig = make_rig(encoder_count_direction=1)
    commands.start(rig.axis, 1, 50.0, V)
    rig.until(lambda axis: axis.error_code == 0x4550, 5.0)
