"""Drive services, 0x7000, 0x7100 and 0x7200 + ID. Source: 002 §6.4.7.

The axis shows most of these rows at 0x00n3_0000, n being the number of the drive.
"""

from functools import partial
from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.axis import ControlBit
from achse.codes.nc.choices import AxisType, OutputFilter
from achse.codes.nc.table import named_rows
from achse.devices.nc import rows
from achse.devices.nc.rows import bound, error_state, not_while_enabled
from achse.devices.nc.tables.places import answered
from achse.motion.fields.drive import DRIVE_DELAY
from achse.motion.parts import AxisDrive
from achse.motion.tables import HIGHEST_TABLE_ID

_PARAMETERS = named_rows(0x7000)
_STATES = named_rows(0x7100)
_FUNCTIONS = named_rows(0x7200)

parameter = partial(rows.parameter, prefix="drive_")
shown = partial(rows.shown, prefix="drive_")

FULL_OUTPUT_VOLTS = 10.0
"""Output of 100 % at an analog drive."""

DIGITAL_INPUTS = 8


def _id(drive: AxisDrive) -> int:
    owner = drive.owner
    return owner.drive_ids[owner.drives.index(drive)]


def _set_time(field: str) -> Any:
    """Delays and filters reach back 64 cycles; a longer time is refused."""

    def write(drive: AxisDrive, seconds: float) -> None:
        longest = DRIVE_DELAY * drive.owner.cycle_ns * 1e-9
        if seconds > longest:
            raise DeviceError(
                NcError.REQUEST_PARAMETER.number, f"{seconds:g} s, at most {longest:g} s"
            )
        setattr(drive, field, seconds)

    return write


def _not_while_closed(drive: AxisDrive) -> None:
    """Refuse another characteristic in a closed loop: it would be a step of the output."""
    owner = drive.owner
    if owner.control_dword & ControlBit.ENABLE or owner.loop_closed:
        raise DeviceError(NcError.DRIVE_TABLE_ID_CHANGED.number, f"axis {drive.axis_id} is enabled")


def _set_table(drive: AxisDrive, table_id: int) -> None:
    if table_id != drive.table_id:
        _not_while_closed(drive)
    with answered():
        drive.owner.tables.characteristics.choose(drive, table_id)


def _remove_table(drive: AxisDrive, table_id: int) -> None:
    if not 1 <= table_id <= HIGHEST_TABLE_ID:
        raise DeviceError(
            NcError.TABLE_ID_RANGE.number, f"table {table_id}, expected 1..{HIGHEST_TABLE_ID}"
        )
    if table_id == drive.table_id:
        _not_while_closed(drive)
    with answered():
        drive.owner.tables.characteristics.remove(drive, table_id)


def _set_interpolation(drive: AxisDrive, interpolation: int) -> None:
    with answered():
        drive.owner.tables.characteristics.interpolate(drive, interpolation)


DRIVE_PARAMETERS = (
    bound(_PARAMETERS["drive_id"], read=_id),
    bound(_PARAMETERS["drive_name"], read=attrgetter("name")),
    shown(_PARAMETERS["drive_type"]),
    parameter(_PARAMETERS["input_address_offset"], NcError.DRIVE_ADDRESS_INPUT),
    parameter(_PARAMETERS["output_address_offset"], NcError.DRIVE_ADDRESS_OUTPUT),
    parameter(_PARAMETERS["motor_polarity"], NcError.DRIVE_MOTOR_POLARITY, guard=not_while_enabled),
    parameter(_PARAMETERS["drive_mode"], NcError.DRIVE_MODE),
    parameter(_PARAMETERS["output_limit_min"], NcError.DRIVE_OUTPUT_LIMITS),
    parameter(_PARAMETERS["output_limit_max"], NcError.DRIVE_OUTPUT_LIMITS),
    shown(_PARAMETERS["output_mask"]),
    parameter(_PARAMETERS["control_dword"], NcError.REQUEST_PARAMETER, "drive_control_dword"),
    parameter(_PARAMETERS["reset_counter"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["dead_time_compensation_mode"], NcError.DEAD_TIME_COMPENSATION),
    parameter(_PARAMETERS["dead_time_compensation_control"], NcError.DEAD_TIME_COMPENSATION),
    parameter(_PARAMETERS["dead_time_compensation_shift"], NcError.DEAD_TIME_COMPENSATION),
    parameter(_PARAMETERS["actual_torque_scaling"], NcError.DRIVE_ACTUAL_TORQUE_SCALING),
    parameter(_PARAMETERS["actual_torque_filter_time"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["actual_torque_derivative_filter_time"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["reference_velocity"], NcError.DRIVE_REFERENCE_VELOCITY),
    parameter(_PARAMETERS["reference_output"], NcError.DRIVE_REFERENCE_OUTPUT),
    bound(
        _PARAMETERS["velocity_at_full_output"],
        read=lambda drive: drive.reference_velocity / drive.reference_output,
    ),
    parameter(_PARAMETERS["velocity_offset"], NcError.DRIVE_DRIFT_COMPENSATION),
    parameter(_PARAMETERS["velocity_scaling"], NcError.DRIVE_VELOCITY_SCALING),
    parameter(_PARAMETERS["dsc_kpc"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["dsc_xerr_scaling"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["position_scaling"], NcError.DRIVE_POSITION_SCALING),
    parameter(_PARAMETERS["acceleration_scaling"], NcError.DRIVE_ACCELERATION_SCALING),
    parameter(_PARAMETERS["torque_offset_scaling"], NcError.DRIVE_TORQUE_SCALING),
    parameter(_PARAMETERS["set_torque_scaling"], NcError.DRIVE_TORQUE_SCALING),
    parameter(
        _PARAMETERS["velocity_output_delay"],
        NcError.REQUEST_PARAMETER,
        write=_set_time("drive_velocity_output_delay"),
    ),
    parameter(_PARAMETERS["acceleration_output_delay"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["torque_output_delay"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["output_filter_type"], NcError.REQUEST_PARAMETER),
    parameter(
        _PARAMETERS["output_filter_time"],
        NcError.REQUEST_PARAMETER,
        write=_set_time("drive_output_filter_time"),
    ),
    parameter(_PARAMETERS["output_filter_order"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["table_id"], NcError.REQUEST_PARAMETER, write=_set_table),
    parameter(
        _PARAMETERS["table_interpolation_type"],
        NcError.TABLE_INTERPOLATION_TYPE,
        write=_set_interpolation,
    ),
    parameter(_PARAMETERS["output_offset"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["quadrant_compensation_factor"], NcError.DRIVE_QUADRANT_COMPENSATION),
    parameter(_PARAMETERS["velocity_reference_point"], NcError.DRIVE_VELOCITY_REFERENCE_POINT),
    parameter(_PARAMETERS["output_reference_point"], NcError.DRIVE_OUTPUT_REFERENCE_POINT),
    parameter(_PARAMETERS["stepper_mask_cycle1"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["stepper_mask_cycle2"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["stepper_mask_cycle3"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["stepper_mask_cycle4"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["stepper_mask_cycle5"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["stepper_mask_cycle6"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["stepper_mask_cycle7"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["stepper_mask_cycle8"], NcError.REQUEST_PARAMETER),
    parameter(_PARAMETERS["stepper_mask_holding_current"], NcError.REQUEST_PARAMETER),
)


def _nonlinear(drive: AxisDrive) -> float:
    """Output in % after the characteristic, which linear and two-speed drives do not have."""
    if drive.special and drive.owner.axis_type != AxisType.DISCRETE_RAPID_CREEP:
        return drive.output_percent_nonlinear
    return drive.output_percent


def _volts(percent: float) -> float:
    return percent * FULL_OUTPUT_VOLTS / 100.0


def _shift(drive: AxisDrive) -> float:
    mode = drive.dead_time_compensation_mode
    return drive.dead_time_compensation_shift * 1e-9 if mode else 0.0


def _filters(drive: AxisDrive) -> bool:
    return drive.output_filter_type != OutputFilter.OFF and bool(drive.ideal)


def _filtered_position(drive: AxisDrive) -> float:
    return drive.filtered_set_position if _filters(drive) else drive.owner.set_position


def _filtered_velocity(drive: AxisDrive) -> float:
    return drive.filtered_set_velocity if _filters(drive) else drive.owner.set_velocity


def _filtered_acceleration(drive: AxisDrive) -> float:
    if _filters(drive):
        return drive.filtered_set_acceleration
    return drive.owner.set_acceleration


def _digital_input(drive: AxisDrive, number: int) -> int:
    if not 1 <= number <= DIGITAL_INPUTS:
        raise DeviceError(
            NcError.REQUEST_PARAMETER.number, f"input {number}, expected 1..{DIGITAL_INPUTS}"
        )
    return drive.owner.drive.io.state8 >> (number - 1) & 1


DRIVE_STATES = (
    error_state(_STATES["error_state"], 0x4600),
    shown(_STATES["output_absolute"], "drive_output"),
    shown(_STATES["output_percent"]),
    bound(_STATES["output_volt"], read=lambda drive: _volts(drive.output_percent)),
    shown(_STATES["output_peak_negative"]),
    shown(_STATES["output_peak_positive"]),
    shown(_STATES["actual_torque"]),
    shown(_STATES["actual_torque_derivative"]),
    shown(_STATES["dead_time_position_correction"]),
    bound(_STATES["dead_time_total_shift"], read=_shift),
    bound(_STATES["output_percent_nonlinear"], read=_nonlinear),
    bound(_STATES["output_volt_nonlinear"], read=lambda drive: _volts(_nonlinear(drive))),
    bound(_STATES["filtered_set_position"], read=_filtered_position),
    bound(_STATES["filtered_set_velocity"], read=_filtered_velocity),
    bound(_STATES["filtered_set_acceleration"], read=_filtered_acceleration),
    bound(_STATES["digital_input_state"], exchange=_digital_input),
)

DRIVE_FUNCTIONS = (bound(_FUNCTIONS["remove_characteristic_table"], write=_remove_table),)
