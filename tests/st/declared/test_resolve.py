"""Declared types: made when first asked for, once each, and told where they are at fault."""

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec import BOOL, DINT, INT, AliasType, EnumType, IecType, Section, StructType
from achse.iec.derived import InterfaceType, PointerType, ReferenceType, SubrangeType
from achse.iec.layout import TC2_X86, TC3_X64, LayoutRules
from achse.st.declare import declare
from achse.st.declared.records import LARGEST
from achse.st.declared.resolve import Resolver, generics_of
from achse.st.declared.scopes import DeclaredUnit, Failed
from achse.st.lexis.source import Source, SourceError
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import parse
from achse.st.syntax.tree import DirectAddress
from achse.st.syntax.units import FunctionBlock, TypeDeclaration


def resolver(
    text: str, rules: LayoutRules = TC3_X64, types: Mapping[str, IecType[Any]] | None = None
) -> Resolver:
    names = Resolver(types or {}, {}, rules)
    names.scopes.add([parse(Source(text)).check()])
    return names


def entry(types: Resolver, name: str) -> DeclaredUnit:
    unit = types.scopes.find(name)
    assert unit is not None
    return unit


def type_of(text: str, name: str = "T", rules: LayoutRules = TC3_X64) -> IecType[Any]:
    types = resolver(text, rules)
    return types.entry_type(entry(types, name), 0)


def spec_type(text: str, rules: LayoutRules = TC3_X64) -> IecType[Any]:
    """The type of a specification as it is after a colon."""
    types = resolver(f"TYPE T : {text}; END_TYPE", rules)
    unit = entry(types, "T")
    assert isinstance(unit.tree, TypeDeclaration)
    return types.type_of(unit.tree.type, types.scopes.scope(unit), "T")


def faults(text: str, name: str = "T") -> list[str]:
    """What is told of a type, however often it is asked for."""
    types = resolver(text)
    for _ in range(2):
        with pytest.raises(Failed):
            types.entry_type(entry(types, name), 0)
    return [
        f"{fault.location.line}:{fault.location.column} {fault.message}"
        for fault in types.scopes.faults
    ]


# specifications -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "name", "size"),
    [
        ("int", "INT", 2),
        ("STRING", "STRING(80)", 81),
        ("STRING(2 + 3)", "STRING(5)", 6),
        ("WSTRING[7]", "WSTRING(7)", 16),
        ("ARRAY [1..3] OF INT", "ARRAY [1..3] OF INT", 6),
        ("ARRAY [-1..1, 0..3] OF BYTE", "ARRAY [-1..1,0..3] OF BYTE", 12),
        ("LTIME_OF_DAY", "LTOD", 8),
        ("LDATE_AND_TIME", "LDT", 8),
    ],
)
def test_specifications(text: str, name: str, size: int) -> None:
    type = spec_type(text)
    assert (type.name, type.size) == (name, size)


@pytest.mark.parametrize(
    ("text", "kind", "name"),
    [
        ("POINTER TO INT", PointerType, "POINTER TO INT"),
        ("REFERENCE TO INT", ReferenceType, "REFERENCE TO INT"),
        (
            "POINTER TO ARRAY [0..1] OF POINTER TO DINT",
            PointerType,
            "POINTER TO ARRAY [0..1] OF POINTER TO DINT",
        ),
    ],
)
@pytest.mark.parametrize(("rules", "size"), [(TC3_X64, 8), (TC2_X86, 4)])
def test_pointers_have_the_size_that_the_target_gives(
    text: str, kind: type, name: str, rules: LayoutRules, size: int
) -> None:
    type = spec_type(text, rules)
    assert isinstance(type, kind)
    assert (type.name, type.size) == (name, size)


@pytest.mark.parametrize(("rules", "size"), [(TC3_X64, 8), (TC2_X86, 4)])
def test_numbers_as_wide_as_a_pointer(rules: LayoutRules, size: int) -> None:
    assert {spec_type(name, rules).size for name in ("PVOID", "__XINT", "UXINT")} == {size}


def test_a_sub_range_keeps_its_limits() -> None:
    type = spec_type("INT (-5..5)")
    assert isinstance(type, SubrangeType)
    assert (type.low, type.high, type.size) == (-5, 5, 2)


def test_a_type_is_looked_for_in_the_sources_then_among_those_handed_in() -> None:
    types = resolver("TYPE T : A; END_TYPE TYPE U : Lib.B; END_TYPE", types={"A": DINT, "B": BOOL})
    assert types.entry_type(entry(types, "T"), 0).size == DINT.size
    types = resolver("TYPE T : A; END_TYPE TYPE A : INT; END_TYPE", types={"A": DINT})
    assert types.entry_type(entry(types, "T"), 0).size == INT.size


# declared types -----------------------------------------------------------------------------


def test_a_type_is_made_once() -> None:
    types = resolver("TYPE T : STRUCT a : U; b : U; END_STRUCT END_TYPE TYPE U : (x); END_TYPE")
    type = types.entry_type(entry(types, "T"), 0)
    assert type is types.entry_type(entry(types, "t"), 0)
    assert isinstance(type, StructType)
    assert type.member("a").type is types.entry_type(entry(types, "U"), 0)


def test_a_structure_lies_as_the_rules_say() -> None:
    text = "TYPE T : STRUCT a : BYTE; b : LREAL; END_STRUCT END_TYPE"
    assert type_of(text).size == 16
    # The base comes first, with the gap that its own alignment asks for.
    text += " TYPE U EXTENDS T : STRUCT c : BYTE; END_STRUCT END_TYPE"
    assert type_of(text, "U").size == 24


def test_a_union_is_as_large_as_its_largest_member() -> None:
    assert type_of("TYPE T : UNION a : BYTE; b : DINT; END_UNION END_TYPE").size == 4


def test_enumerations_count_on() -> None:
    type = type_of("TYPE T : (a, b := 10, c, d := b * 2) UDINT := c; END_TYPE")
    assert isinstance(type, EnumType)
    assert dict(type.numbers) == {"a": 0, "b": 10, "c": 11, "d": 20}
    assert type.size == 4
    assert type.default == (11).to_bytes(4, "little")


def test_an_alias_keeps_its_name_and_its_initial_value() -> None:
    type = type_of("TYPE T : INT := 7; END_TYPE")
    assert isinstance(type, AliasType)
    assert (type.name, type.size, type.default) == ("T", 2, b"\x07\x00")


def test_an_interface_is_a_pointer() -> None:
    type = type_of("INTERFACE T END_INTERFACE", rules=TC2_X86)
    assert isinstance(type, InterfaceType)
    assert type.size == 4


def test_a_program_is_no_type() -> None:
    types = resolver("PROGRAM P END_PROGRAM")
    with pytest.raises(Unexpected, match="P is not a type"):
        types.entry_type(entry(types, "P"), 0)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("TYPE T : Nothing; END_TYPE", "1:10 no type is named 'Nothing'"),
        ("TYPE T : STRUCT a : T; END_STRUCT END_TYPE", "1:21 T contains itself"),
        ("TYPE T : ARRAY [5..1] OF INT; END_TYPE", "array bounds 5..1 run backwards"),
        ("TYPE T : ARRAY [*] OF INT; END_TYPE", "1:10 ARRAY [*] is for VAR_IN_OUT only"),
        ("TYPE T : REAL (0..5); END_TYPE", "1:10 a sub-range of whole numbers, got REAL"),
        ("TYPE T : (a, A); END_TYPE", "1:14 T has two values named A"),
        ("TYPE T : (a := 300) USINT; END_TYPE", "1:11 a = 300 is not a USINT"),
        ("TYPE T : INT<5>; END_TYPE", "1:10 INT has no VAR_GENERIC"),
        (
            f"TYPE T : ARRAY [0..{LARGEST}] OF BYTE; END_TYPE",
            f"has {LARGEST + 1} bytes, more than {LARGEST}",
        ),
        (
            "TYPE T EXTENDS U : INT; END_TYPE TYPE U : INT; END_TYPE",
            "1:16 only a structure extends another",
        ),
        ("FUNCTION_BLOCK T IMPLEMENTS INT END_FUNCTION_BLOCK", "1:29 INT is not an interface"),
    ],
)
def test_a_fault_is_reported_once_in_its_place(text: str, fault: str) -> None:
    (message,) = faults(text)
    assert message.endswith(fault)


def test_a_fault_costs_one_variable_so_that_the_others_are_reported_too() -> None:
    text = "TYPE T : STRUCT\na : Nothing;\nb : INT;\nc : None;\nEND_STRUCT END_TYPE"
    assert faults(text) == ["2:5 no type is named 'Nothing'", "4:5 no type is named 'None'"]


def test_pointers_are_followed_when_all_is_declared() -> None:
    types = resolver("TYPE T : STRUCT p : POINTER TO T; END_STRUCT END_TYPE")
    type = types.entry_type(entry(types, "T"), 0)
    types.check_pointers()
    assert not types.scopes.faults
    assert isinstance(type, StructType)
    pointer = type.member("p").type
    assert isinstance(pointer, PointerType)
    assert pointer.target is type


def test_fault_of_a_pointer_target_is_reported_when_followed() -> None:
    types = resolver("TYPE T : POINTER TO U; END_TYPE TYPE U : INT (5..1); END_TYPE")
    assert types.entry_type(entry(types, "T"), 0).size == 8
    assert not types.scopes.faults
    types.check_pointers()
    assert len(types.scopes.faults) == 1


# generic blocks -----------------------------------------------------------------------------

GENERIC = """FUNCTION_BLOCK FB
VAR_GENERIC CONSTANT nMax : UDINT; nMore : UDINT; END_VAR
VAR aValues : ARRAY [1..nMax] OF INT; aMore : ARRAY [1..nMore] OF BYTE; END_VAR
END_FUNCTION_BLOCK
"""


def test_the_constants_of_a_generic_block() -> None:
    types = resolver(GENERIC + "TYPE T : INT; END_TYPE")
    assert generics_of(entry(types, "FB")) == ["nmax", "nmore"]
    assert generics_of(entry(types, "T")) == []


def test_each_choice_of_constants_is_a_block_of_its_own() -> None:
    text = (
        GENERIC
        + "TYPE T : STRUCT a : FB<4, 3>; b : FB<3, 1>; c : FB<2 * 2, 3>; END_STRUCT END_TYPE"
    )
    type = type_of(text)
    assert isinstance(type, StructType)
    a, b, c = (type.member(name).type for name in "abc")
    assert a is c
    assert (a.name, b.name) == ("FB<4,3>", "FB<3,1>")
    assert isinstance(a, StructType)
    assert isinstance(b, StructType)
    assert (a.member("aValues").type.size, a.member("aMore").type.size) == (8, 3)
    assert (b.member("aValues").type.size, b.member("aMore").type.size) == (6, 1)


def test_a_generic_block_takes_all_its_constants() -> None:
    (fault,) = faults(GENERIC + "TYPE T : FB<4>; END_TYPE")
    assert fault == "5:10 FB<…> takes 2 constants"


# variables ----------------------------------------------------------------------------------


def test_variables_belong_to_a_unit_by_their_section() -> None:
    types = resolver(
        """FUNCTION_BLOCK FB
        VAR_INPUT a, b : INT := 5; END_VAR
        VAR_OUTPUT c : BOOL; END_VAR
        VAR_IN_OUT d : ARRAY [*] OF INT; END_VAR
        VAR CONSTANT PERSISTENT e : INT := 1; END_VAR
        VAR_TEMP f : INT; END_VAR
        VAR_STAT g : INT; END_VAR
        VAR_EXTERNAL h : INT; END_VAR
        END_FUNCTION_BLOCK"""
    )
    unit = entry(types, "FB")
    assert isinstance(unit.tree, FunctionBlock)
    variables = [
        variable
        for variable, _ in types.records.variables(unit.tree.blocks, types.scopes.scope(unit))
    ]
    assert [(variable.name, variable.section) for variable in variables] == [
        ("a", Section.INPUT),
        ("b", Section.INPUT),
        ("c", Section.OUTPUT),
        ("d", Section.IN_OUT),
        ("e", Section.LOCAL),
        ("g", Section.STATIC),
    ]
    by_name = {variable.name: variable for variable in variables}
    assert isinstance(by_name["d"].type, ReferenceType)
    assert (by_name["e"].constant, by_name["e"].persistent, by_name["e"].retain) == (
        True,
        True,
        False,
    )


def test_an_initial_value_that_is_no_constant_becomes_a_start_value() -> None:
    types = resolver(
        """FUNCTION_BLOCK FB
        VAR n : INT := 3; p : POINTER TO INT := ADR(n); END_VAR
        END_FUNCTION_BLOCK"""
    )
    block = types.entry_type(entry(types, "FB"), 0)
    assert not types.scopes.faults
    assert isinstance(block, StructType)
    (start,) = block.member("p").start_values
    assert (start.type.name, start.offset, start.bit) == ("POINTER TO INT", 0, None)
    assert not block.member("n").start_values


def test_addresses_are_read_or_a_fault() -> None:
    types = resolver("")
    assert types.address_of("MAIN.a", None) is None
    place = types.address_of("MAIN.a", DirectAddress("%MB4"))
    assert place is not None
    assert str(place) == "%MB4"
    with pytest.raises(Unexpected) as caught:
        types.address_of("MAIN.a", DirectAddress("%ZB4", 9))
    assert caught.value.at == 9


@given(
    st.sampled_from(["SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "BYTE", "WORD", ""]),
    st.lists(st.integers(-(2**64), 2**64) | st.integers(-300, 70_000), min_size=1, max_size=3),
    st.sampled_from(["{}", "16#{:X}"]),
)
def test_values_of_enumerations_are_the_bits_of_their_type(
    base: str, values: list[int], form: str
) -> None:
    """16#8000 to 16#FFFF of INT are negative; what has more bits is a fault."""
    size, low = {"S": (1, -1), "I": (2, -1), "D": (4, -1), "L": (8, -1)}.get(base[:1], (0, 0))
    if not base:
        size, low = 2, -1
    if base.startswith("U") or base in ("BYTE", "WORD"):
        size = {"USINT": 1, "UINT": 2, "UDINT": 4, "BYTE": 1, "WORD": 2}[base]
        low = 0
    bits = 8 * size
    written = [f"V{n} := {form.format(v) if v >= 0 else v}" for n, v in enumerate(values)]
    text = f"TYPE E : ({', '.join(written)}) {base}; END_TYPE"
    fits = all(low << bits - 1 <= value < 1 << bits for value in values)
    if not fits:
        with pytest.raises(SourceError, match="is not a "):
            declare([parse(Source(text, "x.st"))])
        return
    enum = declare([parse(Source(text, "x.st"))]).types["e"]
    signed = [v - (1 << bits) if low and v >> bits - 1 == 1 else v for v in values]
    assert list(enum.numbers.values()) == signed  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["mro", "_", "_x_", "__"])
def test_values_may_have_names_that_python_keeps(name: str) -> None:
    declared = declare([parse(Source(f"TYPE A : (x, {name} := 7); END_TYPE", "a.st"))])
    type = declared.types["a"]
    assert isinstance(type, EnumType)
    assert type.numbers == {"x": 0, name: 7}
    assert type.encode(name) == type.encode(7)


def test_addresses_of_global_variables_from_var_config() -> None:
    text = """
VAR_GLOBAL a AT %I* : BOOL; b AT %Q* : BOOL; END_VAR
PROGRAM P VAR a AT %I* : BOOL; END_VAR END_PROGRAM
VAR_CONFIG .a AT %IX4.1 : BOOL; .b AT %QX2.0 : BOOL; END_VAR"""
    project = declare([parse(text)])
    (unit,) = project.globals.values()
    assert [str(item.address) for item in unit.__iec__.members] == ["%IX4.1", "%QX2.0"]
    assert str(project.programs["p"].__iec__.members[0].address) == "%I*"
    # TwinCAT 2 wrote the list; a variable that has lost its AT stays where it is.
    (unit,) = declare([parse(text.replace("b AT %Q*", "b"))]).globals.values()
    assert [str(item.address) for item in unit.__iec__.members] == ["%IX4.1", "None"]
