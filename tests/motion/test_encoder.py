"""Encoder: increments become position, velocity and acceleration."""

from typing import Any

import pytest

from achse.motion import commands

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
    count = rig.axis.encoder_software_increments
    assert count == (-5000 if direction else 5000)
    assert rig.axis.actual_position == pytest.approx(57.0)


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


def test_modulo_positions_count_turns_below_zero(rig: Any) -> None:
    commands.start(rig.axis, 1, -90.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.actual_modulo_turns == -1
    assert rig.axis.actual_position_modulo == pytest.approx(270.0, abs=1e-4)
    assert rig.axis.set_modulo_turns == -1
    assert rig.axis.set_position_modulo == pytest.approx(270.0)
