"""What the type table says of declared types."""

# ruff: noqa: N815  (variables carry the prefixes of IEC programs)

from typing import Any

import pytest

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.datatypes import STATIC_OFFSET, ParameterFlag, TypeFlag
from achse.iec.declare import ARRAY, iec_type, method, pointer_to, reference_to, var
from achse.iec.derived import AliasType, InterfaceType, SubrangeType
from achse.iec.describe import describe_type, types_within
from achse.iec.elementary import BIT, BOOL, BYTE, DINT, INT, LREAL, UINT
from achse.iec.enums import Enumeration, EnumType
from achse.iec.strings import STRING
from achse.iec.structs import FunctionBlock, Struct, StructType
from achse.iec.types import IecType
from achse.iec.variables import Section, Variable


class State(Enumeration, base=UINT, name="E_State", attributes={"qualified_only": ""}):
    Idle = 0
    Run = 5


class Part(Struct, name="ST_Part", attributes={"pack_mode": "1"}, comment=" a part"):
    n = var(BYTE)
    f = var(LREAL)


class Block(FunctionBlock, name="FB_Block"):
    bOn = var(BOOL, comment=" on")
    nBit0 = var(BIT)
    nBit1 = var(BIT)
    pPart = var(pointer_to(Part))
    rPart = var(reference_to(INT))
    iMotor = var(InterfaceType("I_Motor"))
    aParts = var(ARRAY(Part, (1, 2)))
    sName = var(STRING(3, "utf-8"), persistent=True)

    @method(DINT, fX=LREAL, outputs={"eState": State})
    def Step(self, x: float) -> tuple[int, State]:  # noqa: N802
        return int(x), State.Run


def test_base_types_carry_their_limits() -> None:
    entry = describe_type(INT)
    assert (entry.name, entry.type_name, entry.size, entry.adst) == ("INT", "", 2, 2)
    assert entry.flags == 0x1081
    assert dict(entry.attributes)["DisplayMinValue"] == "#x8000"
    assert describe_type(BIT).flags == 0x10A1
    assert describe_type(STRING(3)).flags == 0x81


def test_a_structure() -> None:
    entry = describe_type(iec_type(Part))
    assert (entry.flags, entry.adst, entry.size, entry.type_name) == (0x1081, 65, 9, "")
    assert (entry.comment, entry.attributes) == (" a part", (("pack_mode", "1"),))
    assert [(item.name, item.type_name, item.offset, item.flags) for item in entry.members] == [
        ("n", "BYTE", 0, 0x82),
        ("f", "LREAL", 1, 0x82),
    ]
    assert entry.members[1].guid == LREAL.guid
    assert (entry.version, entry.offset) == (1, 0)


def test_the_members_of_a_function_block() -> None:
    entry = describe_type(iec_type(Block))
    assert entry.flags == 0x881
    results = {item.name: (item.offset, item.size, item.flags, item.adst) for item in entry.members}
    assert results == {
        "bOn": (8, 1, 0x82, 33),
        "nBit0": (72, 1, 0xA2, 33),  # byte 9 bit 0, as recorded
        "nBit1": (73, 1, 0xA2, 33),
        "pPart": (16, 8, 0x80082, 65),
        "rPart": (24, 8, 0x80086, 2),
        "iMotor": (32, 8, 0x8048A, 65),
        "aParts": (40, 18, 0x82, 65),
        "sName": (58, 4, 0x1182, 30),
    }
    assert {(item.hash_value, item.type_hash) for item in entry.members} == {(0, 0)}
    assert entry.members[0].comment == " on"
    assert all(item.members == () for item in entry.members)
    assert entry.members[-1].attributes == (("TcEncoding", "UTF-8"),)


def test_member_without_elements_says_that_it_is_an_array() -> None:
    """ads-client looks no type up for a member of size 0, and took it for an integer."""

    class Empty(Struct, name="ST_Empty"):
        aNone = var(ArrayType(INT, [Bounds(1, 0)]))
        aaNone = var(AliasType("T_None", ArrayType(INT, [Bounds(0, 1), Bounds(5, 4)])))
        aOne = var(ARRAY(INT, (1, 1)))

    entry = describe_type(iec_type(Empty))
    assert [(item.size, item.adst, item.dimensions) for item in entry.members] == [
        (0, 2, ((1, 0),)),
        (0, 2, ((0, 2), (5, 0))),
        (2, 2, ()),
    ]


def test_its_methods() -> None:
    (step,) = describe_type(iec_type(Block)).methods
    assert (step.name, step.return_type, step.return_size, step.return_adst) == (
        "Step",
        "DINT",
        4,
        3,
    )
    assert [(item.name, item.type_name, item.size, item.flags) for item in step.parameters] == [
        ("fX", "LREAL", 8, ParameterFlag.IN),
        ("eState", "E_State", 2, ParameterFlag.OUT),
    ]


def test_enumerations_name_their_base_and_values() -> None:
    entry = describe_type(iec_type(State))
    assert (entry.flags, entry.type_name, entry.adst) == (0x3081, "UINT", 18)
    assert entry.enum_values == (("Idle", b"\0\0"), ("Run", b"\5\0"))
    noted = describe_type(EnumType(State, UINT, comments={"Run": "turns"}))
    assert noted.flags & TypeFlag.ENUM_NOTES
    assert [note.comment for note in noted.enum_notes] == ["", "turns"]


@pytest.mark.parametrize(
    ("type", "type_name", "flags", "adst"),
    [
        (AliasType("T_Len", LREAL), "LREAL", 0x81, 5),
        (SubrangeType(INT, 0, 5), "INT", 0x81, 2),
        (SubrangeType(INT, 0, 5, name="T_Few"), "INT (0..5)", 0x81, 2),
        (pointer_to(INT), "", 0x81, 65),
        (InterfaceType("I_Motor"), "", 0x81, 65),
        (ARRAY(INT, (-1, 1), (2, 3)), "INT", 0x81, 2),
    ],
)
def test_types_made_of_another(type: IecType[Any], type_name: str, flags: int, adst: int) -> None:
    entry = describe_type(type)
    assert (entry.type_name, entry.flags, entry.adst) == (type_name, flags, adst)
    assert entry.size == type.size
    assert entry.guid == type.guid


def test_dimensions_are_lower_bound_and_count() -> None:
    assert describe_type(ARRAY(INT, (-1, 1), (2, 3))).dimensions == ((-1, 3), (2, 2))


def test_a_static_member_has_no_offset() -> None:
    members = [Variable[int, int](INT, name="s", section=Section.STATIC)]
    type: StructType[Any] = StructType("FB", members)
    (member,) = describe_type(type).members
    assert member.offset == STATIC_OFFSET
    assert member.flags & TypeFlag.STATIC


def test_a_type_comes_with_all_it_is_made_of() -> None:
    names = {type.name for type in types_within([iec_type(Block), INT, iec_type(Block)])}
    assert names == {
        "FB_Block", "BOOL", "BIT", "POINTER TO ST_Part", "ST_Part", "BYTE", "LREAL",
        "REFERENCE TO INT", "INT", "I_Motor", "ARRAY [1..2] OF ST_Part", "STRING(3)", "DINT",
        "E_State", "UINT",
    }  # fmt: skip
