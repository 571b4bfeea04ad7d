"""Records from declarations."""

import struct
from typing import Any

import pytest

from achse.native.declare import Slot, lay_out, pack, plain_record, reference, within


class Body:
    angle: float = 0.5
    turns: int = 3


class Marks:
    marks: list[float] = [0.0] * 3
    count: int = Slot(7)  # type: ignore[assignment]


WHEEL = lay_out("wheel", [Body, Marks], Slot)


def test_fields_lie_one_behind_the_other() -> None:
    places = {name: (slot.offset, slot.length, slot.is_real) for name, slot in WHEEL.fields.items()}
    assert places == {
        "angle": (0, 0, True), "turns": (1, 0, False), "marks": (2, 3, True),
        "count": (5, 0, False),
    }  # fmt: skip
    assert WHEEL.words == 6


def test_a_plain_record_begins_with_the_defaults() -> None:
    plain = plain_record(WHEEL)
    first, second = plain(), plain()
    first.marks[1] = 2.5
    assert (second.angle, second.turns, second.marks, second.count) == (0.5, 3, [0.0] * 3, 7)
    with pytest.raises(AttributeError):
        first.colour = 1


def test_a_record_is_packed_in_its_layout() -> None:
    assert pack(WHEEL, plain_record(WHEEL)()) == struct.pack("=dq3dq", 0.5, 3, 0.0, 0.0, 0.0, 7)


def test_a_field_is_declared_once() -> None:
    with pytest.raises(TypeError, match="'angle' is declared twice"):
        lay_out("wheel", [Body, Body], Slot)


def test_a_reference_leads_nowhere_at_first_and_is_0_in_the_bytes() -> None:
    class Far:
        value: float = 1.5

    layout = lay_out("far", [Far], Slot)

    class Near:
        far: Any = reference(layout)
        own: int = 3

    near = lay_out("near", [Near], Slot)
    record = plain_record(near)()
    assert record.far is None
    before = pack(near, record)
    record.far = plain_record(layout)()
    assert pack(near, record) == before == struct.pack("=qq", 0, 3)


def test_a_record_holds_others() -> None:
    class Cart:
        load: int = 7
        front: Any = within(WHEEL)
        rear: Any = within(WHEEL, length=2)
        name: int = 8

    cart = lay_out("cart", [Cart], Slot)
    assert [slot.offset for slot in cart.fields.values()] == [0, 1, 7, 19]
    assert cart.words == 20
    record, other = plain_record(cart)(), plain_record(cart)()
    record.rear[1].marks[2] = 0.25
    record.front.turns = 4
    assert (other.front.turns, other.rear[1].marks) == (3, [0.0] * 3)
    wheel = 0.5, 3, 0.0, 0.0, 0.0, 7
    values = (7, 0.5, 4, *wheel[2:], *wheel, *wheel[:4], 0.25, 7, 8)
    assert pack(cart, record) == struct.pack("=q" + 3 * "dq3dq" + "q", *values)


def test_a_record_within_refers_to_nothing() -> None:
    class Near:
        wheel: Any = reference(WHEEL)

    class Holder:
        near: Any = within(lay_out("near", [Near], Slot))

    with pytest.raises(TypeError, match="'near' holds a record that refers to others"):
        lay_out("holder", [Holder], Slot)


def test_fields_can_be_in_front() -> None:
    wheel = lay_out("wheel", [Body, Marks], Slot, ("count", "turns"))
    assert list(wheel.fields) == ["count", "turns", "angle", "marks"]
    assert [slot.offset for slot in wheel.fields.values()] == [0, 1, 2, 3]
    assert pack(wheel, plain_record(wheel)()) == struct.pack("=qqd3d", 7, 3, 0.5, 0.0, 0.0, 0.0)
    with pytest.raises(KeyError):
        lay_out("wheel", [Body], Slot, ("count",))
