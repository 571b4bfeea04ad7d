"""Numbers with names that the axis interface carries: start types, buffer modes, status bits.

Source: 002 §6.5 and the cyclic axis interface (004 §5.1); the status bits 15 and 18 are TwinCAT 3.
"""

from enum import IntEnum

__all__ = [
    "ActualPositionType",
    "BufferMode",
    "CommandState",
    "ControlBit",
    "EndPositionType",
    "MotionPhase",
    "MotionState",
    "NewEndPositionCommand",
    "OperationModeBit",
    "OverrideType",
    "StartType",
    "StateBit",
]


class StartType(IntEnum):
    """Kind of an axis start."""

    ABSOLUTE = 1
    RELATIVE = 2
    ENDLESS_POSITIVE = 3
    ENDLESS_NEGATIVE = 4
    MODULO = 5
    MODULO_SHORTEST = 261
    MODULO_POSITIVE = 517
    MODULO_NEGATIVE = 773
    STOP_AND_LOCK = 4096
    HALT = 8192


class BufferMode(IntEnum):
    """How a command follows the active one."""

    ABORTING = 0
    BUFFERED = 1
    BLENDING_LOW = 18
    BLENDING_PREVIOUS = 19
    BLENDING_NEXT = 20
    BLENDING_HIGH = 21


class EndPositionType(IntEnum):
    """How a new end position is meant."""

    ABSOLUTE = 1
    RELATIVE = 2
    ENDLESS_POSITIVE = 3
    ENDLESS_NEGATIVE = 4
    MODULO = 5


class NewEndPositionCommand(IntEnum):
    """What function 0x12 changes, and when."""

    POSITION = 1
    VELOCITY = 2
    POSITION_AND_VELOCITY = 3
    POSITION_AT_SWITCH_POSITION = 9
    VELOCITY_AT_SWITCH_POSITION = 10
    POSITION_AND_VELOCITY_AT_SWITCH_POSITION = 11


class ActualPositionType(IntEnum):
    """How a set actual position is meant."""

    ABSOLUTE = 1
    RELATIVE = 2
    MODULO = 5


class OverrideType(IntEnum):
    """What 100 % override relates to: the velocity the move would reach, or the commanded one."""

    REDUCED = 1
    ORIGINAL = 2
    REDUCED_ITERATED = 3
    ORIGINAL_ITERATED = 4


class MotionPhase(IntEnum):
    """What the set-point generator works on; our numbers, the manuals print none."""

    NONE = 0
    POSITIONING = 1
    ENDLESS = 2
    STOPPING = 3


class MotionState(IntEnum):
    """AxisState of a master axis."""

    INACTIVE = 0
    RUNNING = 1
    OVERRIDE_ZERO = 2
    CONSTANT_VELOCITY = 3
    ACCELERATING = 4
    DECELERATING = 5


class CommandState(IntEnum):
    """State of a command; our numbers, the manuals print none."""

    NONE = 0
    ACTIVE = 1
    BUFFERED = 2
    DONE = 3
    ABORTED = 4


class ControlBit(IntEnum):
    """Masks of ControlDWord."""

    ENABLE = 1 << 0
    FEED_ENABLE_PLUS = 1 << 1
    FEED_ENABLE_MINUS = 1 << 2
    HOMING_SENSOR = 1 << 5
    ACCEPT_BLOCKED_DRIVE = 1 << 8


class StateBit(IntEnum):
    """Masks of StateDWord."""

    OPERATIONAL = 1 << 0
    HOMED = 1 << 1
    NOT_MOVING = 1 << 2
    IN_POSITION_AREA = 1 << 3
    IN_TARGET_POSITION = 1 << 4
    PROTECTED = 1 << 5
    ERROR_PROPAGATION_DELAYED = 1 << 6
    HAS_BEEN_STOPPED = 1 << 7
    HAS_JOB = 1 << 8
    POSITIVE_DIRECTION = 1 << 9
    NEGATIVE_DIRECTION = 1 << 10
    HOMING_BUSY = 1 << 11
    CONSTANT_VELOCITY = 1 << 12
    COMPENSATING = 1 << 13
    EXTERNAL_SETPOINT_ENABLED = 1 << 14
    PHASING_ACTIVE = 1 << 15
    EXTERNAL_LATCH_VALID = 1 << 16
    NEW_TARGET_POSITION = 1 << 17
    DRIVE_LIMIT_ACTIVE = 1 << 18
    CONTINUOUS_MOTION = 1 << 19
    CONTROL_LOOP_CLOSED = 1 << 20
    CAM_TABLE_QUEUED = 1 << 21
    CAM_DATA_QUEUED = 1 << 22
    CAM_SCALING_PENDING = 1 << 23
    COMMAND_BUFFERED = 1 << 24
    PTP_MODE = 1 << 25
    SOFT_LIMIT_MIN_EXCEEDED = 1 << 26
    SOFT_LIMIT_MAX_EXCEEDED = 1 << 27
    DRIVE_DEVICE_ERROR = 1 << 28
    MOTION_COMMANDS_LOCKED = 1 << 29
    IO_DATA_INVALID = 1 << 30
    ERROR = 1 << 31


class OperationModeBit(IntEnum):
    """Masks of OpModeDWord."""

    POSITION_AREA_MONITORING = 1 << 0
    TARGET_POSITION_MONITORING = 1 << 1
    LOOP = 1 << 2
    MOTION_MONITORING = 1 << 3
    PEH_TIME_MONITORING = 1 << 4
    BACKLASH_COMPENSATION = 1 << 5
    DELAYED_ERROR_REACTION = 1 << 6
    MODULO = 1 << 7
    SIMULATION = 1 << 8
    STOP_MONITORING = 1 << 12
    POSITION_LAG_MONITORING = 1 << 16
    VELOCITY_LAG_MONITORING = 1 << 17
    SOFT_LIMIT_MIN_MONITORING = 1 << 18
    SOFT_LIMIT_MAX_MONITORING = 1 << 19
    POSITION_CORRECTION = 1 << 20
    ALLOW_SLAVE_COMMANDS = 1 << 21
