"""Controller services, 0x6000 and 0x6100 + ID. Source: 002 §6.4.6.

Each axis has one controller, with the id of the axis. The axis shows the same rows at 0x00n2_0000.
"""

from functools import partial

from achse.devices.nc import binding
from achse.devices.nc.layouts import REAL64, UINT16, UINT32, Text
from achse.server import READ, Service

__all__ = ["CONTROLLER_PARAMETERS", "CONTROLLER_STATES"]

parameter = partial(binding.parameter, prefix="controller_")
shown = partial(binding.shown, prefix="controller_")

CONTROLLER_PARAMETERS = (
    shown(0x01, UINT32, "controller_id", "axis_id"),
    Service(0x02, "controller_name", READ, Text(31), "axis name", read=lambda axis: axis.name),
    parameter(0x0B, REAL64, 0x4503, "velocity_feedforward_weight"),
    parameter(0x10, UINT16, 0x4504, "following_error_position_monitoring_enable"),
    parameter(0x11, UINT16, 0x4505, "following_error_velocity_monitoring_enable"),
    parameter(0x12, REAL64, 0x4506, "following_error_position_max"),
    parameter(0x13, REAL64, 0x4507, "following_error_position_filter_time"),
    parameter(0x14, REAL64, 0x4508, "following_error_velocity_max"),
    parameter(0x15, REAL64, 0x4509, "following_error_velocity_filter_time"),
    parameter(0x100, REAL64, 0x4003, "output_limit"),
    parameter(0x102, REAL64, 0x4510, "position_kv"),
    parameter(0x10D, REAL64, 0x451D, "position_dead_band"),
)

CONTROLLER_STATES = (
    shown(0x02, REAL64, "output_absolute", "controller_output", symbol="CtrlOutput"),
    shown(0x03, REAL64, "output_percent"),
    shown(0x0D, REAL64, "following_error_position_uncompensated", "following_error"),
    shown(0x0F, REAL64, "following_error_position", "following_error", symbol="PosDiff"),
    shown(0x10, REAL64, "following_error_peak_negative"),
    shown(0x11, REAL64, "following_error_peak_positive"),
    shown(0x12, REAL64, "following_error_velocity"),
)
"""There is no dead-time compensation, so the uncompensated following error is the plain one."""
