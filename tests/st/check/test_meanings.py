"""Meanings: a name is a value, or one of the other things a name can be."""

from collections.abc import Callable

import pytest

from achse.st.check.body import RoutineBody
from achse.st.check.checking import Checking
from achse.st.check.meanings import (
    BaseInstance,
    BuiltinName,
    Callee,
    PropertyUse,
    SpaceName,
    TypeName,
    UnitName,
)
from achse.st.check.operands import TypedOperand
from achse.st.declare import declare
from achse.st.syntax.parser import parse, parse_expression

SOURCE = """
TYPE E : (A, B); END_TYPE
FUNCTION F : INT END_FUNCTION
PROGRAM MAIN END_PROGRAM
FUNCTION_BLOCK FB_Base END_FUNCTION_BLOCK
FUNCTION_BLOCK FB EXTENDS FB_Base VAR n : INT; END_VAR
    METHOD M END_METHOD
    PROPERTY P : INT GET END_GET END_PROPERTY
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("n", TypedOperand), ("A", TypedOperand), ("E", TypeName), ("E.B", TypedOperand),
        ("F", Callee),
        ("MAIN", UnitName), ("M", Callee), ("THIS^.M", Callee), ("P", PropertyUse),
        ("SUPER^", BaseInstance), ("MAX", BuiltinName), ("Tc2_Nothing", SpaceName),
        ("INT", TypeName),
    ],
)  # fmt: skip
def test_meanings(text: str, kind: type) -> None:
    names = declare([parse(SOURCE)]).names
    checking = Checking(names)
    body = RoutineBody(checking, checking.routines.of_body(names.scopes.entries["fb"]))
    assert type(body.expressions.meaning(parse_expression(text))) is kind


def test_a_library_in_front_means_the_same(lines: Callable[..., list[str]]) -> None:
    assert lines("n : INT;", "n := Tc2_Standard.MAX(n, 1); n := Lib.Sub.B;", SOURCE.replace(
        "PROGRAM MAIN END_PROGRAM", ""
    )) == ["n := CUT.INT(MAX.DINT(EXTEND.DINT(n), 1));", "n := 1;"]  # fmt: skip
