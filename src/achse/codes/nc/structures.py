"""Structures of an axis: the online data, and the cyclic interface with what its members show.

From the members come the structures as IEC types, for symbols and PLC programs, the layouts that
services send, and what clients read in them. Names of the members as in the PLC library (004 §5.1)
and its successor; the structure of TwinCAT 2 is packed, has fewer members and two elsewhere.
"""

from collections.abc import Iterable
from typing import NamedTuple


class StructureMember(NamedTuple):
    """A member of a structure: its name, its IEC type, the value it shows; no value: zeros."""

    name: str
    type: str
    field: str
    field_tc2: str = ""
    """Value in TwinCAT 2, if another."""
    elements: int = 1
    """Elements of an array."""


TO_PLC = (
    StructureMember("StateDWord", "DWORD", "state_dword"),
    StructureMember("ErrorCode", "DWORD", "error_code"),
    StructureMember("AxisState", "DWORD", "motion_state"),
    StructureMember("AxisModeConfirmation", "DWORD", "operation_mode_feedback"),
    StructureMember("HomingState", "DWORD", "homing_state"),
    StructureMember("CoupleState", "DWORD", "coupling_state"),
    StructureMember("SvbEntries", "DWORD", ""),  # a single axis has no preparation table
    StructureMember("SafEntries", "DWORD", "buffer_count"),
    StructureMember("AxisId", "DWORD", "axis_id"),
    StructureMember(
        "OpModeDWord", "DWORD", "operation_mode_and_cycle", "operation_mode_state_dword"
    ),
    StructureMember("ActPos", "LREAL", "actual_position"),
    StructureMember("ModuloActPos", "LREAL", "actual_position_modulo"),
    StructureMember("ActiveControlLoopIndex", "UINT", "active_control_loop"),
    StructureMember(
        "ControlLoopIndex", "UINT", "active_control_loop"
    ),  # a switch is carried out at once
    StructureMember("ModuloActTurns", "DINT", "actual_modulo_turns"),
    StructureMember("ActVelo", "LREAL", "actual_velocity"),
    StructureMember("PosDiff", "LREAL", "following_error"),
    StructureMember("SetPos", "LREAL", "set_position"),
    StructureMember("SetVelo", "LREAL", "set_velocity"),
    StructureMember("SetAcc", "LREAL", "set_acceleration"),
    StructureMember("TargetPos", "LREAL", "target_position"),
    StructureMember("ModuloSetPos", "LREAL", "set_position_modulo"),
    StructureMember("ModuloSetTurns", "DINT", "set_modulo_turns"),
    StructureMember("CmdNo", "UINT", "set_command_number"),
    StructureMember("CmdState", "UINT", "set_command_state"),
    StructureMember("SetJerk", "LREAL", "set_jerk"),
    StructureMember("SetTorque", "LREAL", "set_torque"),
    StructureMember("ActTorque", "LREAL", "drive_actual_torque"),
    StructureMember("StateDWord2", "DWORD", ""),  # avoiding collision, for movers on one track
    StructureMember("StateDWord3", "DWORD", "touch_probe_inputs"),
    StructureMember("TouchProbeState", "DWORD", "touch_probe_status"),
    StructureMember("TouchProbeCounter", "DWORD", "touch_probe_counters"),
    StructureMember("CamCouplingState", "USINT", "", elements=8),
    StructureMember("CamCouplingTableID", "UINT", "", elements=8),
    StructureMember("ActTorqueDerivative", "LREAL", "drive_actual_torque_derivative"),
    StructureMember("SetTorqueDerivative", "LREAL", "set_torque_derivative"),
    StructureMember("AbsPhasingPos", "LREAL", "phasing_position"),
    StructureMember("TorqueOffset", "LREAL", "set_torque_offset"),
    StructureMember("ActPosWithoutPosCorrection", "LREAL", "actual_position_uncorrected"),
    StructureMember("ActAcc", "LREAL", "actual_acceleration"),
    StructureMember("DcTimeStamp", "UDINT", "dc_time_stamp"),
    StructureMember("UserData", "LREAL", "user_data"),
)
"""Members that the NC shows the PLC in each cycle."""

FROM_PLC = (
    StructureMember("ControlDWord", "DWORD", "control_dword"),
    StructureMember("Override", "UDINT", "velocity_override"),
    StructureMember("AxisModeRequest", "DWORD", "operation_mode"),
    StructureMember("AxisModeDWord", "DWORD", "operation_mode_dword"),
    StructureMember("AxisModeLReal", "LREAL", "operation_mode_value"),
    StructureMember("PositionCorrection", "LREAL", "actual_position_correction"),
    StructureMember("ExtSetPos", "LREAL", "external_set_position"),
    StructureMember("ExtSetVelo", "LREAL", "external_set_velocity"),
    StructureMember("ExtSetAcc", "LREAL", "external_set_acceleration"),
    StructureMember("ExtSetDirection", "DINT", "external_set_direction"),
    StructureMember("ExtControllerOutput", "LREAL", "external_controller_component"),
    StructureMember("GearRatio1", "LREAL", "gear_ratio_1"),
    StructureMember("GearRatio2", "LREAL", "gear_ratio_2"),
    StructureMember("GearRatio3", "LREAL", "gear_ratio_3"),
    StructureMember("GearRatio4", "LREAL", "gear_ratio_4"),
    StructureMember("MapState", "BOOL", ""),  # this and the next two: between a PLC and its NC
    StructureMember("PlcCycleControl", "BYTE", ""),
    StructureMember("PlcCycleCount", "BYTE", ""),
    StructureMember("ExtTorque", "LREAL", "external_set_torque"),
    StructureMember("Reserved", "BYTE", "", elements=8),
)
"""Members that the PLC gives the NC in each cycle; the last 24 bytes are reserved in TwinCAT 2."""


def _tc2() -> tuple[StructureMember, ...]:
    """Return the members of TwinCAT 2: up to CmdState, the control loops before the positions."""
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
    return tuple(member._replace(field=member.field_tc2 or member.field) for member in order)


TO_PLC_TC2 = _tc2()
"""Members in the order of TwinCAT 2."""

_SIZES = {"DINT": ("INT32", 4), "LREAL": ("REAL64", 8), "UINT": ("UINT16", 2)}
_WORD = ("UINT32", 4)
_BYTES = {"BOOL": 1, "BYTE": 1, "USINT": 1}


def _layout(members: Iterable[StructureMember], size: int, *, aligned: bool) -> str:
    """Return the layout in `size` bytes; a value that is there twice has its name at its first
    place."""
    parts: list[str] = []
    named: set[str] = set()
    end = gap = 0
    for member in members:
        width = _BYTES.get(member.type, 0)
        kind, width = ("", width) if width else _SIZES.get(member.type, _WORD)
        if aligned:
            gap += -end % width
            end += -end % width
        end += width * member.elements
        if member.field and member.field not in named:
            parts += [f"{gap} unused"] * bool(gap) + [f"{member.field}:{kind}"]
            named.add(member.field)
            gap = 0
        else:
            gap += width * member.elements
    gap += size - end
    return "{" + "; ".join(parts + [f"{gap} unused"] * bool(gap)) + "}"


def _values(*members: str) -> tuple[StructureMember, ...]:
    pairs = (member.split() for member in members)
    return tuple(StructureMember("", type, field) for type, field in pairs)


ONLINE_TC2 = _values(
    "DINT error_code",
    "LREAL actual_position",
    "LREAL actual_position_modulo",
    "LREAL set_position",
    "LREAL set_position_modulo",
    "LREAL actual_velocity",
    "LREAL set_velocity",
    "UDINT velocity_override",
    "LREAL following_error",
    "LREAL following_error_peak_negative",
    "LREAL following_error_peak_positive",
    "LREAL controller_output_percent",
    "LREAL drive_output_percent",
    "UDINT state_dword",
    "UDINT control_dword",
    "UDINT coupling_state",
    "UDINT active_control_loop",
)
"""Online data of an axis in TwinCAT 2, packed."""

ONLINE_TC3 = (
    *ONLINE_TC2,
    *_values(
        "LREAL actual_acceleration",
        "LREAL set_acceleration",
        "LREAL set_jerk",
        "LREAL set_torque",
        "LREAL drive_actual_torque",
        "LREAL set_torque_derivative",
        "LREAL set_torque_offset",
    ),
)
"""Online data of an axis in TwinCAT 3, aligned."""

ONLINE_STRUCTURE = " or ".join(
    (_layout(ONLINE_TC2, 112, aligned=False), _layout(ONLINE_TC3, 256, aligned=True))
)
NC_TO_PLC_STRUCTURE = " or ".join(
    (_layout(TO_PLC_TC2, 128, aligned=False), _layout(TO_PLC, 256, aligned=True))
)
