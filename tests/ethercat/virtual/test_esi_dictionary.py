"""Dictionaries of ESI files: types, defaults in their three forms, access, arrays, slots."""

import struct
from xml.etree.ElementTree import fromstring

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import DataType
from achse.ethercat.application import ObjectAccess, ObjectCode
from achse.ethercat.dictionary import DictionaryObject
from achse.ethercat.virtual.esi_dictionary import read_dictionary, type_number

TYPES = """
<DataType><Name>Modes</Name><BaseType>USINT</BaseType><BitSize>3</BitSize></DataType>
<DataType><Name>DT2000</Name><BitSize>64</BitSize>
 <SubItem><SubIdx>0</SubIdx><Name>Count</Name><Type>USINT</Type><BitSize>8</BitSize></SubItem>
 <SubItem><SubIdx>1</SubIdx><Name>Gain</Name><Type>REAL</Type><BitSize>32</BitSize>
  <Flags><Access WriteRestrictions="PreOP">rw</Access><PdoMapping>RT</PdoMapping>
  <Backup>1</Backup><Setting>1</Setting></Flags></SubItem>
 <SubItem><SubIdx>5</SubIdx><Name>Mode</Name><Type>Modes</Type><BitSize>3</BitSize>
  <Flags><Access ReadRestrictions="SafeOP_OP">ro</Access></Flags></SubItem></DataType>
<DataType><Name>DT2001ARR</Name><BaseType>UINT</BaseType><BitSize>48</BitSize>
 <ArrayInfo><LBound>1</LBound><Elements>3</Elements></ArrayInfo></DataType>
<DataType><Name>DT2001</Name><BitSize>64</BitSize>
 <SubItem><SubIdx>0</SubIdx><Name>Count</Name><Type>USINT</Type><BitSize>8</BitSize></SubItem>
 <SubItem><Name>Elements</Name><Type>DT2001ARR</Type><BitSize>48</BitSize></SubItem></DataType>
"""


def objects(rows: str, shift: int = 0) -> dict[int, DictionaryObject]:
    text = (
        f"<Profile><Dictionary><DataTypes>{TYPES}</DataTypes><Objects>{rows}</Objects>"
        "</Dictionary></Profile>"
    )
    return {each.index: each for each in read_dictionary(iter([fromstring(text)]), shift)}


def one(kind: str, bits: int, info: str, flags: str = "") -> DictionaryObject:
    row = (
        f"<Object><Index>#x3000</Index><Name>X</Name><Type>{kind}</Type><BitSize>{bits}</BitSize>"
        f"<Info>{info}</Info>{flags}</Object>"
    )
    return objects(row)[0x3000]


@given(value=st.integers(-(1 << 31), (1 << 31) - 1), base=st.sampled_from(["d", "x"]))
def test_number_as_value_and_as_bytes(value: int, base: str) -> None:
    text = str(value) if base == "d" or value < 0 else f"#x{value:X}"
    data = value.to_bytes(4, "little", signed=True)
    for info in (
        f"<DefaultValue>{text}</DefaultValue>",
        f"<DefaultData>{data.hex().upper()}</DefaultData>",
    ):
        (entry,) = one("DINT", 32, info).entries
        assert (entry.data_type, entry.bits, entry.default) == (DataType.I32, 32, data)


@given(value=st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_real_has_its_value(value: float) -> None:
    (entry,) = one("REAL", 32, f"<DefaultValue>{value!r}</DefaultValue>").entries
    assert entry.default == struct.pack("<f", value)


def test_text_limits_and_access() -> None:
    (entry,) = one("STRING(4)", 32, "<DefaultString>abcdef</DefaultString>").entries
    assert (entry.data_type, entry.default) == (DataType.VISIBLE_STRING, b"abcd")
    info = "<MinValue>-5</MinValue><MaxValue>9</MaxValue><DefaultValue>1e3</DefaultValue>"
    result = one("SINT", 8, info, "<Flags><Access>wo</Access></Flags>")
    (entry,) = result.entries
    assert (entry.minimum, entry.maximum, entry.default) == (b"\xfb", b"\x09", None)
    assert (result.code, entry.access) == (ObjectCode.VAR, ObjectAccess.WRITE)


def test_record_has_its_entries_with_their_flags() -> None:
    result = objects(
        "<Object><Index>#x2000</Index><Name>R</Name><Type>DT2000</Type><Info>"
        "<SubItem><Name>Gain</Name><Info><DefaultValue>2.5</DefaultValue></Info></SubItem>"
        "<SubItem><Name>Mode</Name><Info><DefaultData>03</DefaultData></Info></SubItem></Info>"
        "</Object>"
    )[0x2000]
    count, gain, mode = result.entries
    assert (count.default, result.code) == (b"\x05", ObjectCode.RECORD)
    assert gain.default == struct.pack("<f", 2.5)
    assert gain.access == ObjectAccess.READ | ObjectAccess.WRITE_PREOP | 0x03C0
    assert (mode.subindex, mode.bits, mode.data_type, mode.default) == (5, 3, DataType.U8, b"\x03")
    assert mode.access == ObjectAccess.READ_SAFEOP | ObjectAccess.READ_OP


def test_array_has_an_entry_for_each_element() -> None:
    values = "".join(
        f"<SubItem><Name>SubIndex {n:03d}</Name><Info><DefaultValue>{n + 6}</DefaultValue></Info>"
        "</SubItem>"
        for n in range(4)
    )
    result = objects(
        f"<Object><Index DependOnSlot='1'>#x2001</Index><Name>A</Name><Type>DT2001</Type>"
        f"<Info>{values}</Info></Object>",
        shift=0x20,
    )[0x2021]
    assert [(each.subindex, each.default) for each in result.entries[1:]] == [
        (n, bytes((n + 6, 0))) for n in (1, 2, 3)
    ]


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("<Object><Index>0</Index></Object>", "Object Index"),
        ("<Object><Index>x</Index></Object>", "expected a number"),
        (
            "<Object><Index>1</Index><Type>INT</Type><BitSize>16</BitSize>"
            "<Info><DefaultData>zz</DefaultData></Info></Object>",
            "object 0001: DefaultData",
        ),
        ("<Object><Index>1</Index><Type>Q</Type><BitSize>99999999</BitSize></Object>", "bits"),
    ],
)
def test_object_that_cannot_be_names_the_fault(row: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        objects(row)


def test_basic_types_by_name() -> None:
    assert [type_number(each) for each in ("UINT", "BIT1", "bit8", "STRING(7)", "Foo")] == [
        6, 0x30, 0x37, 9, 0,
    ]  # fmt: skip
    assert type_number("ARRAY [0..3] OF BYTE") == DataType.OCTET_STRING
