"""The IEC structures of the axis interface have the bytes of its layouts."""

from collections.abc import Callable

import pytest

from achse.client.nc.services import NcLayout
from achse.codes.nc.structures import NC_TO_PLC_STRUCTURE, ONLINE_STRUCTURE
from achse.devices.nc.axes.structures import (
    NC_TO_PLC_TC2,
    NC_TO_PLC_TC3,
    NCTOPLC_AXIS_REF,
    PLC_TO_NC,
    PLCTONC_AXIS_REF,
)
from achse.devices.nc.layouts import ONLINE_TC2, ONLINE_TC3, AxisStructure
from achse.iec import iec_type
from achse.motion import Axis, AxisParameters, Nc


def test_sizes() -> None:
    assert iec_type(NCTOPLC_AXIS_REF).size == NC_TO_PLC_TC3.size == 256
    assert iec_type(PLCTONC_AXIS_REF).size == PLC_TO_NC.size == 128


def test_the_structure_to_the_plc_reads_back(show: Callable[[Axis, str, float], None]) -> None:
    axis = Nc(2_000_000, [AxisParameters(7)], compiled=False).axis(7)
    fields = {
        "state_dword": "StateDWord", "error_code": "ErrorCode", "motion_state": "AxisState",
        "operation_mode_feedback": "AxisModeConfirmation", "homing_state": "HomingState",
        "coupling_state": "CoupleState", "buffer_count": "SafEntries", "axis_id": "AxisId",
        "actual_position": "ActPos",
        "actual_position_modulo": "ModuloActPos", "active_control_loop": "ControlLoopIndex",
        "actual_modulo_turns": "ModuloActTurns", "actual_velocity": "ActVelo",
        "following_error": "PosDiff", "set_position": "SetPos", "set_velocity": "SetVelo",
        "set_acceleration": "SetAcc", "target_position": "TargetPos",
        "set_position_modulo": "ModuloSetPos", "set_modulo_turns": "ModuloSetTurns",
        "set_command_number": "CmdNo", "set_command_state": "CmdState", "set_jerk": "SetJerk",
        "set_torque": "SetTorque", "drive_actual_torque": "ActTorque",
        "drive_actual_torque_derivative": "ActTorqueDerivative",
        "set_torque_derivative": "SetTorqueDerivative", "set_torque_offset": "TorqueOffset",
        "actual_acceleration": "ActAcc",
    }  # fmt: skip
    for value, name in enumerate(fields, 1):
        show(axis, name, value)
    shown = iec_type(NCTOPLC_AXIS_REF).decode(NC_TO_PLC_TC3.encode(axis))
    assert {name: shown[member] for name, member in fields.items()} == {
        name: value for value, name in enumerate(fields, 1)
    }


def test_the_structure_from_the_plc_writes() -> None:
    fields = {
        "ControlDWord": "control_dword", "Override": "velocity_override",
        "AxisModeRequest": "operation_mode", "AxisModeDWord": "operation_mode_dword",
        "AxisModeLReal": "operation_mode_value", "PositionCorrection": "actual_position_correction",
        "ExtSetPos": "external_set_position", "ExtSetVelo": "external_set_velocity",
        "ExtSetAcc": "external_set_acceleration", "ExtSetDirection": "external_set_direction",
        "ExtControllerOutput": "external_controller_component", "GearRatio1": "gear_ratio_1",
        "GearRatio2": "gear_ratio_2", "GearRatio3": "gear_ratio_3", "GearRatio4": "gear_ratio_4",
        "ExtTorque": "external_set_torque",
    }  # fmt: skip
    value = PLCTONC_AXIS_REF({member: n for n, member in enumerate(fields, 1)})
    assert PLC_TO_NC.decode(bytes(value)) == {name: n for n, name in enumerate(fields.values(), 1)}


@pytest.mark.parametrize(
    ("known", "layout"),
    [
        (NC_TO_PLC_TC2, NC_TO_PLC_STRUCTURE.split(" or ")[0]),
        (NC_TO_PLC_TC3, NC_TO_PLC_STRUCTURE.split(" or ")[1]),
        (ONLINE_TC2, ONLINE_STRUCTURE.split(" or ")[0]),
        (ONLINE_TC3, ONLINE_STRUCTURE.split(" or ")[1]),
    ],
)
def test_clients_read_the_values_that_the_axis_shows(known: AxisStructure, layout: str) -> None:
    axis = Nc(2_000_000, [AxisParameters(7)], compiled=False).axis(7)
    axis.control_dword, axis.velocity_override, axis.set_position = 7, 500_000, 12.5
    data = known.encode(axis)
    theirs, ours = known.decode(data), NcLayout(layout).decode(data)
    assert ours == {field: theirs[field] for field in ours}
    assert theirs.keys() == ours.keys()
