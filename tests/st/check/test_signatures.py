"""Signatures: what a routine takes, gives and keeps."""

from achse.st.check.signatures import Routines, attributes_in
from achse.st.declare import declare
from achse.st.syntax.parser import parse
from achse.st.syntax.units import FunctionBlock, Method, Property
from achse.st.typed.project import RoutineKind

SOURCE = """
{attribute 'builtin'}
FUNCTION F : INT
VAR_INPUT a : BYTE; END_VAR
VAR_IN_OUT b : LREAL; c : ARRAY [*, *] OF INT; END_VAR
VAR_OUTPUT d : BOOL; END_VAR
VAR e : INT := 5; END_VAR
VAR_STAT f : INT; END_VAR
VAR CONSTANT g : INT := 3; END_VAR
END_FUNCTION
FUNCTION_BLOCK FB
VAR_INPUT i : INT; END_VAR
VAR_TEMP t : INT; END_VAR
METHOD ABSTRACT M VAR_INST k : INT; END_VAR END_METHOD
PROPERTY P : INT GET END_GET SET VAR x : INT; END_VAR END_SET END_PROPERTY
END_FUNCTION_BLOCK
"""
NAMES = declare([parse(SOURCE)]).names
ROUTINES = Routines(NAMES)


def test_a_function_has_result_parameters_and_locals_in_its_frame() -> None:
    signature = ROUTINES.of_function(NAMES.scopes.entries["f"])
    assert [variable.name for variable in signature.frame.variables] == [
        "F", "a", "b", "c", "__c_lower1", "__c_upper1", "__c_lower2", "__c_upper2", "d", "e",
    ]  # fmt: skip
    assert [
        (item.variable.name, item.section, item.type.name) for item in signature.parameters
    ] == [
        ("a", "VAR_INPUT", "BYTE"),
        ("b", "VAR_IN_OUT", "LREAL"),
        ("c", "VAR_IN_OUT", "INT"),
        ("d", "VAR_OUTPUT", "BOOL"),
    ]
    assert set(signature.statics) == {"f", "g"}
    assert signature.kind is RoutineKind.FUNCTION
    assert ROUTINES.of_function(NAMES.scopes.entries["f"]) is signature
    assert "builtin" in attributes_in(signature.tree)


def test_the_body_of_a_block_has_its_parameters_in_the_instance() -> None:
    signature = ROUTINES.of_body(NAMES.scopes.entries["fb"])
    assert [variable.name for variable in signature.frame.variables] == ["t"]
    assert [(item.variable.name, item.variable.offset) for item in signature.parameters] == [
        ("i", 8)
    ]


def test_methods_keep_their_var_inst_in_the_block() -> None:
    entry = NAMES.scopes.entries["fb"]
    assert isinstance(entry.tree, FunctionBlock)
    method, accessor = entry.tree.parts
    assert isinstance(method, Method)
    assert isinstance(accessor, Property)
    signature = ROUTINES.of_method(entry, method)
    assert (signature.members, signature.is_abstract) == ({"k": "__M__k"}, True)
    get = ROUTINES.of_accessor(entry, accessor, get=True)
    set = ROUTINES.of_accessor(entry, accessor, get=False)
    assert get is not None
    assert set is not None
    assert (get.key, get.kind, get.result and get.result.name) == (
        "fb.__getp", RoutineKind.GET, "P",
    )  # fmt: skip
    assert [variable.name for variable in set.frame.variables] == ["P", "x"]
