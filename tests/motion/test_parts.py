"""Encoders, controllers and drives from outside."""

import pytest

from achse.motion import AxisParameters, Nc
from achse.motion.axis import Axis
from achse.motion.features import Feature
from achse.motion.parts import VIEWS
from achse.motion.readout.shown import SHOWN
from achse.motion.record import FIELDS, PART_OF, PARTS


@pytest.fixture(params=[False, True], ids=["plain", "in memory"])
def axis(request: pytest.FixtureRequest) -> Axis:
    described = AxisParameters(
        4,
        "Press",
        encoder_ids=(1, 2),
        controller_ids=(3,),
        drive_ids=(4, 5, 6),
        values={"encoder_scaling_factor": 0.5},
        elements=[{"encoder_scaling_factor": 0.25, "drive_reference_velocity": 7.0}],
    )
    return Nc(2_000_000, [described], compiled=request.param).axis(4)


def test_each_part_is_a_record_of_its_own(axis: Axis) -> None:
    assert [encoder.scaling_factor for encoder in axis.encoders] == [0.5, 0.25]
    assert [drive.reference_velocity for drive in axis.drives] == [2200.0, 7.0, 2200.0]
    assert (axis.encoder, axis.controller, axis.drive) == (
        axis.encoders[0], axis.controllers[0], axis.drives[0],
    )  # fmt: skip
    assert [part.name for part in axis.drives] == ["Press", "Press 2", "Press 3"]
    assert {part.owner for own in axis.parts().values() for part in own} == {axis}
    assert {part.axis_id for own in axis.parts().values() for part in own} == {4}


def test_values_have_a_name_at_the_part_and_one_at_the_axis(axis: Axis) -> None:
    for name, (part, field) in PART_OF.items():
        if part and not field.length:
            value = getattr(getattr(axis, part), field.name)
            assert getattr(getattr(axis, part), name) == getattr(axis, name) == value, name
    axis.encoder_mask = 99  # type: ignore[attr-defined]
    assert axis.encoder.mask == 99
    axis.drives[1].drive_type = 9  # type: ignore[attr-defined]
    assert (axis.drives[1].type, axis.drive.type) == (9, 5)


def test_every_value_is_of_one_record() -> None:
    assert FIELDS.keys() == PART_OF.keys()
    for part, layout in PARTS.items():
        own = {field.name for kind, field in PART_OF.values() if kind == part}
        stored = {name for name, field in layout.fields.items() if field.refers is None}
        assert own == stored | SHOWN[part].keys()


def test_a_parameter_of_a_part_wakes_its_axis(axis: Axis) -> None:
    axis.features, axis.resting, axis.encoders[1].adapt = 0, 1, 0
    axis.resting = 1
    axis.encoders[1].position_filter_time = 0.5
    assert (axis.resting, axis.features, axis.encoders[1].adapt) == (0, Feature.PARAMETERS, 1)
    axis.features, axis.resting = 0, 1
    axis.drives[2].output = 3.0
    assert (axis.resting, axis.features) == (0, 0)


def test_a_value_is_in_memory_where_no_other_part_can_take_over() -> None:
    nc = Nc(2_000_000, [AxisParameters(1), AxisParameters(2, encoder_ids=(2, 3))], compiled=True)
    assert nc.axis(1).place_of("actual_position", 8) is not None
    assert nc.axis(2).place_of("actual_position", 8) is None
    assert nc.axis(2).encoders[1].place_of("actual_position", 8) is not None
    assert nc.axis(2).place_of("set_position", 8) is not None


def test_there_are_views_of_both_forms() -> None:
    assert all(len(forms) == 2 for forms in VIEWS.values())
