"""Types built from the uploaded table of a target."""

# ruff: noqa: N801, N815  (names carry the prefixes of IEC programs)

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.datatypes import DataTypeEntry, decode_types, encode_types
from achse.iec.declare import ARRAY, iec_type, method, pointer_to, var
from achse.iec.derived import AliasType, InterfaceType, OpaqueType, PointerType, SubrangeType
from achse.iec.describe import describe_type, types_within
from achse.iec.elementary import BIT, BOOL, BYTE, DINT, INT, LREAL, UDINT, UINT
from achse.iec.enums import Enumeration
from achse.iec.errors import DeclarationError, IecDecodeError, IecError, IecValueError
from achse.iec.names import ELEMENTARY
from achse.iec.paths import locate
from achse.iec.strings import STRING, WSTRING
from achse.iec.structs import FunctionBlock, Struct, StructType, Union, plain
from achse.iec.symbols import SymbolEntry
from achse.iec.times import DT, LTIME, TIME
from achse.iec.types import IecType
from achse.iec.typetable import TypeTable
from achse.iec.variables import Variable


class E_State(Enumeration, base=UINT):
    Idle = 0
    Run = 5


class Both(Union, name="U_Both"):
    n = var(UDINT)
    a = var(ARRAY(BYTE, (0, 3)))


class Part(Struct, name="ST_Part"):
    bOn = var(BOOL)
    f = var(LREAL)
    eState = var(E_State)
    b0 = var(BIT)
    b1 = var(BIT)
    sName = var(STRING(5, "utf-8"))
    wName = var(WSTRING(3))
    tRun = var(TIME)
    lRun = var(LTIME)
    dtAt = var(DT)


class Block(FunctionBlock, name="FB_Block"):
    aParts = var(ARRAY(Part, (-1, 0), (1, 2)))
    uBoth = var(Both)
    tLen = var(AliasType("T_Len", LREAL))
    nFew = var(SubrangeType(INT, 0, 5))
    nSome = var(SubrangeType(INT, 0, 9, name="T_Some"))
    pPart = var(pointer_to(Part))
    iMotor = var(InterfaceType("I_Motor"))
    aaRaw = var(ARRAY(ARRAY(INT, (0, 1)), (0, 1)))

    @method(DINT, fX=LREAL)
    def step(self, x: float) -> int:
        return int(x)


def uploaded(*types: IecType[Any]) -> TypeTable:
    """The table as it arrives at a client."""
    entries = [describe_type(item) for item in types_within([*types, *ELEMENTARY.values()])]
    return TypeTable(decode_types(encode_types(entries)))


TABLE = uploaded(iec_type(Block))


@pytest.mark.parametrize("type", types_within([iec_type(Block)]), ids=lambda type: type.name)
def test_every_type_comes_back_as_itself(type: IecType[Any]) -> None:
    again = TABLE.type(type.name.lower() if "TO" not in type.name else type.name)
    assert (again.name, again.size, again.adst) == (type.name, type.size, type.adst)
    # What is derived from the definition tells whether the definition came through.
    if not isinstance(type, PointerType):
        assert again.guid == type.guid
    if not type.is_view:
        assert again.decode(type.default) == type.decode(type.default)


def test_offsets_are_those_of_the_table() -> None:
    block = TABLE.type("FB_Block")
    assert isinstance(block, StructType)
    expected = [(item.name, item.offset, item.bit) for item in iec_type(Block).members]
    assert [(item.name, item.offset, item.bit) for item in block.members] == expected


@given(st.binary(min_size=iec_type(Part).size, max_size=iec_type(Part).size))
def test_a_structure_reads_the_same_by_the_table(data: bytes) -> None:
    ours, theirs = iec_type(Part).decode(data), TABLE.type("ST_Part").decode(data)
    assert repr(plain(theirs)) == repr(plain(ours))


MEMBERS = st.lists(
    st.one_of(
        st.sampled_from([BOOL, INT, UDINT, LREAL, STRING(5), iec_type(Part)]),
        st.builds(
            lambda element, dimensions: ArrayType(
                element, [Bounds(first, first + length - 1) for first, length in dimensions]
            ),
            st.sampled_from([BYTE, INT, LREAL, STRING(2), iec_type(E_State), iec_type(Part)]),
            st.lists(st.tuples(st.integers(-3, 3), st.integers(0, 3)), min_size=1, max_size=3),
        ),
    ),
    min_size=1,
    max_size=5,
)


@given(MEMBERS, st.randoms(use_true_random=False))
def test_arrays_of_any_length_come_through(types: list[IecType[Any]], random: Any) -> None:
    """An array without elements tells no size of its element; members share its offset."""
    result: Any = StructType(
        "ST_Drawn", [Variable(each, name=f"m{n}") for n, each in enumerate(types)]
    )
    entries = [describe_type(item) for item in types_within([result])]
    again = TypeTable(decode_types(encode_types(entries))).type("ST_Drawn")
    assert isinstance(again, StructType)
    assert again.kind is result.kind
    assert [(item.type.name, item.offset, item.type.size) for item in again.members] == [
        (item.type.name, item.offset, item.type.size) for item in result.members
    ]
    data = random.randbytes(result.size)
    assert repr(plain(again.decode(data))) == repr(plain(result.decode(data)))
    assert again.encode(again.decode(result.default)) == result.encode(
        result.decode(result.default)
    )


def test_array_without_elements_of_an_unknown_type_is_empty() -> None:
    entry = DataTypeEntry("ARRAY [1..0] OF T_Far", "T_Far", 0, 65, 0x81, dimensions=((1, 0),))
    array = TypeTable([entry]).type(entry.name)
    assert (array.size, array.decode(b"")) == (0, [])


def test_values_are_written_by_the_table() -> None:
    block = TABLE.type("FB_Block")
    value = block.decode(bytes(block.size))
    value.aParts[-1, 2].sName = "äb"
    value.aParts[0, 1] = {"eState": "Run", "b1": True}
    value["tlen"] = 2.5
    ours = iec_type(Block).decode(bytes(value))
    assert ours.aParts[-1, 2].sName == "äb"
    assert (ours.aParts[0, 1].eState, ours.aParts[0, 1].b1) == (E_State.Run, True)
    assert ours.tLen == 2.5
    with pytest.raises(IecValueError, match=r"INT \(0..5\) takes an integer in 0..5"):
        value.nFew = 6
    with pytest.raises(IecValueError, match=r"INT \(0..9\) takes an integer in 0..9"):
        value.nSome = 10


def test_enumerations_are_made_once() -> None:
    one, other = TABLE.type("e_state"), TABLE.type("E_State")
    assert one is other
    assert one.decode(b"\5\0").name == "Run"
    assert one.decode(b"\5\0") is other.decode(b"\5\0")


def test_methods_come_along() -> None:
    block = TABLE.type("FB_Block")
    assert isinstance(block, StructType)
    step = block.method("STEP")
    assert step.encode_inputs({"fx": 1.0}) == LREAL.encode(1.0)
    assert step.decode_answer(DINT.encode(3)) == (3,)


def test_a_type_may_point_to_its_own_kind() -> None:
    node = DataTypeEntry(
        "ST_Node",
        "",
        16,
        65,
        0x81,
        members=(
            DataTypeEntry("n", "INT", 2, 2, 0x82),
            DataTypeEntry("pNext", "POINTER TO ST_Node", 8, 65, 0x80082, 8),
        ),
    )
    table = TypeTable([node])
    type = table.type("ST_Node")
    result = locate(type, "pNext^.pnext^.n")
    assert (result.type, result.offset, result.hops) == (INT, 0, (8, 8))


def test_unions_share_their_memory() -> None:
    both = TABLE.type("U_Both")
    assert both.encode({"n": 1}) == b"\1\0\0\0"
    assert both.encode({"a": [1, 2, 3, 4]}) == b"\1\2\3\4"


def test_symbols_find_their_type() -> None:
    def symbol(type_name: str, size: int, adst: int, **more: Any) -> IecType[Any]:
        return TABLE.symbol_type(SymbolEntry("x", type_name, 0, 0, size, adst, **more))

    assert symbol("ST_Part", iec_type(Part).size, 65).name == "ST_Part"
    assert symbol("ARRAY [0..2] OF INT", 6, 2).decode(bytes(6)) == [0, 0, 0]
    assert symbol("BOOL", 1, 33, flags=2).is_bit
    utf8 = symbol("STRING(4)", 5, 30, flags=0x1000, attributes=(("TcEncoding", "UTF-8"),))
    assert utf8.decode("ä".encode()) == "ä"
    # names nobody knows, as an older target gives them
    assert symbol("UINT32", 4, 19) is UDINT
    assert symbol("T_Gone", 11, 30) is STRING(10)
    assert symbol("T_Gone", 12, 31) is WSTRING(5)
    assert symbol("PVOID", 4, 19) is UDINT
    opaque = symbol("T_Gone", 3, 65)
    assert isinstance(opaque, OpaqueType)
    assert opaque.decode(opaque.encode(b"abc")) == b"abc"
    with pytest.raises(IecValueError, match="T_Gone takes 3 bytes"):
        opaque.encode(b"ab")


def test_unknown_names_and_late_entries() -> None:
    table = TypeTable()
    with pytest.raises(DeclarationError, match="no type is named 'T_Late'"):
        table.type("T_Late")
    table.add(DataTypeEntry("T_Late", "LREAL", 8, 5, 0x81))
    assert table.type("t_late").size == 8
    assert "T_LATE" in table
    assert len(table) == len(list(table)) == 1
    assert table.entry("T_Late") is not None


def test_static_members_and_properties_have_no_memory() -> None:
    entry = DataTypeEntry(
        "FB",
        "",
        16,
        65,
        0x81,
        members=(
            DataTypeEntry("a", "INT", 2, 2, 0x82, 8),
            DataTypeEntry("s", "INT", 2, 2, 0x20082, 0xFFFF_FFFF),
            DataTypeEntry("p", "INT", 2, 2, 0xC2, 0),
        ),
    )
    type = TypeTable([entry]).type("FB")
    assert plain(type.decode(bytes(16))) == {"a": 0}


@pytest.mark.parametrize(
    "entries",
    [
        [DataTypeEntry("A", "", 8, 65, 1, members=(DataTypeEntry("a", "A", 8, 65, 2),))],
        [DataTypeEntry("A", "B", 8, 65, 1), DataTypeEntry("B", "A", 8, 65, 1)],
        [DataTypeEntry("A", "", 4, 65, 1, members=(DataTypeEntry("a", "INT", 2, 2, 2, 3),))],
        [DataTypeEntry("A", "INT", 5, 2, 1, dimensions=((0, 2),))],
        [DataTypeEntry("A", "INT", 0, 2, 1, dimensions=((2**31 - 1, 2**32 - 1),))],
        [DataTypeEntry("A", "LREAL", 8, 5, 0x2001, enum_values=(("x", bytes(8)),))],
        [DataTypeEntry(f"T{n}", f"T{n + 1}", 8, 65, 1) for n in range(2000)],
    ],
    ids=["itself", "circle", "beyond", "odd", "bounds", "base", "deep"],
)
def test_entries_that_contradict_themselves(entries: list[DataTypeEntry]) -> None:
    with pytest.raises(IecDecodeError):
        TypeTable(entries).type(entries[0].name)


@pytest.mark.parametrize("name", ["__class__", "__slots__", "__iec_buffer__", "in", "", "a b"])
def test_members_may_have_any_name(name: str) -> None:
    members = (DataTypeEntry(name, "INT", 2, 2, 2), DataTypeEntry("n", "INT", 2, 2, 2, 2))
    value = (
        TypeTable([DataTypeEntry("A", "", 4, 65, 1, members=members)]).type("A").decode(b"\1\0\2\0")
    )
    assert (value[name], value.n) == (1, 2)


def test_enumeration_values_may_have_any_name() -> None:
    names = ["_a_", "__b__", "mro", "name", "value", "Ok", "in", "a b", ""]
    values = tuple((name, bytes([n, 0])) for n, name in enumerate(names))
    type = TypeTable([DataTypeEntry("E", "INT", 2, 2, 0x2001, enum_values=values)]).type("E")
    assert type.decode(b"\5\0").name == "Ok"
    assert [type.decode(bytes([n, 0])) for n in range(9)] == list(range(9))


ENTRIES = [describe_type(item) for item in types_within([iec_type(Block)])]
FIELDS = ["size", "offset", "adst", "flags", "type_name", "name", "dimensions"]


@given(st.data())
def test_damaged_tables_give_a_type_or_the_error(data: st.DataObject) -> None:
    damaged = list(ENTRIES)
    for _ in range(data.draw(st.integers(1, 3))):
        index = data.draw(st.integers(0, len(damaged) - 1))
        field = data.draw(st.sampled_from(FIELDS))
        names = st.sampled_from([item.name for item in ENTRIES])
        numbers = st.integers(0, 70) | st.integers(0, 2**32 - 1)
        bounds = st.lists(st.tuples(st.integers(-9, 9), numbers), max_size=2).map(tuple)
        kinds: dict[str, st.SearchStrategy[Any]] = {
            "type_name": names,
            "name": names,
            "dimensions": bounds,
        }
        change: dict[str, Any] = {field: data.draw(kinds.get(field, numbers))}
        entry = damaged[index]
        inside = bool(entry.members) and data.draw(st.booleans())
        if inside:
            member = data.draw(st.integers(0, len(entry.members) - 1))
            changed = replace(entry.members[member], **change)
            members = (*entry.members[:member], changed, *entry.members[member + 1 :])
            damaged[index] = replace(entry, members=members)
        else:
            damaged[index] = replace(entry, **change)
    table = TypeTable(damaged)
    for entry in damaged:
        try:
            type = table.type(entry.name)
            plain(type.decode(bytes(min(type.size, 10_000))))
        except (IecDecodeError, DeclarationError):
            pass


def test_the_errors_are_of_this_room() -> None:
    assert issubclass(IecDecodeError, IecError)
    assert issubclass(DeclarationError, IecError)
