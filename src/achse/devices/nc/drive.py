"""Drive services, 0x7000 and 0x7100 + ID. Source: 002 §6.4.7.

Each axis has one drive, with the id of the axis. The axis shows the same rows at 0x00n3_0000.
"""

from functools import partial

from achse.devices.nc import binding
from achse.devices.nc.binding import not_while_enabled
from achse.devices.nc.layouts import REAL64, UINT16, UINT32, Text
from achse.server import READ, Service

__all__ = ["DRIVE_PARAMETERS", "DRIVE_STATES"]

parameter = partial(binding.parameter, prefix="drive_")
shown = partial(binding.shown, prefix="drive_")

DRIVE_PARAMETERS = (
    shown(0x01, UINT32, "drive_id", "axis_id"),
    Service(0x02, "drive_name", READ, Text(31), "axis name", read=lambda axis: axis.name),
    parameter(0x06, UINT16, 0x4603, "motor_polarity", guard=not_while_enabled),
    parameter(0x0B, REAL64, 0x460A, "output_limit_min"),
    parameter(0x0C, REAL64, 0x460A, "output_limit_max"),
    parameter(0x101, REAL64, 0x4605, "reference_velocity"),
    shown(0x103, REAL64, "velocity_at_full_output", "drive_reference_velocity"),
)

DRIVE_STATES = (
    shown(0x02, REAL64, "output_absolute", "drive_output", symbol="DriveOutput"),
    shown(0x03, REAL64, "output_percent"),
    shown(0x05, REAL64, "output_peak_negative"),
    shown(0x06, REAL64, "output_peak_positive"),
)
