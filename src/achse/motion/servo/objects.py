"""The objects of a CiA 402 drive that process data may hold, as the master sees them."""

from dataclasses import dataclass
from enum import IntEnum


class ServoError(ValueError):
    """Process data by which no axis can work."""


class ServoMode(IntEnum):
    """6060h and 6061h, those that an axis uses."""

    HM = 6
    CSP = 8
    CSV = 9
    CST = 10


@dataclass(frozen=True, slots=True)
class ProcessEntry:
    """An object in the process data of a drive: where it begins, and its size in bytes."""

    index: int
    offset: int
    size: int


@dataclass(frozen=True, slots=True)
class ServoObject:
    """The field of a servo that an object is, its size in bytes, and whether it has a sign."""

    field: str
    size: int
    signed: bool


def _objects(*rows: tuple[int, str, int, bool]) -> dict[int, ServoObject]:
    return {index: ServoObject(field, size, signed) for index, field, size, signed in rows}


OUTPUT_OBJECTS = _objects(
    (0x6040, "controlword", 2, False),
    (0x6060, "mode", 1, True),
    (0x6071, "target_torque", 2, True),
    (0x607A, "target_position", 4, True),
    (0x60B1, "velocity_offset", 4, True),
    (0x60B2, "torque_offset", 2, True),
    (0x60B8, "probe_function", 2, False),
    (0x60FF, "target_velocity", 4, True),
)
"""Objects that an axis sends."""

INPUT_OBJECTS = _objects(
    (0x603F, "drive_alarm", 2, False),
    (0x6041, "statusword", 2, False),
    (0x6061, "mode_display", 1, True),
    (0x6064, "position", 4, True),
    (0x606C, "velocity", 4, True),
    (0x6077, "torque", 2, True),
    (0x60B9, "probe_status", 2, False),
    (0x60BA, "probe1_rising", 4, True),
    (0x60BB, "probe1_falling", 4, True),
    (0x60BC, "probe2_rising", 4, True),
    (0x60BD, "probe2_falling", 4, True),
    (0x60FD, "digital_inputs", 4, False),
)
"""Objects that an axis reads."""
