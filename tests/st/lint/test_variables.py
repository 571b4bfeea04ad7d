"""Rules about variables."""

import pytest

from tests.st.lint.conftest import Linted


def function(variables: str, statements: str = "", before: str = "") -> str:
    """Return a function whose variables are in line 2."""
    return f"FUNCTION F : INT\n{variables}\n{statements}\nEND_FUNCTION\n{before}"


@pytest.mark.parametrize(
    ("variables", "statements", "finding"),
    [
        ("VAR a : INT; END_VAR", "", "2: LT1001 variable 'a' is not used"),
        ("VAR CONSTANT a : INT := 1; END_VAR", "", "2: LT1001 variable 'a' is not used"),
        ("VAR_INPUT a : INT; END_VAR", "", "2: LT1001 parameter 'a' is not used"),
        ("VAR a : INT; END_VAR", "F := a;", "2: LT1002 'a' is read, but nothing writes it"),
        ("VAR a : INT; END_VAR", "a := 1;", "2: LT1003 'a' is written, but nothing reads it"),
        ("VAR a : INT := 3; END_VAR", "F := a;", ""),
        ("VAR CONSTANT a : INT := 3; END_VAR", "F := a;", ""),
        ("VAR_INPUT a : INT; END_VAR", "F := a;", ""),
        ("VAR_OUTPUT a : INT; END_VAR", "a := 1;", ""),
        ("VAR {attribute 'hide'} a : INT; END_VAR", "", ""),
        ("VAR_STAT a : INT; END_VAR", "a := a + 1;", ""),
        (
            "VAR t : TON; END_VAR",
            "",
            "2: LT1005 't' is an instance that starts again with each call",
        ),
        ("VAR_STAT t : TON; END_VAR", "", ""),
        ("VAR t : ARRAY [0..1] OF TON; END_VAR", "", "2: LT1005 't' is an instance"),
    ],
)
def test_variables_of_a_function(
    linted: Linted, variables: str, statements: str, finding: str
) -> None:
    diagnostics = linted(function(variables, statements))
    assert len(diagnostics) == bool(finding)
    assert not finding or diagnostics[0].startswith(finding)


@pytest.mark.parametrize(
    ("type", "declared", "is_default"),
    [
        ("S", "TYPE S : STRUCT n : INT := 5; END_STRUCT END_TYPE", True),
        ("S", "TYPE S : STRUCT n : INT; END_STRUCT END_TYPE", False),
        ("ARRAY [0..1] OF S", "TYPE S : STRUCT n : INT := 5; END_STRUCT END_TYPE", True),
        ("S", "TYPE R : INT := 5; END_TYPE TYPE S : STRUCT n : R; END_STRUCT END_TYPE", True),
        (
            "S",
            "TYPE R : STRUCT n : INT := 5; END_STRUCT END_TYPE"
            " TYPE S EXTENDS R : STRUCT m : INT; END_STRUCT END_TYPE",
            True,
        ),
        ("S", "TYPE S : INT := 4; END_TYPE", True),
        ("S", "TYPE S : (A := 3, B); END_TYPE", True),
        ("S", "TYPE S : (A, B); END_TYPE", False),
    ],
)
def test_a_type_may_begin_with_another_value_than_0(
    linted: Linted, type: str, declared: str, is_default: bool
) -> None:
    text = function(f"VAR a, b : {type}; END_VAR", "b := a; F := SIZEOF(b);", declared)
    assert bool(linted(text, "LT1002")) is not is_default


def test_clients_may_use_what_programs_and_lists_have(linted: Linted) -> None:
    text = (
        "VAR_GLOBAL g : INT; END_VAR\nPROGRAM MAIN\nVAR a, b, c : INT;\nd AT %QX0.0 : BOOL; END_VAR"
    )
    assert linted(f"{text}\na := b;\nEND_PROGRAM") == ["3: LT1001 variable 'c' is not used"]


def test_parameters_that_an_interface_decides_on_may_be_unused(linted: Linted) -> None:
    text = (
        "INTERFACE I\nMETHOD M\nVAR_INPUT n : INT; END_VAR\nEND_METHOD\nEND_INTERFACE\n"
        "FUNCTION_BLOCK FB {}\nMETHOD M\nVAR_INPUT n : INT; END_VAR\n;\nRETURN;\nEND_METHOD\n"
        "END_FUNCTION_BLOCK\n"
    )
    assert linted(text.format("IMPLEMENTS I")) == []
    assert linted(text.format("")) == ["8: LT1001 parameter 'n' is not used"]
    derived = "FUNCTION_BLOCK FB2 EXTENDS FB\nEND_FUNCTION_BLOCK\n"
    assert linted(text.format("") + derived) == []


def test_a_member_of_that_name_anywhere_is_a_use(linted: Linted) -> None:
    text = (
        "FUNCTION_BLOCK FB\nVAR_INPUT a : INT; END_VAR\nVAR b : INT; END_VAR\nEND_FUNCTION_BLOCK\n"
        "PROGRAM MAIN\nVAR f : FB; n : INT; END_VAR\n{}\nEND_PROGRAM\n"
    )
    assert len(linted(text.format(""), "LT1001")) == 3
    assert linted(text.format("f.a := n; n := f.b;"), "LT1") == [
        "3: LT1002 'b' is read, but nothing writes it"
    ]


def test_a_name_hides_that_of_the_block_and_that_of_a_list(linted: Linted) -> None:
    text = (
        "VAR_GLOBAL g : INT; END_VAR\nFUNCTION_BLOCK FB\nVAR a : INT; END_VAR\n"
        "METHOD M\nVAR A : INT; g : INT; END_VAR\nEND_METHOD\nEND_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK FB2 EXTENDS FB\nMETHOD N\nVAR a : INT; END_VAR\nEND_METHOD\n"
        "END_FUNCTION_BLOCK\n"
    )
    assert linted(text, "LT1004") == [
        "5: LT1004 'A' hides the variable of that name of FB",
        "5: LT1004 'g' hides the variable of that name of x",
        "10: LT1004 'a' hides the variable of that name of FB",
    ]


def test_bodies_without_source_use_everything(linted: Linted) -> None:
    text = "{attribute 'builtin'}\n" + function("VAR_INPUT a : INT; END_VAR VAR b : INT; END_VAR")
    assert linted(text, "LT1") == []


def test_an_unknown_type_may_be_a_block(linted: Linted) -> None:
    """What no source declares may do all it is for in FB_init."""
    text = "TYPE T_Alias : INT; END_TYPE FUNCTION_BLOCK FB VAR {} END_VAR END_FUNCTION_BLOCK"
    assert linted(text.format("a : FB_Nowhere; b : ARRAY [0..1] OF Nowhere;")) == []
    assert len(linted(text.format("a : T_Alias; b : ARRAY [0..1] OF T_MaxString; c : INT;"))) == 3


@pytest.mark.parametrize(
    ("declared", "is_found"),
    [
        ("VAR_OUTPUT nText : INT; END_VAR", False),
        ("VAR_OUTPUT bBusy : BOOL; END_VAR", True),
        ("VAR tDelay : TON; END_VAR", True),
        ("VAR aInner : ARRAY [1..2] OF FB_Edge; END_VAR", True),
        ("VAR pOther : POINTER TO FB_Edge; END_VAR", False),
    ],
)
def test_an_instance_that_needs_one_call_may_start_again(
    linted: Linted, declared: str, is_found: bool
) -> None:
    blocks = f"""FUNCTION_BLOCK FB_Edge VAR rt : R_TRIG; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Maker {declared} END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Derived EXTENDS FB_Maker END_FUNCTION_BLOCK
FUNCTION F : INT VAR fb : FB_Derived; END_VAR F := 1; END_FUNCTION
"""
    assert bool(linted(blocks, "LT1005")) is is_found
