"""Axis parameter services, 0x4000 + ID. Source: 002 §6.4.4.1."""

from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.binding import parameter, per_element, shown
from achse.devices.nc.controller import CONTROLLER_VIEWS
from achse.devices.nc.drive import DRIVE_VIEWS
from achse.devices.nc.encoder import ENCODER_VIEWS
from achse.devices.nc.groups.every import OWNERS_OF_AXIS
from achse.devices.nc.layouts import REAL64, UINT16, UINT32, OfAxis, Text
from achse.devices.nc.parameter_set import LongParameterSet, ShortParameterSet
from achse.motion import Axis
from achse.server import READ, Layout, Service

__all__ = ["AXIS_PARAMETERS"]

MOST_ELEMENTS = 9
USER_DATA_STATES = (0, 0x1_0012, 0x1_0014, 0x1_0017)


def _ids(axis: Axis) -> tuple[int, ...]:
    every = axis.encoder_ids, axis.controller_ids, axis.drive_ids
    return tuple(id for ids in every for id in (*ids, *(0,) * (MOST_ELEMENTS - len(ids))))


def _hardware(axis: Axis) -> tuple[Any, ...]:
    """NetId, port, channel of a drive on a bus; all zero where the hardware is simulated."""
    return axis.hardware_address


def _hardware_extended(axis: Axis) -> tuple[Any, ...]:
    """The same with ids, indices and types; there are no object ids."""
    n = axis.active_control_loop
    encoder = axis.encoder_ids[min(n, len(axis.encoder_ids) - 1)]
    drive = axis.drive_ids[min(n, len(axis.drive_ids) - 1)]
    drive_part = drive, n, axis.drive.type
    encoder_part = encoder, n, axis.encoder.type
    return *axis.hardware_address, *drive_part, *encoder_part, axis.axis_id, axis.axis_type, 0, 0


def _text(offset: int, name: str, size: int, attribute: str, description: str) -> Service:
    return Service(offset, name, READ, Text(size), description, read=attrgetter(attribute))


def _optional(offset: int, error: int, name: str, least: float) -> Service:
    """A parameter that is 0, not given, or at least `least`."""

    def write(axis: Axis, value: float) -> None:
        if 0.0 < value < least:
            raise DeviceError(error, f"{name} = {value:g}, expected 0 or at least {least:g}")
        setattr(axis, name, value)

    return parameter(offset, REAL64, error, name, write=write)


_OWN = (
    shown(0x01, UINT32, "axis_id"),
    _text(0x02, "axis_name", 31, "name", "axis name"),
    shown(0x03, UINT32, "axis_type"),
    Service(
        0x04, "saf_cycle_time", READ, UINT32, "cycle time of the axis", "µs",
        read=lambda axis: axis.cycle_ns // 1000,
    ),
    _text(0x05, "physical_unit", 11, "unit", "position unit"),
    parameter(
        0x06, REAL64, NcError.AXIS_HOMING_VELOCITY_TOWARDS_CAM, "homing_velocity_towards_cam"
    ),
    parameter(0x07, REAL64, NcError.AXIS_HOMING_VELOCITY_OFF_CAM, "homing_velocity_off_cam"),
    parameter(0x08, REAL64, NcError.AXIS_JOG_VELOCITY_SLOW, "jog_velocity_slow"),
    parameter(0x09, REAL64, NcError.AXIS_JOG_VELOCITY_FAST, "jog_velocity_fast"),
    parameter(0x0A, REAL64, NcError.AXIS_RAPID_VELOCITY, "rapid_traverse_velocity"),
    parameter(
        0x0F, UINT16, NcError.AXIS_POSITION_WINDOW_MONITORING, "position_range_monitoring_enable"
    ),
    parameter(0x10, REAL64, NcError.AXIS_POSITION_WINDOW, "position_range_window"),
    parameter(0x11, UINT16, NcError.AXIS_MOTION_MONITORING, "motion_monitoring_enable"),
    parameter(0x12, REAL64, NcError.AXIS_MOTION_MONITORING_TIME, "motion_monitoring_time"),
    parameter(0x13, UINT16, NcError.AXIS_LOOP, "loop_enable"),
    parameter(0x14, REAL64, NcError.AXIS_LOOP_DISTANCE, "loop_distance"),
    parameter(
        0x15, UINT16, NcError.AXIS_TARGET_WINDOW_MONITORING, "target_position_monitoring_enable"
    ),
    parameter(0x16, REAL64, NcError.AXIS_TARGET_WINDOW, "target_position_window"),
    parameter(0x17, REAL64, NcError.AXIS_TARGET_WINDOW_TIME, "target_position_monitoring_time"),
    parameter(0x18, REAL64, NcError.REQUEST_PARAMETER, "pulse_distance_positive"),
    parameter(0x19, REAL64, NcError.REQUEST_PARAMETER, "pulse_distance_negative"),
    parameter(0x1A, UINT32, NcError.REQUEST_PARAMETER, "error_reaction_mode"),
    parameter(0x1B, REAL64, NcError.REQUEST_PARAMETER, "error_reaction_delay"),
    parameter(0x1C, UINT16, NcError.REQUEST_PARAMETER, "couple_slaves_by_actual_values"),
    _optional(0x1D, NcError.AXIS_ACCELERATION, "fading_acceleration", 0.01),
    parameter(0x1E, UINT32, NcError.REQUEST_PARAMETER, "fast_axis_stop_signal_type"),
    parameter(0x20, UINT16, NcError.REQUEST_PARAMETER, "allow_slave_motion_commands"),
    parameter(
        0x21, UINT16, NcError.REQUEST_PARAMETER, "allow_motion_commands_with_external_setpoint"
    ),
    parameter(0x26, UINT32, NcError.AXIS_UNIT_INTERPRETATION, "unit_interpretation"),
    parameter(0x27, REAL64, NcError.AXIS_MAX_VELOCITY, "max_velocity"),
    parameter(0x28, REAL64, NcError.AXIS_MOTION_MONITORING_WINDOW, "motion_monitoring_window"),
    parameter(0x29, UINT16, NcError.AXIS_PEH_MONITORING, "peh_monitoring_enable"),
    parameter(0x2A, REAL64, NcError.AXIS_PEH_TIME, "peh_monitoring_time"),
    parameter(0x2B, UINT16, NcError.REQUEST_PARAMETER, "backlash_compensation_enable"),
    parameter(0x2C, REAL64, NcError.REQUEST_PARAMETER, "backlash"),
    shown(0x30, UINT16, "persistent_data_enable"),
    Service(
        0x31, "hardware_ams_address", READ,
        (
            OfAxis(Layout("<6sHH"), _hardware),
            OfAxis(Layout("<6sHH2x3I3I2I2I12x"), _hardware_extended),
        ),
        "AMS address of the hardware; the long form has ids and types too",
        read=lambda axis: axis,
    ),
    Service(
        0x33, "application_request", READ, Layout("<HHII1012x"),
        "request bit, type, command number and version of a request to the application",
        read=lambda axis: (
            axis.application_request,
            axis.application_request_type,
            axis.application_command_number,
            1,
        ),
    ),
    *OWNERS_OF_AXIS,
    Service(
        0x57, "encoder_count", READ, UINT32, "number of encoders", "1",
        read=lambda axis: len(axis.encoder_ids),
    ),
    Service(
        0x58, "controller_count", READ, UINT32, "number of controllers", "1",
        read=lambda axis: len(axis.controller_ids),
    ),
    Service(
        0x59, "drive_count", READ, UINT32, "number of drives", "1",
        read=lambda axis: len(axis.drive_ids),
    ),
    Service(
        0x5A, "subelement_ids", READ, Layout("<27I"),
        "ids of 9 encoders, 9 controllers, 9 drives, 0 = none", "1", read=_ids,
    ),
    parameter(0xF1, REAL64, NcError.AXIS_ACCELERATION, "max_acceleration"),
    parameter(0xF2, REAL64, NcError.AXIS_DECELERATION, "max_deceleration"),
    parameter(0x101, REAL64, NcError.AXIS_ACCELERATION, "default_acceleration"),
    parameter(0x102, REAL64, NcError.AXIS_DECELERATION, "default_deceleration"),
    parameter(0x103, REAL64, NcError.AXIS_JERK, "default_jerk"),
    parameter(
        0x104, REAL64, NcError.AXIS_POSITION_VELOCITY_DELAY, "setpoint_velocity_position_delay"
    ),
    parameter(0x105, UINT32, NcError.AXIS_OVERRIDE_TYPE, "override_type"),
    parameter(0x106, REAL64, NcError.REQUEST_PARAMETER, "max_velocity_jump"),
    parameter(0x107, UINT16, NcError.REQUEST_PARAMETER, "auxiliary_axis_limiting_enable"),
    parameter(0x108, REAL64, NcError.REQUEST_PARAMETER, "auxiliary_axis_tolerance_ball"),
    parameter(0x109, REAL64, NcError.REQUEST_PARAMETER, "auxiliary_axis_max_position_deviation"),
    _optional(0x10A, NcError.AXIS_ACCELERATION, "fast_axis_stop_acceleration", 0.01),
    _optional(0x10B, NcError.AXIS_DECELERATION, "fast_axis_stop_deceleration", 0.01),
    _optional(0x10C, NcError.AXIS_JERK, "fast_axis_stop_jerk", 0.1),
    parameter(
        0x10D, UINT32, NcError.REQUEST_PARAMETER, "user_data_state_offset", choices=USER_DATA_STATES
    ),
    parameter(0x201, UINT32, NcError.REQUEST_PARAMETER, "stepper_operation_mode"),
    parameter(0x202, REAL64, NcError.REQUEST_PARAMETER, "stepper_step_scaling"),
    parameter(0x203, REAL64, NcError.REQUEST_PARAMETER, "stepper_min_velocity"),
    parameter(0x204, UINT32, NcError.REQUEST_PARAMETER, "stepper_steps_per_velocity_level"),
    parameter(0x301, REAL64, NcError.REQUEST_PARAMETER, "creep_distance_positive"),
    parameter(0x302, REAL64, NcError.REQUEST_PARAMETER, "creep_distance_negative"),
    parameter(0x303, REAL64, NcError.REQUEST_PARAMETER, "brake_distance_positive"),
    parameter(0x304, REAL64, NcError.REQUEST_PARAMETER, "brake_distance_negative"),
    parameter(0x305, REAL64, NcError.REQUEST_PARAMETER, "brake_delay_positive"),
    parameter(0x306, REAL64, NcError.REQUEST_PARAMETER, "brake_delay_negative"),
    parameter(0x307, REAL64, NcError.REQUEST_PARAMETER, "rapid_to_creep_switch_time"),
    parameter(0x308, REAL64, NcError.REQUEST_PARAMETER, "creep_distance_stop"),
    parameter(0x309, REAL64, NcError.REQUEST_PARAMETER, "brake_release_delay"),
    parameter(0x30A, REAL64, NcError.REQUEST_PARAMETER, "pulse_time_positive"),
    parameter(0x30B, REAL64, NcError.REQUEST_PARAMETER, "pulse_time_negative"),
    *ENCODER_VIEWS["parameters"],
    *CONTROLLER_VIEWS["parameters"],
    *DRIVE_VIEWS["parameters"],
)  # fmt: skip

_IN_THE_STRUCTURE = tuple(
    row
    for row in _OWN
    if not isinstance(row.codec, tuple)
    and row.name not in ("axis_id", "axis_name", "axis_type")
    and row.name != "application_request"
)

AXIS_PARAMETERS = (
    *per_element(
        Service(
            0x00,
            "axis_parameter_structure",
            READ,
            (
                ShortParameterSet(_IN_THE_STRUCTURE),
                LongParameterSet(_OWN),
            ),
            "all parameters of the axis, TwinCAT 2 or 3 by length",
            read=lambda axis: axis,
        )
    ),
    *_OWN,
)
