"""Types of symbol files: names with namespaces, pointers, arrays, what cannot be known."""

from typing import Any

import pytest

from achse.iec import IecType, StructType
from achse.st.lexis.source import SourceError
from achse.st.lexis.xml import parse_xml
from achse.st.symbolfiles.types import FileTypes


def _symbol(types: FileTypes, base: str, bits: int, around: str = "") -> IecType[object]:
    xml = f"<Symbol>{base}<BitSize>{bits}</BitSize>{around}</Symbol>"
    return types.type_of(parse_xml(xml.encode(), "f.tmc"), "BaseType")


ARRAY = "<ArrayInfo{}><LBound>1</LBound><Elements>4</Elements></ArrayInfo>"


@pytest.mark.parametrize(
    ("base", "bits", "around", "name"),
    [
        ("<BaseType>INT</BaseType>", 16, "", "INT"),
        ("<BaseType>WSTRING(4)</BaseType>", 80, "", "WSTRING(4)"),
        ('<BaseType PointerTo="2">INT</BaseType>', 64, "", "POINTER TO POINTER TO INT"),
        ('<BaseType ReferenceTo="true">INT</BaseType>', 64, "", "REFERENCE TO INT"),
        ("<BaseType>INT</BaseType>", 64, ARRAY.format(""), "ARRAY [1..4] OF INT"),
        (
            "<BaseType>INT</BaseType>",
            64,
            ARRAY.format(' ReferenceTo="true"'),
            "REFERENCE TO ARRAY [1..4] OF INT",
        ),
        (
            '<BaseType PointerTo="1">INT</BaseType>',
            256,
            ARRAY.format(""),
            "ARRAY [1..4] OF POINTER TO INT",
        ),
        (
            "<BaseType>INT</BaseType>",
            256,
            ARRAY.format("") + ARRAY.format(""),
            "ARRAY [1..4,1..4] OF INT",
        ),
        ("<BaseType>OTCID</BaseType>", 32, "", "OTCID"),
        ("<BaseType>BOOL</BaseType>", 1, "", "BOOL"),
    ],
)
def test_names(base: str, bits: int, around: str, name: str) -> None:
    assert _symbol(FileTypes([]), base, bits, around).name == name


def test_unknown_type_is_its_bytes() -> None:
    type = _symbol(FileTypes([]), '<BaseType Namespace="Lib">T_X</BaseType>', 24)
    assert (type.name, type.size, type.decode(b"abc")) == ("Lib.T_X", 3, b"abc")


def test_pointers_of_a_32_bit_target() -> None:
    assert _symbol(FileTypes([], 4), '<BaseType PointerTo="1">INT</BaseType>', 32).size == 4


def test_a_type_is_found_by_its_guid_when_the_name_lacks_the_namespace() -> None:
    xml = (
        '<DataType><Name GUID="{0a000000-0000-0000-0000-000000000001}" Namespace="L">T</Name>'
        "<BitSize>16</BitSize><BaseType>INT</BaseType></DataType>"
    )
    types = FileTypes([parse_xml(xml.encode(), "f.tmc")])
    symbol = _symbol(
        types, '<BaseType GUID="{0A000000-0000-0000-0000-000000000001}">T</BaseType>', 16
    )
    assert symbol.name == "L.T"
    assert [type.name for type in types.all()] == ["L.T"]


def test_inherited_members_may_be_listed_again_at_their_place() -> None:
    def derived(first: str) -> list[IecType[Any]]:
        member = "<SubItem><Name>{}</Name><Type>INT</Type><BitSize>16</BitSize>{}</SubItem>".format
        base = member("nFirst", "<BitOffs>64</BitOffs>")
        own = first + member("nSecond", "<BitOffs>80</BitOffs>")
        texts = (
            f"<DataType><Name>FB_Base</Name><BitSize>128</BitSize>{base}<FbInfo/></DataType>",
            "<DataType><Name>FB_More</Name><BitSize>128</BitSize>"
            f"<ExtendsType>FB_Base</ExtendsType>{own}<FbInfo/></DataType>",
        )
        return FileTypes([parse_xml(text.encode(), "f.tpy") for text in texts]).all()

    again = "<SubItem><Name>nFirst</Name><Type>INT</Type><BitSize>16</BitSize>"
    more = derived(again + "<BitOffs>64</BitOffs></SubItem>")[1]
    assert isinstance(more, StructType)
    assert [(m.name, m.offset) for m in more.members] == [("nFirst", 8), ("nSecond", 10)]
    with pytest.raises(SourceError, match=r"two members are named .nFirst"):
        derived(again + "<BitOffs>96</BitOffs></SubItem>")
