"""What is declared, somewhere, is not missing."""

from achse.st.declare import examine
from achse.st.lexis.source import Source
from achse.st.missing.walk import MissingNames
from achse.st.syntax.parser import parse


def missing(text: str) -> MissingNames:
    declarations, _ = examine([parse(Source(text, "x.st"))])
    return MissingNames(declarations.names)


def test_nothing_is_missing_in_a_whole_project() -> None:
    text = """
    TYPE E : (a, b); END_TYPE
    VAR_GLOBAL CONSTANT c : INT := 3; END_VAR
    FUNCTION_BLOCK FB VAR t : TON; n : INT; END_VAR
    METHOD M : INT M := n; END_METHOD
    PROPERTY P : INT GET P := n; END_GET END_PROPERTY
    t(IN := TRUE, PT := T#1S); n := THIS^.M() + P + c + E.b + a;
    END_FUNCTION_BLOCK
    PROGRAM MAIN VAR fb : FB; p : POINTER TO FB; s : STRING; END_VAR
    p := ADR(fb); fb(); s := CONCAT(Tc2_Standard.LEFT(s, 1), INT_TO_STRING(fb.P + p^.n));
    MEMSET(ADR(s), 0, SIZEOF(s)); fb.n := SEL(fb.t.Q, 1, 2);
    IF TwinCAT_SystemInfoVarList._TaskInfo[1].CycleCount > 5 THEN RETURN; END_IF
    END_PROGRAM"""
    meanings = missing(text).meanings
    assert (meanings.types.uses, meanings.names) == ({}, {})


def test_names_behind_a_missing_base() -> None:
    """A bare name is of the base, what is in front of a dot or in a bound is of a library."""
    text = """
    FUNCTION_BLOCK FB EXTENDS FB_Base
    VAR a : ARRAY [1..cMost] OF INT; END_VAR
    bDone := Lib.bReady AND fbInner.bReady;
    END_FUNCTION_BLOCK"""
    meanings = missing(text).meanings
    assert sorted(meanings.types.uses["fb_base"].members) == ["bdone", "fbinner"]
    assert sorted(meanings.names) == ["cmost", "lib"]
    assert meanings.types.uses["fb_base"].members["bdone"].type == "BOOL"
