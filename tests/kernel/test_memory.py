"""Records in memory."""

from typing import Any

from achse.kernel.declare import Slot, lay_out
from achse.kernel.memory import Rows, RowView, field_property, reader


class Wheel:
    angle: float = 0.0
    turns: int = 0
    marks: list[float] = [0.0] * 3


LAYOUT = lay_out("wheel", [Wheel], Slot)


class View(RowView):
    angle: Any = field_property(LAYOUT.fields["angle"])
    turns: Any = field_property(LAYOUT.fields["turns"])
    marks: Any = field_property(LAYOUT.fields["marks"])


def test_rows_begin_empty_and_apart() -> None:
    rows = Rows(LAYOUT, 3)
    rows.row(1)[:] = b"\xff" * 40
    assert bytes(rows.row(0)) == bytes(rows.row(2)) == bytes(40)
    assert rows.address % 8 == 0
    assert rows.count == 3


def test_a_view_has_the_fields_as_attributes() -> None:
    view = View(Rows(LAYOUT, 1).row(0))
    view.angle = 2.5
    view.turns = -3
    view.marks[2] = 0.25
    assert (view.angle, view.turns, list(view.marks)) == (2.5, -3, [0.0, 0.0, 0.25])
    assert view.wholes[1] == -3
    assert view.reals[4] == 0.25
    assert reader(LAYOUT.fields["turns"])(view) == -3
