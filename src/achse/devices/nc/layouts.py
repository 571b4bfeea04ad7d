"""Layouts of the NC: numbers as they travel, and structures that are read straight off an axis.

Sizes differ between TwinCAT 2 (packed) and TwinCAT 3 (naturally aligned); a structure with two
forms is served in the one whose size was asked for.
"""

import struct
from operator import attrgetter
from typing import Any

from achse.motion import Axis
from achse.server import Layout

__all__ = [
    "FLAG",
    "INT32",
    "INT64",
    "NC_TO_PLC_TC2",
    "NC_TO_PLC_TC3",
    "ONLINE_TC2",
    "ONLINE_TC3",
    "REAL64",
    "UINT8",
    "UINT32",
    "AxisStructure",
    "Counter",
    "Text",
]

REAL64 = Layout("<d")
INT32 = Layout("<i")
INT64 = Layout("<q")
UINT8 = Layout("<B")
UINT32 = Layout("<I")
FLAG = Layout("<H")
"""0 or 1 in a UINT16."""


class Counter:
    """A UINT32 that a longer counter wraps into."""

    size = 4
    name = "UINT32"

    def encode(self, value: int) -> bytes:
        return (value & 0xFFFF_FFFF).to_bytes(4, "little")

    def decode(self, data: bytes) -> int:
        return int.from_bytes(data, "little")


class Text:
    """A text of at most `size` - 1 characters of cp1252, padded with NUL."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.name = f"STRING[{size}]"

    def encode(self, value: str) -> bytes:
        return value.encode("cp1252", "replace")[: self.size - 1].ljust(self.size, b"\0")

    def decode(self, data: bytes) -> str:
        return data.split(b"\0", 1)[0].decode("cp1252", "replace")


class AxisStructure:
    """A structure whose fields are fields of the axis record, or padding.

    `fields` is a sequence of (record field, struct code); the field "" is padding. `aligned`
    places each on a multiple of its size (TwinCAT 3); `size` appends zeros up to the full size.
    """

    def __init__(
        self, name: str, fields: tuple[tuple[str, str], ...], *, aligned: bool, size: int
    ) -> None:
        codes = ["<"]
        end = 0
        for _, code in fields:
            width = struct.calcsize("<" + code)
            if aligned and not code.endswith("x"):
                pad = -end % width
                codes.append(f"{pad}x" * bool(pad))
                end += pad
            codes.append(code)
            end += width
        if end > size:
            raise ValueError(f"{name}: fields take {end} bytes, the structure has {size}")
        self.name = name
        self.size = size
        self._layout = struct.Struct("".join(codes) + f"{size - end}x" * (size > end))
        self._values = attrgetter(*(field for field, _ in fields if field))

    def encode(self, axis: Axis) -> bytes:
        return self._layout.pack(*self._values(axis))

    def decode(self, data: bytes) -> Any:
        raise ValueError(f"{self.name} cannot be written")


_ONLINE_COMMON = (
    ("error_code", "i"),
    ("actual_position", "d"),
    ("actual_position_modulo", "d"),
    ("set_position", "d"),
    ("set_position_modulo", "d"),
    ("actual_velocity", "d"),
    ("set_velocity", "d"),
    ("velocity_override", "I"),
    ("following_error", "d"),
    ("following_error_peak_negative", "d"),
    ("following_error_peak_positive", "d"),
    ("controller_output_percent", "d"),
    ("drive_output_percent", "d"),
    ("state_dword", "I"),
    ("operation_mode_state_dword", "I"),
    ("coupling_state", "I"),
    ("", "4x"),  # index of the active control loop: there is one
)

ONLINE_TC2 = AxisStructure(
    "NCAXISSTATE_ONLINESTRUCT (112)", _ONLINE_COMMON, aligned=False, size=112
)
ONLINE_TC3 = AxisStructure(
    "NCAXISSTATE_ONLINESTRUCT (256)",
    (
        *_ONLINE_COMMON,
        ("actual_acceleration", "d"),
        ("set_acceleration", "d"),
        ("set_jerk", "d"),
    ),
    aligned=True,
    size=256,
)
"""Torque fields (offset 144 on) are zero: the simulated drive is a velocity drive."""

NC_TO_PLC_TC3 = AxisStructure(
    "NCTOPLC_AXIS_REF (256)",
    (
        ("state_dword", "I"),
        ("error_code", "I"),
        ("motion_state", "I"),
        ("", "4x"),  # operation mode confirmation
        ("homing_state", "I"),
        ("coupling_state", "I"),
        ("", "4x"),  # SVB entries: a single axis has no preparation table
        ("buffer_count", "I"),
        ("axis_id", "I"),
        ("operation_mode_state_dword", "I"),
        ("actual_position", "d"),
        ("actual_position_modulo", "d"),
        ("", "4x"),  # active and commanded control loop
        ("actual_modulo_turns", "i"),
        ("actual_velocity", "d"),
        ("following_error", "d"),
        ("set_position", "d"),
        ("set_velocity", "d"),
        ("set_acceleration", "d"),
        ("target_position", "d"),
        ("set_position_modulo", "d"),
        ("set_modulo_turns", "i"),
        ("set_command_number", "H"),
        ("set_command_state", "H"),
        ("set_jerk", "d"),
        ("", "88x"),  # torque, touch probe, cam coupling, phasing: not on this axis
        ("actual_position", "d"),  # without position correction, of which there is none
        ("actual_acceleration", "d"),
    ),
    aligned=True,
    size=256,
)

NC_TO_PLC_TC2 = AxisStructure(
    "NCTOPLC_AXIS_REF (128)",
    (
        ("state_dword", "I"),
        ("error_code", "I"),
        ("motion_state", "I"),
        ("", "4x"),  # operation mode confirmation
        ("homing_state", "I"),
        ("coupling_state", "I"),
        ("", "4x"),
        ("buffer_count", "I"),
        ("axis_id", "I"),
        ("operation_mode_state_dword", "I"),
        ("", "4x"),  # active and commanded control loop
        ("actual_position", "d"),
        ("actual_position_modulo", "d"),
        ("actual_modulo_turns", "i"),
        ("actual_velocity", "d"),
        ("following_error", "d"),
        ("set_position", "d"),
        ("set_velocity", "d"),
        ("set_acceleration", "d"),
        ("target_position", "d"),
        ("set_position_modulo", "d"),
        ("set_modulo_turns", "i"),
        ("set_command_number", "H"),
        ("set_command_state", "H"),
    ),
    aligned=False,
    size=128,
)
