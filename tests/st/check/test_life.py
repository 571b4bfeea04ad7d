"""The life cycle: FB_init, FB_exit, FB_reinit and call_after_init in the documented order."""

from collections.abc import Callable

from achse.st.typed.project import TypedProject
from achse.st.typed.text import lines_of

SOURCE = """
{attribute 'call_after_init'}
FUNCTION_BLOCK FB_Base
VAR nBase : INT; END_VAR
    METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR nBase := 1; END_METHOD
    METHOD FB_exit : BOOL VAR_INPUT bInCopyCode : BOOL; END_VAR END_METHOD
    METHOD FB_reinit : BOOL END_METHOD
    {attribute 'call_after_init'}
    METHOD After nBase := 2; END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Next EXTENDS FB_Base
VAR fbInner : FB_Base; n : INT; END_VAR
    METHOD FB_init : BOOL
    VAR_INPUT bInitRetains, bInCopyCode : BOOL; nStart : INT; END_VAR
        n := nStart;
    END_METHOD
END_FUNCTION_BLOCK
TYPE ST_Pair : STRUCT a : FB_Next(nStart := 5); END_STRUCT END_TYPE
PROGRAM MAIN
VAR
    fb : FB_Next(nStart := 3) := (n := 4);
    aFb : ARRAY [0..1] OF FB_Next[(nStart := 1), (nStart := 2)];
    aSame : ARRAY [0..3] OF FB_Base;
    pair : ST_Pair;
    nPlain : INT := 3;
END_VAR
END_PROGRAM
"""
FLAGS = "callee.bInitRetains := bInitRetains, callee.bInCopyCode := bInCopyCode"


def routine(project: TypedProject, key: str) -> list[str]:
    return list(lines_of(project.routines[key].body or ()))


def test_elements_of_an_array_take_arguments_by_position(
    typed: Callable[[str], TypedProject],
) -> None:
    text = SOURCE.replace("nStart : INT; END_VAR", "nStart : INT; nStep : INT; END_VAR")
    text = text.replace("nStart := 3", "3, 0").replace("nStart := 5", "5, 0")
    project = typed(text.replace("(nStart := 1), (nStart := 2)", "(1, 7), (2, nStep := 8)"))
    assert not project.faults
    assert [line for line in routine(project, "main.__create") if "aFb" in line] == [
        f"CREATE aFb[0] : FB_Next: {FLAGS}, callee.nStart := 1, callee.nStep := 7",
        f"CREATE aFb[1] : FB_Next: {FLAGS}, callee.nStart := 2, callee.nStep := 8",
    ]


def test_create(typed: Callable[[str], TypedProject]) -> None:
    project = typed(SOURCE)
    assert not project.faults
    assert routine(project, "main.__create") == [
        "fb.n := 0;",
        f"CREATE fb : FB_Next: {FLAGS}, callee.nStart := 3",
        "    fb.n := 4;",
        f"CREATE aFb[0] : FB_Next: {FLAGS}, callee.nStart := 1",
        f"CREATE aFb[1] : FB_Next: {FLAGS}, callee.nStart := 2",
        f"CREATE aSame : FB_Base * 4: {FLAGS}",
        f"CREATE pair : ST_Pair: {FLAGS}",
    ]
    assert routine(project, "fb_next.__create") == [
        f"ADR(THIS^)->fb_base.__create({FLAGS});",
        f"CREATE fbInner : FB_Base: {FLAGS}",
        f"ADR(THIS^)->fb_next.fb_init({FLAGS}, callee.nStart := nStart);",
    ]
    assert routine(project, "st_pair.__create") == [
        f"CREATE a : FB_Next: {FLAGS}, callee.nStart := 5"
    ]


def test_exit_goes_the_other_way(typed: Callable[[str], TypedProject]) -> None:
    project = typed(SOURCE)
    flag = "callee.bInCopyCode := bInCopyCode"
    assert routine(project, "fb_next.__exit") == [
        f"EXIT fbInner : FB_Base: {flag}",
        f"ADR(THIS^)->fb_base.__exit({flag});",
    ]
    assert routine(project, "fb_base.__exit") == [f"ADR(THIS^)->fb_base.fb_exit({flag});"]


def test_reinit_is_that_of_the_most_derived(typed: Callable[[str], TypedProject]) -> None:
    project = typed(SOURCE)
    assert routine(project, "fb_next.__reinit") == [
        "REINIT fbInner : FB_Base",
        "ADR(THIS^)->fb_base.fb_reinit();",
    ]


def test_call_after_init_needs_the_attribute_on_block_and_method(
    typed: Callable[[str], TypedProject],
) -> None:
    project = typed(SOURCE)
    assert project.blocks["fb_base"].after_init == ("fb_base.after",)
    assert project.blocks["fb_next"].after_init == ()


def test_what_is_constant_needs_no_code(typed: Callable[[str], TypedProject]) -> None:
    project = typed("PROGRAM MAIN VAR n : INT := 3; END_VAR END_PROGRAM")
    assert project.units["main"].create == ""
    assert set(project.routines) == {"main"}
