"""Folders of sources."""

from pathlib import Path

import pytest

from achse.plc import PlcRuntime, Task
from achse.plc.bodies import Bodies
from achse.st.check import check
from achse.st.files.files import parse_file, source_files
from achse.st.lexis.source import SourceError
from achse.st.project import load_project

TYPE = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject><DUT Name="ST_X"><Declaration><![CDATA[TYPE ST_X :
STRUCT
    a : INT := 3;
END_STRUCT
END_TYPE]]></Declaration></DUT></TcPlcObject>"""
LIST = """<TcPlcObject><GVL Name="GVL"><Declaration><![CDATA[VAR_GLOBAL
    x : ST_X;
END_VAR]]></Declaration></GVL></TcPlcObject>"""
PROGRAM = """<TcPlcObject><POU Name="MAIN"><Declaration><![CDATA[PROGRAM MAIN
VAR n : INT := 5; END_VAR]]></Declaration><Implementation><ST><![CDATA[n := n + 1;]]></ST>
</Implementation></POU></TcPlcObject>"""
TASK = """<TcPlcObject><Task Name="PlcTask"><CycleTime>2000</CycleTime><Priority>5</Priority>
<PouCall><Name>MAIN</Name></PouCall></Task></TcPlcObject>"""
PROJECT = r"""<Project xmlns="http://schemas.microsoft.com/developer/msbuild/2003"><ItemGroup>
<Compile Include="DUTs\ST_X.TcDUT"><SubType>Code</SubType></Compile>
<Compile Include="GVLs\GVL.TcGVL"/>
<Compile Include="POUs\MAIN%20.TcPOU"/>
<Compile Include="Old.TcPOU"><ExcludeFromBuild>true</ExcludeFromBuild></Compile>
<Compile Include="Vis\Screen.TcVIS"/>
</ItemGroup></Project>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in {
        "DUTs/ST_X.TcDUT": TYPE,
        "GVLs/GVL.TcGVL": LIST,
        "POUs/MAIN .TcPOU": PROGRAM,
        "PlcTask.TcTTO": TASK,
        ".git/x.st": "nonsense",
        "readme.txt": "nothing",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, "utf-8-sig")
    return tmp_path


def test_a_folder(folder: Path) -> None:
    project = load_project(folder)
    assert [unit.__iec__.name for unit in project.declarations.units] == ["GVL", "MAIN"]
    assert project.declarations.types["st_x"].default == b"\3\0"
    ((name, cycle_ns, priority, programs, *_),) = project.tasks
    assert (name, cycle_ns, priority, programs) == ("PlcTask", 2_000_000, 5, ("MAIN",))
    assert len(project.sources) == 3


def test_a_project_file_says_what_counts(folder: Path) -> None:
    (folder / "Old.TcPOU").write_text("nonsense")
    with pytest.raises(SourceError, match=r"Old\.TcPOU:1:"):
        load_project(folder, check_all=True)
    (folder / "Plc.plcproj").write_text(PROJECT)
    for path in (folder, folder / "Plc.plcproj"):
        assert len(load_project(path).sources) == 3
    names = [name for _, name in source_files(folder)]
    assert names == ["DUTs/ST_X.TcDUT", "GVLs/GVL.TcGVL", "POUs/MAIN .TcPOU"]


def test_a_folder_that_is_excluded_from_the_build(tmp_path: Path) -> None:
    (tmp_path / "Plc.plcproj").write_text(
        r"""<Project><ItemGroup>
<Compile Include="POUs\Trial\Deep\F_A.TcPOU"><SubType>Code</SubType></Compile>
<Compile Include="POUs\trial\F_B.TcPOU"/>
<Compile Include="POUs\Trials\F_C.TcPOU"/>
<Compile Include="Trial\F_D.TcPOU"/>
<Folder Include="POUs"/>
<Folder Include="POUs\Trial"><ExcludeFromBuild>true</ExcludeFromBuild></Folder>
<Folder Include="POUs\Trials"><ExcludeFromBuild>false</ExcludeFromBuild></Folder>
</ItemGroup></Project>"""
    )
    names = [name for _, name in source_files(tmp_path)]
    assert names == ["POUs/Trials/F_C.TcPOU", "Trial/F_D.TcPOU"]


def test_structured_text_files(tmp_path: Path) -> None:
    (tmp_path / "Globals.st").write_bytes(
        b"VAR_GLOBAL s : STRING := '\xe4'; END_VAR\r\nPROGRAM P END_PROGRAM"
    )
    (tmp_path / "types.ST").write_text("TYPE T : STRING := 'ä'; END_TYPE", "utf-8-sig")
    (tmp_path / "wide.st").write_text("TYPE W : STRING := 'ä'; END_TYPE", "utf-16")
    declarations = load_project(tmp_path).declarations
    assert "w" in declarations.types
    assert declarations.globals["globals"].__iec__.members[0].initial == "ä"
    assert declarations.types["t"].default[:2] == b"\xe4\0"
    alone = load_project(tmp_path / "Globals.st").declarations
    assert list(alone.programs) == ["p"]


def test_libraries(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    user = tmp_path_factory.mktemp("user")
    (user / "P.st").write_text("PROGRAM P VAR x : Lib.ST_X; END_VAR END_PROGRAM")
    declarations = load_project(user, libraries=[folder]).declarations
    assert [unit.__iec__.name for unit in declarations.units] == ["P"]
    assert declarations.programs["p"].__iec__.size == 2


def test_all_faults_of_all_files_are_reported(folder: Path) -> None:
    (folder / "a.st").write_text("PROGRAM a x := ; END_PROGRAM")
    (folder / "b.st").write_text("TYPE T INT; END_TYPE\nTYPE U INT; END_TYPE")
    (folder / "c.TcPOU").write_text("<a>")
    with pytest.raises(SourceError) as caught:
        load_project(folder, check_all=True)
    assert [str(fault.location) for fault in caught.value.faults] == [
        "a.st:1:16", "b.st:1:8", "b.st:2:8", "c.TcPOU:1:4",
    ]  # fmt: skip


def test_faults_name_file_line_and_column(folder: Path) -> None:
    (folder / "GVLs/GVL.TcGVL").write_text(LIST.replace("ST_X", "ST_Y"))
    with pytest.raises(SourceError) as caught:
        load_project(folder, check_all=True)
    assert str(caught.value) == (
        "GVLs/GVL.TcGVL:2:9: no type is named 'ST_Y'\n        x : ST_Y;\n            ^"
        f"\n{caught.value.hint}"
    )


@pytest.mark.parametrize(
    ("files", "path", "message"),
    [
        ({}, "", "expected files like .st, .tcpou"),
        ({}, "nowhere", "expected a folder of PLC sources or a source file"),
        ({"x.txt": ""}, "x.txt", "expected a file like .st, .tcpou"),
        ({"a.plcproj": "<a/>"}, "", "expected <Compile Include=…> of at least one source"),
        ({"a.plcproj": "<a>"}, "", "no well-formed XML"),
        ({"a.plcproj": "<a/>", "b.plcproj": "<a/>"}, "", "several projects: name one of a.plcproj"),
        ({"a.plcproj": '<a><Compile Include="x.st"/></a>'}, "", "cannot be read: No such file"),
        ({"a.tctto": "<a/>"}, "", "expected <Task> in <a>"),
    ],
)
def test_what_is_no_project(tmp_path: Path, files: dict[str, str], path: str, message: str) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(SourceError) as caught:
        load_project(tmp_path / path)
    assert message in caught.value.faults[0].message


def test_one_file(folder: Path) -> None:
    parsed = parse_file(folder / "DUTs/ST_X.TcDUT")
    assert [unit.name for unit in parsed.units] == ["ST_X"]
    with pytest.raises(SourceError, match="cannot be read"):
        parse_file(folder / "DUTs")


LIBRARY = """<TcModuleClass><DataTypes>
<DataType><Name Namespace="Lib">E_Lib</Name><BitSize>16</BitSize><BaseType>INT</BaseType>
 <EnumInfo><Text>Off</Text><Enum>0</Enum></EnumInfo>
 <EnumInfo><Text>Slow</Text><Enum>3</Enum></EnumInfo></DataType>
<DataType><Name Namespace="Lib">ST_Lib</Name><BitSize>64</BitSize>
 <SubItem><Name>n</Name><Type>INT</Type><BitSize>16</BitSize><BitOffs>32</BitOffs>
  <Default><Value>5</Value></Default></SubItem></DataType>
<DataType><Name Namespace="Lib">FB_Lib</Name><BitSize>192</BitSize>
 <SubItem><Name>nState</Name><Type>DINT</Type><BitSize>32</BitSize><BitOffs>64</BitOffs></SubItem>
 <Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType>
<DataType><Name>ST_Own</Name><BitSize>8</BitSize><BaseType>BYTE</BaseType></DataType>
</DataTypes>
<Modules><Module TargetPlatform="TwinCAT RT (x64)"><Name>Old</Name></Module></Modules>
</TcModuleClass>"""
USER = """TYPE ST_Own : STRUCT a, b : LREAL; END_STRUCT END_TYPE
FUNCTION_BLOCK FB_User EXTENDS Lib.FB_Lib
VAR n : INT := nState; END_VAR
END_FUNCTION_BLOCK
PROGRAM P
VAR
    st : ST_Lib := (n := Slow);
    e : Lib.E_Lib := E_Lib.Slow;
    f : Lib.E_Lib := Lib.E_Lib.Slow;
    own : ST_Own;
    fb : FB_User;
END_VAR
END_PROGRAM
"""


def test_types_that_nothing_declares_come_from_the_symbol_file_beside(tmp_path: Path) -> None:
    (tmp_path / "P.st").write_text(USER)
    (tmp_path / "Old.TMC").write_text(LIBRARY)
    program = load_project(tmp_path).declarations.programs["p"].__iec__
    members = {item.name: item for item in program.members}
    assert [(m.name, m.type.name, m.type.size) for m in program.members] == [
        ("st", "Lib.ST_Lib", 8),
        ("e", "Lib.E_Lib", 2),
        ("f", "Lib.E_Lib", 2),
        ("own", "ST_Own", 16),  # What the sources declare is theirs.
        ("fb", "FB_User", 32),
    ]
    assert members["st"].initial_bytes() == b"\0\0\0\0\3\0\0\0"
    assert members["e"].initial_bytes() == members["f"].initial_bytes() == b"\3\0"
    assert members["fb"].type.member("n").offset == 24  # type: ignore[attr-defined]


def test_a_symbol_file_is_named_among_the_libraries_or_bears_the_name(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a/P.st").write_text("PROGRAM P VAR x : ST_Lib; END_VAR END_PROGRAM")
    (tmp_path / "b.tmc").write_text(LIBRARY)
    declarations = load_project(tmp_path / "a", libraries=[tmp_path / "b.tmc"]).declarations
    assert declarations.programs["p"].__iec__.size == 8
    (tmp_path / "a/other.tmc").write_text(LIBRARY)
    with pytest.raises(SourceError, match="no type is named 'ST_Lib'"):
        load_project(tmp_path / "a/P.st")
    (tmp_path / "a/p.tmc").write_text(LIBRARY)
    assert load_project(tmp_path / "a/P.st").declarations.programs["p"].__iec__.size == 8
    (tmp_path / "a/P.plcproj").write_text('<a><Compile Include="P.st"/></a>')
    assert load_project(tmp_path).declarations.programs["p"].__iec__.size == 8


def test_types_of_a_library_come_from_the_symbol_file_beside_it(tmp_path: Path) -> None:
    for name, text in (
        ("lib/L.plcproj", '<a><Title>L</Title><Compile Include="F.st"/></a>'),
        ("lib/F.st", "TYPE ST_More EXTENDS ST_Lib : STRUCT m : LINT; END_STRUCT END_TYPE"),
        ("lib/L.tmc", LIBRARY),
        ("a/P.plcproj", '<a><PlaceholderReference Include="L"/><Compile Include="P.st"/></a>'),
        ("a/P.st", "PROGRAM P VAR x : ST_More; END_VAR END_PROGRAM"),
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    declarations = load_project(tmp_path / "a", libraries=[tmp_path]).declarations
    assert declarations.programs["p"].__iec__.size == 16


def test_a_type_in_neither_is_reported_with_both(tmp_path: Path) -> None:
    (tmp_path / "P.st").write_text("PROGRAM P VAR x : ST_Nowhere; END_VAR END_PROGRAM")
    (tmp_path / "Old.tmc").write_text(LIBRARY)
    with pytest.raises(SourceError) as caught:
        load_project(tmp_path)
    message = r"no type is named 'ST_Nowhere', in the sources or in Old.tmc"
    assert caught.value.faults[0].message == message
    assert "P.st:1:19" in str(caught.value)


def test_the_symbol_file_has_the_platform(tmp_path: Path) -> None:
    (tmp_path / "P.st").write_text("PROGRAM P VAR x : POINTER TO INT; END_VAR END_PROGRAM")
    assert load_project(tmp_path).rules.pointer_size == 8
    (tmp_path / "P.tmc").write_text(LIBRARY.replace("x64", "x86"))
    project = load_project(tmp_path)
    assert project.rules.pointer_size == 4
    assert project.declarations.programs["p"].__iec__.size == 4


def test_a_fault_in_the_symbol_file_is_reported_in_its_place(tmp_path: Path) -> None:
    (tmp_path / "P.st").write_text("PROGRAM P VAR x : ST_Lib; END_VAR END_PROGRAM")
    (tmp_path / "P.tmc").write_text(LIBRARY.replace(">32</BitOffs>", ">320</BitOffs>"))
    with pytest.raises(SourceError, match=r"P\.tmc:6:2: member 'n' ends at 42 of 8 bytes"):
        load_project(tmp_path)


def test_capitals_of_file_names_do_not_count_in_a_project(folder: Path) -> None:
    (folder / "Plc.plcproj").write_text(PROJECT.replace("DUTs", "duts").replace("GVL.Tc", "gvl.TC"))
    assert len(load_project(folder).sources) == 3


LISTS = """<TcModuleClass><DataTypes>
<DataType><Name Namespace="Lib">I_Mode</Name><BitSize>64</BitSize>
 <Method><Name>__setEnableMode</Name></Method></DataType>
<DataType><Name Namespace="Lib">FB_Stage</Name><BitSize>128</BitSize>
 <SubItem><Name>nId</Name><Type>INT</Type><BitSize>16</BitSize><BitOffs>64</BitOffs>
  <Default><Value>3</Value></Default></SubItem>
 <Method><Name>__getEnableMode</Name></Method><Method><Name>__setEnableMode</Name></Method>
 <Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType>
<DataType><Name Namespace="Lib">FB_Axis</Name><BitSize>128</BitSize>
 <ExtendsType Namespace="Lib">FB_Stage</ExtendsType>
 <Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType></DataTypes>
<Modules><Module TargetPlatform="TwinCAT RT (x64)"><Name>P</Name><DataAreas><DataArea>
<AreaNo AreaType="Internal">3</AreaNo>
<Symbol><Name>Limits.MAX_STATES</Name><BitSize>16</BitSize><BaseType>UINT</BaseType>
 <Default><Value>6</Value></Default>
 <Properties><Property><Name>TcVarGlobal</Name></Property></Properties>
 <BitOffs>0</BitOffs></Symbol>
<Symbol><Name>Limits.sHost</Name><BitSize>64</BitSize><BaseType>STRING(7)</BaseType>
 <Default><String>plant</String></Default>
 <Properties><Property><Name>TcVarGlobal</Name></Property></Properties>
 <BitOffs>16</BitOffs></Symbol>
<Symbol><Name>MAIN.nOwn</Name><BitSize>16</BitSize><BaseType>INT</BaseType>
 <Default><Value>9</Value></Default><BitOffs>128</BitOffs></Symbol>
</DataArea></DataAreas></Module></Modules></TcModuleClass>"""

OF_LISTS = """PROGRAM P
VAR
    a : ARRAY [1..Limits.MAX_STATES] OF INT;
    b : ARRAY [0..Lib.limits.max_states] OF BYTE;
    s : STRING(10) := Limits.sHost;
    fbA : FB_Stage := (EnableMode := 2, nId := 4);
    fbB : FB_Axis := (EnableMode := 2);
    n : INT;
END_VAR
n := Limits.MAX_STATES + 1;
END_PROGRAM
"""


def test_values_of_lists_and_properties_of_blocks_that_only_the_symbol_file_has(
    tmp_path: Path,
) -> None:
    (tmp_path / "P.st").write_text(OF_LISTS)
    (tmp_path / "old.tmc").write_text(LISTS)
    declarations = load_project(tmp_path).declarations
    members = {item.name: item for item in declarations.programs["p"].__iec__.members}
    assert (members["a"].type.count, members["b"].type.count) == (6, 7)  # type: ignore[attr-defined]
    assert members["s"].initial == "plant"
    assert members["fbA"].initial == {"nId": 4}
    bodies = Bodies(check(declarations))
    plc = PlcRuntime([Task("T", 1_000_000, list(declarations.programs.values()))], bodies=bodies)
    plc.run_due(1_000_000)
    assert plc.failure == ""
    assert plc.instance("P")["n"] == 7


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Limits.sHost", "Limits.nNo", "no constant or variable is named 'Limits.nNo'"),
        ("Limits.sHost", "MAIN.nOwn", "no constant or variable is named 'MAIN.nOwn'"),
        ("EnableMode := 2, nId", "NoMode := 2, nId", "Lib.FB_Stage has no member 'NoMode'"),
    ],
)
def test_what_the_symbol_file_has_not_either(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    (tmp_path / "P.st").write_text(OF_LISTS.replace(old, new))
    (tmp_path / "old.tmc").write_text(LISTS)
    with pytest.raises(SourceError, match=message):
        load_project(tmp_path)


def test_properties_of_a_variable_list(tmp_path: Path) -> None:
    def accessor(kind: str, code: str) -> str:
        code = f"<Implementation><ST><![CDATA[{code}]]></ST></Implementation>"
        return f'<{kind} Name="{kind}"><Declaration><![CDATA[]]></Declaration>{code}</{kind}>'

    def listed(name: str, declaration: str, *properties: tuple[str, str]) -> None:
        inside = "".join(
            f'<Property Name="P"><Declaration><![CDATA[PROPERTY {head}]]></Declaration>'
            f"{accessors}</Property>"
            for head, accessors in properties
        )
        (tmp_path / f"{name}.TcGVL").write_text(
            f'<TcPlcObject><GVL Name="{name}"><Declaration><![CDATA[{declaration}]]>'
            f"</Declaration>{inside}</GVL></TcPlcObject>"
        )

    listed(
        "GVL_A",
        "{attribute 'qualified_only'}\nVAR_GLOBAL n : INT := 3; t : ST_X; END_VAR",
        ("PUBLIC Twice : INT", accessor("Get", "Twice := 2 * n;")
         + accessor("Set", "GVL_A.n := Twice / 2;")),
        ("Place : REFERENCE TO ST_X", accessor("Get", "Place REF= GVL_A.t;")),
    )  # fmt: skip
    listed("GVL_B", "", ("Calm : INT", accessor("Get", "Calm := 40;")))
    (tmp_path / "ST_X.TcDUT").write_text(TYPE)
    (tmp_path / "MAIN.st").write_text(
        "PROGRAM MAIN VAR a, b, c, d : INT; e : INT := GVL_A.Twice; f : INT := Calm; END_VAR"
        " a := GVL_A.Twice; GVL_A.Twice := 20;"
        " b := GVL_A.n; GVL_A.Place.a := 8; c := GVL_A.t.a; d := Calm + GVL_B.Calm; END_PROGRAM"
    )
    project = load_project(tmp_path)
    typed = check(project.declarations)
    assert not typed.faults
    programs = list(project.declarations.programs.values())
    plc = PlcRuntime(
        [Task("T", 1_000_000, programs)], project.declarations.units, bodies=Bodies(typed)
    )
    plc.run_due(1_000_000)
    assert plc.failure == ""
    main = plc.instance("MAIN")
    assert [main[name] for name in "abcdef"] == [6, 10, 8, 80, 6, 40]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("GVL.Left := 3;", "cannot be written"),
        ("n := GVL.Right;", "cannot be read"),
        ("n := Left;", "which one is meant"),
        ("n := GVL.Hidden;", "PRIVATE"),
        ("n := GVL.Nothing;", "GVL has no variable 'Nothing'"),
    ],
)
def test_properties_of_lists_that_cannot_be_used(tmp_path: Path, body: str, message: str) -> None:
    get = '<Get Name="Get"><Implementation><ST><![CDATA[Left := 1;]]></ST></Implementation></Get>'
    left = f"<Property><Declaration>PROPERTY Left : INT</Declaration>{get}</Property>"
    right = (
        "<Property><Declaration>PROPERTY Right : INT</Declaration>"
        '<Set Name="Set"><Declaration/></Set></Property>'
        f"<Property><Declaration>PROPERTY PRIVATE Hidden : INT</Declaration>"
        f"{get.replace('Left', 'Hidden')}</Property>"
    )
    for name, inside in (("GVL", left + right), ("Other", left)):
        (tmp_path / f"{name}.TcGVL").write_text(
            f'<TcPlcObject><GVL Name="{name}"><Declaration>VAR_GLOBAL {name}1 : INT; END_VAR'
            f"</Declaration>{inside}</GVL></TcPlcObject>"
        )
    (tmp_path / "MAIN.st").write_text(f"PROGRAM MAIN VAR n : INT; END_VAR {body} END_PROGRAM")
    faults = check(load_project(tmp_path).declarations).faults
    assert [message in fault.message for fault in faults] == [True], faults
