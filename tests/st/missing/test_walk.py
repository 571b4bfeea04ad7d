"""Every missing type is found, wherever it is named."""

import pytest

from achse.st.declare import declare, examine
from achse.st.lexis.source import SourceError
from achse.st.missing.walk import MissingNames
from achse.st.syntax.parser import parse


def test_all_missing_types_at_once() -> None:
    """Those behind a missing base, in methods and in bounds, too."""
    text = """
    FUNCTION_BLOCK FB EXTENDS FB_Base IMPLEMENTS I_A
    VAR a : ARRAY [1..nMost] OF ST_A; b : ST_B; END_VAR
    METHOD M : ST_C VAR_INPUT d : ST_D; END_VAR END_METHOD
    PROPERTY P : ST_E GET VAR f : ST_F; END_VAR END_GET END_PROPERTY
    END_FUNCTION_BLOCK
    FUNCTION F : ST_G VAR_IN_OUT h : POINTER TO ST_H; END_VAR END_FUNCTION"""
    with pytest.raises(SourceError) as caught:
        declare([parse(text)])
    names = ["FB_Base", "I_A", *(f"ST_{letter}" for letter in "ABCDEFGH")]
    assert caught.value.hint.splitlines()[0] == f"missing types: {', '.join(names)}"
    messages = " ".join(fault.message for fault in caught.value.faults)
    assert all(f"no type is named '{name}'" in messages for name in names)


def test_places_of_missing_types() -> None:
    declarations, _ = examine(
        [parse("PROGRAM MAIN VAR a : T; b : ARRAY [0..1] OF Lib.T; END_VAR END_PROGRAM")]
    )
    places = MissingNames(declarations.names).places
    assert [(spec.name, spec.at) for _, spec in places] == [("T", 21), ("Lib.T", 44)]


def test_deep_and_odd_sources_end() -> None:
    deep = "x := " + "a." * 100 + "b" + " + c" * 3000 + ";"
    for odd in (
        f"PROGRAM MAIN VAR a : A; END_VAR {deep} END_PROGRAM",
        "FUNCTION_BLOCK A EXTENDS B c := d; END_FUNCTION_BLOCK"
        " FUNCTION_BLOCK B EXTENDS A END_FUNCTION_BLOCK",
        "TYPE T : T; END_TYPE PROGRAM P VAR t : T; END_VAR t.a := 1; END_PROGRAM",
        "TYPE T : U; END_TYPE TYPE U : REFERENCE TO T; END_TYPE"
        " PROGRAM P VAR t : T; END_VAR t[1].a := 1; END_PROGRAM",
    ):
        declarations, _ = examine([parse(odd)])
        MissingNames(declarations.names)
