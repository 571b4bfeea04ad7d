"""Checking a project: everything that can be called is there, once, and nothing else."""

from collections.abc import Callable

import pytest

from achse.iec import UDINT, GlobalVariables, var
from achse.st.check import check
from achse.st.declare import declare
from achse.st.syntax.parser import parse
from achse.st.typed.project import InitCall, TypedProject
from achse.st.typed.text import lines_of

Typed = Callable[[str], TypedProject]


def test_libraries_are_checked_as_far_as_they_are_used() -> None:
    library = parse(
        """
        FUNCTION F_Used : INT F_Used := F_Inner(); END_FUNCTION
        FUNCTION F_Inner : INT F_Inner := nLib; END_FUNCTION
        FUNCTION F_Unused : INT F_Unused := nothing; END_FUNCTION
        VAR_GLOBAL nLib : INT; END_VAR
        FUNCTION_BLOCK FB_Lib METHOD M END_METHOD END_FUNCTION_BLOCK
        """
    )
    own = parse("PROGRAM MAIN VAR n : INT; fb : FB_Lib; END_VAR n := F_Used(); END_PROGRAM")
    project = check(declare([own], libraries=[library]))
    assert project.faults == ()
    assert {"f_used", "f_inner", "fb_lib", "fb_lib.m"} < set(project.routines)
    assert "f_unused" not in project.routines
    assert set(project.units) == {"main", "gvl"}
    declared = project.units["gvl"].declared
    assert declared is not None
    assert declared.__iec__.name == "GVL"


def test_what_the_runtime_declares_is_known() -> None:
    class SystemList(GlobalVariables, name="SystemList"):
        nCycle = var(UDINT)  # noqa: N815

    own = parse("PROGRAM MAIN VAR n : UDINT; END_VAR n := nCycle + SystemList.nCycle; END_PROGRAM")
    project = check(declare([own]), predefined=[SystemList])
    assert project.faults == ()
    assert list(lines_of(project.routines["main"].body or ())) == [
        "n := ADD.UDINT(nCycle, nCycle);"
    ]


def test_tables_have_the_most_derived_parts(typed: Typed) -> None:
    project = typed(
        """
        FUNCTION_BLOCK FB_A IMPLEMENTS I_A
            METHOD Go END_METHOD
            METHOD Stop END_METHOD
            PROPERTY P : INT GET END_GET SET END_SET END_PROPERTY
            ACTION Act: ; END_ACTION
        END_FUNCTION_BLOCK
        FUNCTION_BLOCK FB_B EXTENDS FB_A
            METHOD Go END_METHOD
            PROPERTY P : INT GET END_GET END_PROPERTY
        END_FUNCTION_BLOCK
        INTERFACE I_A METHOD Go END_METHOD END_INTERFACE
        """
    )
    block = project.blocks["fb_b"]
    assert block.table == {
        "": "fb_b",
        "go": "fb_b.go",
        "stop": "fb_a.stop",
        "__getp": "fb_b.__getp",
        "__setp": "fb_a.__setp",
        "act": "fb_a.act",
    }
    assert (block.base, block.interfaces) == ("fb_a", {"i_a"})
    assert project.interfaces["i_a"].methods == {"go": "i_a.go"}
    assert sorted(one.number for one in project.blocks.values()) == [1, 2]


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ("FUNCTION_BLOCK FB IMPLEMENTS I_A END_FUNCTION_BLOCK",
         "FB implements I_A without its Go"),
        ("FUNCTION_BLOCK FB EXTENDS FB_Abstract END_FUNCTION_BLOCK",
         "FB leaves FB_Abstract.Go abstract"),
        ("FUNCTION_BLOCK FB VAR x : FB_Abstract; END_VAR END_FUNCTION_BLOCK",
         "FB_Abstract is abstract: there is no instance of it"),
    ],
)  # fmt: skip
def test_what_is_missing_of_a_block_is_reported(typed: Typed, block: str, message: str) -> None:
    units = """
    INTERFACE I_A METHOD Go END_METHOD END_INTERFACE
    FUNCTION_BLOCK ABSTRACT FB_Abstract METHOD ABSTRACT Go END_METHOD END_FUNCTION_BLOCK
    """
    assert [fault.message for fault in typed(block + units).faults] == [message]


def test_units_are_created_by_their_slots(typed: Typed) -> None:
    project = typed(
        """
        VAR_GLOBAL CONSTANT c : INT := 1; END_VAR
        PROGRAM P1 END_PROGRAM
        {attribute 'global_init_slot' := '100'}
        PROGRAM P2 END_PROGRAM
        """
    )
    assert list(project.units) == ["p2", "gvl", "p1"]


def test_calls_before_the_first_cycle_are_ordered(typed: Typed) -> None:
    project = typed(
        """
        {attribute 'call_after_global_init_slot' := '200'}
        FUNCTION F_Late END_FUNCTION
        FUNCTION_BLOCK FB
            {attribute 'call_after_global_init_slot' := '100'}
            METHOD Early END_METHOD
        END_FUNCTION_BLOCK
        """
    )
    assert project.init_calls == (InitCall(100, "fb.early", "fb"), InitCall(200, "f_late"))


def test_a_generic_block_is_checked_for_each_of_its_values(typed: Typed) -> None:
    project = typed(
        """
        FUNCTION_BLOCK FB_List
        VAR_GENERIC CONSTANT nMax : DINT; END_VAR
        VAR a : ARRAY [1..nMax] OF INT; END_VAR
        a[1] := nMax;
        END_FUNCTION_BLOCK
        PROGRAM MAIN VAR l : FB_List<8>; END_VAR l(); END_PROGRAM
        """
    )
    assert project.faults == ()
    assert list(lines_of(project.routines["fb_list<8>"].body or ())) == ["a[1] := 8;"]


def test_statics_of_routines_are_listed(typed: Typed) -> None:
    project = typed("FUNCTION F VAR_STAT n : INT; END_VAR n := n + 1; END_FUNCTION")
    assert [(one.owner, one.variable.name) for one in project.statics] == [("F", "n")]


def test_an_interface_cannot_extend_itself(typed: Typed) -> None:
    text = "INTERFACE I_A EXTENDS I_B\nEND_INTERFACE\nINTERFACE I_B EXTENDS I_A\nEND_INTERFACE\n"
    messages = [fault.message for fault in typed(text).faults]
    assert messages == ["interface I_A extends itself", "interface I_B extends itself"]


def test_an_address_of_var_config_without_a_variable_is_a_warning(typed: Typed) -> None:
    project = typed(
        """
        VAR_GLOBAL a AT %I* : BOOL; b : BOOL; END_VAR
        VAR_CONFIG .a AT %IX0.0 : BOOL; .b AT %IX0.1 : BOOL; END_VAR
        """
    )
    assert [one.message for one in project.warnings] == [
        "no global variable b is declared AT %I*, %Q* or %M*"
    ]


def test_an_address_of_var_config_inside_an_instance_is_a_warning(typed: Typed) -> None:
    project = typed(
        """
        FUNCTION_BLOCK FB VAR_INPUT in AT %I* : BOOL; END_VAR END_FUNCTION_BLOCK
        VAR_GLOBAL f : FB; END_VAR
        VAR_CONFIG .f.in AT %IX0.0 : BOOL; END_VAR
        """
    )
    assert not project.faults
    assert [one.message for one in project.warnings] == [
        "f.in keeps its place in its instance: %IX0.0 is not given"
    ]


def test_bits_of_process_images_are_numbers(typed: Typed) -> None:
    """They are numbers of the System Manager: a public project divides one."""
    project = typed(
        """
        PROGRAM MAIN
        VAR nByte : BITARR8; nWord : BITARR16; nLong : BITARR32; bHigh : BOOL; END_VAR
        nWord := 270;
        bHigh := nWord / 256 > 0 AND nWord.1;
        nWord := nWord MOD 256;
        nByte := 16#0E;
        nLong := nWord;
        END_PROGRAM
        """
    )
    assert not project.faults
