"""Signatures: what goes over, and what may stand for another in a table."""

from achse.native.backend import ADDRESS, I16, I64, U64
from achse.plc.machine.signatures import signature_of
from achse.st.check import check
from achse.st.declare import declare
from achse.st.syntax.parser import parse

TEXT = """
TYPE T : STRUCT a, b : DINT; END_STRUCT END_TYPE
FUNCTION_BLOCK FB
METHOD M : STRING(20)
VAR_INPUT i : INT; s : STRING; t : T; END_VAR
VAR_OUTPUT n : INT; w : STRING(3); END_VAR
M := s;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION F : INT VAR_INPUT i : INT; END_VAR F := i; END_FUNCTION
PROGRAM MAIN VAR b : FB; n : INT; END_VAR b.M(i := F(1), s := 'x', n => n); END_PROGRAM
"""


def test_values_texts_and_records() -> None:
    project = check(declare([parse(TEXT)]))
    assert not project.faults, project.faults[0]  # fmt: skip
    method = signature_of(project.routines["fb.m"])
    assert method.parameters == [
        U64, I16, ADDRESS, I64, ADDRESS, ADDRESS, ADDRESS, ADDRESS, ADDRESS,
    ]  # fmt: skip
    assert method.results == [I64]
    assert not method.is_simple
    function = project.routines["f"]
    assert signature_of(function).parameters == [I16]
    assert signature_of(function, dispatched=True).parameters == [U64, I16]
    assert signature_of(project.routines["main"]).is_simple
    assert method.like != signature_of(function).like
