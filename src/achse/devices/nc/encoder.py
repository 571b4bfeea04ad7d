"""Encoder services, 0x5000 and 0x5100 + ID. Source: 002 §6.4.5.

Each axis has one encoder, with the id of the axis. The axis shows the same rows at 0x00n1_0000.
"""

from functools import partial

from achse.devices.nc import binding
from achse.devices.nc.binding import not_while_enabled
from achse.devices.nc.layouts import INT32, INT64, REAL64, UINT16, UINT32, Text
from achse.server import READ, Service

__all__ = ["ENCODER_PARAMETERS", "ENCODER_STATES"]

parameter = partial(binding.parameter, prefix="encoder_")
shown = partial(binding.shown, prefix="encoder_")

ENCODER_PARAMETERS = (
    shown(0x01, UINT32, "encoder_id", "axis_id"),
    Service(0x02, "encoder_name", READ, Text(31), "axis name", read=lambda axis: axis.name),
    parameter(0x06, REAL64, 0x4406, "scaling_factor", guard=not_while_enabled),
    parameter(0x07, REAL64, 0x4407, "position_offset", guard=not_while_enabled),
    parameter(0x08, UINT16, 0x4403, "count_direction", guard=not_while_enabled),
    parameter(0x09, REAL64, 0x4408, "modulo_factor"),
    parameter(0x0B, UINT16, 0x4420, "soft_limit_min_enable"),
    parameter(0x0C, UINT16, 0x4421, "soft_limit_max_enable"),
    parameter(0x0D, REAL64, 0x4423, "soft_limit_min"),
    parameter(0x0E, REAL64, 0x4424, "soft_limit_max"),
    parameter(0x10, REAL64, 0x4409, "position_filter_time"),
    parameter(0x11, REAL64, 0x440A, "velocity_filter_time"),
    parameter(0x12, REAL64, 0x440B, "acceleration_filter_time"),
    parameter(0x1B, REAL64, 0x4417, "modulo_tolerance_window"),
    shown(0x1D, UINT16, "is_absolute"),
)

ENCODER_STATES = (
    shown(0x02, REAL64, "actual_position", symbol="ActPos"),
    shown(0x03, REAL64, "actual_position_modulo", symbol="ActPosModulo"),
    shown(0x04, INT32, "actual_modulo_turns"),
    shown(0x05, REAL64, "actual_velocity", symbol="ActVelo"),
    shown(0x06, REAL64, "actual_acceleration", symbol="ActAcc"),
    shown(0x07, INT32, "hardware_increments"),
    shown(0x08, INT64, "software_increments"),
    parameter(0x09, UINT16, 0x4404, "homed_flag", "homed"),
    shown(0x0B, REAL64, "actual_position_uncorrected", "actual_position"),
    shown(0x10, REAL64, "actual_velocity_uncorrected", "actual_velocity"),
    shown(0x12, REAL64, "actual_position_unfiltered"),
    shown(0x15, REAL64, "actual_velocity_unfiltered"),
    shown(0x17, REAL64, "set_position_offset"),
)
"""There is no position correction, so uncorrected values are the plain ones."""
