"""Numbers with names of the axis interface that its users meet: starts, buffer modes, status bits.

Source: 002 §6.5 and the cyclic axis interface (004 §5.1); the status bits 15 and 18 are TwinCAT 3.
"""

from enum import IntEnum


class StartType(IntEnum):
    """Kind of an axis start; 6, 9 and 1029 are constants of the PLC library Tc2_MC2."""

    ABSOLUTE = 1
    RELATIVE = 2
    ENDLESS_POSITIVE = 3
    ENDLESS_NEGATIVE = 4
    MODULO = 5
    ADDITIVE = 6
    ABSOLUTE_INTERNAL = 9
    MODULO_SHORTEST = 261
    MODULO_POSITIVE = 517
    MODULO_NEGATIVE = 773
    MODULO_CURRENT = 1029
    STOP_AND_LOCK = 4096
    HALT = 8192


class JogType(IntEnum):
    """Start types of manual travel (004 §3.1.2); one more is the same to smaller positions.

    Endless at a velocity of the axis, a step by its pulse distance, or one of a fixed length at the
    velocity that the command names.
    """

    SLOW = 0x110
    FAST = 0x210
    RAPID = 0x310
    PULSE = 0x120
    STEP_0_001 = 0x220
    STEP_0_01 = 0x320
    STEP_0_1 = 0x420
    STEP_1 = 0x520


class BufferMode(IntEnum):
    """Transition from the active command to the next one."""

    ABORTING = 0
    BUFFERED = 1
    BLENDING_LOW = 18
    BLENDING_PREVIOUS = 19
    BLENDING_NEXT = 20
    BLENDING_HIGH = 21


class ActualPositionType(IntEnum):
    """Reference of a new actual position."""

    ABSOLUTE = 1
    RELATIVE = 2
    MODULO = 5


class MotionState(IntEnum):
    """AxisState of an axis; those of a slave are for slaves that synchronise (004 §5.1.1)."""

    INACTIVE = 0
    RUNNING = 1
    OVERRIDE_ZERO = 2
    CONSTANT_VELOCITY = 3
    ACCELERATING = 4
    DECELERATING = 5
    SLAVE_PREPHASE = 11
    SLAVE_SYNCHRONISING = 12
    SLAVE_SYNCHRONOUS = 13
    EXTERNAL = 41
    INTERNAL_AND_EXTERNAL = 42


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
    """Masks of OpModeDWord; bits 8, 12, 13 and 22 are those of the PLC library."""

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
    OUTPUT_FILTER = 1 << 13
    POSITION_LAG_MONITORING = 1 << 16
    VELOCITY_LAG_MONITORING = 1 << 17
    SOFT_LIMIT_MIN_MONITORING = 1 << 18
    SOFT_LIMIT_MAX_MONITORING = 1 << 19
    POSITION_CORRECTION = 1 << 20
    ALLOW_SLAVE_COMMANDS = 1 << 21
    ALLOW_COMMANDS_WITH_EXTERNAL_SETPOINT = 1 << 22
    APPLICATION_REQUEST = 1 << 23


class HomingState(IntEnum):
    """Step of the homing sequence (004 §5.1.1)."""

    READY = 0
    TOWARDS_CAM = 1
    AWAIT_CAM = 2
    LEAVE_CAM = 3
    AWAIT_CAM_OFF = 4
    AWAIT_LATCH = 5
    SET_POSITION = 6
