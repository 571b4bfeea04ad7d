"""Access to a record from outside: the same on both forms, and it wakes the axis."""

import struct
from typing import Any

import pytest

from achse.motion.readout.shown import ShownField
from achse.motion.record import FIELDS, LAYOUT, SHOWN_FIELDS
from achse.native.declare import pack, reset

WOKEN = {"resting", "features", "encoder_adapt"}
"""What a change of other values sets."""


@pytest.fixture(params=[False, True], ids=["plain", "compiled"])
def either(request: Any, make_rig: Any) -> Any:
    return make_rig(compiled=request.param)


def test_every_field_reads_as_python_number(either: Any) -> None:
    for name, row in FIELDS.items():
        value = getattr(either.axis, name)
        kind = float if row.is_real else int
        if row.length:
            assert len(value) == row.length
            assert all(type(item) is kind for item in value)
        else:
            assert type(value) is kind, name


def test_every_scalar_can_be_written_and_is_its_own(either: Any) -> None:
    written = [
        name
        for name, row in FIELDS.items()
        if not row.length and name not in WOKEN and not isinstance(row, ShownField)
    ]
    for number, name in enumerate(written):
        setattr(either.axis, name, number)
    for number, name in enumerate(written):
        assert getattr(either.axis, name) == number, name


def test_array_elements_can_be_written(either: Any) -> None:
    either.axis.profile.jerk[3] = 2.5
    either.axis.coupling.masters[3] = 7
    assert either.axis.profile.jerk[3] == 2.5
    assert either.axis.coupling.masters[3] == 7
    assert either.axis.profile.time[3] == 0.0


def test_arrays_cannot_be_replaced(either: Any) -> None:
    with pytest.raises(AttributeError):
        either.axis.profile.jerk = [0.0]


def test_jobs_are_within_the_axis_and_wake_it(either: Any) -> None:
    axis = either.axis
    before = axis.pack()
    axis.waiting[7].position = 2.5
    axis.job.number = 7
    assert [job.position for job in axis.waiting] == [0.0] * 7 + [2.5]
    assert (axis.job.number, axis.job.position) == (7, 0.0)
    assert axis.pack() != before
    either.run(100)
    assert axis.resting == 1
    axis.job.jerk = 1.0
    assert axis.resting == 0
    either.run(100)
    assert axis.resting == 1
    axis.cams[2].next.table = 4
    assert axis.resting == 0


def test_shown_value_of_a_part_has_a_name_at_the_axis(either: Any) -> None:
    axis = either.axis
    for number, (name, part, row) in enumerate(SHOWN_FIELDS, 2):
        axis.resting = 1
        setattr(axis, name, number)
        assert getattr(getattr(axis, part), row.name) == number, name
        assert axis.resting == 0, name
        place = axis.place_of(name, 8)
        assert place is not None
        assert place() == struct.pack("<d" if row.is_real else "<q", number), name


PARTS = [row.name for row, _ in LAYOUT.records_within if not row.length]


@pytest.mark.parametrize("part", PARTS)
def test_part_of_an_axis_is_reset_as_one(make_rig: Any, part: str) -> None:
    fresh = {}
    for compiled in (False, True):
        axis = make_rig(compiled=compiled).axis
        own = getattr(axis, part)
        reset(own)
        fresh[compiled] = own.pack()
        for row in own.layout.fields.values():
            if row.length:
                getattr(own, row.name)[0] = 3
            elif row.holds is None:
                setattr(own, row.name, 3)
        assert own.pack() != fresh[compiled]
        reset(own)
        assert own.pack() == fresh[compiled]
        assert axis.pack().count(own.pack())
    assert fresh[False] == fresh[True] == pack(own.layout, own.layout.plain())


def test_a_change_wakes_the_axis(either: Any) -> None:
    either.run(100)
    either.axis.control_dword = 7  # as a PLC task writes it again and again
    assert either.axis.resting == 1
    either.axis.target_position_window = 3.0
    assert either.axis.resting == 0


def test_an_axis_says_who_and_where_it_is(either: Any) -> None:
    assert repr(either.axis) == "<Axis 1 'Axis 1' at 0 mm>"
