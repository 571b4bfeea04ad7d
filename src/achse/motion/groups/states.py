"""Numbers with names of groups and channels (002 §6.5)."""

from enum import IntEnum


class ChannelType(IntEnum):
    """Kind of work of a channel."""

    NONE = 0
    STANDARD = 1
    INTERPRETER = 2
    FIFO = 3
    KINEMATIC_TRANSFORMATION = 4


class InterpreterType(IntEnum):
    """The language of a channel's programs; 002 calls 2 "classic", 000 "Siemens dialect"."""

    NONE = 0
    GST = 1
    CLASSIC = 2


class GroupType(IntEnum):
    """Kind of motion of a group; the manual names no other than PTP for a single axis."""

    NOT_DEFINED = 0
    PTP = 1
    ONE_D = 2
    TWO_D = 3
    THREE_D = 4
    RAPID_CREEP = 5
    LOW_COST_STEPPER = 6
    TABLE = 7
    ENCODER = 9
    FIFO = 11
    KINEMATIC = 12


class SafState(IntEnum):
    """State of a group in the set-point task; our numbers, the manuals print none."""

    IDLE = 0
    READY = 1
    RUNNING = 2
    STOPPING = 3
    ERROR = 4


class FifoInterpolation(IntEnum):
    """Interpolation between two rows of a FIFO."""

    LINEAR = 0
    FOUR_POINT = 1
    CUBIC_SPLINE = 4


class FifoOverrideType(IntEnum):
    """Transition of a FIFO to another override."""

    INSTANTANEOUS = 1
    PT2 = 2
