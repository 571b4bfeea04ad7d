"""Cyclic axis interface as services, 0x4300 + ID: enables and override in, status out.

Source: 002 §6.4.4.4; bits of the status double word 004 §5.1.1.
"""

from operator import attrgetter
from typing import Any

from achse.ams import DeviceError
from achse.codes import NcError
from achse.devices.nc.axis_structures import NC_TO_PLC_TC2, NC_TO_PLC_TC3, PLC_TO_NC
from achse.devices.nc.binding import in_sub_range, parameter, per_element, shown
from achse.devices.nc.io_structures import DRIVE_IO, ENCODER_IO
from achse.devices.nc.layouts import (
    INT32,
    REAL64,
    UINT8,
    UINT16,
    UINT32,
    OfAxis,
)
from achse.motion import Axis
from achse.motion.states import AxisType, ControlBit, StateBit
from achse.server import READ, WRITE, Layout, Service

__all__ = ["AXIS_CYCLIC"]

FULL_OVERRIDE = 1_000_000


def _control_bit(offset: int, bit: ControlBit, name: str, description: str) -> Service:
    def read(axis: Axis) -> int:
        return int(axis.control_dword & bit != 0)

    def write(axis: Axis, value: int) -> None:
        others = axis.control_dword & ~bit
        axis.control_dword = others | bit if value else others

    return Service(
        offset, name, READ | WRITE, UINT16, description, "1",
        read=read, write=write, minimum=0, maximum=1,
    )  # fmt: skip


def _state_bit(offset: int, bit: StateBit, name: str, description: str) -> Service:
    def read(axis: Axis) -> int:
        return int(axis.state_dword & bit != 0)

    return Service(offset, name, READ, UINT16, description, "1", read=read)


def _state_byte(offset: int, number: int) -> Service:
    def read(axis: Axis) -> int:
        return axis.state_dword >> 8 * (number - 1) & 0xFF

    name = f"state_dword_byte{number}"
    return Service(offset, name, READ, UINT8, f"status double word, byte {number}", read=read)


def _take_structure(axis: Axis, values: dict[str, Any]) -> None:
    """All of it or nothing: the ranges of the single rows hold."""
    if values["velocity_override"] > FULL_OVERRIDE:
        raise DeviceError(NcError.OVERRIDE_INVALID.number, f"{values['velocity_override']}")
    if abs(values["external_set_direction"]) > 1:
        raise DeviceError(NcError.REQUEST_PARAMETER.number, "direction -1, 0 or 1")
    for name, value in values.items():
        setattr(axis, name, value)


_FROM_PLC = Service(
    0x00,
    "plc_to_nc_structure",
    READ | WRITE,
    PLC_TO_NC,
    "cyclic structure from the PLC, equal in TwinCAT 2 and 3",
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


_EXTERNAL_SET_POINT = Service(
    0x27,
    "external_setpoint",
    READ | WRITE,
    (
        OfAxis(Layout("<dddi"), attrgetter(*_EXTERNAL, _DIRECTION)),
        OfAxis(Layout("<ddddi12x"), attrgetter(*_EXTERNAL, _TORQUE, _DIRECTION)),
    ),
    "set point of an external generator; the value 002 leaves unnamed is the torque",
    read=lambda axis: axis,
    write=_take_external,
    code=NcError.REQUEST_PARAMETER.number,
)


def _rapid(axis: Axis) -> int:
    """A two-speed axis at its fast speed."""
    return int(
        axis.drive.control_byte & 0b1001 != 0 and axis.axis_type == AxisType.DISCRETE_RAPID_CREEP
    )


_STRUCTURE = Service(
    0x80,
    "nc_to_plc_structure",
    READ,
    (NC_TO_PLC_TC2, NC_TO_PLC_TC3),
    "cyclic structure to the PLC, TwinCAT 2 or 3 by length",
    read=lambda axis: axis,
)

AXIS_CYCLIC = (
    *per_element(
        _FROM_PLC,
        parameter(0x01, UINT32, NcError.REQUEST_PARAMETER, "control_dword", symbol="ControlDWord"),
        _control_bit(0x02, ControlBit.ENABLE, "controller_enable", "controller enable"),
        _control_bit(0x03, ControlBit.FEED_ENABLE_PLUS, "feed_enable_plus", "feed enable plus"),
        _control_bit(0x04, ControlBit.FEED_ENABLE_MINUS, "feed_enable_minus", "feed enable minus"),
        _control_bit(0x07, ControlBit.HOMING_SENSOR, "homing_cam", "homing cam"),
        parameter(
            0x21, UINT32, NcError.OVERRIDE_INVALID,
            "velocity_override", maximum=FULL_OVERRIDE, symbol="OverrideV"
        ),
        parameter(0x22, UINT32, NcError.REQUEST_PARAMETER, "operation_mode"),
        parameter(0x25, REAL64, NcError.REQUEST_PARAMETER, "actual_position_correction"),
        parameter(0x26, REAL64, NcError.REQUEST_PARAMETER, "external_controller_component"),
        _EXTERNAL_SET_POINT,
        _state_byte(0x71, 1),
        _state_byte(0x72, 2),
        _state_byte(0x73, 3),
        _state_byte(0x74, 4),
        _STRUCTURE,
        shown(0x81, UINT32, "state_dword", symbol="StateDWord"),
        _state_bit(0x82, StateBit.OPERATIONAL, "ready", "axis is ready for operation"),
        _state_bit(0x83, StateBit.HOMED, "homed", "axis is homed"),
        _state_bit(0x84, StateBit.PROTECTED, "protected_mode", "axis is a slave or on a path"),
        Service(
            0x85, "rapid_mode", READ, UINT16, "axis moves in rapid traverse", "1", read=_rapid
        ),
        _state_bit(0x88, StateBit.IO_DATA_INVALID, "io_data_invalid", "I/O data are invalid"),
        _state_bit(0x89, StateBit.ERROR, "error", "axis is in error"),
        _state_bit(0x8A, StateBit.POSITIVE_DIRECTION, "moving_positive", "to larger positions"),
        _state_bit(0x8B, StateBit.NEGATIVE_DIRECTION, "moving_negative", "to smaller positions"),
        _state_bit(0x8C, StateBit.NOT_MOVING, "standstill", "the set point stands"),
        _state_bit(0x8D, StateBit.HOMING_BUSY, "homing_busy", "axis is homing"),
        _state_bit(0x8E, StateBit.IN_POSITION_AREA, "in_position_range", "in the position window"),
        _state_bit(0x8F, StateBit.IN_TARGET_POSITION, "in_target_position", "arrived"),
        _state_bit(0x90, StateBit.CONSTANT_VELOCITY, "constant_velocity", "velocity is constant"),
        Service(
            0x9A, "operation_mode_busy", READ, UINT16, "operation mode is not yet carried out", "1",
            read=lambda axis: int(axis.operation_mode != axis.operation_mode_feedback),
        ),
        _state_bit(0x9B, StateBit.HAS_JOB, "has_job", "a command is at work"),
        shown(0xB1, UINT32, "error_code"),
        shown(0xB2, UINT32, "motion_state", symbol="AxisState"),
        shown(0xB3, UINT32, "operation_mode_feedback"),
        shown(0xB4, UINT32, "homing_state", symbol="HomingState"),
        shown(0xB5, UINT32, "coupling_state", symbol="CoupleState"),
        Service(
            0xB6, "svb_entry_count", READ, UINT32,
            "entries of the preparation task, which has none of a single axis", "1",
            read=lambda axis: 0,
        ),
        shown(0xB7, UINT32, "saf_entry_count", "buffer_count"),
        shown(0xB8, UINT32, "axis_id"),
        shown(0xB9, UINT32, "operation_mode_state_dword"),
        shown(0xBA, REAL64, "actual_position"),
        shown(0xBB, REAL64, "actual_position_modulo"),
        shown(0xBC, INT32, "modulo_turns", "actual_modulo_turns"),
        shown(0xBD, REAL64, "actual_velocity"),
        shown(0xBE, REAL64, "following_error"),
        shown(0xBF, REAL64, "set_position"),
        shown(0xC0, REAL64, "set_velocity"),
        shown(0xC1, REAL64, "set_acceleration"),
    ),
    *in_sub_range("encoder_", ENCODER_IO),
    *in_sub_range("drive_", DRIVE_IO),
)  # fmt: skip
