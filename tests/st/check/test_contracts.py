"""What blocks owe to what they extend and implement."""

from collections.abc import Callable

import pytest

from achse.st.typed.project import TypedProject

Typed = Callable[[str], TypedProject]

UNITS = """
INTERFACE I_A METHOD Go : BOOL VAR_INPUT n : INT; END_VAR END_METHOD END_INTERFACE
FUNCTION_BLOCK ABSTRACT FB_Abstract
    METHOD ABSTRACT Go : BOOL VAR_INPUT n : INT; END_VAR END_METHOD
    METHOD FINAL Last END_METHOD
    METHOD PRIVATE Hidden END_METHOD
    METHOD PROTECTED Kept END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Whole EXTENDS FB_Abstract VAR nInner : INT; END_VAR VAR_INPUT nIn : INT; END_VAR
    METHOD Go : BOOL VAR_INPUT n : INT; END_VAR END_METHOD
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ("FUNCTION_BLOCK FB IMPLEMENTS I_A END_FUNCTION_BLOCK",
         "FB implements I_A without its Go"),
        ("FUNCTION_BLOCK FB EXTENDS FB_Abstract END_FUNCTION_BLOCK",
         "FB leaves FB_Abstract.Go abstract"),
        ("FUNCTION_BLOCK FB EXTENDS FB_Whole METHOD Go : BOOL END_METHOD END_FUNCTION_BLOCK",
         "FB.Go overrides FB_Whole.Go, but takes 0 parameters instead of 1"),
        ("FUNCTION_BLOCK FB IMPLEMENTS I_A METHOD Go : BOOL VAR_INPUT n : DINT; END_VAR END_METHOD"
         " END_FUNCTION_BLOCK",
         "FB.Go overrides I_A.Go, but its n is a DINT instead of a INT"),
        ("FUNCTION_BLOCK FB IMPLEMENTS I_A METHOD Go VAR_INPUT n : INT; END_VAR END_METHOD"
         " END_FUNCTION_BLOCK",
         "FB.Go overrides I_A.Go, but gives nothing instead of a BOOL"),
        ("FUNCTION_BLOCK FB EXTENDS FB_Whole METHOD Last END_METHOD END_FUNCTION_BLOCK",
         "FB_Abstract.Last is FINAL"),
        ("FUNCTION_BLOCK FB EXTENDS FB_Whole Hidden(); END_FUNCTION_BLOCK",
         "FB_Abstract.Hidden is PRIVATE: only FB_Abstract uses it"),
        ("FUNCTION_BLOCK FB EXTENDS FB_Whole Kept(); END_FUNCTION_BLOCK", None),
        ("FUNCTION_BLOCK FB VAR w : FB_Whole; END_VAR w.Kept(); END_FUNCTION_BLOCK",
         "FB_Abstract.Kept is PROTECTED: only blocks that extend it use it"),
        ("FUNCTION_BLOCK FB EXTENDS FB_Whole METHOD FB_init : BOOL VAR_INPUT bInitRetains,"
         " bInCopyCode : BOOL; n : INT; END_VAR END_METHOD END_FUNCTION_BLOCK", None),
        ("INTERFACE I_B METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR"
         " END_METHOD METHOD FB_exit : BOOL VAR_INPUT bInCopyCode : BOOL; END_VAR END_METHOD"
         " END_INTERFACE FUNCTION_BLOCK FB IMPLEMENTS I_B END_FUNCTION_BLOCK", None),
    ],
)  # fmt: skip
def test_contracts(typed: Typed, block: str, message: str | None) -> None:
    messages = [fault.message for fault in typed(block + UNITS).faults]
    assert messages == ([] if message is None else [message])


def test_only_inputs_are_written_from_outside(typed: Typed) -> None:
    project = typed(
        "PROGRAM MAIN VAR w : FB_Whole; END_VAR w.nIn := 1; w.nInner := 2; END_PROGRAM" + UNITS
    )
    assert project.faults == ()
    assert [warning.message for warning in project.warnings] == [
        "FB_Whole.nInner is not an input: only its block should write it"
    ]
