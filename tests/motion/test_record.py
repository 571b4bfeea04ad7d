"""The axis record: one declaration, two forms with the same content."""

import random

import pytest

from achse.motion.axis import WordsAxis
from achse.motion.record import (
    FIELDS,
    LAYOUT,
    SEGMENTS,
    AxisFields,
    Role,
    SlotsRecord,
    pack_record,
)
from achse.motion.segments import MAX_SEGMENTS
from achse.native.memory import Rows


def test_fields_lie_one_behind_the_other() -> None:
    end = 0
    for row in LAYOUT.fields.values():
        assert row.offset == end
        end += row.length or 1
    assert end == LAYOUT.words


def test_a_fresh_record_has_the_defaults() -> None:
    record = SlotsRecord()
    for name, row in FIELDS.items():
        value = getattr(record, name)
        assert value == ([row.default] * row.length if row.length else row.default)


def test_both_forms_have_the_same_bytes() -> None:
    record, dice = SlotsRecord(), random.Random(1)
    axis = WordsAxis(Rows(LAYOUT, 1), 0)
    for name, row in FIELDS.items():
        values = [
            dice.uniform(-1e6, 1e6) if row.is_real else dice.randrange(1 << 40)
            for _ in range(row.words)
        ]
        setattr(record, name, values if row.length else values[0])
        if row.length:
            for n, value in enumerate(values):
                getattr(axis, name)[n] = value
        else:
            setattr(axis, name, values[0])
    axis.resting, axis.adapt = record.resting, record.adapt
    assert pack_record(record) == axis.pack()


def test_types_follow_the_annotations() -> None:
    annotations: dict[str, object] = {}
    for section in AxisFields.__mro__:
        annotations |= getattr(section, "__annotations__", {})
    kinds = {float: (True, False), int: (False, False)}
    kinds |= {list[float]: (True, True), list[int]: (False, True)}
    for name, row in FIELDS.items():
        assert kinds[annotations[name]] == (row.is_real, row.length > 0), name  # type: ignore[index]


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
