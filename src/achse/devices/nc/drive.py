"""Drive services, 0x7000, 0x7100 and 0x7200 + ID. Source: 002 §6.4.7.

The axis shows most of these rows at 0x00n3_0000, n being the number of the drive.
"""

from functools import partial
from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc import binding
from achse.devices.nc.binding import error_state, in_sub_range, not_while_enabled
from achse.devices.nc.layouts import INT32, REAL64, UINT8, UINT16, UINT32, Text
from achse.devices.nc.table_places import answered
from achse.motion.parts import AxisDrive
from achse.motion.record import DRIVE_DELAY
from achse.motion.states import AxisType, ControlBit, OutputFilter
from achse.motion.tables import HIGHEST_TABLE_ID
from achse.server import READ, READ_WRITE, WRITE, Service

__all__ = ["DRIVE_FUNCTIONS", "DRIVE_PARAMETERS", "DRIVE_STATES", "DRIVE_VIEWS"]

parameter = partial(binding.parameter, prefix="drive_")
shown = partial(binding.shown, prefix="drive_")

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
    """Another characteristic would be a step of the output."""
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
    Service(0x01, "drive_id", READ, UINT32, "id of the drive", "1", read=_id),
    Service(0x02, "drive_name", READ, Text(31), "name", read=attrgetter("name")),
    shown(0x03, UINT32, "drive_type"),
    parameter(0x04, UINT32, NcError.DRIVE_ADDRESS_INPUT, "input_address_offset"),
    parameter(0x05, UINT32, NcError.DRIVE_ADDRESS_OUTPUT, "output_address_offset"),
    parameter(
        0x06, UINT16, NcError.DRIVE_MOTOR_POLARITY, "motor_polarity", guard=not_while_enabled
    ),
    parameter(0x0A, UINT32, NcError.DRIVE_MODE, "drive_mode"),
    parameter(0x0B, REAL64, NcError.DRIVE_OUTPUT_LIMITS, "output_limit_min"),
    parameter(0x0C, REAL64, NcError.DRIVE_OUTPUT_LIMITS, "output_limit_max"),
    shown(0x0D, UINT32, "output_mask"),
    parameter(0x10, UINT32, NcError.REQUEST_PARAMETER, "control_dword", "drive_control_dword"),
    parameter(0x11, UINT32, NcError.REQUEST_PARAMETER, "reset_counter"),
    parameter(0x20, UINT32, NcError.DEAD_TIME_COMPENSATION, "dead_time_compensation_mode"),
    parameter(0x21, UINT32, NcError.DEAD_TIME_COMPENSATION, "dead_time_compensation_control"),
    parameter(0x22, INT32, NcError.DEAD_TIME_COMPENSATION, "dead_time_compensation_shift"),
    parameter(0x31, REAL64, NcError.DRIVE_ACTUAL_TORQUE_SCALING, "actual_torque_scaling"),
    parameter(0x32, REAL64, NcError.REQUEST_PARAMETER, "actual_torque_filter_time"),
    parameter(0x33, REAL64, NcError.REQUEST_PARAMETER, "actual_torque_derivative_filter_time"),
    parameter(0x101, REAL64, NcError.DRIVE_REFERENCE_VELOCITY, "reference_velocity"),
    parameter(0x102, REAL64, NcError.DRIVE_REFERENCE_OUTPUT, "reference_output"),
    Service(
        0x103, "velocity_at_full_output", READ, REAL64, "velocity at 100 % output", "mm/s",
        read=lambda drive: drive.reference_velocity / drive.reference_output,
    ),
    parameter(0x104, REAL64, NcError.DRIVE_DRIFT_COMPENSATION, "velocity_offset"),
    parameter(0x105, REAL64, NcError.DRIVE_VELOCITY_SCALING, "velocity_scaling"),
    parameter(0x106, UINT32, NcError.REQUEST_PARAMETER, "dsc_kpc"),
    parameter(0x107, REAL64, NcError.REQUEST_PARAMETER, "dsc_xerr_scaling"),
    parameter(0x109, REAL64, NcError.DRIVE_POSITION_SCALING, "position_scaling"),
    parameter(0x10A, REAL64, NcError.DRIVE_ACCELERATION_SCALING, "acceleration_scaling"),
    parameter(0x10B, REAL64, NcError.DRIVE_TORQUE_SCALING, "torque_offset_scaling"),
    parameter(0x10C, REAL64, NcError.DRIVE_TORQUE_SCALING, "set_torque_scaling"),
    parameter(
        0x10D, REAL64, NcError.REQUEST_PARAMETER, "velocity_output_delay",
        write=_set_time("drive_velocity_output_delay"),
    ),
    parameter(0x10E, REAL64, NcError.REQUEST_PARAMETER, "acceleration_output_delay"),
    parameter(0x10F, REAL64, NcError.REQUEST_PARAMETER, "torque_output_delay"),
    parameter(0x110, UINT32, NcError.REQUEST_PARAMETER, "output_filter_type"),
    parameter(
        0x111, REAL64, NcError.REQUEST_PARAMETER,
        "output_filter_time", write=_set_time("drive_output_filter_time")
    ),
    parameter(0x112, UINT32, NcError.REQUEST_PARAMETER, "output_filter_order"),
    parameter(0x120, UINT32, NcError.REQUEST_PARAMETER, "table_id", write=_set_table),
    parameter(
        0x121, UINT32, NcError.TABLE_INTERPOLATION_TYPE,
        "table_interpolation_type", write=_set_interpolation
    ),
    parameter(0x122, REAL64, NcError.REQUEST_PARAMETER, "output_offset"),
    parameter(0x151, REAL64, NcError.DRIVE_QUADRANT_COMPENSATION, "quadrant_compensation_factor"),
    parameter(0x152, REAL64, NcError.DRIVE_VELOCITY_REFERENCE_POINT, "velocity_reference_point"),
    parameter(0x153, REAL64, NcError.DRIVE_OUTPUT_REFERENCE_POINT, "output_reference_point"),
    parameter(0x301, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_cycle1"),
    parameter(0x302, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_cycle2"),
    parameter(0x303, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_cycle3"),
    parameter(0x304, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_cycle4"),
    parameter(0x305, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_cycle5"),
    parameter(0x306, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_cycle6"),
    parameter(0x307, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_cycle7"),
    parameter(0x308, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_cycle8"),
    parameter(0x310, UINT8, NcError.REQUEST_PARAMETER, "stepper_mask_holding_current"),
)  # fmt: skip


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
    error_state(0x4600, "error code of the drive"),
    shown(0x02, REAL64, "output_absolute", "drive_output", symbol="DriveOutput"),
    shown(0x03, REAL64, "output_percent"),
    Service(
        0x04, "output_volt", READ, REAL64, "total output", "V",
        read=lambda drive: _volts(drive.output_percent),
    ),
    shown(0x05, REAL64, "output_peak_negative"),
    shown(0x06, REAL64, "output_peak_positive"),
    shown(0x07, REAL64, "actual_torque", symbol="ActTorque"),
    shown(0x08, REAL64, "actual_torque_derivative"),
    shown(0x0C, REAL64, "dead_time_position_correction"),
    Service(
        0x0D, "dead_time_total_shift", READ, REAL64, "dead time that is compensated", "s",
        read=_shift,
    ),
    Service(
        0x13, "output_percent_nonlinear", READ, REAL64, "total output after the characteristic",
        "%", read=_nonlinear,
    ),
    Service(
        0x14, "output_volt_nonlinear", READ, REAL64, "total output after the characteristic",
        "V", read=lambda drive: _volts(_nonlinear(drive)),
    ),
    Service(
        0x11A, "filtered_set_position", READ, REAL64, "set position after the output filter",
        "mm", read=_filtered_position,
    ),
    Service(
        0x11E, "filtered_set_velocity", READ, REAL64, "set velocity after the output filter",
        "mm/s", read=_filtered_velocity,
    ),
    Service(
        0x11F, "filtered_set_acceleration", READ, REAL64,
        "set acceleration after the output filter", "mm/s²", read=_filtered_acceleration,
    ),
    Service(
        0x200, "digital_input_state", READ_WRITE, UINT32, "state of digital input 1..8",
        exchange=_digital_input, response=UINT32,
    ),
)  # fmt: skip

DRIVE_FUNCTIONS = (
    Service(
        0x102, "remove_characteristic_table", WRITE, UINT32,
        "take the characteristic table out of the drive, and delete it",
        write=_remove_table,
    ),
)  # fmt: skip

_NOT_AT_THE_AXIS = {0x20, 0x21, 0x22}
"""002 prints scaling and filter of torque and the output filters at the drive only, but the PLC
library reads and writes them at the axis (MC_AxisParameter 1081 … 1093)."""

DRIVE_VIEWS = {
    "parameters": tuple(in_sub_range("drive_", DRIVE_PARAMETERS, without=_NOT_AT_THE_AXIS)),
    "states": tuple(in_sub_range("drive_", DRIVE_STATES, without={0x0C, 0x0D, 0x200})),
}
"""The rows as the axis shows them."""
