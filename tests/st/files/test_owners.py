"""Owners of drawn bodies: unit, part, memory, result; places of exports."""

import pytest

from achse.st.files.owners import address_for_station, with_drawn_bodies
from achse.st.graphical.body import GraphicalBody
from achse.st.syntax.nodes import changed
from achse.st.syntax.parser import parse
from achse.st.syntax.units import FunctionBlock, Method

TEXT = """FUNCTION_BLOCK FB_X
VAR n : INT; END_VAR
METHOD Done : BOOL
END_METHOD
ACTION Run: END_ACTION
END_FUNCTION_BLOCK"""


def test_bodies_know_their_unit_and_part() -> None:
    (unit,) = parse(TEXT).units
    assert isinstance(unit, FunctionBlock)
    bodies = [GraphicalBody("NWL", b"<NWL />", 1000 * number, 1) for number in range(3)]
    parts = tuple(
        changed(part, body=body) for part, body in zip(unit.parts, bodies[1:], strict=True)
    )
    owners = {"Done": bodies[1].owner, "Run": bodies[2].owner}
    owner = with_drawn_bodies(changed(unit, body=bodies[0], parts=parts), {"done"})
    assert owner.name == "FB_X"
    own = bodies[0].owner
    assert (own.unit, own.part, own.keeps_memory, own.result) == ("FB_X", "", True, "")
    assert own.actions == {"run": "Run"}
    assert list(own.variables) == ["n"]
    assert (owners["Run"].keeps_memory, owners["Run"].result) == (True, "")
    assert (owners["Done"].keeps_memory, owners["Done"].result) == (False, "Done")
    assert isinstance(parts[0], Method)


def test_unit_without_drawings_stays_as_it_is() -> None:
    (unit,) = parse(TEXT).units
    assert isinstance(unit, FunctionBlock)
    assert with_drawn_bodies(unit) is unit


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("%QW9.1.0", "%Q*"),
        ("%QD0.2", "%Q*"),
        ("%IX0.16", "%I*"),
        ("%MW3", "%MW3"),
        ("%IX0.7", "%IX0.7"),
        ("%I*", "%I*"),
    ],
)
def test_place_in_a_configuration_of_hardware_is_left_to_the_station(
    address: str, expected: str
) -> None:
    assert address_for_station(address) == expected
