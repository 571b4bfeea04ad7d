"""Blocks find their parts and interfaces through all they extend."""

from achse.iec.derived import InterfaceType
from achse.iec.structs import StructType
from achse.st.check.blocks import Blocks
from achse.st.declare import declare
from achse.st.syntax.parser import parse

SOURCE = """
INTERFACE I_A METHOD Go END_METHOD END_INTERFACE
INTERFACE I_B EXTENDS I_A METHOD Stop END_METHOD END_INTERFACE
FUNCTION_BLOCK FB_A IMPLEMENTS I_B
    METHOD Go END_METHOD
    METHOD Stop END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_B EXTENDS FB_A
    METHOD Go END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_C END_FUNCTION_BLOCK
"""
NAMES = declare([parse(SOURCE)]).names
BLOCKS = Blocks(NAMES)


def test_the_nearest_part_is_found() -> None:
    derived = NAMES.scopes.entries["fb_b"]
    assert [entry.name for entry in BLOCKS.chain(derived)] == ["FB_B", "FB_A"]
    go, stop = BLOCKS.part(derived, "go"), BLOCKS.part(derived, "stop")
    assert go is not None
    assert stop is not None
    assert (go.entry.name, stop.entry.name) == ("FB_B", "FB_A")
    assert BLOCKS.part(derived, "pause") is None


def test_an_interface_has_the_methods_of_those_it_extends() -> None:
    part = BLOCKS.part(NAMES.scopes.entries["i_b"], "go")
    assert part is not None
    assert part.entry.name == "I_A"


def test_interfaces_are_inherited() -> None:
    assert BLOCKS.interfaces(NAMES.scopes.entries["fb_b"]) == {"i_a", "i_b"}
    blocks = [NAMES.scopes.entries[key].type for key in ("fb_b", "fb_c")]
    interface = NAMES.scopes.entries["i_a"].type
    assert isinstance(interface, InterfaceType)
    answers = [BLOCKS.implements(b, interface) for b in blocks if isinstance(b, StructType)]
    assert answers == [True, False]
