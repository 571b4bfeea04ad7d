"""Axis state services, 0x4100 + ID: set values, actual values and the online structure.

Source: 002 §6.4.4.2.
"""

from dataclasses import replace

from achse.devices.nc.binding import in_sub_range, per_element, shown
from achse.devices.nc.controller import CONTROLLER_STATES
from achse.devices.nc.drive import DRIVE_STATES
from achse.devices.nc.encoder import ENCODER_STATES
from achse.devices.nc.layouts import (
    INT32,
    ONLINE_TC2,
    ONLINE_TC3,
    REAL64,
    UINT16,
    UINT32,
    request,
)
from achse.motion import Axis, commands
from achse.server import READ, READ_WRITE, Layout, Service

__all__ = ["AXIS_STATES"]

_ONLINE = Service(
    0x00,
    "axis_online_structure",
    READ,
    (ONLINE_TC2, ONLINE_TC3),
    "online data of the axis, TwinCAT 2 or 3 by length",
    read=lambda axis: axis,
)


def _remaining(axis: Axis) -> tuple[float, float]:
    return axis.remaining_time, axis.remaining_distance


_REMAINING = Service(
    0x14,
    "remaining_time_and_distance",
    READ,
    Layout("<dd"),
    "until the set point arrives: time, distance",
    "s, mm",
    read=_remaining,
    port=501,
)

_OVERRIDE = Service(
    0x17,
    "set_velocity_override",
    READ,
    REAL64,
    "override in force, 1.0 = 100 %",
    "1",
    read=lambda axis: axis.velocity_override / 1e6,
)

_STOP_INFORMATION = Service(
    0x18,
    "stop_information",
    READ_WRITE,
    request(deceleration="d", jerk="d"),
    "distance and time of a stop begun now; 0 is the value of the running command",
    "mm, s",
    exchange=lambda axis, ramp: commands.stop_information(axis, *ramp),
    response=Layout("<dd"),
    port=501,
)

AXIS_STATES = (
    *per_element(
        _ONLINE,
        shown(0x09, UINT32, "set_cycle_counter"),
        shown(0x0A, REAL64, "set_position", symbol="SetPos"),
        shown(0x0B, REAL64, "set_position_modulo", symbol="SetPosModulo"),
        shown(0x0C, INT32, "set_modulo_turns"),
        shown(0x0D, REAL64, "set_direction"),
        shown(0x0E, REAL64, "set_velocity", symbol="SetVelo"),
        shown(0x0F, REAL64, "set_acceleration", symbol="SetAcc"),
        shown(0x10, REAL64, "set_jerk", symbol="SetJerk"),
        shown(0x13, REAL64, "target_position"),
        _REMAINING,
        shown(0x15, UINT32, "set_command_number", symbol="CmdNo"),
        shown(0x16, REAL64, "last_positioning_time"),
        _OVERRIDE,
    ),
    shown(0x01, UINT32, "error_code", symbol="ErrState"),
    _STOP_INFORMATION,
    shown(0x20, UINT32, "coupling_state"),
    shown(0x29, UINT32, "delayed_error_code"),
    shown(0x2E, UINT32, "reset_command_counter"),
    shown(0x50, UINT32, "set_motion_phase"),
    shown(0x51, UINT16, "axis_disabled"),
    # the homed flag can be written at the encoder only
    *(replace(row, access=READ) for row in in_sub_range("encoder_", ENCODER_STATES)),
    *in_sub_range("controller_", CONTROLLER_STATES),
    *in_sub_range("drive_", DRIVE_STATES),
)
