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
    "Member",
]


class Member(NamedTuple):
    """A member of a structure: its name and type, and the record's field, empty for zeros."""

    name: str
    type: Any
    field: str
    field_tc2: str = ""
    """What TwinCAT 2 shows instead."""


TO_PLC = (
    Member("StateDWord", DWORD, "state_dword"),
    Member("ErrorCode", DWORD, "error_code"),
    Member("AxisState", DWORD, "motion_state"),
    Member("AxisModeConfirmation", DWORD, "operation_mode_feedback"),
    Member("HomingState", DWORD, "homing_state"),
    Member("CoupleState", DWORD, "coupling_state"),
    Member("SvbEntries", DWORD, ""),  # a single axis has no preparation table
    Member("SafEntries", DWORD, "buffer_count"),
    Member("AxisId", DWORD, "axis_id"),
    Member("OpModeDWord", DWORD, "operation_mode_and_cycle", "operation_mode_state_dword"),
    Member("ActPos", LREAL, "actual_position"),
    Member("ModuloActPos", LREAL, "actual_position_modulo"),
    Member("ActiveControlLoopIndex", UINT, "active_control_loop"),
    Member("ControlLoopIndex", UINT, "active_control_loop"),  # a switch is carried out at once
    Member("ModuloActTurns", DINT, "actual_modulo_turns"),
    Member("ActVelo", LREAL, "actual_velocity"),
    Member("PosDiff", LREAL, "following_error"),
    Member("SetPos", LREAL, "set_position"),
    Member("SetVelo", LREAL, "set_velocity"),
    Member("SetAcc", LREAL, "set_acceleration"),
    Member("TargetPos", LREAL, "target_position"),
    Member("ModuloSetPos", LREAL, "set_position_modulo"),
    Member("ModuloSetTurns", DINT, "set_modulo_turns"),
    Member("CmdNo", UINT, "set_command_number"),
    Member("CmdState", UINT, "set_command_state"),
    Member("SetJerk", LREAL, "set_jerk"),
    Member("SetTorque", LREAL, "set_torque"),
    Member("ActTorque", LREAL, "drive_actual_torque"),
    Member("StateDWord2", DWORD, ""),  # avoiding collision, for movers on one track
    Member("StateDWord3", DWORD, "touch_probe_inputs"),
    Member("TouchProbeState", DWORD, "touch_probe_status"),
    Member("TouchProbeCounter", DWORD, "touch_probe_counters"),
    Member("CamCouplingState", ARRAY(USINT, (0, 7)), ""),
    Member("CamCouplingTableID", ARRAY(UINT, (0, 7)), ""),
    Member("ActTorqueDerivative", LREAL, "drive_actual_torque_derivative"),
    Member("SetTorqueDerivative", LREAL, "set_torque_derivative"),
    Member("AbsPhasingPos", LREAL, "phasing_position"),
    Member("TorqueOffset", LREAL, "set_torque_offset"),
    Member("ActPosWithoutPosCorrection", LREAL, "actual_position_uncorrected"),
    Member("ActAcc", LREAL, "actual_acceleration"),
    Member("DcTimeStamp", UDINT, "dc_time_stamp"),
    Member("UserData", LREAL, "user_data"),
)
"""What the NC shows the PLC in each cycle."""

FROM_PLC = (
    Member("ControlDWord", DWORD, "control_dword"),
    Member("Override", UDINT, "velocity_override"),
    Member("AxisModeRequest", DWORD, "operation_mode"),
    Member("AxisModeDWord", DWORD, "operation_mode_dword"),
    Member("AxisModeLReal", LREAL, "operation_mode_value"),
    Member("PositionCorrection", LREAL, "actual_position_correction"),
    Member("ExtSetPos", LREAL, "external_set_position"),
    Member("ExtSetVelo", LREAL, "external_set_velocity"),
    Member("ExtSetAcc", LREAL, "external_set_acceleration"),
    Member("ExtSetDirection", DINT, "external_set_direction"),
    Member("ExtControllerOutput", LREAL, "external_controller_component"),
    Member("GearRatio1", LREAL, "gear_ratio_1"),
    Member("GearRatio2", LREAL, "gear_ratio_2"),
    Member("GearRatio3", LREAL, "gear_ratio_3"),
    Member("GearRatio4", LREAL, "gear_ratio_4"),
    Member("MapState", BOOL, ""),  # this and the next two: between a PLC and its NC
    Member("PlcCycleControl", BYTE, ""),
    Member("PlcCycleCount", BYTE, ""),
    Member("ExtTorque", LREAL, "external_set_torque"),
    Member("Reserved", ARRAY(BYTE, (0, 7)), ""),
)
"""What the PLC gives the NC in each cycle; the last 24 bytes are reserved in TwinCAT 2."""


def _declared(name: str, members: Sequence[Member], doc: str) -> type[Struct]:
    body = {member.name: var(member.type) for member in members}
    return types.new_class(
        name, (Struct,), exec_body=lambda space: space.update({"__doc__": doc} | body)
    )


NCTOPLC_AXIS_REF = _declared("NCTOPLC_AXIS_REF", TO_PLC, "What the NC shows the PLC, 256 bytes.")
PLCTONC_AXIS_REF = _declared("PLCTONC_AXIS_REF", FROM_PLC, "What the PLC gives the NC, 128 bytes.")

_CODES: dict[IecType[Any], str] = {DWORD: "I", UDINT: "I", DINT: "i", LREAL: "d", UINT: "H"}


def _fields(members: Sequence[Member]) -> tuple[tuple[str, str], ...]:
    return tuple(
        (_CODES[member.type] if member.field else f"{iec_type(member.type).size}x", member.field)
        for member in members
    )


def _tc2() -> list[Member]:
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
