"""Storages of parameters: counted from the frame of the called routine, or in a unit."""

from typing import Any

from achse.iec.elementary import DINT
from achse.iec.variables import Variable
from achse.st.check.parameter_places import place_beside, place_of_variable
from achse.st.typed.places import CalleeBase, Storage, UnitBase


def test_a_variable_of_a_routine_is_in_its_frame() -> None:
    place = place_of_variable(Variable(DINT).placed("n", 12, 0, apart=False), 7)
    assert (place.base, place.offset, place.name, place.at) == (CalleeBase(), 12, "n", 7)


def test_what_is_beside_a_parameter_is_where_the_parameter_is() -> None:
    size: Variable[Any, Any] = Variable(DINT).placed("n__size", 20, 0, apart=False)
    n: Variable[Any, Any] = Variable(DINT).placed("n", 12, 0, apart=False)
    inside = place_beside(place_of_variable(n, 7), size)
    assert (inside.base, inside.offset, inside.at) == (CalleeBase(), 20, 7)
    of_unit = place_beside(Storage(UnitBase("main", n), 0, DINT, name="n"), size)
    assert (of_unit.base, of_unit.offset) == (UnitBase("main", size), 0)
