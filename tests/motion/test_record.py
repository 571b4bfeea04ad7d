"""The axis record: one declaration, two forms with the same content."""

import random
from collections import Counter
from typing import Any

import pytest

from achse.motion import AxisParameters, Nc, commands
from achse.motion.fields.declare import Role
from achse.motion.fields.often import OFTEN
from achse.motion.fields.setpoint import SEGMENTS
from achse.motion.machine.record import AMPLIFIER, MACHINE, SENSOR
from achse.motion.port import DRIVE_IO, ENCODER_IO
from achse.motion.profiles.segments import MAX_SEGMENTS
from achse.motion.record import (
    CONTROLLER,
    DRIVE,
    ENCODER,
    FIELDS,
    JOB,
    LAYOUT,
    AxisDriveFields,
    AxisFields,
    ControllerFields,
    EncoderFields,
    JobFields,
    SlotsRecord,
    controller_record,
    drive_record,
    encoder_record,
    pack_record,
)
from achse.motion.views import Store, View
from achse.native.declare import LINE_WORDS, pack, plain_record


def test_fields_lie_one_behind_the_other() -> None:
    end = 0
    for row in LAYOUT.fields.values():
        assert row.offset == end
        end += row.words
    assert end <= LAYOUT.words < end + LINE_WORDS


LAYOUTS = {
    "axis": (LAYOUT, AxisFields, SlotsRecord),
    "encoder": (ENCODER, EncoderFields, encoder_record),
    "controller": (CONTROLLER, ControllerFields, controller_record),
    "drive": (DRIVE, AxisDriveFields, drive_record),
    "job": (JOB, JobFields, plain_record(JOB)),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_fresh_record_has_the_defaults(name: str) -> None:
    layout, _, make = LAYOUTS[name]
    record = make()
    for field, row in layout.fields.items():
        expected = [row.default] * row.length if row.length else row.default
        if row.holds is None:
            assert getattr(record, field) == (None if row.refers else expected)


@pytest.mark.parametrize("name", LAYOUTS)
def test_both_forms_have_the_same_bytes(name: str) -> None:
    layout, _, make = LAYOUTS[name]
    record, dice = make(), random.Random(1)
    (row_view,) = Store(View, layout, make, 1, compiled=True).views
    for field, row in layout.fields.items():
        if row.refers is None and row.holds is None:
            values = [
                dice.uniform(-1e6, 1e6) if row.is_real else dice.randrange(1 << 40)
                for _ in range(row.words)
            ]
            setattr(record, field, values if row.length else values[0])
            if row.length:
                for n, value in enumerate(values):
                    getattr(row_view, field)[n] = value
            else:
                setattr(row_view, field, values[0])
    assert pack(layout, record) == row_view.pack()
    if name == "axis":
        assert pack_record(record) == row_view.pack()


@pytest.mark.parametrize("name", LAYOUTS)
def test_types_follow_the_annotations(name: str) -> None:
    layout, whole, _ = LAYOUTS[name]
    annotations: dict[str, object] = {}
    for section in whole.__mro__:
        annotations |= getattr(section, "__annotations__", {})
    kinds: dict[object, tuple[bool, bool]] = {float: (True, False), int: (False, False)}
    kinds |= {list[float]: (True, True), list[int]: (False, True)}
    for field, row in layout.fields.items():
        if row.refers is None and row.holds is None:
            assert kinds[annotations[field]] == (row.is_real, row.length > 0), field


RECORDS = (
    *(LAYOUT, ENCODER, CONTROLLER, DRIVE, JOB, ENCODER_IO, DRIVE_IO),
    *(MACHINE, SENSOR, AMPLIFIER),
)


def test_what_a_usual_cycle_touches_lies_in_front() -> None:
    """In a cache line with others like it: `fields/often.py` is to be changed if this fails."""
    presets = {"control_dword": 7, "velocity_override": 1_000_000}
    nc = Nc(2_000_000, [AxisParameters(1, values=presets)], compiled=False)
    nc.cycle(3)
    commands.start(nc.axis(1), 1, 300.0, 200.0)
    nc.cycle(50)
    touched: dict[str, Counter[str]] = {layout.name: Counter() for layout in RECORDS}
    for layout in RECORDS:

        def read(
            record: Any, name: str, *, layout: Any = layout, count: Any = touched[layout.name]
        ) -> Any:
            count[name] += name in layout.fields
            return object.__getattribute__(record, name)

        layout.plain.__getattribute__ = read  # type: ignore[method-assign,assignment]
    try:
        nc.cycle(100)
    finally:
        for layout in RECORDS:
            del layout.plain.__getattribute__
    for layout in RECORDS:
        usual = {name for name, count in touched[layout.name].items() if count >= 50}
        assert usual <= set(OFTEN[layout.name]), layout.name
        assert list(layout.fields)[: len(OFTEN[layout.name])] == list(OFTEN[layout.name])


def test_defaults_are_inside_their_ranges() -> None:
    for row in FIELDS.values():
        assert row.doc
        assert row.unit
        if row.role in (Role.PARAMETER, Role.INPUT):
            assert row.least <= row.default <= row.most, row.name


def test_the_segment_table_has_room_for_every_profile() -> None:
    assert SEGMENTS >= MAX_SEGMENTS


def test_a_record_has_no_other_attributes() -> None:
    with pytest.raises(AttributeError):
        SlotsRecord().no_such_field = 1  # type: ignore[attr-defined]
