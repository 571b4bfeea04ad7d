"""Axis parameter services, 0x4000 + ID. Source: 002 §6.4.4.1."""

from achse.devices.nc.binding import in_sub_range, parameter, shown
from achse.devices.nc.controller import CONTROLLER_PARAMETERS
from achse.devices.nc.drive import DRIVE_PARAMETERS
from achse.devices.nc.encoder import ENCODER_PARAMETERS
from achse.devices.nc.layouts import REAL64, UINT16, UINT32, Text
from achse.server import READ, Service

__all__ = ["AXIS_PARAMETERS"]

AXIS_PARAMETERS = (
    shown(0x01, UINT32, "axis_id"),
    Service(0x02, "axis_name", READ, Text(31), "axis name", read=lambda axis: axis.name),
    Service(0x05, "physical_unit", READ, Text(11), "position unit", read=lambda axis: axis.unit),
    parameter(0x0F, UINT16, 0x4321, "position_range_monitoring_enable"),
    parameter(0x10, REAL64, 0x4326, "position_range_window"),
    parameter(0x11, UINT16, 0x4320, "motion_monitoring_enable"),
    parameter(0x12, REAL64, 0x4324, "motion_monitoring_time"),
    parameter(0x15, UINT16, 0x4322, "target_position_monitoring_enable"),
    parameter(0x16, REAL64, 0x4325, "target_position_window"),
    parameter(0x17, REAL64, 0x4327, "target_position_monitoring_time"),
    parameter(0x1A, UINT32, 0x4003, "error_reaction_mode"),
    parameter(0x1B, REAL64, 0x4003, "error_reaction_delay"),
    parameter(0x27, REAL64, 0x432F, "max_velocity"),
    parameter(0x28, REAL64, 0x4330, "motion_monitoring_window"),
    parameter(0x29, UINT16, 0x4331, "peh_monitoring_enable"),
    parameter(0x2A, REAL64, 0x4332, "peh_monitoring_time"),
    parameter(0xF1, REAL64, 0x4309, "max_acceleration"),
    parameter(0xF2, REAL64, 0x430A, "max_deceleration"),
    parameter(0x101, REAL64, 0x4309, "default_acceleration"),
    parameter(0x102, REAL64, 0x430A, "default_deceleration"),
    parameter(0x103, REAL64, 0x430B, "default_jerk"),
    parameter(0x105, UINT32, 0x430D, "override_type"),
    parameter(0x10B, REAL64, 0x430A, "fast_axis_stop_deceleration"),
    parameter(0x10C, REAL64, 0x430B, "fast_axis_stop_jerk"),
    *in_sub_range("encoder_", ENCODER_PARAMETERS),
    *in_sub_range("controller_", CONTROLLER_PARAMETERS),
    *in_sub_range("drive_", DRIVE_PARAMETERS),
)
