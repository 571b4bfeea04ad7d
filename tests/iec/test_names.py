"""Type names as text."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.arrays import ArrayType
from achse.iec.declare import ARRAY, pointer_to, reference_to
from achse.iec.derived import AliasType, PointerType, SubrangeType
from achse.iec.elementary import INT, LREAL, UDINT, UXINT
from achse.iec.errors import DeclarationError
from achse.iec.names import ELEMENTARY, name_within, parse_type, with_coding
from achse.iec.strings import STRING, WSTRING, StringType
from achse.iec.times import DATE_AND_TIME, TIME


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("string(20)", "STRING(20)"),
        ("STRING[20]", "STRING(20)"),
        ("STRING", "STRING(80)"),
        (" wstring ( 5 ) ", "WSTRING(5)"),
        ("array[0..3]of int", "ARRAY [0..3] OF INT"),
        ("ARRAY [ -1 .. 2 , 3..4 ] OF STRING(2)", "ARRAY [-1..2,3..4] OF STRING(2)"),
        ("ARRAY [0..1] OF ARRAY [0..2] OF BYTE", "ARRAY [0..1] OF ARRAY [0..2] OF BYTE"),
        ("pointer to int", "POINTER TO int"),
        ("INT (-5..10)", "INT (-5..10)"),
        ("INT(-5..10)", "INT (-5..10)"),
    ],
)
def test_names_are_read_freely(text: str, name: str) -> None:
    assert parse_type(text).name == name


@pytest.mark.parametrize("type", ELEMENTARY.values(), ids=lambda type: type.name)
def test_every_elementary_type_is_found_by_its_name(type: object) -> None:
    name = type.name  # type: ignore[attr-defined]
    assert parse_type(name) is parse_type(name.lower()) is type


@pytest.mark.parametrize("name", ["PVOID", "__UXINT", "XINT", "__XWORD"])
def test_what_is_as_wide_as_a_pointer(name: str) -> None:
    assert [parse_type(name, pointer_size=size).size for size in (4, 8)] == [4, 8]
    assert parse_type(name, pointer_size=4).guid == parse_type(name).guid


@pytest.mark.parametrize(
    "type",
    [
        STRING(7),
        WSTRING(9),
        ARRAY(LREAL, (-4, -2), (0, 7)),
        ARRAY(ARRAY(STRING(3), (1, 2)), (0, 1)),
        pointer_to(ARRAY(INT, (0, 1))),
        reference_to(pointer_to(UDINT)),
        SubrangeType(INT, -1, 1),
    ],
    ids=lambda type: type.name,
)
def test_the_names_of_types_are_read_back(type: object) -> None:
    assert parse_type(type.name).name == type.name  # type: ignore[attr-defined]
    assert parse_type(type.name).size == type.size  # type: ignore[attr-defined]


def test_other_names_are_looked_up() -> None:
    alias = AliasType("T_Len", LREAL)
    find = {"T_Len": alias}.get
    assert parse_type("ARRAY [1..2] OF T_Len", find).size == 16
    pointer = parse_type("POINTER TO T_Len", find)
    assert isinstance(pointer, PointerType)
    assert pointer.target is alias
    assert parse_type("POINTER TO T_Len", find, pointer_size=4).size == 4
    assert ELEMENTARY["__uxint"] is UXINT
    assert parse_type("DATE_AND_TIME") is DATE_AND_TIME


def test_what_a_pointer_points_at_may_be_unknown() -> None:
    pointer = parse_type("POINTER TO T_Unknown")
    assert isinstance(pointer, PointerType)
    assert (pointer.target.name, pointer.target.size) == ("T_Unknown", 0)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "T_Unknown",
        "STRING(9999999999)",
        "ARRAY [] OF INT",
        "ARRAY [0..] OF INT",
        "ARRAY [2..1] OF T_X",
        "ARRAY [0..99999999999] OF INT",
        "ARRAY [0..1] OF ",
        "INT (5..1)",
        "LREAL (0..1)",
        "x" * 10_000,
        "ARRAY [0..1] OF " * 5_000 + "INT",
        "ARRAY [0..1] OF " * 40 + "INT",
    ],
    ids=range(13),
)
def test_texts_that_name_no_type(text: str) -> None:
    with pytest.raises(DeclarationError) as caught:
        parse_type(text)
    assert len(str(caught.value)) < 200


@given(st.text("ARRAY [0..1]OF INTPOINTER TO STRING(9),x", max_size=60))
def test_any_text_is_a_type_or_refused(text: str) -> None:
    with contextlib.suppress(DeclarationError):
        assert parse_type(text).size >= 0


def test_the_coding_reaches_into_arrays_and_aliases() -> None:
    array = with_coding(ARRAY(STRING(4), (0, 1)), "utf-8")
    assert isinstance(array, ArrayType)
    assert array.decode("ä".encode().ljust(5, b"\0") * 2) == ["ä", "ä"]
    alias = with_coding(AliasType("T_Name", STRING(4)), "utf-8")
    assert alias.name == "T_Name"
    assert alias.decode("ä".encode()) == "ä"
    assert isinstance(with_coding(STRING(4), "utf-8"), StringType)
    assert with_coding(TIME, "utf-8") is TIME
    assert with_coding(ARRAY(INT, (0, 1)), "utf-8").name == "ARRAY [0..1] OF INT"


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("ST_X", "ST_X"),
        ("ARRAY [0..1] OF array[1..2] of PLC.ST_X", "PLC.ST_X"),
        ("FB_Ring<3>", "FB_Ring<3>"),
        ("T_Level (1..3)", "T_Level"),
        ("INT (1..3)", None),
        ("LREAL", None),
        ("ARRAY [0..3] OF STRING(8)", None),
        ("POINTER TO ST_X", None),
        ("ARRAY [0..3] OF REFERENCE TO ST_X", None),
        ("", None),
    ],
)
def test_the_name_that_a_type_text_leaves_open(text: str, name: str | None) -> None:
    assert name_within(text) == name
