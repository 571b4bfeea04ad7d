"""Symbols by name and by address lead to the same place."""

import pytest

from achse.plc.routines.symbol_places import SymbolPlace
from tests.plc.code.conftest import Ran

TEXT = """
TYPE ST : STRUCT a : INT; b : ARRAY [1..2] OF LREAL; END_STRUCT END_TYPE
FUNCTION_BLOCK FB VAR n : UDINT; st : ST; END_VAR END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fb : ARRAY [0..2] OF FB; x : LREAL; p : POINTER TO LREAL; on : BIT; END_VAR
p := ADR(fb[1].st.b[2]);
END_PROGRAM
"""


@pytest.fixture(scope="module")
def ran() -> Ran:
    return Ran(TEXT, has_twin=False).cycle()


def _named(ran: Ran, name: str) -> SymbolPlace | None:
    assert ran.plc.bodies is not None
    return ran.plc.bodies.context.symbol_named(name)


@pytest.mark.parametrize("name", ["MAIN.fb", "main.FB[1]", "MAIN.fb[2].st", "MAIN.fb[1].st.b[2]"])
def test_place_by_name_is_found_by_address(ran: Ran, name: str) -> None:
    place = _named(ran, name)
    assert place is not None
    assert ran.plc.bodies is not None
    symbol = ran.plc.bodies.context.symbol_at(place.address, place.type.size)
    assert symbol is not None
    assert (symbol.address, symbol.type.name) == (place.address, place.type.name)


def test_pointer_leads_to_the_address_of_the_symbol(ran: Ran) -> None:
    place = _named(ran, "MAIN.fb[1].st.b[2]")
    assert place is not None
    assert (place.address, place.type.name) == (ran["p"], "LREAL")


@pytest.mark.parametrize("name", ["", "MAIN", "MAIN.none", "MAIN.fb[3]", "MAIN.p^", "MAIN.x.3"])
def test_other_names_have_no_place(ran: Ran, name: str) -> None:
    assert _named(ran, name) is None


def test_address_within_a_value_has_no_symbol(ran: Ran) -> None:
    place = _named(ran, "MAIN.x")
    assert place is not None
    assert ran.plc.bodies is not None
    assert ran.plc.bodies.context.symbol_at(place.address + 1, 4) is None
    assert ran.plc.bodies.context.symbol_at(place.address, 3) is None
    assert ran.plc.bodies.context.symbol_at(8, 8) is None


def test_types_are_found_by_name_without_case(ran: Ran) -> None:
    assert ran.plc.bodies is not None
    context = ran.plc.bodies.context
    type = context.type_named("st")
    assert type is not None
    assert (type.name, type.size) == ("ST", 24)
    assert context.type_named("ST_None") is None
