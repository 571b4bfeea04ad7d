"""Names: which unit, variable or value a name stands for, and what constants rest on."""

from typing import Any

import pytest

from achse.iec import INT, IecType
from achse.iec.errors import IecError
from achse.iec.layout import TC3_X64
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import DEEPEST, DeclaredUnit, Failed, Scopes
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Source
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import parse

PROJECT = """
TYPE E_State : (Idle := 3, Run); END_TYPE
{attribute 'qualified_only'}
TYPE E_Mode : (Auto := 7, Manual); END_TYPE
VAR_GLOBAL CONSTANT
    cMax : INT := 10;
    cNext : INT := cMax + 1;
    cSelf : INT := cSelf;
    cWide : SINT := 1000;
END_VAR
VAR_GLOBAL
    nCount : INT := 5;
END_VAR
FUNCTION_BLOCK FB_Base
VAR CONSTANT cOwn : INT := 21; END_VAR
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Axis EXTENDS FB_Base
VAR CONSTANT cMax : INT := 99; END_VAR
VAR aValues : ARRAY [1..cMax] OF INT; END_VAR
END_FUNCTION_BLOCK
NAMESPACE Lib
    TYPE E_Side : (Left := 11, Right); END_TYPE
END_NAMESPACE
"""


def scopes(text: str = PROJECT, **constants: object) -> Resolver:
    names = Resolver({}, constants, TC3_X64)
    names.scopes.add([parse(Source(text, "a.st"), name="GVL").check()])
    return names


def entry(names: Resolver, name: str) -> DeclaredUnit:
    unit = names.scopes.find(name)
    assert unit is not None
    return unit


def messages(names: Resolver) -> list[str]:
    return messages_of(names.scopes)


def messages_of(names: Scopes) -> list[str]:
    return [f"{fault.location.line} {fault.message}" for fault in names.faults]


# what is declared ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "space", "expected"),
    [
        ("e_STATE", "", "E_State"),
        ("Lib.E_Side", "", "Lib.E_Side"),
        ("E_Side", "Lib", "Lib.E_Side"),
        ("E_Side", "Lib.Inner", "Lib.E_Side"),
        ("E_State", "Lib", "E_State"),
        ("Tc2_MC2.E_State", "", "E_State"),
        ("E_Side", "", None),
        ("nothing", "", None),
    ],
)
def test_units_are_found_from_a_name_space_without_case(
    name: str, space: str, expected: str | None
) -> None:
    unit = scopes().scopes.find(name, space)
    assert (None if unit is None else unit.name) == expected


def test_a_second_unit_of_a_name_is_a_fault_that_names_the_first() -> None:
    names = scopes("TYPE T : INT; END_TYPE\nTYPE t : BOOL; END_TYPE")
    assert messages(names) == ["2 t is declared already, at a.st:1:6"]


def test_what_a_library_declares_gives_way() -> None:
    names = scopes("TYPE T : INT; END_TYPE")
    names.scopes.add([parse("TYPE T : BOOL; END_TYPE TYPE U : BOOL; END_TYPE")], is_library=True)
    assert not names.scopes.faults
    assert not entry(names, "T").is_library
    assert entry(names, "U").is_library


def _with_library(project: str, library: str) -> Resolver:
    names = Resolver({}, {}, TC3_X64)
    names.scopes.add([parse(Source(project, "a.st"), name="GVL").check()])
    source = Source(library, "b.st")
    source.library = "My Library"
    names.scopes.add([parse(source, name="Lib").check()], is_library=True)
    return names


def test_a_library_does_not_see_what_the_project_calls_the_same() -> None:
    names = _with_library(
        "TYPE ST_A : STRUCT a : INT; END_STRUCT END_TYPE\n"
        "TYPE E_A : (Same := 7); END_TYPE\n"
        "VAR_GLOBAL CONSTANT cMost : INT := 5; END_VAR",
        "TYPE ST_A : STRUCT b : LINT; END_STRUCT END_TYPE\n"
        "TYPE E_B : (Same := 9); END_TYPE\n"
        "VAR_GLOBAL CONSTANT cMost : INT := 6; END_VAR",
    )
    mine, theirs = (names.scopes.find("ST_A", space) for space in ("", "My Library"))
    assert mine is not None
    assert theirs is not None
    assert (mine.is_library, theirs.is_library) == (False, True)
    assert names.scopes.find("My Library.ST_A") is theirs
    for space, most, same in (("", 5, 7), ("My Library", 6, 9)):
        assert names.constants.global_constant("cmost", "cMost", space, 0).value == most
        assert names.constants.global_constant("same", "Same", space, 0).value == same
    assert messages(names) == []


def test_an_internal_unit_of_a_library_is_not_seen_by_the_project() -> None:
    names = _with_library("", "FUNCTION_BLOCK INTERNAL _FB_A END_FUNCTION_BLOCK")
    assert names.scopes.find("_FB_A") is None
    assert names.scopes.find("_FB_A", "My Library") is not None
    assert messages(names) == []


def test_a_name_of_two_libraries_is_doubtful() -> None:
    names = _with_library("", "TYPE E_B : (Same := 9); END_TYPE")
    other = Source("TYPE E_C : (Same := 8); END_TYPE", "c.st")
    other.library = "Other"
    names.scopes.add([parse(other).check()], is_library=True)
    with pytest.raises(Unexpected, match="which one is meant"):
        names.constants.global_constant("same", "Same", "", 0)
    assert names.constants.global_constant("same", "Same", "Other", 0).value == 8


def test_names_with_two_underscores_are_reserved() -> None:
    names = scopes("TYPE __T : INT; END_TYPE")
    assert messages(names) == ["1 names with two underscores in front are reserved"]
    assert names.scopes.find("__T") is None


def test_a_scope_holds_the_variables_of_a_unit_and_rests_on_that_of_its_base() -> None:
    names = scopes()
    scope = names.scopes.scope(entry(names, "FB_Axis"))
    assert set(scope.variables) == {"cmax", "avalues"}
    assert scope.base is names.scopes.scope(entry(names, "FB_Base"))
    assert scope is names.scopes.scope(entry(names, "FB_Axis"))


# faults -------------------------------------------------------------------------------------


def test_what_goes_wrong_inside_is_reported_once_in_its_source() -> None:
    names = Scopes()
    source = Source("ab\ncd", "a.st")
    for _ in range(2):
        with pytest.raises(Failed), names.inside(source):
            raise Unexpected(3, "wrong", Code.UNKNOWN_TYPE)
    assert [str(fault.location) for fault in names.faults] == ["a.st:2:1"]


def test_declarations_rest_on_each_other_only_so_deep() -> None:
    names = Scopes()

    def deeper(levels: int) -> None:
        with names.inside(Source("")):
            if levels:
                deeper(levels - 1)
            names.check_depth(0)

    deeper(DEEPEST - 1)
    with pytest.raises(Failed):
        deeper(DEEPEST)
    assert messages_of(names) == [f"1 declarations rest on each other more than {DEEPEST} deep"]
    deeper(DEEPEST - 1)


def test_an_error_of_the_type_system_becomes_one_of_the_source() -> None:
    def refused() -> IecType[Any]:
        raise IecError("no such type")

    with pytest.raises(Unexpected, match="no such type") as caught:
        Scopes.build(refused, 17)
    assert caught.value.at == 17
    assert Scopes.build(lambda: INT, 17) is INT
