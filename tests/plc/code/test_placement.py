"""Where storages of a typed project are."""

from typing import Any

import pytest

from achse.iec.elementary import DINT
from achse.iec.variables import Variable
from achse.plc.code.placement import MissingPlaceError, Placement, Spot
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.st.typed.places import ImageBase, StaticBase, UnitBase


def test_units_statics_and_images_have_their_place() -> None:
    variable: Variable[Any, Any] = Variable(DINT, 7, name="n")
    memory = Memory()
    placement = Placement(memory, [PlacedVariable("MAIN.n", variable, Area.FLAG, 12, 3)])
    assert placement.spot(UnitBase("Main", variable)) == Spot(Area.FLAG, 12, 3)
    assert placement.spot(ImageBase("Q")) == Spot(Area.OUTPUT, 0)
    static = StaticBase("F_Count", variable)
    with pytest.raises(MissingPlaceError, match=r"F_Count\.n"):
        placement.spot(static)
    placement.add_static(static)
    spot = placement.spot(static)
    placement.add_static(static)
    assert placement.spot(static) == spot
    assert memory[Area.DATA].read(spot.offset, 4) == b"\x07\0\0\0"
