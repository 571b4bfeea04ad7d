"""Cyclic axis interface as services, 0x4300 + ID: enables and override in, status out.

Source: 002 §6.4.4.4; bits of the status double word 004 §5.1.1.
"""

from achse.devices.nc.binding import parameter, per_element, shown
from achse.devices.nc.layouts import (
    INT32,
    NC_TO_PLC_TC2,
    NC_TO_PLC_TC3,
    REAL64,
    UINT8,
    UINT16,
    UINT32,
)
from achse.motion import Axis
from achse.motion.states import ControlBit, StateBit
from achse.server import READ, WRITE, Service

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


_STRUCTURE = Service(
    0x80,
    "nc_to_plc_structure",
    READ,
    (NC_TO_PLC_TC2, NC_TO_PLC_TC3),
    "cyclic structure to the PLC, TwinCAT 2 or 3 by length",
    read=lambda axis: axis,
)

AXIS_CYCLIC = tuple(
    per_element(
        parameter(0x01, UINT32, 0x4003, "control_dword", symbol="ControlDWord"),
        _control_bit(0x02, ControlBit.ENABLE, "controller_enable", "controller enable"),
        _control_bit(0x03, ControlBit.FEED_ENABLE_PLUS, "feed_enable_plus", "feed enable plus"),
        _control_bit(0x04, ControlBit.FEED_ENABLE_MINUS, "feed_enable_minus", "feed enable minus"),
        _control_bit(0x07, ControlBit.HOMING_SENSOR, "homing_cam", "homing cam"),
        parameter(
            0x21, UINT32, 0x42CE, "velocity_override", maximum=FULL_OVERRIDE, symbol="OverrideV"
        ),
        _state_byte(0x71, 1),
        _state_byte(0x72, 2),
        _state_byte(0x73, 3),
        _state_byte(0x74, 4),
        _STRUCTURE,
        shown(0x81, UINT32, "state_dword", symbol="StateDWord"),
        _state_bit(0x82, StateBit.OPERATIONAL, "ready", "axis is ready for operation"),
        _state_bit(0x83, StateBit.HOMED, "homed", "axis is homed"),
        _state_bit(0x84, StateBit.PROTECTED, "protected_mode", "axis is a slave or on a path"),
        _state_bit(0x88, StateBit.IO_DATA_INVALID, "io_data_invalid", "I/O data are invalid"),
        _state_bit(0x89, StateBit.ERROR, "error", "axis is in error"),
        _state_bit(0x8A, StateBit.POSITIVE_DIRECTION, "moving_positive", "to larger positions"),
        _state_bit(0x8B, StateBit.NEGATIVE_DIRECTION, "moving_negative", "to smaller positions"),
        _state_bit(0x8C, StateBit.NOT_MOVING, "standstill", "the set point stands"),
        _state_bit(0x8D, StateBit.HOMING_BUSY, "homing_busy", "axis is homing"),
        _state_bit(0x8E, StateBit.IN_POSITION_AREA, "in_position_range", "in the position window"),
        _state_bit(0x8F, StateBit.IN_TARGET_POSITION, "in_target_position", "arrived"),
        _state_bit(0x90, StateBit.CONSTANT_VELOCITY, "constant_velocity", "velocity is constant"),
        _state_bit(0x9B, StateBit.HAS_JOB, "has_job", "a command is at work"),
        shown(0xB1, UINT32, "error_code"),
        shown(0xB2, UINT32, "motion_state", symbol="AxisState"),
        shown(0xB4, UINT32, "homing_state", symbol="HomingState"),
        shown(0xB5, UINT32, "coupling_state", symbol="CoupleState"),
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
    )
)
