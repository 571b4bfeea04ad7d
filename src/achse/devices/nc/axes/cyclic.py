"""Cyclic axis interface as services, 0x4300 + ID: enables and override in, status out.

Source: 002 §6.4.4.4; bits of the status double word 004 §5.1.1.
"""

from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.codes.axis import ControlBit, StateBit
from achse.codes.nc.choices import AxisType
from achse.codes.nc.row import NcRow
from achse.codes.nc.table import named_rows, rows_of
from achse.devices.nc.axes.io_structures import DRIVE_IO, ENCODER_IO
from achse.devices.nc.axes.structures import NC_TO_PLC_TC2, NC_TO_PLC_TC3, PLC_TO_NC
from achse.devices.nc.layouts import (
    OfAxis,
)
from achse.devices.nc.rows import at_axis, bound, parameter, per_element, shown
from achse.motion import Axis
from achse.server import Layout, Service

_ROWS = named_rows(0x4300)

FULL_OVERRIDE = 1_000_000


def _control_bit(row: NcRow, bit: ControlBit) -> Service:
    def read(axis: Axis) -> int:
        return int(axis.control_dword & bit != 0)

    def write(axis: Axis, value: int) -> None:
        others = axis.control_dword & ~bit
        axis.control_dword = others | bit if value else others

    return bound(row, read=read, write=write)


def _state_bit(row: NcRow, bit: StateBit) -> Service:
    return bound(row, read=lambda axis: int(axis.state_dword & bit != 0))


def _state_byte(number: int) -> Service:
    def read(axis: Axis) -> int:
        return axis.state_dword >> 8 * (number - 1) & 0xFF

    return bound(_ROWS[f"state_dword_byte{number}"], read=read)


def _take_structure(axis: Axis, values: dict[str, Any]) -> None:
    """Apply all of the structure or nothing: the ranges of the single rows hold."""
    if values["velocity_override"] > FULL_OVERRIDE:
        raise DeviceError(NcError.OVERRIDE_INVALID.number, f"{values['velocity_override']}")
    if abs(values["external_set_direction"]) > 1:
        raise DeviceError(NcError.REQUEST_PARAMETER.number, "direction -1, 0 or 1")
    for name, value in values.items():
        setattr(axis, name, value)


_FROM_PLC = bound(
    _ROWS["plc_to_nc_structure"],
    codec=PLC_TO_NC,
    read=lambda axis: axis,
    write=_take_structure,
    code=NcError.REQUEST_PARAMETER.number,
)

_EXTERNAL = ("external_set_position", "external_set_velocity", "external_set_acceleration")
_TORQUE, _DIRECTION = "external_set_torque", "external_set_direction"


def _take_external(axis: Axis, values: tuple[Any, ...]) -> None:
    names = (*_EXTERNAL, *(_TORQUE,) * (len(values) - 4), _DIRECTION)
    if abs(values[-1]) > 1:
        raise DeviceError(NcError.REQUEST_PARAMETER.number, "direction -1, 0 or 1")
    for name, value in zip(names, values, strict=True):
        setattr(axis, name, value)


_EXTERNAL_SET_POINT = bound(
    _ROWS["external_setpoint"],
    codec=(
        OfAxis(Layout("<dddi"), attrgetter(*_EXTERNAL, _DIRECTION)),
        OfAxis(Layout("<ddddi12x"), attrgetter(*_EXTERNAL, _TORQUE, _DIRECTION)),
    ),
    read=lambda axis: axis,
    write=_take_external,
    code=NcError.REQUEST_PARAMETER.number,
)


def _rapid(axis: Axis) -> int:
    """Return a two-speed axis at its fast speed."""
    return int(
        axis.drive.control_byte & 0b1001 != 0 and axis.axis_type == AxisType.DISCRETE_RAPID_CREEP
    )


_STRUCTURE = bound(
    _ROWS["nc_to_plc_structure"], codec=(NC_TO_PLC_TC2, NC_TO_PLC_TC3), read=lambda axis: axis
)

AXIS_CYCLIC = (
    *per_element(
        _FROM_PLC,
        parameter(_ROWS["control_dword"], NcError.REQUEST_PARAMETER),
        _control_bit(_ROWS["controller_enable"], ControlBit.ENABLE),
        _control_bit(_ROWS["feed_enable_plus"], ControlBit.FEED_ENABLE_PLUS),
        _control_bit(_ROWS["feed_enable_minus"], ControlBit.FEED_ENABLE_MINUS),
        _control_bit(_ROWS["homing_cam"], ControlBit.HOMING_SENSOR),
        parameter(_ROWS["velocity_override"], NcError.OVERRIDE_INVALID),
        parameter(_ROWS["operation_mode"], NcError.REQUEST_PARAMETER),
        parameter(_ROWS["actual_position_correction"], NcError.REQUEST_PARAMETER),
        parameter(_ROWS["external_controller_component"], NcError.REQUEST_PARAMETER),
        _EXTERNAL_SET_POINT,
        _state_byte(1),
        _state_byte(2),
        _state_byte(3),
        _state_byte(4),
        _STRUCTURE,
        shown(_ROWS["state_dword"]),
        _state_bit(_ROWS["ready"], StateBit.OPERATIONAL),
        _state_bit(_ROWS["homed"], StateBit.HOMED),
        _state_bit(_ROWS["protected_mode"], StateBit.PROTECTED),
        bound(_ROWS["rapid_mode"], read=_rapid),
        _state_bit(_ROWS["io_data_invalid"], StateBit.IO_DATA_INVALID),
        _state_bit(_ROWS["error"], StateBit.ERROR),
        _state_bit(_ROWS["moving_positive"], StateBit.POSITIVE_DIRECTION),
        _state_bit(_ROWS["moving_negative"], StateBit.NEGATIVE_DIRECTION),
        _state_bit(_ROWS["standstill"], StateBit.NOT_MOVING),
        _state_bit(_ROWS["homing_busy"], StateBit.HOMING_BUSY),
        _state_bit(_ROWS["in_position_range"], StateBit.IN_POSITION_AREA),
        _state_bit(_ROWS["in_target_position"], StateBit.IN_TARGET_POSITION),
        _state_bit(_ROWS["constant_velocity"], StateBit.CONSTANT_VELOCITY),
        bound(
            _ROWS["operation_mode_busy"],
            read=lambda axis: int(axis.operation_mode != axis.operation_mode_feedback),
        ),
        _state_bit(_ROWS["has_job"], StateBit.HAS_JOB),
        shown(_ROWS["error_code"]),
        shown(_ROWS["motion_state"]),
        shown(_ROWS["operation_mode_feedback"]),
        shown(_ROWS["homing_state"]),
        shown(_ROWS["coupling_state"]),
        bound(_ROWS["svb_entry_count"], read=lambda axis: 0),
        shown(_ROWS["saf_entry_count"], "buffer_count"),
        shown(_ROWS["axis_id"]),
        shown(_ROWS["operation_mode_state_dword"]),
        shown(_ROWS["actual_position"]),
        shown(_ROWS["actual_position_modulo"]),
        shown(_ROWS["modulo_turns"], "actual_modulo_turns"),
        shown(_ROWS["actual_velocity"]),
        shown(_ROWS["following_error"]),
        shown(_ROWS["set_position"]),
        shown(_ROWS["set_velocity"]),
        shown(_ROWS["set_acceleration"]),
    ),
    *at_axis("encoder_", rows_of(0x4300), ENCODER_IO),
    *at_axis("drive_", rows_of(0x4300), DRIVE_IO),
)
