"""Every expected byte is at the offset that the manuals print for it."""

import struct
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes.nc.table import named_rows
from achse.devices.nc.axes.structures import NC_TO_PLC_TC2, NC_TO_PLC_TC3, PLC_TO_NC
from achse.devices.nc.layouts import (
    INT32,
    NO_DATA,
    NOTHING,
    ONLINE_TC2,
    ONLINE_TC3,
    UINT8,
    UINT16,
    UINT32,
    AxisStructure,
    Integer,
    Text,
    codec_of,
    codecs_of,
)
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.native.backend import compiler_installed


@pytest.fixture
def axis() -> Axis:
    return Nc(2_000_000, [AxisParameters(7)], compiled=False).axis(7)


def placed(size: int, values: Mapping[int, tuple[str, float]]) -> bytes:
    """`size` bytes with values at offsets; zero elsewhere."""
    data = bytearray(size)
    for offset, (code, value) in values.items():
        assert not any(data[offset : offset + struct.calcsize(code)])
        struct.pack_into("<" + code, data, offset, value)
    return bytes(data)


# field: (struct code, value, offset in TwinCAT 2, offset in TwinCAT 3); None: not in that form
ONLINE = {
    "error_code": ("i", 0x4550, 0, 0),
    "actual_position": ("d", 1.5, 4, 8),
    "actual_position_modulo": ("d", 2.5, 12, 16),
    "set_position": ("d", 3.5, 20, 24),
    "set_position_modulo": ("d", 4.5, 28, 32),
    "actual_velocity": ("d", -5.5, 36, 40),
    "set_velocity": ("d", 6.5, 44, 48),
    "velocity_override": ("I", 500_000, 52, 56),
    "following_error": ("d", 7.5, 56, 64),
    "following_error_peak_negative": ("d", -8.5, 64, 72),
    "following_error_peak_positive": ("d", 9.5, 72, 80),
    "controller_output_percent": ("d", 10.5, 80, 88),
    "drive_output_percent": ("d", 11.5, 88, 96),
    "state_dword": ("I", 0x8000_0005, 96, 104),
    "control_dword": ("I", 0x0000_0107, 100, 108),
    "coupling_state": ("I", 3, 104, 112),
    "active_control_loop": ("I", 1, 108, 116),
    "actual_acceleration": ("d", 12.5, None, 120),
    "set_acceleration": ("d", 13.5, None, 128),
    "set_jerk": ("d", 14.5, None, 136),
    "set_torque": ("d", 15.5, None, 144),
    "drive_actual_torque": ("d", 16.5, None, 152),
    "set_torque_derivative": ("d", 17.5, None, 160),
    "set_torque_offset": ("d", 18.5, None, 168),
}

NC_TO_PLC = {
    "state_dword": ("I", 0x8000_0005, 0, 0),
    "error_code": ("I", 0x4550, 4, 4),
    "motion_state": ("I", 4, 8, 8),
    "operation_mode_feedback": ("I", 5, 12, 12),
    "homing_state": ("I", 2, 16, 16),
    "coupling_state": ("I", 3, 20, 20),
    "buffer_count": ("I", 6, 28, 28),
    "axis_id": ("I", 7, 32, 32),
    "operation_mode_state_dword": ("I", 0x000F_0083, 36, None),
    "actual_position": ("d", 1.5, 44, 40),
    "actual_position_modulo": ("d", 2.5, 52, 48),
    "actual_modulo_turns": ("i", -3, 60, 60),
    "actual_velocity": ("d", 4.5, 64, 64),
    "following_error": ("d", 5.5, 72, 72),
    "set_position": ("d", 6.5, 80, 80),
    "set_velocity": ("d", 7.5, 88, 88),
    "set_acceleration": ("d", 8.5, 96, 96),
    "target_position": ("d", 9.5, 104, 104),
    "set_position_modulo": ("d", 10.5, 112, 112),
    "set_modulo_turns": ("i", -11, 120, 120),
    "set_command_number": ("H", 0xFFFE, 124, 124),
    "set_command_state": ("H", 2, 126, 126),
    "active_control_loop": ("H", 1, 40, 56),
    "set_jerk": ("d", 12.5, None, 128),
    "set_torque": ("d", 14.5, None, 136),
    "drive_actual_torque": ("d", 15.5, None, 144),
    "drive_actual_torque_derivative": ("d", 16.5, None, 192),
    "set_torque_derivative": ("d", 17.5, None, 200),
    "set_torque_offset": ("d", 18.5, None, 216),
    "phasing_position": ("d", 19.5, None, 208),
    "actual_acceleration": ("d", 13.5, None, 232),
}

LOOP_ASKED_FOR = {42: ("H", 1)}
COMPUTED = {
    36: ("I", 0x030F_0083),
    58: ("H", 1),
    156: ("I", 0b10),
    160: ("I", 0x0000_0003),
    164: ("I", 0x0500_0007),
    224: ("d", 1.5 - 0.25),
    240: ("I", 3 * 2_000_000),
    248: ("d", 77.5),
}


@pytest.mark.parametrize(
    ("structure", "fields", "size", "form", "again"),
    [
        (ONLINE_TC2, ONLINE, 112, 2, {}),
        (ONLINE_TC3, ONLINE, 256, 3, {}),
        (NC_TO_PLC_TC2, NC_TO_PLC, 128, 2, LOOP_ASKED_FOR),
        (NC_TO_PLC_TC3, NC_TO_PLC, 256, 3, COMPUTED),
    ],
    ids=["online TC2", "online TC3", "NC to PLC TC2", "NC to PLC TC3"],
)
def test_fields_stand_at_their_offsets(
    axis: Axis,
    show: Callable[[Axis, str, float], None],
    structure: AxisStructure,
    fields: Mapping[str, tuple[str, float, int | None, int]],
    size: int,
    form: int,
    again: Mapping[int, tuple[str, float]],
) -> None:
    for name, (_, value, *_) in fields.items():
        show(axis, name, value)
    axis.encoder.position_correction = 0.25
    axis.set_cycle_counter = 3
    axis.user_data_state_offset = 0x1_0017
    axis.encoder.set_position_offset = 77.5
    axis.drive.io.state8 = 0b110
    axis.encoder.latch_active = axis.encoder.probe_active[4] = axis.encoder.probe_valid[0] = 1
    axis.encoder.probe_counter[0], axis.encoder.probe_counter[4] = 4, 3
    axis.encoder.probe_counter[7] = 0x105
    offsets: dict[Any, tuple[str, float]] = {
        row[form]: row[:2] for row in fields.values() if row[form] is not None
    }
    expected = placed(size, {**offsets, **again})
    assert structure.size == size
    assert structure.encode(axis).hex() == expected.hex()
    shown = structure.decode(expected)
    computed = {
        "actual_position_uncorrected",
        "dc_time_stamp",
        "operation_mode_and_cycle",
        "touch_probe_counters",
        "touch_probe_inputs",
        "touch_probe_status",
        "user_data",
    }
    assert {name: value for name, value in shown.items() if name not in computed} == {
        name: row[1] for name, row in fields.items() if row[form] is not None
    }


PLC_TO_NC_FIELDS = {
    "control_dword": ("I", 0x8000_0127, 0),
    "velocity_override": ("I", 750_000, 4),
    "operation_mode": ("I", 3, 8),
    "operation_mode_dword": ("I", 4, 12),
    "operation_mode_value": ("d", 1.5, 16),
    "actual_position_correction": ("d", 2.5, 24),
    "external_set_position": ("d", 3.5, 32),
    "external_set_velocity": ("d", 4.5, 40),
    "external_set_acceleration": ("d", 5.5, 48),
    "external_set_direction": ("i", -1, 56),
    "external_controller_component": ("d", 6.5, 64),
    "gear_ratio_1": ("d", 7.5, 72),
    "gear_ratio_2": ("d", 8.5, 80),
    "gear_ratio_3": ("d", 9.5, 88),
    "gear_ratio_4": ("d", 10.5, 96),
    "external_set_torque": ("d", 11.5, 112),
}


def test_the_structure_from_the_plc(axis: Axis) -> None:
    for name, (_, value, _) in PLC_TO_NC_FIELDS.items():
        setattr(axis, name, value)
    expected = placed(128, {row[2]: row[:2] for row in PLC_TO_NC_FIELDS.values()})
    assert PLC_TO_NC.size == 128
    assert PLC_TO_NC.encode(axis).hex() == expected.hex()
    assert PLC_TO_NC.decode(expected) == {
        name: value for name, (_, value, _) in PLC_TO_NC_FIELDS.items()
    }


def test_a_count_beyond_its_field_wraps(
    axis: Axis, show: Callable[[Axis, str, float], None]
) -> None:
    axis.error_code = 0xFFFF_FFFF
    show(axis, "set_modulo_turns", 2**31)
    show(axis, "actual_modulo_turns", -(2**40) - 1)
    axis.set_position = 1.0
    assert ONLINE_TC3.encode(axis)[:4] == b"\xff" * 4
    data = NC_TO_PLC_TC3.encode(axis)
    assert struct.unpack_from("<Ii", data, 4)[0] == 0xFFFF_FFFF
    assert struct.unpack_from("<i", data, 60) == (-1,)
    assert struct.unpack_from("<i", data, 120) == (-(2**31),)
    assert struct.unpack_from("<d", data, 80) == (1.0,)


def test_a_structure_must_have_room_for_its_fields() -> None:
    with pytest.raises(ValueError, match="fields take 12 bytes, the structure has 8"):
        AxisStructure("S", (("I", "axis_id"), ("d", "set_position")), aligned=False, size=8)


def test_both_forms_of_a_request_mean_the_same() -> None:
    row = named_rows(0x4200)["start"]._replace(
        layout="{kind:UINT32; position:REAL64; flag:UINT16; velocity:REAL64}"
    )
    packed, aligned = map(codec_of, row.layouts)
    values = (5, 1.5, 1, -2.5)
    assert packed.encode(values) == struct.pack("<IdHd", *values)
    assert aligned.encode(values) == struct.pack("<I4xdH6xd", *values)
    assert packed.decode(packed.encode(values)) == aligned.decode(aligned.encode(values)) == values
    assert packed.decode(packed.encode(values)).velocity == -2.5


@pytest.mark.parametrize(
    ("layout", "value", "data"),
    [
        ("REAL64", 1.5, struct.pack("<d", 1.5)),
        ("UINT16", 0x1_0002, b"\2\0"),
        ("STRING[4]", "abcd", b"abc\0"),
        ("STRING[n]", "abcd", b"abcd\0"),
        ("UINT32[n]", (1, 2), struct.pack("<II", 1, 2)),
        ("{2 UINT32; 4 unused; REAL64}", (1, 2, 0.5), struct.pack("<II4xd", 1, 2, 0.5)),
    ],
)
def test_layouts_of_rows_have_codecs(layout: str, value: Any, data: bytes) -> None:
    assert codec_of(layout).encode(value) == data
    assert codecs_of((layout,)) is codec_of(layout)


def test_no_data_beside_longer_forms_has_no_length() -> None:
    alone, beside = codecs_of(("VOID",)), codecs_of(("VOID", "REAL64"))
    assert alone is NO_DATA
    assert beside == (NOTHING, codec_of("REAL64"))


@pytest.mark.parametrize(
    ("integer", "name", "size"),
    [(UINT8, "UINT8", 1), (UINT16, "UINT16", 2), (UINT32, "UINT32", 4), (INT32, "INT32", 4)],
)
def test_integers_are_named_as_in_the_manuals(integer: Integer, name: str, size: int) -> None:
    assert (integer.name, integer.size) == (name, size)


@given(st.integers(-(2**70), 2**70))
def test_integers_wrap(value: int) -> None:
    assert UINT32.decode(UINT32.encode(value)) == value % 2**32
    assert INT32.decode(INT32.encode(value)) == (value + 2**31) % 2**32 - 2**31


def test_texts_are_padded_and_end_before_the_last_byte() -> None:
    text = Text(5)
    assert text.encode("X°") == b"X\xb0\0\0\0"
    assert text.encode("longer") == b"long\0"
    assert text.encode("轴") == b"?\0\0\0\0"
    assert text.decode(b"X\xb0\0ju") == "X°"


def test_functions_without_data_pass_over_what_comes() -> None:
    assert NO_DATA.size is None
    assert NO_DATA.decode(b"\1") == NO_DATA.decode(b"") == ()
    assert NO_DATA.encode(()) == b""


@pytest.mark.parametrize("form", [NC_TO_PLC_TC2, NC_TO_PLC_TC3, ONLINE_TC3])
@pytest.mark.parametrize("compiled", [False, True])
def test_an_axis_is_shown_alike_again_and_again(form: AxisStructure, compiled: bool) -> None:
    """Copied from memory where the record is there, by names where not."""
    if compiled and not compiler_installed():
        pytest.skip("needs llvmlite")
    nc = Nc(2_000_000, [AxisParameters(7)], compiled=compiled)
    axis = nc.axis(7)
    show = form.of(axis)
    assert show() == form.encode(axis)
    axis.control_dword, axis.velocity_override = 7, 1_000_000
    commands.start(axis, 3, 0.0, 100.0)
    for _ in range(40):
        nc.cycle()
        assert show() == form.encode(axis)
    axis.set_cycle_counter = 2**40 + 3
    axis.set_command_number = 2**17 + 5
    assert show() == form.encode(axis)
