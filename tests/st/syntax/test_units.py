"""Units in the tree: what they compare by, and the places they know."""

from dataclasses import fields, is_dataclass, replace

import pytest

from achse.st.syntax import units
from achse.st.syntax.parser import parse
from achse.st.syntax.units import (
    FunctionBlock,
    Interface,
    Method,
    Namespace,
    Program,
    Property,
    Unit,
)
from tests.public_names import public_names

NODES = [node for name in public_names(units) if is_dataclass(node := getattr(units, name))]

TEXTS = [
    "TYPE T_Alias : INT; END_TYPE",
    "FUNCTION F_Sum : INT F_Sum := 1; END_FUNCTION",
    "FUNCTION_BLOCK FB_Valve EXTENDS FB_Part END_FUNCTION_BLOCK",
    "PROGRAM MAIN VAR n : INT; END_VAR n := 1; END_PROGRAM",
    "INTERFACE I_Part METHOD Run END_METHOD END_INTERFACE",
    "NAMESPACE Own TYPE T : INT; END_TYPE END_NAMESPACE",
]


def unit(text: str) -> Unit:
    (parsed_unit,) = parse(text).check().units
    return parsed_unit


@pytest.mark.parametrize("node", NODES)
def test_places_do_not_count_and_are_not_shown(node: type) -> None:
    (place,) = (item for item in fields(node) if item.name == "at")
    assert (place.default, place.compare, place.repr) == (0, False, False)
    assert all(item.compare for item in fields(node) if item is not place)


@pytest.mark.parametrize("text", TEXTS)
def test_a_unit_knows_where_its_name_stands(text: str) -> None:
    text = f"// first\n{text}"
    tree_of_unit = unit(text)
    # The name of a name space may be a path, of which it is a part: its place is its keyword.
    sign = "NAMESPACE" if isinstance(tree_of_unit, Namespace) else tree_of_unit.name
    assert tree_of_unit.at == text.index(sign)


@pytest.mark.parametrize("text", TEXTS)
def test_the_same_unit_elsewhere_is_the_same_tree(text: str) -> None:
    here, there = unit(text), unit("\n\n" + text.replace(" ", "\n"))
    assert here == there
    assert hash(here) == hash(there)
    assert here.at != there.at


def test_a_list_of_variables_bears_the_name_of_its_file() -> None:
    (tree_of_unit,) = parse("VAR_GLOBAL a : INT; END_VAR", name="GVL_Axis").units
    assert tree_of_unit.name == "GVL_Axis"


def test_a_block_with_parts_of_each_kind() -> None:
    block = unit(
        """FUNCTION_BLOCK ABSTRACT FB EXTENDS FB_Base IMPLEMENTS I_A, I_B
        a := 1;
        METHOD PUBLIC Run : BOOL Run := TRUE; END_METHOD
        PROPERTY nCount : INT GET nCount := 1; END_GET END_PROPERTY
        ACTION Stop: a := 2; END_ACTION
        END_FUNCTION_BLOCK"""
    )
    assert isinstance(block, FunctionBlock)
    assert block.modifiers == ("ABSTRACT",)
    assert block.extends is not None
    assert block.extends.name == "FB_Base"
    assert [base.name for base in block.implements] == ["I_A", "I_B"]
    assert [(type(part), part.name) for part in block.parts] == [
        (Method, "Run"),
        (Property, "nCount"),
        (units.Action, "Stop"),
    ]
    _, counted, _ = block.parts
    assert isinstance(counted, Property)
    assert counted.get is not None
    assert counted.set is None


def test_a_body_in_another_language_is_not_an_empty_one() -> None:
    program = unit("PROGRAM P END_PROGRAM")
    assert isinstance(program, Program)
    assert program.body == ()
    assert replace(program, body=None) != program


def test_methods_of_an_interface_are_declared_only() -> None:
    interface = unit("INTERFACE I EXTENDS J METHOD m : INT END_METHOD END_INTERFACE")
    assert isinstance(interface, Interface)
    (method,) = interface.parts
    assert isinstance(method, Method)
    assert not method.body
