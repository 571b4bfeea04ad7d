"""The axis record: every value of one NC axis, declared once.

`AxisFields` is the table. From it come a NumPy structured dtype (`record_dtype`), a class with
`__slots__` (`SlotsRecord`) and the static type of both. All values are 64 bits wide, so that the
kernel means the same on either form. A field carries the name of the axis service row that shows it
wherever such a row exists (002 §6.4.4; encoder, controller and drive values with that prefix), so
that a device binds rows to fields by name.

Positions are in the axis unit (mm, degree), times in seconds, flags 0 or 1.
"""

import math
import struct
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import TYPE_CHECKING, Any

__all__ = [
    "COMMAND_BUFFER",
    "DRIVE_DELAY",
    "FIELDS",
    "RECORD_SIZE",
    "SEGMENTS",
    "AxisFields",
    "AxisInputFields",
    "AxisInternalFields",
    "AxisParameterFields",
    "AxisStateFields",
    "Field",
    "Role",
    "SlotsRecord",
    "pack_record",
    "record_dtype",
]

COMMAND_BUFFER = 8
"""Commands that can wait behind the active one; one more is refused with 0x4292."""

SEGMENTS = 12
"""Room of the set-point table; the planner's MAX_SEGMENTS."""

DRIVE_DELAY = 16
"""Longest dead time of the simulated drive, in cycles."""


class Role(Enum):
    """What a field is for, which is also who may write it."""

    PARAMETER = "configured, written by parameter services"
    INPUT = "written each PLC cycle or by functions, read by the kernel"
    STATE = "written by the kernel, read by everybody"
    INTERNAL = "the kernel's own memory"


@dataclass(slots=True)
class Field:
    """One declared value: `length` 0 is a scalar, otherwise a fixed array.

    `least` and `most` bound what may be written to a parameter or input.
    """

    default: float | int
    unit: str
    doc: str
    length: int = 0
    least: float = -math.inf
    most: float = math.inf
    name: str = ""
    role: Role = Role.INTERNAL
    offset: int = 0
    """Position in the record, in words of 8 bytes."""

    @property
    def is_real(self) -> bool:
        return isinstance(self.default, float)

    @property
    def words(self) -> int:
        return self.length or 1


# Any: the declarations below are annotated with the type of the value, not of its description
def _real(
    default: float, unit: str, doc: str, least: float = -math.inf, most: float = math.inf
) -> Any:
    return Field(default, unit, doc, least=least, most=most)


def _whole(default: int, unit: str, doc: str, least: float = 0, most: float = 0xFFFF_FFFF) -> Any:
    return Field(default, unit, doc, least=least, most=most)


def _flag(default: int, doc: str) -> Any:
    return Field(default, "0/1", doc, least=0, most=1)


def _reals(length: int, unit: str, doc: str) -> Any:
    return Field(0.0, unit, doc, length)


def _wholes(length: int, unit: str, doc: str) -> Any:
    return Field(0, unit, doc, length)


class AxisParameterFields:
    """Parameters of axis, encoder, controller, drive and simulation (002 §6.4.4.1, 0x4000+ID)."""

    # axis
    axis_id: int = _whole(0, "1", "axis id 1..255")
    max_velocity: float = _real(2000.0, "mm/s", "largest velocity of a command", 1e-3, 1e10)
    max_acceleration: float = _real(1e5, "mm/s²", "largest acceleration of a command", 0.01, 1e10)
    max_deceleration: float = _real(1e6, "mm/s²", "largest deceleration of a command", 0.01, 1e10)
    default_acceleration: float = _real(
        1500.0, "mm/s²", "acceleration unless a command gives one", 0.01, 1e10
    )
    default_deceleration: float = _real(
        1500.0, "mm/s²", "deceleration unless a command gives one", 0.01, 1e10
    )
    default_jerk: float = _real(2250.0, "mm/s³", "jerk unless a command gives one", 0.1, 1e12)
    fast_axis_stop_deceleration: float = _real(
        0.0,
        "mm/s²",
        "deceleration of the stop after an error; 0 = that of the running command",
        0.0,
        1e10,
    )
    fast_axis_stop_jerk: float = _real(
        0.0, "mm/s³", "jerk of the stop after an error; 0 = that of the running command", 0.0, 1e12
    )
    override_type: int = _whole(1, "OverrideType", "what 100 % override relates to", 1, 4)
    unit_interpretation: int = _whole(0, "bits", "bit 2: modulo axis", 0, 7)
    position_range_monitoring_enable: int = _flag(1, "position window is watched")
    position_range_window: float = _real(5.0, "mm", "half width of the position window", 0.0, 1e6)
    target_position_monitoring_enable: int = _flag(1, "target window is watched")
    target_position_window: float = _real(2.0, "mm", "half width of the target window", 0.0, 1e6)
    target_position_monitoring_time: float = _real(
        0.02, "s", "time inside until arrival counts", 0.0, 600.0
    )
    peh_monitoring_enable: int = _flag(0, "arrival in the target window is supervised")
    peh_monitoring_time: float = _real(5.0, "s", "time from logical end to arrival", 0.0, 600.0)
    motion_monitoring_enable: int = _flag(0, "physical movement is supervised")
    motion_monitoring_window: float = _real(0.1, "mm", "movement that counts as movement", 0.0, 1e6)
    motion_monitoring_time: float = _real(0.5, "s", "time in which it must be seen", 0.0, 600.0)
    error_reaction_mode: int = _whole(0, "1", "0 at once, 1 delayed", 0, 1)
    error_reaction_delay: float = _real(0.0, "s", "delay of the reaction in mode 1", 0.0, 1000.0)

    # encoder
    encoder_scaling_factor: float = _real(1e-4, "mm/INC", "distance of one increment", 1e-12, 1e3)
    encoder_position_offset: float = _real(0.0, "mm", "added to the scaled count", -1e9, 1e9)
    encoder_count_direction: int = _flag(0, "counting direction is inverted")
    encoder_is_absolute: int = _flag(0, "encoder is absolute: its position cannot be set")
    encoder_modulo_factor: float = _real(360.0, "mm", "length of a modulo period", 1e-3, 1e9)
    encoder_modulo_tolerance_window: float = _real(
        0.0, "mm", "a directed modulo start goes back within this window", 0.0, 5e8
    )
    encoder_soft_limit_min_enable: int = _flag(0, "lower software limit is watched")
    encoder_soft_limit_max_enable: int = _flag(0, "upper software limit is watched")
    encoder_soft_limit_min: float = _real(0.0, "mm", "lower software limit", -1e10, 1e10)
    encoder_soft_limit_max: float = _real(0.0, "mm", "upper software limit", -1e10, 1e10)
    encoder_position_filter_time: float = _real(
        0.0, "s", "PT1 filter of the actual position", 0.0, 60.0
    )
    encoder_velocity_filter_time: float = _real(
        0.01, "s", "PT1 filter of the actual velocity", 0.0, 60.0
    )
    encoder_acceleration_filter_time: float = _real(
        0.1, "s", "PT1 filter of the actual acceleration", 0.0, 60.0
    )

    # controller
    controller_position_kv: float = _real(
        20.0, "1/s", "proportional gain of the position loop", 0.0, 1000.0
    )
    controller_velocity_feedforward_weight: float = _real(
        1.0, "1", "share of set velocity added", 0.0, 1.0
    )
    controller_output_limit: float = _real(
        0.5, "1", "largest controller part of full output", 0.0, 1.0
    )
    controller_position_dead_band: float = _real(
        0.0, "mm", "error that is not acted upon", 0.0, 1e4
    )
    controller_following_error_position_monitoring_enable: int = _flag(
        1, "position following error is supervised"
    )
    controller_following_error_position_max: float = _real(
        5.0, "mm", "largest following error", 0.0, 1e6
    )
    controller_following_error_position_filter_time: float = _real(
        0.02, "s", "time above it until error 0x4550", 0.0, 600.0
    )
    controller_following_error_velocity_monitoring_enable: int = _flag(
        0, "velocity following error is supervised"
    )
    controller_following_error_velocity_max: float = _real(
        500.0, "mm/s", "largest velocity following error", 0.0, 1e6
    )
    controller_following_error_velocity_filter_time: float = _real(
        0.02, "s", "time above it until error 0x4551", 0.0, 600.0
    )

    # drive
    drive_motor_polarity: int = _flag(0, "motor turns the other way round")
    drive_reference_velocity: float = _real(2200.0, "mm/s", "velocity at 100 % output", 1e-3, 1e10)
    drive_output_limit_min: float = _real(-1.0, "1", "lowest output", -1.0, 1.0)
    drive_output_limit_max: float = _real(1.0, "1", "highest output", -1.0, 1.0)

    # simulated drive
    simulation_ideal: int = _flag(0, "the drive follows the set position without error")
    simulation_time_constant: float = _real(
        0.004, "s", "first-order lag of the drive's velocity", 0.0, 10.0
    )
    simulation_dead_time: float = _real(
        0.0, "s", "delay from output to drive, 16 cycles at most", 0.0, 1.0
    )
    simulation_blocked: int = _flag(0, "the motor is stuck (fault injection)")
    simulation_not_ready: int = _flag(0, "the drive reports not ready (fault injection)")


class AxisInputFields:
    """Cyclic interface from the PLC and switches set by functions (002 §6.4.4.4, 0x4300+ID)."""

    control_dword: int = _whole(
        0, "bits", "bit 0 enable, 1 feed enable plus, 2 minus, 5 homing cam"
    )
    velocity_override: int = _whole(0, "1e-6", "velocity override, 1000000 = 100 %")
    axis_disabled: int = _flag(0, "whole axis is deactivated (function 0x50)")
    drive_output_disabled: int = _flag(0, "drive output is switched off (function 0x60)")
    external_error: int = _whole(0, "NcError", "error injected from outside (function 0x19)")


class AxisStateFields:
    """What the axis shows (002 §6.4.4.2, 0x4100+ID and the cyclic interface to the PLC)."""

    error_code: int = _whole(0, "NcError", "error of the axis, 0 = none")
    delayed_error_code: int = _whole(0, "NcError", "error whose reaction is delayed")
    state_dword: int = _whole(0, "StateBit", "status double word")
    operation_mode_state_dword: int = _whole(0, "OperationModeBit", "active monitoring functions")
    motion_state: int = _whole(0, "MotionState", "what the set-point generator does")
    homing_state: int = _whole(0, "1", "step of the homing sequence, 0 = done")
    coupling_state: int = _whole(0, "1", "0 single, 1 master, 2 both, 3 slave")
    homed: int = _flag(0, "axis is homed")

    set_cycle_counter: int = _whole(0, "1", "cycles of this axis")
    set_position: float = _real(0.0, "mm", "set position")
    set_velocity: float = _real(0.0, "mm/s", "set velocity")
    set_acceleration: float = _real(0.0, "mm/s²", "set acceleration")
    set_jerk: float = _real(0.0, "mm/s³", "set jerk")
    set_direction: float = _real(0.0, "1", "-1, 0, 1: sign of the set velocity")
    set_position_modulo: float = _real(0.0, "mm", "set position within its period")
    set_modulo_turns: int = _whole(0, "1", "period of the set position")
    set_motion_phase: int = _whole(0, "1", "0 no job, 1 to a position, 2 endless, 3 stopping")
    target_position: float = _real(0.0, "mm", "position where the axis will stand")
    remaining_time: float = _real(0.0, "s", "until the set point arrives")
    remaining_distance: float = _real(0.0, "mm", "until the set point arrives")
    last_positioning_time: float = _real(0.0, "s", "last job, from start to target window")
    set_command_number: int = _whole(0, "1", "number of the active command, 16 bits")
    set_command_state: int = _whole(0, "CommandState", "state of the active command")

    actual_position: float = _real(0.0, "mm", "actual position")
    actual_position_modulo: float = _real(0.0, "mm", "actual position within its period")
    actual_modulo_turns: int = _whole(0, "1", "period of the actual position")
    actual_velocity: float = _real(0.0, "mm/s", "actual velocity, filtered")
    actual_velocity_unfiltered: float = _real(0.0, "mm/s", "actual velocity of this cycle")
    actual_acceleration: float = _real(0.0, "mm/s²", "actual acceleration, filtered")
    encoder_actual_position_unfiltered: float = _real(0.0, "mm", "position before the PT1 filter")
    encoder_hardware_increments: int = _whole(0, "INC", "count of the encoder, 32 bits signed")
    encoder_software_increments: int = _whole(0, "INC", "count without overflow")
    encoder_set_position_offset: float = _real(0.0, "mm", "shift made by 'set actual position'")

    following_error: float = _real(0.0, "mm", "set minus actual position")
    following_error_peak_negative: float = _real(0.0, "mm", "smallest following error so far")
    following_error_peak_positive: float = _real(0.0, "mm", "largest following error so far")
    following_error_velocity: float = _real(0.0, "mm/s", "set minus actual velocity")
    controller_output: float = _real(0.0, "mm/s", "output of the position controller")
    controller_output_percent: float = _real(0.0, "%", "the same of full output")
    drive_output: float = _real(0.0, "mm/s", "total output to the drive")
    drive_output_percent: float = _real(0.0, "%", "the same of full output")
    drive_limit_active: int = _flag(0, "the output is held at a limit")
    drive_output_peak_negative: float = _real(0.0, "mm/s", "smallest total output so far")
    drive_output_peak_positive: float = _real(0.0, "mm/s", "largest total output so far")

    reset_command_counter: int = _whole(0, "1", "resets so far")
    command_counter: int = _whole(0, "1", "number given to the last accepted command, 16 bits")
    motion_locked: int = _flag(0, "a stop holds the axis until the lock is released")
    has_been_stopped: int = _flag(0, "a stop was given since the last start")
    got_new_target: int = _flag(0, "the target was changed during motion")
    loop_closed: int = _flag(0, "position control loop is closed")
    in_position_range: int = _flag(0, "actual position is inside the position window")
    in_target_position: int = _flag(0, "arrived: long enough inside the target window")


class AxisInternalFields:
    """The kernel's memory from cycle to cycle."""

    resting: int = _flag(0, "nothing changes until somebody writes to the record")
    quiet_cycles: int = _whole(0, "1", "cycles without a change")

    # active command
    replan: int = _flag(0, "the set-point table must be computed anew")
    job_start_type: int = _whole(0, "StartType", "kind of the active command")
    job_velocity: float = _real(0.0, "mm/s", "commanded velocity")
    job_acceleration: float = _real(0.0, "mm/s²", "commanded acceleration")
    job_deceleration: float = _real(0.0, "mm/s²", "commanded deceleration")
    job_jerk: float = _real(0.0, "mm/s³", "commanded jerk")
    job_end_velocity: float = _real(0.0, "mm/s", "velocity at the target")
    job_direction: float = _real(0.0, "1", "direction of an endless command")
    job_timing: int = _flag(0, "positioning time is being measured")
    job_time: float = _real(0.0, "s", "positioning time so far")
    job_peak_velocity: float = _real(0.0, "mm/s", "velocity the job reaches at 100 % override")
    switch_armed: int = _whole(0, "1", "change at the switch position: 1 velocity, 2 target too")
    switch_from_below: int = _flag(0, "the switch position lies in positive direction")
    switch_position: float = _real(0.0, "mm", "where the change happens")
    switch_target: float = _real(0.0, "mm", "target from there on")
    switch_velocity: float = _real(0.0, "mm/s", "velocity from there on")

    # set-point table
    planned_override: int = _whole(0, "1e-6", "override the table was computed for")
    table_end: int = _whole(0, "1", "what follows the table: 0 rest, 1 target, 2 constant velocity")
    table_velocity: float = _real(0.0, "mm/s", "velocity at its end")
    segment_count: int = _whole(0, "1", "rows of the table")
    segment_index: int = _whole(0, "1", "active row")
    segment_elapsed: float = _real(0.0, "s", "time since its start")
    segment_position: float = _real(0.0, "mm", "position at its start")
    segment_velocity: float = _real(0.0, "mm/s", "velocity at its start")
    segment_acceleration: float = _real(0.0, "mm/s²", "acceleration at its start")
    segment_time: list[float] = _reals(SEGMENTS, "s", "duration of each row")
    segment_jerk: list[float] = _reals(SEGMENTS, "mm/s³", "jerk of each row")

    # commands waiting behind the active one, a ring
    buffer_first: int = _whole(0, "1", "oldest entry")
    buffer_count: int = _whole(0, "1", "entries")
    buffer_number: list[int] = _wholes(COMMAND_BUFFER, "1", "command number")
    buffer_start_type: list[int] = _wholes(COMMAND_BUFFER, "StartType", "kind")
    buffer_mode: list[int] = _wholes(
        COMMAND_BUFFER, "BufferMode", "transition from its predecessor"
    )
    buffer_position: list[float] = _reals(COMMAND_BUFFER, "mm", "target or distance")
    buffer_velocity: list[float] = _reals(COMMAND_BUFFER, "mm/s", "velocity")
    buffer_acceleration: list[float] = _reals(COMMAND_BUFFER, "mm/s²", "acceleration")
    buffer_deceleration: list[float] = _reals(COMMAND_BUFFER, "mm/s²", "deceleration")
    buffer_jerk: list[float] = _reals(COMMAND_BUFFER, "mm/s³", "jerk")
    buffer_end_velocity: list[float] = _reals(COMMAND_BUFFER, "mm/s", "velocity at the target")

    # monitoring
    output_cut: int = _flag(0, "an error opened the control loop; reset closes it")
    following_error_time: float = _real(0.0, "s", "time above the position window")
    following_error_velocity_time: float = _real(0.0, "s", "time above the velocity window")
    target_window_time: float = _real(0.0, "s", "time inside the target window")
    peh_time: float = _real(0.0, "s", "time since the logical end")
    motion_time: float = _real(0.0, "s", "time without movement")
    motion_position: float = _real(0.0, "mm", "where the last movement was seen")
    delayed_error_cut: int = _flag(0, "the delayed error will open the loop")
    delayed_error_time: float = _real(0.0, "s", "time since it was seen")

    # simulated drive
    plant_position: float = _real(0.0, "INC", "position of the motor")
    plant_velocity: float = _real(0.0, "mm/s", "velocity of the motor")
    delay_index: int = _whole(0, "1", "next slot of the dead-time line")
    delay_output: list[float] = _reals(DRIVE_DELAY, "mm/s", "outputs under way to the drive")


class AxisFields(AxisParameterFields, AxisInputFields, AxisStateFields, AxisInternalFields):
    """All fields of an axis, in the order of the record."""


def _declared() -> dict[str, Field]:
    fields: dict[str, Field] = {}
    offset = 0
    for section, role in (
        (AxisParameterFields, Role.PARAMETER),
        (AxisInputFields, Role.INPUT),
        (AxisStateFields, Role.STATE),
        (AxisInternalFields, Role.INTERNAL),
    ):
        for name in section.__annotations__:
            row: Field = getattr(section, name)
            row.name, row.role, row.offset = name, role, offset
            fields[name] = row
            offset += row.words
    return fields


FIELDS = _declared()
"""Every field by name, in record order."""

RECORD_SIZE = 8 * sum(row.words for row in FIELDS.values())
"""Bytes of one record."""

_LAYOUT = struct.Struct(
    "=" + "".join(f"{row.words}{'d' if row.is_real else 'q'}" for row in FIELDS.values())
)

if TYPE_CHECKING:

    class SlotsRecord(AxisFields):
        pass

else:

    class SlotsRecord:
        """One axis as a plain object: the record's form without NumPy."""

        __slots__ = tuple(FIELDS)

        def __init__(self) -> None:
            for name, row in FIELDS.items():
                setattr(self, name, [row.default] * row.length if row.length else row.default)


@cache
def record_dtype() -> Any:
    """The record as a NumPy structured dtype; imports NumPy.

    One object for all: Numba finds the type of an array by the identity of its dtype.
    """
    import numpy

    kinds = {True: numpy.float64, False: numpy.int64}
    return numpy.dtype(
        [
            (row.name, kinds[row.is_real], (row.length,))
            if row.length
            else (row.name, kinds[row.is_real])
            for row in FIELDS.values()
        ]
    )


def pack_record(record: AxisFields) -> bytes:
    """The record's bytes, equal for both forms when every value is equal."""
    values: list[float] = []
    extend: Iterable[float]
    for name, row in FIELDS.items():
        value = getattr(record, name)
        extend = value if row.length else (value,)
        values.extend(extend)
    return _LAYOUT.pack(*values)
