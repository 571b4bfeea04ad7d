"""Mentions: the units that a unit names, by declarations, bodies and drawings."""

from collections.abc import Sequence

import pytest

from achse.iec.layout import TC3_X64
from achse.st.declared.resolve import Resolver
from achse.st.lexis.source import Source
from achse.st.mentions import mentions_of
from achse.st.syntax.parser import parse

OTHERS = """
TYPE T : STRUCT n : INT; END_STRUCT END_TYPE
TYPE E : (Idle, Run); END_TYPE
{attribute 'qualified_only'}
TYPE Q : (Idle, Run); END_TYPE
INTERFACE I END_INTERFACE
FUNCTION_BLOCK B END_FUNCTION_BLOCK
FUNCTION F : INT END_FUNCTION
PROGRAM P END_PROGRAM
"""


def mentioned(text: str) -> list[str]:
    """Return the units that X of the text names."""
    names = Resolver({}, {}, TC3_X64)
    sources = [
        parse(Source(OTHERS + text, "all.st")),
        parse(Source("VAR_GLOBAL g : INT; END_VAR", "G.st"), name="G"),
        parse(Source("{attribute 'qualified_only'} VAR_GLOBAL k : INT; END_VAR", "H.st"), name="H"),
    ]
    assert not [fault for one in sources for fault in one.faults]
    names.scopes.add(sources)
    mentions = mentions_of(names.scopes.entries["x"], names.scopes)
    return sorted(entry.name for entry in mentions.units if entry.name != "X")


@pytest.mark.parametrize(
    ("text", "units"),
    [
        ("VAR v : T; END_VAR", ["T"]),
        ("VAR v : ARRAY [0..1] OF POINTER TO T; END_VAR", ["T"]),
        ("VAR v : ARRAY [0..g] OF INT; END_VAR", ["G"]),
        ("VAR v : INT := Run; END_VAR", ["E"]),
        ("VAR v : INT := Q.Run; END_VAR", ["Q"]),
        ("VAR v : REFERENCE TO I; END_VAR", ["I"]),
        ("VAR v : B(n := g); END_VAR", ["B", "G"]),
        ("VAR_EXTERNAL g : INT; END_VAR g := 1;", ["G"]),
        ("g := 1;", ["G"]),
        ("g := E#Run;", ["E", "G"]),
        ("H.k := 1;", ["H"]),
        ("k := 1;", []),
        ("P();", ["P"]),
        ("P;", ["P"]),
        ("g := Lib.F();", ["F", "G"]),
        ("g := .g + F();", ["F", "G"]),
        ("IF SIZEOF(T) > 1 THEN ; END_IF", ["T"]),
        ("CASE g OF Run: F(); END_CASE", ["E", "F", "G"]),
        ("VAR P : INT; END_VAR P := 1;", []),
        ("VAR T : T; END_VAR T.n := 1;", ["T"]),
        ("VAR v : X; END_VAR v.P := 1; v.a[1].F := 2;", []),
        ("(* P *) // F\n", []),
    ],
)
def test_mentions_are_found_in_declarations_and_bodies(text: str, units: Sequence[str]) -> None:
    assert mentioned(f"FUNCTION_BLOCK X {text} END_FUNCTION_BLOCK") == units


@pytest.mark.parametrize(
    ("text", "units"),
    [
        ("METHOD m : T VAR v : B; END_VAR F(); END_METHOD", ["B", "F", "T"]),
        ("METHOD m VAR F : INT; END_VAR F := 1; END_METHOD", []),
        ("METHOD F END_METHOD METHOD m F(); END_METHOD", []),
        ("METHOD m VAR P : INT; END_VAR END_METHOD METHOD k P(); END_METHOD", ["P"]),
        ("PROPERTY p : T GET p := F(); END_GET END_PROPERTY", ["F", "T"]),
        ("ACTION a: P(); END_ACTION", ["P"]),
    ],
)
def test_names_of_parts_hide_units(text: str, units: Sequence[str]) -> None:
    assert mentioned(f"FUNCTION_BLOCK X {text} END_FUNCTION_BLOCK") == units


def test_bases_and_interfaces_are_mentions() -> None:
    assert mentioned("FUNCTION_BLOCK X EXTENDS B IMPLEMENTS I END_FUNCTION_BLOCK") == ["B", "I"]
    assert mentioned("INTERFACE X EXTENDS I END_INTERFACE") == ["I"]
    assert mentioned("TYPE X : ARRAY [0..1] OF E := [Idle, Run]; END_TYPE") == ["E"]
