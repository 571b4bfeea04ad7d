"""Constants by name: which one a name means, what it rests on, what is told of faulty ones."""

import pytest

from achse.iec import INT, EnumType
from achse.iec.layout import TC3_X64
from achse.st.declared.resolve import Resolver
from achse.st.declared.scopes import Failed, Scope
from achse.st.lexis.source import Source
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import parse, parse_expression
from achse.st.values.values import Constant, NotConstant
from tests.st.declared.test_scopes import entry, messages, scopes


def value(text: str, names: Resolver, unit: str = "FB_Base") -> Constant:
    return names.constants.constant(parse_expression(text), names.scopes.scope(entry(names, unit)))


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


def test_a_name_declared_twice_is_qualified_by_its_list() -> None:
    text = "VAR_GLOBAL CONSTANT c : INT := 1; END_VAR FUNCTION_BLOCK FB END_FUNCTION_BLOCK"
    names = scopes(text)
    names.scopes.add([parse("VAR_GLOBAL CONSTANT c : INT := 2; END_VAR", name="Other")])
    with pytest.raises(Unexpected, match="'c' is declared in GVL and Other: which one is meant"):
        value("c", names, "FB")
    assert value("Other.c", names, "FB").value == 2


def test_values_of_two_enumerations_are_qualified_by_their_type() -> None:
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
def test_a_constant_at_fault_is_reported_once_in_its_place(name: str, fault: str) -> None:
    names = scopes()
    for _ in range(2):
        with pytest.raises(Failed):
            value(name, names)
    (message,) = messages(names)
    assert message.startswith(fault)


def test_whole_numbers_are_checked() -> None:
    names = Resolver({}, {}, TC3_X64)
    scope = Scope(Source(""), "P")
    assert names.constants.integer(parse_expression("2 + 3"), scope, "a length") == 5
    with pytest.raises(Unexpected, match="a length"):
        names.constants.integer(parse_expression("2.5"), scope, "a length")
