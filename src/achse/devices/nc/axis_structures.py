"""The cyclic axis interface: each member of both structures once, with what it shows of the axis.

From one table come the structures as IEC types, for symbols and for programs that look into them,
and the layouts that services send. Names of the members as in the PLC library (004 §5.1) and its
successor; the structure of TwinCAT 2 is packed, has fewer members and two of them elsewhere.
"""

import types
from collections.abc import Sequence
from typing import Any, NamedTuple

from achse.devices.nc.layouts import AxisStructure
from achse.iec import (
    ARRAY,
    BOOL,
    BYTE,
    DINT,
    DWORD,
    LREAL,
    UDINT,
    UINT,
    USINT,
    IecType,
    Struct,
    iec_type,
    var,
)

__all__ = [
    "FROM_PLC",
    "NCTOPLC_AXIS_REF",
    "NC_TO_PLC_TC2",
    "NC_TO_PLC_TC3",
    "PLCTONC_AXIS_REF",
    "PLC_TO_NC",
    "TO_PLC",
    "StructureMember",
]


class StructureMember(NamedTuple):
    """A member of a structure: its name and type, and the record's field, empty for zeros."""

    name: str
    type: Any
    field: str
    field_tc2: str = ""
    """What TwinCAT 2 shows instead."""


TO_PLC = (
    StructureMember("StateDWord", DWORD, "state_dword"),
    StructureMember("ErrorCode", DWORD, "error_code"),
    StructureMember("AxisState", DWORD, "motion_state"),
    StructureMember("AxisModeConfirmation", DWORD, "operation_mode_feedback"),
    StructureMember("HomingState", DWORD, "homing_state"),
    StructureMember("CoupleState", DWORD, "coupling_state"),
    StructureMember("SvbEntries", DWORD, ""),  # a single axis has no preparation table
    StructureMember("SafEntries", DWORD, "buffer_count"),
    StructureMember("AxisId", DWORD, "axis_id"),
    StructureMember("OpModeDWord", DWORD, "operation_mode_and_cycle", "operation_mode_state_dword"),
    StructureMember("ActPos", LREAL, "actual_position"),
    StructureMember("ModuloActPos", LREAL, "actual_position_modulo"),
    StructureMember("ActiveControlLoopIndex", UINT, "active_control_loop"),
    StructureMember(
        "ControlLoopIndex", UINT, "active_control_loop"
    ),  # a switch is carried out at once
    StructureMember("ModuloActTurns", DINT, "actual_modulo_turns"),
    StructureMember("ActVelo", LREAL, "actual_velocity"),
    StructureMember("PosDiff", LREAL, "following_error"),
    StructureMember("SetPos", LREAL, "set_position"),
    StructureMember("SetVelo", LREAL, "set_velocity"),
    StructureMember("SetAcc", LREAL, "set_acceleration"),
    StructureMember("TargetPos", LREAL, "target_position"),
    StructureMember("ModuloSetPos", LREAL, "set_position_modulo"),
    StructureMember("ModuloSetTurns", DINT, "set_modulo_turns"),
    StructureMember("CmdNo", UINT, "set_command_number"),
    StructureMember("CmdState", UINT, "set_command_state"),
    StructureMember("SetJerk", LREAL, "set_jerk"),
    StructureMember("SetTorque", LREAL, "set_torque"),
    StructureMember("ActTorque", LREAL, "drive_actual_torque"),
    StructureMember("StateDWord2", DWORD, ""),  # avoiding collision, for movers on one track
    StructureMember("StateDWord3", DWORD, "touch_probe_inputs"),
    StructureMember("TouchProbeState", DWORD, "touch_probe_status"),
    StructureMember("TouchProbeCounter", DWORD, "touch_probe_counters"),
    StructureMember("CamCouplingState", ARRAY(USINT, (0, 7)), ""),
    StructureMember("CamCouplingTableID", ARRAY(UINT, (0, 7)), ""),
    StructureMember("ActTorqueDerivative", LREAL, "drive_actual_torque_derivative"),
    StructureMember("SetTorqueDerivative", LREAL, "set_torque_derivative"),
    StructureMember("AbsPhasingPos", LREAL, "phasing_position"),
    StructureMember("TorqueOffset", LREAL, "set_torque_offset"),
    StructureMember("ActPosWithoutPosCorrection", LREAL, "actual_position_uncorrected"),
    StructureMember("ActAcc", LREAL, "actual_acceleration"),
    StructureMember("DcTimeStamp", UDINT, "dc_time_stamp"),
    StructureMember("UserData", LREAL, "user_data"),
)
"""What the NC shows the PLC in each cycle."""

FROM_PLC = (
    StructureMember("ControlDWord", DWORD, "control_dword"),
    StructureMember("Override", UDINT, "velocity_override"),
    StructureMember("AxisModeRequest", DWORD, "operation_mode"),
    StructureMember("AxisModeDWord", DWORD, "operation_mode_dword"),
    StructureMember("AxisModeLReal", LREAL, "operation_mode_value"),
    StructureMember("PositionCorrection", LREAL, "actual_position_correction"),
    StructureMember("ExtSetPos", LREAL, "external_set_position"),
    StructureMember("ExtSetVelo", LREAL, "external_set_velocity"),
    StructureMember("ExtSetAcc", LREAL, "external_set_acceleration"),
    StructureMember("ExtSetDirection", DINT, "external_set_direction"),
    StructureMember("ExtControllerOutput", LREAL, "external_controller_component"),
    StructureMember("GearRatio1", LREAL, "gear_ratio_1"),
    StructureMember("GearRatio2", LREAL, "gear_ratio_2"),
    StructureMember("GearRatio3", LREAL, "gear_ratio_3"),
    StructureMember("GearRatio4", LREAL, "gear_ratio_4"),
    StructureMember("MapState", BOOL, ""),  # this and the next two: between a PLC and its NC
    StructureMember("PlcCycleControl", BYTE, ""),
    StructureMember("PlcCycleCount", BYTE, ""),
    StructureMember("ExtTorque", LREAL, "external_set_torque"),
    StructureMember("Reserved", ARRAY(BYTE, (0, 7)), ""),
)
"""What the PLC gives the NC in each cycle; the last 24 bytes are reserved in TwinCAT 2."""


def _declared(name: str, members: Sequence[StructureMember], doc: str) -> type[Struct]:
    body = {member.name: var(member.type) for member in members}
    return types.new_class(
        name, (Struct,), exec_body=lambda space: space.update({"__doc__": doc} | body)
    )


NCTOPLC_AXIS_REF = _declared("NCTOPLC_AXIS_REF", TO_PLC, "What the NC shows the PLC, 256 bytes.")
PLCTONC_AXIS_REF = _declared("PLCTONC_AXIS_REF", FROM_PLC, "What the PLC gives the NC, 128 bytes.")

_CODES: dict[IecType[Any], str] = {DWORD: "I", UDINT: "I", DINT: "i", LREAL: "d", UINT: "H"}


def _fields(members: Sequence[StructureMember]) -> tuple[tuple[str, str], ...]:
    return tuple(
        (_CODES[member.type] if member.field else f"{iec_type(member.type).size}x", member.field)
        for member in members
    )


def _tc2() -> list[StructureMember]:
    """The members of TwinCAT 2: up to CmdState, the control loops before the positions."""
    names = [member.name for member in TO_PLC]
    positions, loops, turns = map(
        names.index, ("ActPos", "ActiveControlLoopIndex", "ModuloActTurns")
    )
    order = (
        *TO_PLC[:positions],
        *TO_PLC[loops:turns],
        *TO_PLC[positions:loops],
        *TO_PLC[turns : names.index("SetJerk")],
    )
    return [member._replace(field=member.field_tc2 or member.field) for member in order]


NC_TO_PLC_TC2 = AxisStructure("NCTOPLC_AXIS_REF", _fields(_tc2()), aligned=False, size=128)
NC_TO_PLC_TC3 = AxisStructure("NCTOPLC_AXIS_REF", _fields(TO_PLC), aligned=True, size=256)
PLC_TO_NC = AxisStructure("PLCTONC_AXIS_REF", _fields(FROM_PLC), aligned=True, size=128)
