"""Declared types of paths."""

import pytest

from achse.st.lint.declared_types import DeclaredTypes
from achse.st.lint.uses import tracked_units, with_chains
from achse.st.syntax.parser import parse_expression
from tests.st.lint.conftest import declared

TEXT = """TYPE E_State : (Idle, Run); END_TYPE
TYPE E_Other : E_State; END_TYPE
TYPE ST_Point : STRUCT e : E_State; n : INT; END_STRUCT END_TYPE
FUNCTION F_State : E_State
END_FUNCTION
INTERFACE I_Above
PROPERTY Above : E_State
END_PROPERTY
END_INTERFACE
INTERFACE I_Part EXTENDS I_Above
METHOD Find : E_State
END_METHOD
END_INTERFACE
VAR_GLOBAL eGlobal : E_State; END_VAR
FUNCTION_BLOCK FB_Base
VAR eBase : E_Other; END_VAR
METHOD Find : E_State
END_METHOD
METHOD Start
END_METHOD
PROPERTY State : E_State
GET
END_GET
END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB EXTENDS FB_Base
VAR
    st : ST_Point;
    a : ARRAY [0..3] OF ST_Point;
    p : POINTER TO ST_Point;
    r : REFERENCE TO E_State;
    fb : ARRAY [0..1] OF FB_Base;
    i : I_Part;
    n : INT;
END_VAR
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fb : FB; e : E_State; END_VAR
END_PROGRAM
"""
NAMES = declared(TEXT).names
UNITS = tracked_units([one for one in NAMES.scopes.entries.values() if not one.is_library])
CHAIN = {unit.entry.name: chain for unit, chain in with_chains(UNITS, NAMES.scopes)}["FB"]
TYPES = DeclaredTypes(NAMES.scopes)
UNIT = NAMES.scopes.entries["fb"]


@pytest.mark.parametrize(
    "path",
    [
        "st.e", "a[1].e", "p^.e", "r", "eBase", "fb[0].eBase", "F_State()", "eGlobal", ".eGlobal",
        "MAIN.e", "MAIN.fb.st.e", "State", "Find()", "fb[0].State", "fb[1].Find()", "i.Find()",
        "i.Above", "THIS^.State", "THIS^.st.e", "MAIN.fb.Find()",
    ],
)  # fmt: skip
def test_a_path_to_an_enumeration_is_found(path: str) -> None:
    values = TYPES.values_of(parse_expression(path), CHAIN, UNIT)
    assert values is not None
    assert values.name == "E_State"


@pytest.mark.parametrize(
    "path",
    [
        "n", "st", "st.n", "a", "nothing", "st.nothing", "MAIN", "MAIN.nothing", "1", "F()", "n[1]",
        "Start()", "i.Start()", "THIS^", "THIS^.nothing", "fb[0].Start()",
    ],
)  # fmt: skip
def test_other_paths_have_no_enumeration(path: str) -> None:
    assert TYPES.values_of(parse_expression(path), CHAIN, UNIT) is None


def test_instances_of_blocks_are_known() -> None:
    (variables, *_) = CHAIN
    declared = {key: each.declaration for key, each in variables.items()}
    assert [key for key, each in declared.items() if TYPES.may_be_block(each, "")] == ["fb"]
    assert not any(TYPES.takes_several_calls(each, "") for each in declared.values())
