"""Structures, unions and function blocks over memory."""

# ruff: noqa: N815  (variables carry the prefixes of IEC programs)

import copy
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.declare import ARRAY, iec_type, var
from achse.iec.elementary import BIT, BOOL, BYTE, DINT, INT, LREAL, UDINT, USINT
from achse.iec.enums import Enumeration
from achse.iec.errors import DeclarationError, IecDecodeError, IecPathError, IecValueError
from achse.iec.layout import TC2_X86
from achse.iec.strings import STRING, WSTRING
from achse.iec.structs import FunctionBlock, Struct, StructType, Union, bind, plain
from achse.iec.times import DT, TIME
from achse.iec.variables import Variable


class State(Enumeration, base=USINT):
    Idle = 0
    Run = 1


class Point(Struct, name="ST_Point"):
    x = var(LREAL)
    y = var(LREAL, 2.5)


class Axis(Struct, name="ST_Axis"):
    bOn = var(BOOL)
    stPos = var(Point)
    aPath = var(ARRAY(Point, (1, 2)))
    aRaw = var(ARRAY(INT, (0, 2)), [1, 2, 3])
    sName = var(STRING(7), "X")
    wName = var(WSTRING(3))
    eState = var(State, State.Run)
    b0 = var(BIT)
    b1 = var(BIT, True)
    tRamp = var(TIME)
    dtBuilt = var(DT)


def test_the_layout_is_natural() -> None:
    # BOOL 0, struct of LREAL to 8, 2 x 16 from 24, INT 56..62, STRING(7) 62..70, WSTRING(3)
    # 70..78, USINT 78, bits 79, TIME 80, DT 84
    assert [(item.name, item.offset, item.bit) for item in iec_type(Axis).members] == [
        ("bOn", 0, None),
        ("stPos", 8, None),
        ("aPath", 24, None),
        ("aRaw", 56, None),
        ("sName", 62, None),
        ("wName", 70, None),
        ("eState", 78, None),
        ("b0", 79, 0),
        ("b1", 79, 1),
        ("tRamp", 80, None),
        ("dtBuilt", 84, None),
    ]
    assert iec_type(Axis).size == 88


def test_a_new_record_starts_as_declared() -> None:
    axis = Axis()
    assert axis.stPos.y == 2.5
    assert axis.aPath[2].y == 2.5
    assert axis.aRaw == [1, 2, 3]
    assert (axis.sName, axis.eState, axis.b0, axis.b1) == ("X", State.Run, False, True)
    assert bytes(axis) == iec_type(Axis).default


def test_attributes_are_the_memory() -> None:
    memory = bytearray(100)
    axis = iec_type(Axis).read(memory, 8)
    axis.stPos.x = 1.0
    assert memory[16:24] == LREAL.encode(1.0)
    memory[16:24] = LREAL.encode(3.0)
    assert axis.stPos.x == 3.0
    axis.aPath[1] = {"x": 4}
    assert plain(axis.aPath[1]) == {"x": 4.0, "y": 2.5}
    axis.stPos = axis.aPath[1]
    axis.aPath[1].x = 9.0
    assert axis.stPos.x == 4.0
    axis.b1 = True
    assert memory[8 + 79] == 2


def test_members_are_also_reached_by_name_without_case() -> None:
    axis = Axis()
    axis["SNAME"] = "abc"
    assert axis["sname"] == axis.sName == "abc"
    with pytest.raises(IecPathError, match="ST_Axis has no member 'sNam'"):
        axis["sNam"]


def test_a_misspelt_attribute_is_no_member() -> None:
    with pytest.raises(AttributeError):
        Point().z = 1.0  # type: ignore[attr-defined]


def test_values_come_from_keywords_and_mappings() -> None:
    assert Point(x=1.0) == Point({"X": 1.0})
    assert Axis(stPos={"y": 1}).stPos.y == 1.0
    assert iec_type(Axis).encode({}) == iec_type(Axis).default
    assert iec_type(Point).encode(Point(x=1.0)) == LREAL.encode(1.0) + LREAL.encode(2.5)
    for value, message in (
        ({"z": 1}, "ST_Point takes members x, y, got 'z'"),
        ({5: 1}, "ST_Point takes members x, y, got 5"),
        (5, "ST_Point takes a ST_Point or a mapping of its members, got 5"),
        ({"x": "1"}, "ST_Point.x: LREAL takes a number"),
    ):
        with pytest.raises(IecValueError, match=message):
            iec_type(Point).encode(value)


def test_records_compare_and_print_by_value() -> None:
    assert Point(x=1) == Point(x=1)
    assert Point(x=1) != Point(x=2)
    assert Point() != 5
    assert repr(Point(x=1)) == "ST_Point(x=1.0, y=2.5)"
    with pytest.raises(TypeError, match="unhashable"):
        hash(Point())


def test_a_copy_has_memory_of_its_own() -> None:
    axis = Axis()
    for other in (copy.copy(axis), copy.deepcopy(axis)):
        assert other == axis
        other.stPos.x = 7.0
        assert axis.stPos.x == 0.0


def test_padding_does_not_count() -> None:
    class Gap(Struct):
        a = var(BYTE)
        b = var(DINT)

    assert iec_type(Gap).decode(b"\1\0\0\0\2\0\0\0") == iec_type(Gap).decode(b"\1xyz\2\0\0\0")


@given(st.binary(min_size=88, max_size=88))
def test_any_bytes_are_a_record_and_come_back(data: bytes) -> None:
    axis = iec_type(Axis).decode(data)
    assert bytes(axis) == data
    values = plain(axis)
    again = iec_type(Axis).decode(iec_type(Axis).encode(axis))
    assert repr(plain(again)) == repr(values)


@given(st.floats(allow_nan=False), st.text("abcä€", max_size=7), st.sampled_from(State))
def test_values_come_back(x: float, name: str, state: State) -> None:
    axis = Axis(stPos={"x": x}, sName=name, eState=state)
    assert iec_type(Axis).decode(bytes(axis)) == axis
    assert iec_type(Axis).decode(iec_type(Axis).encode(plain(axis))) == axis


def test_packing_and_platform() -> None:
    class Packed(Struct, pack=1):
        a = var(BYTE)
        b = var(LREAL)

    class ByAttribute(Struct, attributes={"pack_mode": "2"}):
        a = var(BYTE)
        b = var(LREAL)

    class Old(Struct, rules=TC2_X86):
        a = var(BYTE)
        b = var(LREAL)

    assert [iec_type(item).size for item in (Packed, ByAttribute, Old)] == [9, 10, 9]

    class Holder(Struct):
        a = var(BYTE)
        packed = var(Packed)

    assert iec_type(Holder).size == 10


def test_inheritance_puts_the_base_first() -> None:
    class Point3(Point):
        z = var(BYTE)

    class Point4(Point3):
        w = var(LREAL)

    members = [(item.name, item.offset) for item in iec_type(Point4).members]
    assert members == [("x", 0), ("y", 8), ("z", 16), ("w", 24)]
    point = Point4(x=1.0, w=2.0)
    assert (point.x, point.w, point["X"]) == (1.0, 2.0, 1.0)


def test_union_members_share_their_memory() -> None:
    class Both(Union):
        n = var(UDINT)
        a = var(ARRAY(BYTE, (0, 3)))

    both = Both(n=0x01020304)
    assert both.a == [4, 3, 2, 1]
    both.a[3] = 0
    assert both.n == 0x020304
    assert iec_type(Both).size == 4


def test_function_blocks_have_a_table_pointer_and_python_state() -> None:
    class Counter(FunctionBlock, name="FB_Counter"):
        nCount = var(UDINT)

        def __init__(self) -> None:
            super().__init__()
            self.calls = 0

        def __call__(self) -> None:
            self.calls += 1
            self.nCount += 2

    class Holder(Struct):
        fb = var(Counter)
        fbs = var(ARRAY(Counter, (1, 2)))

    assert iec_type(Counter).members[0].offset == 8
    assert iec_type(Counter).size == 16
    holder = Holder()
    holder.fb()
    holder.fb()
    holder.fbs[2]()
    assert (holder.fb.calls, holder.fb.nCount) == (2, 4)
    assert (holder.fbs[2].calls, holder.fbs[2].nCount, holder.fbs[1].nCount) == (1, 2, 0)
    alone = Counter()
    alone()
    assert alone.nCount == 2


def test_binding_needs_enough_memory() -> None:
    point = Point()
    with pytest.raises(IecValueError, match="ST_Point takes 16 bytes of memory, got 15"):
        bind(point, bytearray(20), 5)
    with pytest.raises(IecDecodeError, match="ST_Point has 16 bytes, got 15"):
        iec_type(Point).decode(bytes(15))


def test_a_type_made_of_variables_has_a_record_class() -> None:
    type: StructType[Any] = StructType(
        "ST_Free", [Variable(INT, name="a"), Variable(INT, name="B")]
    )
    value = type.decode(b"\1\0\2\0")
    assert (value.a, value["b"]) == (1, 2)
    assert repr(value) == "ST_Free(a=1, B=2)"


def test_impossible_records() -> None:
    with pytest.raises(DeclarationError, match="has two members named A"):
        StructType("ST_Twice", [Variable(INT, name="a"), Variable(INT, name="A")])
    with pytest.raises(DeclarationError, match="initial value of n: INT takes"):

        class Bad(Struct):
            n = var(INT, 1 << 20)

    with pytest.raises(DeclarationError, match="exactly one record class"):

        class Two(Point, Axis):
            pass
