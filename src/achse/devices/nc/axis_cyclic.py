"""Cyclic axis interface as services, 0x4300 + ID: enables and override in, status out.

Source: 002 §6.4.4.4; bits of the status double word 004 §5.1.1.
"""

from achse.devices.nc.binding import per_element, shown
from achse.devices.nc.layouts import (
    FLAG,
    INT32,
    NC_TO_PLC_TC2,
    NC_TO_PLC_TC3,
    REAL64,
    UINT8,
    UINT32,
)
from achse.motion import Axis
from achse.motion.states import ControlBit, StateBit
from achse.server import READ, WRITE, Service

__all__ = ["AXIS_CYCLIC"]

FULL_OVERRIDE = 1_000_000


def _control_bit(offset: int, name: str, bit: ControlBit, description: str) -> Service:
    def write(axis: Axis, value: int) -> None:
        others = axis.control_dword & ~bit
        axis.control_dword = others | bit if value else others

    return Service(
        offset,
        name,
        READ | WRITE,
        FLAG,
        description,
        "1",
        read=lambda axis: int(axis.control_dword & bit != 0),
        write=write,
        minimum=0,
        maximum=1,
    )


def _state_bit(offset: int, name: str, bit: StateBit, description: str) -> Service:
    return Service(
        offset,
        name,
        READ,
        FLAG,
        description,
        "1",
        read=lambda axis: int(axis.state_dword & bit != 0),
    )


def _state_byte(number: int) -> Service:
    shift = 8 * (number - 1)
    return Service(
        0x70 + number,
        f"state_dword_byte{number}",
        READ,
        UINT8,
        f"status double word, byte {number}",
        "1",
        read=lambda axis: axis.state_dword >> shift & 0xFF,
    )


_ROWS = (
    Service(
        0x01,
        "control_dword",
        READ | WRITE,
        UINT32,
        "enable (bit 0), feed enable plus (1) and minus (2), homing cam (5)",
        "1",
        field="control_dword",
        symbol="ControlDWord",
    ),
    _control_bit(0x02, "controller_enable", ControlBit.ENABLE, "controller enable"),
    _control_bit(0x03, "feed_enable_plus", ControlBit.FEED_ENABLE_PLUS, "feed enable plus"),
    _control_bit(0x04, "feed_enable_minus", ControlBit.FEED_ENABLE_MINUS, "feed enable minus"),
    _control_bit(0x07, "homing_cam", ControlBit.HOMING_SENSOR, "homing cam"),
    Service(
        0x21,
        "velocity_override",
        READ | WRITE,
        UINT32,
        "velocity override, 1000000 = 100 %",
        "1e-6",
        field="velocity_override",
        minimum=0,
        maximum=FULL_OVERRIDE,
        symbol="OverrideV",
    ),
    *map(_state_byte, (1, 2, 3, 4)),
    Service(
        0x80,
        "nc_to_plc_structure",
        READ,
        (NC_TO_PLC_TC2, NC_TO_PLC_TC3),
        "cyclic structure to the PLC (NCTOPLC_AXIS_REF), TwinCAT 2 or 3 by length",
        read=lambda axis: axis,
    ),
    shown(0x81, "state_dword", UINT32, "1", "status double word", symbol="StateDWord"),
    _state_bit(0x82, "ready", StateBit.OPERATIONAL, "axis is ready for operation"),
    _state_bit(0x83, "homed", StateBit.HOMED, "axis is homed"),
    _state_bit(0x84, "protected_mode", StateBit.PROTECTED, "axis is a slave or in a path group"),
    _state_bit(0x88, "io_data_invalid", StateBit.IO_DATA_INVALID, "I/O data are invalid"),
    _state_bit(0x89, "error", StateBit.ERROR, "axis is in error"),
    _state_bit(0x8A, "moving_positive", StateBit.POSITIVE_DIRECTION, "moves to larger positions"),
    _state_bit(0x8B, "moving_negative", StateBit.NEGATIVE_DIRECTION, "moves to smaller positions"),
    _state_bit(0x8C, "standstill", StateBit.NOT_MOVING, "the set point stands"),
    _state_bit(0x8D, "homing_busy", StateBit.HOMING_BUSY, "axis is homing"),
    _state_bit(0x8E, "in_position_range", StateBit.IN_POSITION_AREA, "inside the position window"),
    _state_bit(0x8F, "in_target_position", StateBit.IN_TARGET_POSITION, "arrived at the target"),
    _state_bit(0x90, "constant_velocity", StateBit.CONSTANT_VELOCITY, "velocity is constant"),
    _state_bit(0x9B, "has_job", StateBit.HAS_JOB, "a command is at work"),
    shown(0xB1, "error_code", UINT32, "1", "error of the axis"),
    shown(0xB2, "motion_state", UINT32, "1", "state of the motion", symbol="AxisState"),
    shown(0xB4, "homing_state", UINT32, "1", "step of the homing sequence", symbol="HomingState"),
    shown(0xB5, "coupling_state", UINT32, "1", "coupling state", symbol="CoupleState"),
    shown(0xB7, "saf_entry_count", UINT32, "1", "buffered commands", field="buffer_count"),
    shown(0xB8, "axis_id", UINT32, "1", "axis id"),
    shown(0xB9, "operation_mode_state_dword", UINT32, "1", "active monitoring functions"),
    shown(0xBA, "actual_position", REAL64, "mm", "actual position"),
    shown(0xBB, "actual_position_modulo", REAL64, "degree", "modulo actual position"),
    shown(0xBC, "modulo_turns", INT32, "1", "modulo turns", field="actual_modulo_turns"),
    shown(0xBD, "actual_velocity", REAL64, "mm/s", "actual velocity"),
    shown(0xBE, "following_error", REAL64, "mm", "following error"),
    shown(0xBF, "set_position", REAL64, "mm", "set position"),
    shown(0xC0, "set_velocity", REAL64, "mm/s", "set velocity"),
    shown(0xC1, "set_acceleration", REAL64, "mm/s²", "set acceleration"),
)

AXIS_CYCLIC = tuple(per_element(_ROWS))
