"""Position controller against its equations."""

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


def test_the_dead_band_is_not_corrected(make_rig: Any) -> None:
    rig = make_rig(controller_position_dead_band=1.0, controller_velocity_feedforward_weight=0.99)
    commands.start(rig.axis, 1, 50.0, V)
    rig.until_rest()
    rig.seconds(2.0)
    assert 0.1 < abs(rig.axis.following_error) <= 1.0
