"""Axis state services, 0x4100 + ID: set values, actual values and the online structure.

Source: 002 §6.4.4.2.
"""

from achse.devices.nc.axis_functions import STOP_INFORMATION
from achse.devices.nc.binding import in_sub_range, per_element, shown
from achse.devices.nc.elements import CONTROLLER_STATES, DRIVE_STATES, ENCODER_STATES
from achse.devices.nc.layouts import (
    FLAG,
    INT32,
    ONLINE_TC2,
    ONLINE_TC3,
    REAL64,
    UINT32,
    Counter,
)
from achse.server import READ, Layout, Service

__all__ = ["AXIS_STATES"]

_PER_ELEMENT = (
    Service(
        0x00,
        "axis_online_structure",
        READ,
        (ONLINE_TC2, ONLINE_TC3),
        "online data of the axis (NCAXISSTATE_ONLINESTRUCT), TwinCAT 2 or 3 by length",
        read=lambda axis: axis,
    ),
    shown(0x09, "set_cycle_counter", Counter(), "1", "cycles of the axis"),
    shown(0x0A, "set_position", REAL64, "mm", "set position", symbol="SetPos"),
    shown(
        0x0B,
        "set_position_modulo",
        REAL64,
        "degree",
        "set position within its modulo period",
        symbol="SetPosModulo",
    ),
    shown(0x0C, "set_modulo_turns", INT32, "1", "modulo period of the set position"),
    shown(0x0D, "set_direction", REAL64, "1", "direction of travel: -1, 0, 1"),
    shown(0x0E, "set_velocity", REAL64, "mm/s", "set velocity", symbol="SetVelo"),
    shown(0x0F, "set_acceleration", REAL64, "mm/s²", "set acceleration", symbol="SetAcc"),
    shown(0x10, "set_jerk", REAL64, "mm/s³", "set jerk", symbol="SetJerk"),
    shown(0x13, "target_position", REAL64, "mm", "position where the axis will stand"),
    Service(
        0x14,
        "remaining_time_and_distance",
        READ,
        Layout("<dd"),
        "until the set point arrives: time (s), distance",
        "s, mm",
        read=lambda axis: (axis.remaining_time, axis.remaining_distance),
        port=501,
    ),
    shown(0x15, "set_command_number", Counter(), "1", "number of the command", symbol="CmdNo"),
    shown(0x16, "last_positioning_time", REAL64, "s", "last job, from start to target window"),
    Service(
        0x17,
        "set_velocity_override",
        READ,
        REAL64,
        "override in force",
        "%",
        read=lambda axis: axis.velocity_override / 10_000,
    ),
)

AXIS_STATES = (
    *per_element(_PER_ELEMENT),
    STOP_INFORMATION,
    shown(0x01, "error_code", UINT32, "1", "error of the axis, 0 = none", symbol="ErrState"),
    shown(0x20, "coupling_state", UINT32, "1", "0 single, 1 master, 2 both, 3 slave"),
    shown(0x29, "delayed_error_code", UINT32, "1", "error whose reaction is delayed"),
    shown(0x2E, "reset_command_counter", Counter(), "1", "resets so far"),
    shown(0x50, "set_motion_phase", UINT32, "1", "phase of the set-point generator"),
    shown(0x51, "axis_disabled", FLAG, "1", "axis is deactivated"),
    *in_sub_range("encoder_", (row for row in ENCODER_STATES if row.offset != 0x09)),
    *in_sub_range(
        "encoder_", (shown(0x09, "homed_flag", FLAG, "1", "axis is homed", field="homed"),)
    ),
    *in_sub_range("controller_", CONTROLLER_STATES),
    *in_sub_range("drive_", DRIVE_STATES),
)
