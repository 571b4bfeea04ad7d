"""Views of records: both forms alike, references, and what a change tells."""

from typing import Any

import pytest

from achse.motion.fields.declare import Field, floats, real, whole
from achse.motion.views import Store, View
from achse.native.declare import lay_out, plain_record, reference, within


class Wheel:
    angle: float = real(0.5, "1", "angle")
    turns: int = whole(3, "1", "turns")
    marks: list[float] = floats(2, "1", "marks")


WHEEL = lay_out("wheel", [Wheel], Field)


class Cart:
    wheel: Wheel = reference(WHEEL, Field)
    load: int = whole(7, "1", "load")


CART = lay_out("cart", [Cart], Field)


class WheelView(View):
    changed_fields: list[str]

    def changed(self, field: Field) -> None:
        self.changed_fields = [*getattr(self, "changed_fields", []), field.name]


@pytest.fixture(params=[False, True], ids=["plain", "in memory"])
def stores(request: pytest.FixtureRequest) -> Any:
    return (
        Store(WheelView, WHEEL, plain_record(WHEEL), 2, compiled=request.param),
        Store(View, CART, plain_record(CART), 2, compiled=request.param),
    )


def test_fields_are_attributes_of_their_kind(stores: Any) -> None:
    wheel, other = stores[0].views
    assert (wheel.angle, wheel.turns, list(wheel.marks)) == (0.5, 3, [0.0, 0.0])
    wheel.angle, wheel.turns, wheel.marks[1] = 2, 5.0, 0.25
    assert (wheel.angle, wheel.turns, list(wheel.marks)) == (2.0, 5, [0.0, 0.25])
    assert (type(wheel.angle), type(wheel.turns)) == (float, int)
    assert (other.angle, other.turns) == (0.5, 3)


def test_a_change_is_reported_once(stores: Any) -> None:
    wheel = stores[0].views[0]
    wheel.angle = 0.5
    wheel.turns = 4
    wheel.turns = 4
    assert wheel.changed_fields == ["turns"]


def test_a_reference_leads_to_the_view_of_its_record(stores: Any) -> None:
    wheel, cart = stores[0].views[1], stores[1].views[0]
    before = cart.pack()
    cart.link("wheel", wheel)
    assert cart.wheel is wheel
    assert cart.pack() == before
    with pytest.raises(AttributeError):
        cart.wheel = wheel


def test_record_has_the_values_and_a_change_of_it_is_not_reported(stores: Any) -> None:
    wheel, cart = stores[0].views[1], stores[1].views[0]
    cart.link("wheel", wheel)
    record = cart.record
    record.wheel.turns = 9
    record.wheel.marks[1] = 0.75
    record.load = 2
    assert (wheel.turns, list(wheel.marks), cart.load) == (9, [0.0, 0.75], 2)
    assert not hasattr(wheel, "changed_fields")
    wheel.angle = 1.5
    assert record.wheel.angle == 1.5


def test_both_forms_have_the_same_bytes() -> None:
    packed = set()
    for compiled in (False, True):
        wheel = Store(WheelView, WHEEL, plain_record(WHEEL), 1, compiled=compiled).views[0]
        wheel.angle, wheel.marks[0] = 1.25, -3.0
        packed.add(wheel.pack())
    assert len(packed) == 1


def test_what_a_kernel_takes(stores: Any) -> None:
    arguments = stores[0].arguments
    assert arguments[-1] == 2 or len(arguments[0]) == 2


class Train:
    length: int = whole(2, "1", "length")
    engine: Wheel = within(WHEEL, Field)
    axles: list[Wheel] = within(WHEEL, Field, 3)


TRAIN = lay_out("train", [Train], Field)


class TrainView(View):
    changed_fields: list[str]

    def changed(self, field: Field) -> None:
        self.changed_fields = [*getattr(self, "changed_fields", []), field.name]


@pytest.mark.parametrize("compiled", [False, True])
def test_records_within_are_views_that_report_to_the_outer_one(compiled: bool) -> None:
    first, train = Store(TrainView, TRAIN, plain_record(TRAIN), 2, compiled=compiled).views
    before = train.pack()
    train.axles[2].turns = 5
    train.engine.angle = 1.5
    train.axles[0].marks[1] = 0.25
    assert [axle.turns for axle in train.axles] == [3, 3, 5]
    assert (train.engine.angle, list(train.axles[0].marks)) == (1.5, [0.0, 0.25])
    assert train.changed_fields == ["turns", "angle"]
    assert first.pack() == before != train.pack()
    with pytest.raises(AttributeError):
        train.engine = train.axles[0]


def test_records_within_have_the_same_bytes_in_both_forms() -> None:
    packed = set()
    for compiled in (False, True):
        train = Store(TrainView, TRAIN, plain_record(TRAIN), 1, compiled=compiled).views[0]
        train.axles[1].turns, train.engine.marks[0] = 9, -2.0
        packed.add(train.pack())
    assert len(packed) == 1
