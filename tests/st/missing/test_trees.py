"""Parts of syntax trees that tell of missing names."""

import pytest

from achse.st.declared.scopes import Scopes
from achse.st.lexis.source import Source
from achse.st.missing.trees import bases_of, is_plain, literal_text
from achse.st.syntax.parser import parse
from achse.st.syntax.tree import ArrayOf, Literal
from achse.st.syntax.units import FunctionBlock, Interface


@pytest.mark.parametrize(
    ("literal", "type"),
    [
        ("TRUE", "BOOL"),
        ("7", "DINT"),
        ("7.5", "LREAL"),
        ("UINT#7", "UINT"),
        ("T#1s", "TIME"),
        ("'text'", "STRING(255)"),
        ("E_Mode#Auto", "E_Mode"),
    ],
)
def test_literals_show_types(literal: str, type: str) -> None:
    assert literal_text(Literal("", literal)) == type


def test_bases_and_bounds() -> None:
    text = """
INTERFACE I_A EXTENDS I_B, I_C END_INTERFACE
FUNCTION_BLOCK FB_A EXTENDS FB_B VAR a : ARRAY [1..3, 0..nMost] OF INT; END_VAR
END_FUNCTION_BLOCK"""
    interface, block = parse(Source(text, "a.st")).units
    assert isinstance(interface, Interface)
    assert [base.name for base in bases_of(interface)] == ["I_B", "I_C"]
    assert isinstance(block, FunctionBlock)
    assert [base.name for base in bases_of(block)] == ["FB_B"]
    spec = block.blocks[0].variables[0].type
    assert isinstance(spec, ArrayOf)
    scopes = Scopes()
    assert [is_plain(each, scopes) for each in spec.dimensions] == [True, False]
    lists = Source("VAR_GLOBAL CONSTANT nMost : INT := 2; END_VAR", "GVL.st")
    scopes.add((parse(lists),))
    assert [is_plain(each, scopes) for each in spec.dimensions] == [True, True]
