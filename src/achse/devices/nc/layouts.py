"""Layouts of the NC: numbers as they travel, requests, and structures read straight off an axis.

TwinCAT 2 packs structures, TwinCAT 3 aligns each field to a multiple of its size. Both forms are
served: a request is understood by its length, an answer has the form whose length was asked for.
"""

import struct
from collections import namedtuple
from collections.abc import Callable
from operator import attrgetter
from typing import Any

from achse.motion import Axis
from achse.server import Codec, Layout

__all__ = [
    "INT32",
    "INT64",
    "NC_TO_PLC_TC2",
    "NC_TO_PLC_TC3",
    "NOTHING",
    "NO_DATA",
    "ONLINE_TC2",
    "ONLINE_TC3",
    "PLC_TO_NC",
    "REAL64",
    "UINT8",
    "UINT16",
    "UINT32",
    "UINT64",
    "AxisStructure",
    "Integer",
    "OfAxis",
    "Text",
    "request",
]


class Integer:
    """A whole number of `size` bytes; one too long for it wraps, as counters do."""

    def __init__(self, size: int, *, signed: bool = False) -> None:
        self.size = size
        self.signed = signed
        self.name = f"{'' if signed else 'U'}INT{8 * size}"
        self._mask = (1 << 8 * size) - 1

    def encode(self, value: int) -> bytes:
        return (value & self._mask).to_bytes(self.size, "little")

    def decode(self, data: bytes) -> int:
        return int.from_bytes(data, "little", signed=self.signed)


REAL64 = Layout("<d")
INT32 = Integer(4, signed=True)
INT64 = Integer(8, signed=True)
UINT8 = Integer(1)
UINT16 = Integer(2)
UINT32 = Integer(4)
UINT64 = Integer(8)


class Text:
    """A text of at most `size` - 1 characters of cp1252, padded with NUL."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.name = f"STRING[{size}]"

    def encode(self, value: str) -> bytes:
        return value.encode("cp1252", "replace")[: self.size - 1].ljust(self.size, b"\0")

    def decode(self, data: bytes) -> str:
        return data.split(b"\0", 1)[0].decode("cp1252", "replace")


class OfAxis:
    """A layout of a value that `read` takes off the axis: for rows whose layouts show different."""

    def __init__(self, codec: Codec, read: Callable[[Axis], Any]) -> None:
        self.size = codec.size
        self.name = getattr(codec, "name", str(codec))
        self._codec = codec
        self._read = read

    def encode(self, axis: Axis) -> bytes:
        return self._codec.encode(self._read(axis))

    def decode(self, data: bytes) -> Any:
        return self._codec.decode(data)


class _NoData:
    """Functions without data; some clients send a byte all the same, which is passed over."""

    name = "VOID"
    size: int | None = None

    def encode(self, value: Any) -> bytes:
        return b""

    def decode(self, data: bytes) -> tuple[()]:
        return ()


NO_DATA = _NoData()


class _Nothing(_NoData):
    """A function called without data, beside longer forms: the length tells which was meant."""

    size = 0


NOTHING = _Nothing()


def _aligned(codes: list[str]) -> str:
    """`struct` codes with the gaps that put each field on a multiple of its size."""
    end = 0
    placed = ""
    for code in codes:
        width = struct.calcsize("<" + code)
        gap = 0 if code.endswith("x") else -end % width
        placed += f"{gap}x" * bool(gap) + code
        end += gap + width
    return placed


def request(**fields: str) -> tuple[Layout, ...]:
    """Layouts of a request with these fields (name = `struct` code); values are tuples.

    Two layouts, packed and aligned, where alignment leaves gaps (the reserved words of 002).
    """
    record = namedtuple("Request", fields)  # type: ignore[misc]
    codes = list(fields.values())
    forms = dict.fromkeys(("".join(codes), _aligned(codes)))
    return tuple(Layout("<" + form, record) for form in forms)


class AxisStructure:
    """A structure of `size` bytes whose fields are fields of the axis record.

    `fields` is a sequence of (`struct` code, record field); codes of "x" leave zeros and name no
    field, as do the bytes up to `size`.
    """

    def __init__(
        self, name: str, fields: tuple[tuple[str, str], ...], *, aligned: bool, size: int
    ) -> None:
        codes = [code for code, _ in fields]
        form = "<" + (_aligned(codes) if aligned else "".join(codes))
        rest = size - struct.calcsize(form)
        if rest < 0:
            raise ValueError(f"{name}: fields take {size - rest} bytes, the structure has {size}")
        form += f"{rest}x" * bool(rest)
        self.name = f"{name} ({size} bytes)"
        self.size = size
        shown = [(code, field) for code, field in fields if field]
        layout = struct.Struct(form)
        self._pack, self._unpack = layout.pack, layout.unpack
        self._fields = tuple(field for _, field in shown)
        self._values = attrgetter(*self._fields)
        self._pack_unsigned = struct.Struct(form.replace("i", "I")).pack
        self._masks = [
            None if code == "d" else (1 << 8 * struct.calcsize("<" + code)) - 1 for code, _ in shown
        ]

    def encode(self, axis: Axis) -> bytes:
        values = self._values(axis)
        try:
            return self._pack(*values)
        except struct.error:  # a count beyond its field wraps
            pairs = zip(values, self._masks, strict=True)
            return self._pack_unsigned(*(v if mask is None else v & mask for v, mask in pairs))

    def decode(self, data: bytes) -> dict[str, Any]:
        """The values by record field; for clients, as no row takes a structure in."""
        return dict(zip(self._fields, self._unpack(data), strict=True))


_ONLINE = (
    ("i", "error_code"),
    ("d", "actual_position"),
    ("d", "actual_position_modulo"),
    ("d", "set_position"),
    ("d", "set_position_modulo"),
    ("d", "actual_velocity"),
    ("d", "set_velocity"),
    ("I", "velocity_override"),
    ("d", "following_error"),
    ("d", "following_error_peak_negative"),
    ("d", "following_error_peak_positive"),
    ("d", "controller_output_percent"),
    ("d", "drive_output_percent"),
    ("I", "state_dword"),
    ("I", "control_dword"),
    ("I", "coupling_state"),
    ("I", "active_control_loop"),
)

_ONLINE_SINCE_TC3 = (
    ("d", "actual_acceleration"),
    ("d", "set_acceleration"),
    ("d", "set_jerk"),
    ("d", "set_torque"),
    ("d", "drive_actual_torque"),
    ("d", "set_torque_derivative"),
    ("d", "set_torque_offset"),
)

_NAME = "NCAXISSTATE_ONLINESTRUCT"
ONLINE_TC2 = AxisStructure(_NAME, _ONLINE, aligned=False, size=112)
ONLINE_TC3 = AxisStructure(_NAME, _ONLINE + _ONLINE_SINCE_TC3, aligned=True, size=256)

_STATES = (
    ("I", "state_dword"),
    ("I", "error_code"),
    ("I", "motion_state"),
    ("I", "operation_mode_feedback"),
    ("I", "homing_state"),
    ("I", "coupling_state"),
    ("4x", ""),  # SVB entries: a single axis has no preparation table
    ("I", "buffer_count"),
    ("I", "axis_id"),
)

_MODE_TC2 = (("I", "operation_mode_state_dword"),)
_MODE_TC3 = (("I", "operation_mode_and_cycle"),)

_POSITION = (
    ("d", "actual_position"),
    ("d", "actual_position_modulo"),
)

_LOOPS = (
    ("H", "active_control_loop"),
    ("H", "active_control_loop"),  # as commanded: a switch is carried out at once
)

_MOTION = (
    ("i", "actual_modulo_turns"),
    ("d", "actual_velocity"),
    ("d", "following_error"),
    ("d", "set_position"),
    ("d", "set_velocity"),
    ("d", "set_acceleration"),
    ("d", "target_position"),
    ("d", "set_position_modulo"),
    ("i", "set_modulo_turns"),
    ("H", "set_command_number"),
    ("H", "set_command_state"),
)

_SINCE_TC3 = (
    ("d", "set_jerk"),
    ("d", "set_torque"),
    ("d", "drive_actual_torque"),
    ("4x", ""),  # StateDWord2: avoiding collision, for movers on one track
    ("I", "touch_probe_inputs"),
    ("I", "touch_probe_status"),
    ("I", "touch_probe_counters"),
    ("24x", ""),  # cam coupling
    ("d", "drive_actual_torque_derivative"),
    ("d", "set_torque_derivative"),
    ("d", "phasing_position"),
    ("d", "set_torque_offset"),
    ("d", "actual_position_uncorrected"),
    ("d", "actual_acceleration"),
    ("I", "dc_time_stamp"),
    ("d", "user_data"),
)

_NAME = "NCTOPLC_AXIS_REF"
NC_TO_PLC_TC2 = AxisStructure(
    _NAME, _STATES + _MODE_TC2 + _LOOPS + _POSITION + _MOTION, aligned=False, size=128
)
NC_TO_PLC_TC3 = AxisStructure(
    _NAME,
    _STATES + _MODE_TC3 + _POSITION + _LOOPS + _MOTION + _SINCE_TC3,
    aligned=True,
    size=256,
)

_FROM_PLC = (
    ("I", "control_dword"),
    ("I", "velocity_override"),
    ("I", "operation_mode"),
    ("I", "operation_mode_dword"),
    ("d", "operation_mode_value"),
    ("d", "actual_position_correction"),
    ("d", "external_set_position"),
    ("d", "external_set_velocity"),
    ("d", "external_set_acceleration"),
    ("i", "external_set_direction"),
    ("4x", ""),
    ("d", "external_controller_component"),
    ("d", "gear_ratio_1"),
    ("d", "gear_ratio_2"),
    ("d", "gear_ratio_3"),
    ("d", "gear_ratio_4"),
    ("8x", ""),  # MapState, PlcCycleControl, PlcCycleCount: between a PLC and its NC
    ("d", "external_set_torque"),
)
PLC_TO_NC = AxisStructure("PLCTONC_AXIS_REF", _FROM_PLC, aligned=False, size=128)
"""Both TwinCAT 2 and 3; the last 24 bytes of the former are reserved."""
