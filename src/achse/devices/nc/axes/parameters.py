"""Axis parameter services, 0x4000 + ID. Source: 002 §6.4.4.1."""

from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows, rows_of
from achse.devices.nc.axes.controller import CONTROLLER_PARAMETERS
from achse.devices.nc.axes.drive import DRIVE_PARAMETERS
from achse.devices.nc.axes.encoder import ENCODER_PARAMETERS
from achse.devices.nc.axes.parameter_set import LongParameterSet, ShortParameterSet
from achse.devices.nc.groups.every import OWNERS_OF_AXIS
from achse.devices.nc.layouts import OfAxis
from achse.devices.nc.rows import at_axis, bound, parameter, per_element, shown
from achse.motion import Axis
from achse.server import Layout, Service

_ROWS = named_rows(0x4000)

MOST_ELEMENTS = 9


def _ids(axis: Axis) -> tuple[int, ...]:
    every = axis.encoder_ids, axis.controller_ids, axis.drive_ids
    return tuple(id for ids in every for id in (*ids, *(0,) * (MOST_ELEMENTS - len(ids))))


def _hardware(axis: Axis) -> tuple[Any, ...]:
    """NetId, port, channel of a drive on a bus; all zero where the hardware is simulated."""
    return axis.hardware_address


def _hardware_extended(axis: Axis) -> tuple[Any, ...]:
    """Return the structure with ids, indices and types, without object ids."""
    n = axis.active_control_loop
    encoder = axis.encoder_ids[min(n, len(axis.encoder_ids) - 1)]
    drive = axis.drive_ids[min(n, len(axis.drive_ids) - 1)]
    drive_part = drive, n, axis.drive.type
    encoder_part = encoder, n, axis.encoder.type
    return *axis.hardware_address, *drive_part, *encoder_part, axis.axis_id, axis.axis_type, 0, 0


def _optional(row: NcRow, error: int, least: float) -> Service:
    """Return a parameter that is 0, not given, or at least `least`."""

    def write(axis: Axis, value: float) -> None:
        if 0.0 < value < least:
            raise DeviceError(error, f"{row.name} = {value:g}, expected 0 or at least {least:g}")
        setattr(axis, row.name, value)

    return parameter(row, error, write=write)


_OWN = (
    shown(_ROWS["axis_id"]),
    bound(_ROWS["axis_name"], read=attrgetter("name")),
    shown(_ROWS["axis_type"]),
    bound(_ROWS["saf_cycle_time"], read=lambda axis: axis.cycle_ns // 1000),
    bound(_ROWS["physical_unit"], read=attrgetter("unit")),
    parameter(_ROWS["homing_velocity_towards_cam"], NcError.AXIS_HOMING_VELOCITY_TOWARDS_CAM),
    parameter(_ROWS["homing_velocity_off_cam"], NcError.AXIS_HOMING_VELOCITY_OFF_CAM),
    parameter(_ROWS["jog_velocity_slow"], NcError.AXIS_JOG_VELOCITY_SLOW),
    parameter(_ROWS["jog_velocity_fast"], NcError.AXIS_JOG_VELOCITY_FAST),
    parameter(_ROWS["rapid_traverse_velocity"], NcError.AXIS_RAPID_VELOCITY),
    parameter(_ROWS["position_range_monitoring_enable"], NcError.AXIS_POSITION_WINDOW_MONITORING),
    parameter(_ROWS["position_range_window"], NcError.AXIS_POSITION_WINDOW),
    parameter(_ROWS["motion_monitoring_enable"], NcError.AXIS_MOTION_MONITORING),
    parameter(_ROWS["motion_monitoring_time"], NcError.AXIS_MOTION_MONITORING_TIME),
    parameter(_ROWS["loop_enable"], NcError.AXIS_LOOP),
    parameter(_ROWS["loop_distance"], NcError.AXIS_LOOP_DISTANCE),
    parameter(_ROWS["target_position_monitoring_enable"], NcError.AXIS_TARGET_WINDOW_MONITORING),
    parameter(_ROWS["target_position_window"], NcError.AXIS_TARGET_WINDOW),
    parameter(_ROWS["target_position_monitoring_time"], NcError.AXIS_TARGET_WINDOW_TIME),
    parameter(_ROWS["pulse_distance_positive"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["pulse_distance_negative"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["error_reaction_mode"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["error_reaction_delay"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["couple_slaves_by_actual_values"], NcError.REQUEST_PARAMETER),
    _optional(_ROWS["fading_acceleration"], NcError.AXIS_ACCELERATION, 0.01),
    parameter(_ROWS["fast_axis_stop_signal_type"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["allow_slave_motion_commands"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["allow_motion_commands_with_external_setpoint"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["unit_interpretation"], NcError.AXIS_UNIT_INTERPRETATION),
    parameter(_ROWS["max_velocity"], NcError.AXIS_MAX_VELOCITY),
    parameter(_ROWS["motion_monitoring_window"], NcError.AXIS_MOTION_MONITORING_WINDOW),
    parameter(_ROWS["peh_monitoring_enable"], NcError.AXIS_PEH_MONITORING),
    parameter(_ROWS["peh_monitoring_time"], NcError.AXIS_PEH_TIME),
    parameter(_ROWS["backlash_compensation_enable"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["backlash"], NcError.REQUEST_PARAMETER),
    shown(_ROWS["persistent_data_enable"]),
    bound(
        _ROWS["hardware_ams_address"],
        codec=(
            OfAxis(Layout("<6sHH"), _hardware),
            OfAxis(Layout("<6sHH2x3I3I2I2I12x"), _hardware_extended),
        ),
        read=lambda axis: axis,
    ),
    bound(
        _ROWS["application_request"],
        read=lambda axis: (
            axis.application_request,
            axis.application_request_type,
            axis.application_command_number,
            1,
        ),
    ),
    *OWNERS_OF_AXIS,
    bound(_ROWS["encoder_count"], read=lambda axis: len(axis.encoder_ids)),
    bound(_ROWS["controller_count"], read=lambda axis: len(axis.controller_ids)),
    bound(_ROWS["drive_count"], read=lambda axis: len(axis.drive_ids)),
    bound(_ROWS["subelement_ids"], read=_ids),
    parameter(_ROWS["max_acceleration"], NcError.AXIS_ACCELERATION),
    parameter(_ROWS["max_deceleration"], NcError.AXIS_DECELERATION),
    parameter(_ROWS["default_acceleration"], NcError.AXIS_ACCELERATION),
    parameter(_ROWS["default_deceleration"], NcError.AXIS_DECELERATION),
    parameter(_ROWS["default_jerk"], NcError.AXIS_JERK),
    parameter(_ROWS["setpoint_velocity_position_delay"], NcError.AXIS_POSITION_VELOCITY_DELAY),
    parameter(_ROWS["override_type"], NcError.AXIS_OVERRIDE_TYPE),
    parameter(_ROWS["max_velocity_jump"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["auxiliary_axis_limiting_enable"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["auxiliary_axis_tolerance_ball"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["auxiliary_axis_max_position_deviation"], NcError.REQUEST_PARAMETER),
    _optional(_ROWS["fast_axis_stop_acceleration"], NcError.AXIS_ACCELERATION, 0.01),
    _optional(_ROWS["fast_axis_stop_deceleration"], NcError.AXIS_DECELERATION, 0.01),
    _optional(_ROWS["fast_axis_stop_jerk"], NcError.AXIS_JERK, 0.1),
    parameter(_ROWS["user_data_state_offset"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["stepper_operation_mode"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["stepper_step_scaling"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["stepper_min_velocity"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["stepper_steps_per_velocity_level"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["creep_distance_positive"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["creep_distance_negative"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["brake_distance_positive"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["brake_distance_negative"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["brake_delay_positive"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["brake_delay_negative"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["rapid_to_creep_switch_time"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["creep_distance_stop"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["brake_release_delay"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["pulse_time_positive"], NcError.REQUEST_PARAMETER),
    parameter(_ROWS["pulse_time_negative"], NcError.REQUEST_PARAMETER),
    *at_axis("encoder_", rows_of(0x4000), ENCODER_PARAMETERS),
    *at_axis("controller_", rows_of(0x4000), CONTROLLER_PARAMETERS),
    *at_axis("drive_", rows_of(0x4000), DRIVE_PARAMETERS),
)

_IN_THE_STRUCTURE = tuple(
    row
    for row in _OWN
    if not isinstance(row.codec, tuple)
    and row.name not in ("axis_id", "axis_name", "axis_type")
    and row.name != "application_request"
)

AXIS_PARAMETERS = (
    *per_element(
        bound(
            _ROWS["axis_parameter_structure"],
            codec=(
                ShortParameterSet(_IN_THE_STRUCTURE),
                LongParameterSet(_OWN),
            ),
            read=lambda axis: axis,
        )
    ),
    *_OWN,
)
