"""The homing command: what forbids it, and homing by the application."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import OperationModeBit, StateBit, commands


@pytest.mark.parametrize(
    ("values", "error"),
    [
        ({"encoder_is_absolute": 1}, NcError.FUNCTION_NOT_ALLOWED),
        (
            {"homing_velocity_towards_cam": 3000.0},
            NcError.AXIS_HOMING_VELOCITY_TOWARDS_CAM,
        ),
        ({"homing_velocity_off_cam": 3000.0}, NcError.AXIS_HOMING_VELOCITY_OFF_CAM),
        ({"drive_operation_mode": 1}, NcError.FUNCTION_NOT_AVAILABLE),
        ({"control_dword": 0}, NcError.CONTROLLER_ENABLE_MISSING),
        ({"control_dword": 3}, NcError.ENABLE_MISSING),
        ({"control_dword": 5}, NcError.ENABLE_MISSING),
        ({"simulation_not_ready": 1}, NcError.DRIVE_NOT_READY_AT_START),
    ],
)
def test_what_forbids_homing(make_rig: Any, values: Any, error: NcError) -> None:
    rig = make_rig(**values)
    rig.refuses(error, commands.home)


def test_there_is_no_homing_without_a_reference_mode(rig: Any) -> None:
    rig.axis.encoder.reference_mode = 0  # 002: not defined, what an axis has by default
    rig.refuses(NcError.ENCODER_REFERENCE_MODE, commands.home)


def test_homing_is_refused_while_the_axis_moves_or_is_in_error(rig: Any) -> None:
    commands.start(rig.axis, 1, 10.0, 10.0)
    rig.refuses(NcError.GROUP_BUSY, commands.home)
    commands.set_external_error(rig.axis, 0x4655)
    rig.until_rest()
    assert commands.home(rig.axis) == 0x4655


def test_a_latch_in_use_is_not_taken_away(make_rig: Any) -> None:
    rig = make_rig(encoder_reference_mode=3)
    commands.activate_touch_probe(rig.axis, 1, 1, 1, 1)
    rig.refuses(NcError.ENCODER_HARDWARE_LATCH, commands.home)
    rig.axis.encoder.reference_mode = 2
    assert commands.home(rig.axis) == 0


def test_a_probe_waits_for_homing_to_let_its_latch_go(make_rig: Any) -> None:
    rig = make_rig(encoder_reference_mode=3, simulation_cam_end=1.0)
    commands.home(rig.axis)
    rig.until(lambda axis: axis.homing_state == 5)
    rig.refuses(NcError.ENCODER_EXTERNAL_LATCH, commands.activate_touch_probe, 1, 0, 1, 1)
    assert commands.activate_touch_probe(rig.axis, 2, 0, 1, 2) == 0


def test_homing_is_a_command_with_a_number(rig: Any) -> None:
    number = rig.axis.command_counter
    commands.home(rig.axis)
    assert rig.axis.set_command_number == number + 1
    rig.until(lambda axis: axis.homing_state == 0)
    assert rig.axis.set_command_state == 3


def test_the_application_is_requested_to_home(make_rig: Any) -> None:
    rig = make_rig(encoder_reference_mode=20, control_dword=0)
    axis = rig.axis
    for number in (1, 2):
        assert commands.home(axis) == 0
        assert axis.application_command_number == number
    assert (axis.application_request, axis.application_request_type) == (1, 1)
    rig.run(1)
    assert axis.operation_mode_state_dword & OperationModeBit.APPLICATION_REQUEST
    assert not rig.has(StateBit.HOMING_BUSY)
    commands.set_homing_state(axis, 2)
    rig.run(1)
    assert rig.has(StateBit.HOMING_BUSY)
    commands.set_actual_position(axis, 1, 12.0)
    commands.set_homed_flag(axis, 1)
    commands.set_homing_state(axis, 0)
    rig.run(1)
    assert (axis.application_request, axis.application_request_type) == (0, 0)
    assert not axis.operation_mode_state_dword & OperationModeBit.APPLICATION_REQUEST
    assert rig.has(StateBit.HOMED)
    assert not rig.has(StateBit.HOMING_BUSY)
    assert axis.actual_position == 12.0


@pytest.mark.parametrize("end", [lambda axis: commands.set_homing_state(axis, 0), commands.reset])
def test_what_else_ends_the_request(make_rig: Any, end: Any) -> None:
    rig = make_rig(encoder_reference_mode=20)
    commands.home(rig.axis)
    end(rig.axis)
    assert rig.axis.application_request == 0


def test_the_steps_of_the_nc_are_its_own(rig: Any) -> None:
    commands.home(rig.axis)
    rig.seconds(0.1)
    rig.refuses(NcError.GROUP_BUSY, commands.set_homing_state, 0)


def test_an_axis_that_is_led_from_outside_does_not_home(rig: Any) -> None:
    assert commands.start_external_setpoint(rig.axis, 1, 0.0) == 0
    rig.axis.allow_motion_commands_with_external_setpoint = 1
    rig.refuses(NcError.EXTERNAL_GENERATOR_ACTIVE, commands.home)
