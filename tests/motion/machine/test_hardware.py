"""Machines are built as their axes are set up at the start."""

from collections.abc import Mapping

import pytest

from achse.motion import AxisParameters, AxisParametersError, Nc
from achse.motion.machine.hardware import Hardware, count_from, place_machine
from achse.motion.machine.kernel import STEPPER, TWO_SPEEDS


def axis(values: Mapping[str, float], compiled: bool = False) -> Nc:
    return Nc(2_000_000, [AxisParameters(1, values=values)], compiled=compiled)


@pytest.mark.parametrize("compiled", [False, True])
def test_what_the_axis_is_set_to_is_what_its_machine_is(compiled: bool) -> None:
    values = {
        "encoder_scaling_numerator": 3.0, "encoder_scaling_denominator": 4.0,
        "encoder_count_direction": 1, "encoder_mask": 0xFFFF,
        "drive_reference_velocity": 900.0, "drive_reference_output": 0.5,
        "drive_motor_polarity": 1, "drive_output_mask": 0x7FFF,
        "drive_position_scaling": 6.0, "drive_velocity_scaling": 7.0,
        "drive_acceleration_scaling": 8.0, "drive_torque_offset_scaling": 9.0,
        "drive_set_torque_scaling": 10.0, "drive_actual_torque_scaling": 0.1,
        "stepper_step_scaling": 0.02,
    }  # fmt: skip
    result = axis(values, compiled).axis(1)
    sensor, drive = result.sensor, result.amplifier
    assert (sensor.encoder_resolution, sensor.encoder_inverted) == (0.75, 1)
    assert (sensor.encoder_mask, sensor.way) == (0xFFFF, -0.75)
    assert (drive.full_velocity, drive.full_output, drive.motor_inverted) == (1800.0, 0x7FFF, 1)
    assert (drive.position_weight, drive.velocity_weight) == (8.0, 7.0)
    assert (drive.acceleration_weight, drive.torque_offset_weight) == (8.0, 9.0)
    assert (drive.set_torque_weight, drive.torque_weight) == (10.0, 10.0)
    result.encoder.scaling_factor = 5.0
    assert sensor.encoder_resolution == 0.75


def test_what_is_said_of_the_machine_itself_counts_more() -> None:
    result = axis({"encoder_scaling_factor": 2.0, "simulation_encoder_resolution": 3.0}).axis(1)
    assert (result.encoder.scaling_factor, result.sensor.encoder_resolution) == (2.0, 3.0)
    assert result.simulation_encoder_resolution == 3.0  # type: ignore[attr-defined]


def test_drives_that_are_switched() -> None:
    masks = {f"drive_stepper_mask_cycle{n}": n for n in range(1, 7)}
    result = axis({"axis_type": 3, "drive_type": 8, "stepper_operation_mode": 2} | masks).axis(1)
    assert result.amplifier.kind == STEPPER
    assert list(result.amplifier.masks) == [1, 2, 3, 4, 5, 6]
    assert (result.amplifier.mask_count, result.amplifier.mask_bits) == (6, 7)
    assert axis({"axis_type": 2, "drive_type": 7}).axis(1).amplifier.kind == TWO_SPEEDS


def test_each_encoder_and_drive_has_its_own_part_of_one_machine() -> None:
    described = AxisParameters(
        1,
        encoder_ids=(1, 2),
        drive_ids=(1, 2),
        elements=[{"encoder_scaling_factor": 0.01, "simulation_time_constant": 0.5}],
    )
    result = Nc(2_000_000, [described], compiled=False).axis(1)
    assert [each.sensor.encoder_resolution for each in result.encoders] == [1e-4, 0.01]
    assert [each.amplifier.time_constant for each in result.drives] == [0.004, 0.5]
    assert {each.sensor.machine for each in result.encoders} == {result.machine}
    with pytest.raises(AxisParametersError, match="no parameter 'simulation_cam_end'"):
        AxisParameters(1, drive_ids=(1, 2), elements=[{"simulation_cam_end": 1.0}])


def test_a_machine_is_where_it_was_and_its_encoders_count_from_0() -> None:
    machine = Hardware(1, 2, 1, compiled=False).build(2, 1)
    machine.sensors[1].encoder_inverted = 1
    place_machine(machine, 2.5)
    assert [sensor.zero for sensor in machine.sensors] == [-25_000.0, 25_000.0]
    assert (machine.position, machine.amplifiers[0].origin) == (2.5, -2.5)


def test_a_drive_counts_from_another_number() -> None:
    machine = Hardware(1, 1, 1, compiled=False).build(1, 1)
    count_from(machine.sensors[0], machine.amplifiers[0], 500)
    assert machine.sensors[0].io.data_in1 == machine.sensors[0].count == 500
    assert machine.amplifiers[0].origin == pytest.approx(0.05)
