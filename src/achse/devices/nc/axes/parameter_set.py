"""All parameters of an axis in one answer, 0x4000 + ID:0x00: 1024 bytes, or 512 in TwinCAT 2.

The long form is the structure ST_AxisParameterSet of the PLC library, places as symbol files of
public projects print them. Of the short one only the first three fields are documented (000
§6.4.4.1): the rest are the parameter rows in their order, packed.
"""

import struct
from collections.abc import Mapping, Sequence
from typing import Any

from achse.motion import Axis
from achse.server import Service

_NAME = 31
_NS = 1e-9

PLACES: Mapping[str, int] = {
    "position_range_monitoring_enable": 48,
    "position_range_window": 56,
    "motion_monitoring_enable": 64,
    "motion_monitoring_time": 72,
    "loop_enable": 80,
    "loop_distance": 88,
    "target_position_monitoring_enable": 96,
    "target_position_window": 104,
    "target_position_monitoring_time": 112,
    "max_velocity": 120,
    "homing_velocity_towards_cam": 128,
    "homing_velocity_off_cam": 136,
    "jog_velocity_slow": 144,
    "jog_velocity_fast": 152,
    "motion_monitoring_window": 160,
    "peh_monitoring_enable": 168,
    "peh_monitoring_time": 176,
    "backlash_compensation_enable": 184,
    "backlash": 192,
    "default_acceleration": 232,
    "default_deceleration": 240,
    "default_jerk": 248,
    "encoder_id": 256,
    "encoder_type": 260,
    "encoder_name": 264,
    "encoder_scaling_numerator": 296,
    "encoder_scaling_denominator": 304,
    "encoder_scaling_factor": 312,
    "encoder_position_offset": 320,
    "encoder_count_direction": 328,
    "encoder_modulo_factor": 336,
    "encoder_mode": 344,
    "encoder_soft_limit_min_enable": 348,
    "encoder_soft_limit_max_enable": 350,
    "encoder_soft_limit_min": 352,
    "encoder_soft_limit_max": 360,
    "encoder_mask": 368,
    "encoder_sub_mask": 372,
    "encoder_actual_position_correction_enable": 376,
    "encoder_reference_system": 380,
    "encoder_actual_position_correction_filter_time": 384,
    "encoder_homing_cam_search_inverse": 392,
    "encoder_sync_pulse_search_inverse": 394,
    "encoder_reference_mode": 396,
    "encoder_reference_position": 400,
    "controller_id": 408,
    "controller_type": 412,
    "controller_name": 416,
    "controller_following_error_position_monitoring_enable": 448,
    "controller_following_error_velocity_monitoring_enable": 450,
    "controller_following_error_position_max": 456,
    "controller_following_error_position_filter_time": 464,
    "controller_position_kv": 472,
    "controller_position_tn": 480,
    "controller_position_tv": 488,
    "controller_position_td": 496,
    "controller_position_kv_fast": 504,
    "controller_position_kv_velocity_threshold": 512,
    "controller_acceleration_feedforward_ka": 520,
    "drive_id": 528,
    "drive_type": 532,
    "drive_name": 536,
    "drive_motor_polarity": 568,
    "drive_control_dword": 572,
    "drive_reference_velocity": 576,
    "drive_reference_output": 584,
    "drive_acceleration_scaling": 592,
    "drive_torque_offset_scaling": 600,
    "drive_actual_torque_scaling": 608,
    "drive_actual_torque_filter_time": 616,
    "drive_actual_torque_derivative_filter_time": 624,
    "max_acceleration": 632,
    "max_deceleration": 640,
}
"""Places of the parameter rows in the long form; before them id, type, name, cycle time in s. The
address of the hardware, bytes 200 … 227, is zero."""

_HEAD_LONG = struct.Struct("<II31sxd")
_HEAD_SHORT = struct.Struct("<I31sI")


def _encoded(row: Service, axis: Axis) -> bytes:
    target = axis if row.element is None else row.element(axis, 0)
    return row.encoder(0)(row.get(target))


def _name(axis: Axis) -> bytes:
    return axis.name.encode("cp1252", "replace")[: _NAME - 1]


def _shown(axis_id: int, name: bytes, axis_type: int) -> dict[str, Any]:
    text = name.split(b"\0", 1)[0].decode("cp1252", "replace")
    return {"axis_id": axis_id, "axis_name": text, "axis_type": axis_type}


class LongParameterSet:
    """ST_AxisParameterSet, 1024 bytes; only its head is decoded, for clients."""

    size = 1024
    name = "axis parameters (1024 bytes)"

    def __init__(self, rows: Sequence[Service]) -> None:
        known = {row.name: row for row in rows}
        self._rows = [(place, known[name]) for name, place in PLACES.items()]

    def encode(self, axis: Axis) -> bytes:
        data = bytearray(self.size)
        _HEAD_LONG.pack_into(
            data, 0, axis.axis_id, axis.axis_type, _name(axis), axis.cycle_ns * _NS
        )
        for place, row in self._rows:
            value = _encoded(row, axis)
            data[place : place + len(value)] = value
        return bytes(data)

    def decode(self, data: bytes) -> dict[str, Any]:
        axis_id, axis_type, name, _ = _HEAD_LONG.unpack_from(data)
        return _shown(axis_id, name, axis_type)


class ShortParameterSet:
    """TwinCAT 2, 512 bytes; what does not fit is left out."""

    size = 512
    name = "axis parameters (512 bytes)"

    def __init__(self, rows: Sequence[Service]) -> None:
        self._rows = rows

    def encode(self, axis: Axis) -> bytes:
        data = bytearray(_HEAD_SHORT.pack(axis.axis_id, _name(axis), axis.axis_type))
        for row in self._rows:
            value = _encoded(row, axis)
            if len(data) + len(value) > self.size:
                break
            data += value
        return bytes(data.ljust(self.size, b"\0"))

    def decode(self, data: bytes) -> dict[str, Any]:
        return _shown(*_HEAD_SHORT.unpack_from(data))
