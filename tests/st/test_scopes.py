"""Names: which unit, variable or value a name stands for, and what constants rest on."""

from typing import Any

import pytest

from achse.iec import INT, EnumType, IecType
from achse.iec.errors import IecError
from achse.iec.layout import TC3_X64
from achse.st.cursor import Unexpected
from achse.st.given import GivenTypes
from achse.st.parser import parse, parse_expression
from achse.st.resolve import Resolver
from achse.st.scopes import DEEPEST, Entry, Failed, Scope, Scopes, attributes_of
from achse.st.source import Source
from achse.st.tree import Note
from achse.st.values import Constant, NotConstant

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
    """With types, for which `Scopes` relies on the floor above."""
    made = Resolver({}, constants, TC3_X64)
    made.add([parse(Source(text, "a.st"), name="GVL").check()])
    return made


def entry(names: Scopes, name: str) -> Entry:
    found = names.find(name)
    assert found is not None
    return found


def value(text: str, names: Scopes, unit: str = "FB_Base") -> Constant:
    return names.constant(parse_expression(text), names.scope(entry(names, unit)))


def messages(names: Scopes) -> list[str]:
    return [f"{fault.location.line} {fault.message}" for fault in names.faults]


# what is declared ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "space", "found"),
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
    name: str, space: str, found: str | None
) -> None:
    unit = scopes().find(name, space)
    assert (None if unit is None else unit.name) == found


def test_a_second_unit_of_a_name_is_a_fault_that_names_the_first() -> None:
    names = scopes("TYPE T : INT; END_TYPE\nTYPE t : BOOL; END_TYPE")
    assert messages(names) == ["2 t is declared already, at a.st:1:6"]


def test_what_a_library_declares_gives_way() -> None:
    names = scopes("TYPE T : INT; END_TYPE")
    names.add([parse("TYPE T : BOOL; END_TYPE TYPE U : BOOL; END_TYPE")], is_library=True)
    assert not names.faults
    assert not entry(names, "T").is_library
    assert entry(names, "U").is_library


def test_names_with_two_underscores_are_reserved() -> None:
    names = scopes("TYPE __T : INT; END_TYPE")
    assert messages(names) == ["1 names with two underscores in front are reserved"]
    assert names.find("__T") is None


def test_a_scope_holds_the_variables_of_a_unit_and_rests_on_that_of_its_base() -> None:
    names = scopes()
    scope = names.scope(entry(names, "FB_Axis"))
    assert set(scope.variables) == {"cmax", "avalues"}
    assert scope.base is names.scope(entry(names, "FB_Base"))
    assert scope is names.scope(entry(names, "FB_Axis"))


# constants ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("cMax", "FB_Base", 10),
        ("CMAX * 2", "FB_Base", 20),
        ("cNext", "FB_Base", 11),
        ("GVL.cMax", "FB_Axis", 10),
        ("cMax", "FB_Axis", 99),
        ("cNext", "FB_Axis", 11),
        ("cOwn", "FB_Axis", 21),
        ("Idle", "FB_Base", 3),
        ("E_State.Run", "FB_Base", 4),
        ("E_Mode.Manual", "FB_Base", 8),
        ("Lib.E_Side.Right", "FB_Base", 12),
        ("cGiven", "FB_Base", 77),
        ("Library.cGiven", "FB_Base", 77),
        ("SIZEOF(aValues)", "FB_Axis", 198),
        ("SIZEOF(E_State)", "FB_Base", 2),
        ("SIZEOF(LREAL)", "FB_Base", 8),
    ],
)
def test_constants_are_those_that_the_unit_sees_first(text: str, unit: str, number: int) -> None:
    assert value(text, scopes(cGiven=77), unit).value == number


def test_a_constant_bears_its_type() -> None:
    names = scopes()
    assert value("cMax", names).type is INT
    assert isinstance(value("Idle", names).type, EnumType)


@pytest.mark.parametrize("text", ["nCount", "GVL.nCount", "nCount.x", "FB_Base", "cGiven"])
def test_what_only_shows_at_run_time_is_no_constant(text: str) -> None:
    with pytest.raises(NotConstant):
        value(text, scopes(cGiven=[1]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("cNone", "no constant or variable is named 'cNone'"),
        ("a.b", "no constant or variable is named 'a.b'"),
        ("Auto", "no constant or variable is named 'Auto'"),
        ("E_Mode.Off", "E_Mode has no value 'off'"),
        ("GVL.cNone", "GVL has no variable 'cnone'"),
    ],
)
def test_names_that_stand_for_nothing(text: str, message: str) -> None:
    with pytest.raises(Unexpected) as caught:
        value(text, scopes())
    assert caught.value.message == message


def test_a_name_declared_twice_is_asked_for_by_its_list() -> None:
    text = "VAR_GLOBAL CONSTANT c : INT := 1; END_VAR FUNCTION_BLOCK FB END_FUNCTION_BLOCK"
    names = scopes(text)
    names.add([parse("VAR_GLOBAL CONSTANT c : INT := 2; END_VAR", name="Other")])
    with pytest.raises(Unexpected, match="'c' is declared in GVL and Other: which one is meant"):
        value("c", names, "FB")
    assert value("Other.c", names, "FB").value == 2


def test_values_of_two_enumerations_are_asked_for_by_their_type() -> None:
    names = scopes(
        "TYPE A : (x); END_TYPE TYPE B : (y, x); END_TYPE FUNCTION_BLOCK FB END_FUNCTION_BLOCK"
    )
    with pytest.raises(Unexpected, match="'x' is a value of A and B: which one is meant"):
        value("x", names, "FB")
    assert value("B.x", names, "FB").value == 1


@pytest.mark.parametrize(
    ("name", "fault"),
    [("cSelf", "8 the constant 'cself' rests on itself"), ("cWide", "9 ")],
)
def test_a_constant_at_fault_is_told_once_in_its_place(name: str, fault: str) -> None:
    names = scopes()
    for _ in range(2):
        with pytest.raises(Failed):
            value(name, names)
    (message,) = messages(names)
    assert message.startswith(fault)


# faults -------------------------------------------------------------------------------------


def test_what_goes_wrong_inside_is_reported_once_in_its_source() -> None:
    names = Scopes({}, GivenTypes({}, 8))
    source = Source("ab\ncd", "a.st")
    for _ in range(2):
        with pytest.raises(Failed), names.inside(source):
            raise Unexpected(3, "wrong")
    assert [str(fault.location) for fault in names.faults] == ["a.st:2:1"]


def test_declarations_rest_on_each_other_only_so_deep() -> None:
    names = Scopes({}, GivenTypes({}, 8))

    def deeper(levels: int) -> None:
        with names.inside(Source("")):
            if levels:
                deeper(levels - 1)
            names.check_depth(0)

    deeper(DEEPEST - 1)
    with pytest.raises(Failed):
        deeper(DEEPEST)
    assert messages(names) == [f"1 declarations rest on each other more than {DEEPEST} deep"]
    deeper(DEEPEST - 1)


def test_an_error_of_the_type_system_becomes_one_of_the_source() -> None:
    def refused() -> IecType[Any]:
        raise IecError("no such type")

    with pytest.raises(Unexpected, match="no such type") as caught:
        Scopes.made(refused, 17)
    assert caught.value.at == 17
    assert Scopes.made(lambda: INT, 17) is INT


def test_whole_numbers_are_asked_for_by_what_they_are() -> None:
    names = Scopes({}, GivenTypes({}, 8))
    scope = Scope(Source(""), "P")
    assert names.integer(parse_expression("2 + 3"), scope, "a length") == 5
    with pytest.raises(Unexpected, match="a length"):
        names.integer(parse_expression("2.5"), scope, "a length")


def test_attributes_keep_their_spelling_but_the_one_that_decides_a_layout() -> None:
    note = Note("", (("Pack_Mode", "1"), ("TcEncoding", "UTF-8"), ("OPC.UA.DA", "1")))
    assert attributes_of(note) == {"pack_mode": "1", "TcEncoding": "UTF-8", "OPC.UA.DA": "1"}
