"""Types of libraries out of .tmc files: found by the names that sources use."""

import pytest

from achse.iec import StructType
from achse.iec.errors import DeclarationError
from achse.st.lexis.source import SourceError
from achse.st.symbolfiles.library import LibraryTypes

ANOTHER = b"""<TcModuleClass><DataTypes>
<DataType><Name Namespace="Other">T_Text</Name><BitSize>80</BitSize><BaseType>STRING(9)</BaseType>
</DataType>
<DataType><Name Namespace="Lib">T_Text</Name><BitSize>72</BitSize><BaseType>STRING(8)</BaseType>
</DataType>
<DataType><Name>E_Shut</Name><BitSize>16</BitSize><BaseType>INT</BaseType>
 <EnumInfo><Text>Alone</Text><Enum>1</Enum></EnumInfo>
 <Properties><Property><Name>Qualified_Only</Name></Property></Properties></DataType>
</DataTypes>
<Modules><Module TargetPlatform="TwinCAT RT (PLATFORM)"><Name>Other</Name></Module></Modules>
</TcModuleClass>"""


def another(platform: str = "x64") -> tuple[bytes, str]:
    return ANOTHER.replace(b"PLATFORM", platform.encode()), "other.tmc"


def test_a_type_is_found_with_and_without_its_library(tmc: bytes) -> None:
    types = LibraryTypes([(tmc, "plant.tmc")])
    for name in ("Lib.T_Text", "t_text", "More.Lib.T_TEXT"):
        type = types.type(name)
        assert type is not None
        assert (type.name, type.size) == ("Lib.T_Text", 16)
    axis = types.type("Somewhere.ST_Axis")
    assert isinstance(axis, StructType)
    assert axis.size == 64
    assert types.type("ST_Nothing") is None
    assert types.names == ["plant.tmc"]


def test_a_derived_structure_knows_its_base(tmc: bytes) -> None:
    types = LibraryTypes([(tmc, "plant.tmc")])
    axis = types.type("ST_Axis")
    assert isinstance(axis, StructType)
    assert axis.base is types.type("ST_Base")
    assert axis.own_members == axis.members[1:]
    assert [member.offset for member in axis.members[:2]] == [0, 8]


def test_the_first_file_counts(tmc: bytes) -> None:
    types = LibraryTypes([(tmc, "plant.tmc"), another()])
    type = types.type("T_Text")
    assert type is not None
    assert type.size == 16
    assert types.type("E_Shut") is not None


def test_an_enumeration_of_two_files_is_one_with_its_value() -> None:
    """A folder may have copies of a project's file, with names of libraries spelt otherwise."""
    text = (
        '<TcModuleClass><DataTypes><DataType><Name Namespace="Lib">E_Mode</Name>'
        "<BitSize>16</BitSize><BaseType>INT</BaseType>"
        "<EnumInfo><Text>Auto</Text><Enum>3</Enum></EnumInfo></DataType></DataTypes>"
        '<Modules><Module TargetPlatform="TwinCAT RT (x64)"><Name>P</Name></Module></Modules>'
        "</TcModuleClass>"
    )
    other = text.replace('"Lib"', '"LIB"').replace("<Enum>3", "<Enum>4")
    types = LibraryTypes([(text.encode(), "a.tmc"), (other.encode(), "b.tmc")])
    assert [enum.numbers for enum in types.enumerations("auto")] == [{"Auto": 3}]


def test_a_name_of_two_libraries_is_a_question() -> None:
    types = LibraryTypes([another()])
    with pytest.raises(DeclarationError, match=r"which type is meant: lib\.t_text or other\.t_te"):
        types.type("T_Text")
    type = types.type("Other.T_Text")
    assert type is not None
    assert type.size == 10


def test_values_of_enumerations_that_may_stand_alone(tmc: bytes) -> None:
    types = LibraryTypes([(tmc, "plant.tmc"), another()])
    assert [type.name for type in types.enumerations("busy")] == ["E_State"]
    assert types.enumerations("alone") == []


def test_files_are_of_one_platform(tmc: bytes) -> None:
    assert LibraryTypes([]).pointer_size == 8
    assert LibraryTypes([another("x86")]).pointer_size == 4
    with pytest.raises(SourceError, match=r"other\.tmc:\d.*64-bit PLC, like those of plant\.tmc"):
        LibraryTypes([(tmc, "plant.tmc"), another("x86")])
    with pytest.raises(SourceError, match=r"x\.tmc:1"):
        LibraryTypes([(b"<a/>", "x.tmc")])


def test_files_beside_the_project_for_another_platform_are_left_out(tmc: bytes) -> None:
    types = LibraryTypes([], [(tmc, "plant.tmc"), another("x86")])
    assert (types.pointer_size, types.names) == (8, ["plant.tmc"])
    assert types.type("E_Shut") is None


POINTERS = b"""<TcModuleClass><DataTypes>
<DataType><Name>ST_Far</Name><BitSize>32</BitSize><SubItem><Name>p</Name>
<Type PointerTo="1">INT</Type><BitSize>32</BitSize><BitOffs>0</BitOffs></SubItem></DataType>
<DataType><Name>ST_Near</Name><BitSize>32</BitSize><SubItem><Name>n</Name>
<Type>DINT</Type><BitSize>32</BitSize><BitOffs>0</BitOffs></SubItem></DataType>
</DataTypes>
<Modules><Module TargetPlatform="TwinCAT RT (x86)"><Name>Lib</Name></Module></Modules>
</TcModuleClass>"""


def test_libraries_give_what_the_project_lacks(tmc: bytes) -> None:
    shelved = [another(), (b"<a/>", "broken.tmc"), (POINTERS, "far.tmc")]
    types = LibraryTypes([(tmc, "plant.tmc")], libraries=shelved)
    types_in_order = [types.type(name) for name in ("T_Text", "E_Shut", "ST_Near")]
    assert [type and type.size for type in types_in_order] == [16, 2, 4]
    assert types.type("ST_Far") is None  # a pointer of another platform has another size
    assert types.names == ["plant.tmc"]
