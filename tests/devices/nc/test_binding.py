import random
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.devices.nc.binding import (
    in_sub_range,
    not_while_enabled,
    parameter,
    per_element,
    shown,
)
from achse.devices.nc.layouts import INT32, REAL64, UINT16, UINT32
from achse.motion import AxisParameters, Nc
from achse.motion.record import FIELDS
from achse.motion.states import OverrideType
from achse.server import READ, WRITE, Layout


def test_a_row_takes_unit_and_meaning_from_the_field_of_its_name() -> None:
    row = shown(0x0E, REAL64, "set_velocity", symbol="SetVelo")
    assert (row.offset, row.field, row.access) == (0x0E, "set_velocity", READ)
    assert (row.unit, row.description, row.symbol) == ("mm/s", "set velocity", "SetVelo")


def test_a_parameter_takes_its_range_from_the_field_too() -> None:
    row = parameter(0x10, REAL64, 0x4326, "position_range_window")
    assert row.access == READ | WRITE
    assert (row.minimum, row.maximum, row.code) == (0.0, 1e6, 0x4326)


def test_a_field_that_counts_an_enumeration_takes_its_members_only() -> None:
    row = parameter(0x105, UINT32, 0x430D, "override_type")
    assert row.choices is OverrideType
    assert row.unit == "1"
    assert "1=REDUCED" in row.range_text


def test_a_row_may_narrow_the_range() -> None:
    assert parameter(1, UINT32, 0x42CE, "velocity_override", maximum=10).maximum == 10


def test_the_prefixed_field_comes_first() -> None:
    assert shown(1, REAL64, "output_percent", prefix="drive_").field == "drive_output_percent"
    assert shown(1, REAL64, "actual_position", prefix="encoder_").field == "actual_position"


def test_another_field_can_be_named() -> None:
    row = shown(0xB7, UINT32, "saf_entry_count", "buffer_count")
    assert (row.name, row.field) == ("saf_entry_count", "buffer_count")


@pytest.mark.parametrize("names", [("no_such_field",), ("axis_id", "no_such_field")])
def test_a_row_that_refers_to_nothing_is_an_error(names: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match="refers to nothing"):
        shown(1, UINT32, *names)
    with pytest.raises(ValueError, match="refers to nothing"):
        parameter(1, UINT32, 0x4003, *names)


def test_what_scales_positions_is_locked_until_the_loop_is_open(bench: Any) -> None:
    with pytest.raises(DeviceError, match="axis 1 is enabled") as refusal:
        not_while_enabled(bench.axis)
    assert refusal.value.code == 0x4B42
    bench.start(1000, 200)
    bench.run(1.0)
    bench.axis.control_dword = 0
    bench.run(0.01)  # still braking, so still in control
    with pytest.raises(DeviceError):
        not_while_enabled(bench.axis)
    bench.until(lambda: not bench.axis.loop_closed)
    not_while_enabled(bench.axis)


@pytest.mark.parametrize(
    ("prefix", "base", "code"),
    [("encoder_", 0x10000, 0x4013), ("controller_", 0x20000, 0x4014), ("drive_", 0x30000, 0x4015)],
)
def test_sub_ranges_have_offset_prefix_and_only_the_standard_element(
    bench: Any, prefix: str, base: int, code: int
) -> None:
    rows = (shown(0x03, REAL64, "set_velocity"), shown(0x01, UINT32, prefix + "id", "axis_id"))
    velocity, number = in_sub_range(prefix, rows)
    assert (velocity.offset, velocity.name) == (base + 3, prefix + "set_velocity")
    assert (number.offset, number.name) == (base + 1, prefix + "id")
    assert velocity.element is not None
    assert velocity.element(bench.axis, 0) is bench.axis
    with pytest.raises(DeviceError, match="no sub-element 2") as refusal:
        velocity.element(bench.axis, 2)
    assert refusal.value.code == code


def test_the_axis_itself_is_the_only_element_of_its_rows(bench: Any) -> None:
    (row,) = per_element(shown(0x0A, REAL64, "set_position"))
    assert row.offset == 0x0A
    assert row.element is not None
    with pytest.raises(DeviceError) as refusal:
        row.element(bench.axis, 1)
    assert refusal.value.code == 0x4012


def test_samples_of_memory_are_what_a_read_gives() -> None:
    """Every row that shows a field, in both kernels, whatever bits the field has."""
    dice = random.Random(3)
    axis = Nc(2_000_000, [AxisParameters(1)], compiled=True).axis(1)
    direct = 0
    for name, field in FIELDS.items():
        if field.length or name == "element_number":
            continue
        if field.is_real:
            setattr(axis, name, dice.uniform(-1e9, 1e9))
        else:
            setattr(axis, name, dice.randint(-(1 << 63), (1 << 63) - 1))
        for codec in (REAL64,) if field.is_real else (UINT16, INT32, UINT32):
            row = shown(0x01, codec, name)
            assert row.sample is not None
            for length in (2, codec.size, 12):
                read = row.sample(axis, length)
                assert read is not None
                assert read() == row.encoder(length)(row.get(axis))[:length]
                direct += 1
    assert direct > 1_000


def test_where_there_is_no_memory_or_another_form_samples_are_read() -> None:
    plain = Nc(2_000_000, [AxisParameters(1)], compiled=False).axis(1)
    row = shown(0x0A, REAL64, "set_position")
    assert row.sample is not None
    assert row.sample(plain, 8) is None
    assert shown(0x01, Layout("<f"), "set_position").sample is None
    assert shown(0x01, UINT32, "set_position").sample is None
