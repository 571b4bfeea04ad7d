"""Folders of sources."""

from pathlib import Path

import pytest

from achse.iec.project import load_project, parse_file, source_files
from achse.iec.st.source import SourceError

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
    ((name, cycle_ns, priority, programs),) = project.tasks
    assert (name, cycle_ns, priority, programs) == ("PlcTask", 2_000_000, 5, ("MAIN",))
    assert len(project.sources) == 3


def test_a_project_file_says_what_counts(folder: Path) -> None:
    (folder / "Old.TcPOU").write_text("nonsense")
    with pytest.raises(SourceError, match=r"Old\.TcPOU:1:"):
        load_project(folder)
    (folder / "Plc.plcproj").write_text(PROJECT)
    for path in (folder, folder / "Plc.plcproj"):
        assert len(load_project(path).sources) == 3
    names = [name for _, name in source_files(folder)]
    assert names == ["DUTs/ST_X.TcDUT", "GVLs/GVL.TcGVL", "POUs/MAIN .TcPOU"]


def test_structured_text_files(tmp_path: Path) -> None:
    (tmp_path / "Globals.st").write_bytes(
        b"VAR_GLOBAL s : STRING := '\xe4'; END_VAR\r\nPROGRAM P END_PROGRAM"
    )
    (tmp_path / "types.ST").write_text("TYPE T : STRING := 'ä'; END_TYPE", "utf-8-sig")
    (tmp_path / "wide.st").write_text("TYPE W : STRING := 'ä'; END_TYPE", "utf-16")
    found = load_project(tmp_path).declarations
    assert "w" in found.types
    assert found.globals["globals"].__iec__.members[0].initial == "ä"
    assert found.types["t"].default[:2] == b"\xe4\0"
    alone = load_project(tmp_path / "Globals.st").declarations
    assert list(alone.programs) == ["p"]


def test_libraries(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    user = tmp_path_factory.mktemp("user")
    (user / "P.st").write_text("PROGRAM P VAR x : Lib.ST_X; END_VAR END_PROGRAM")
    found = load_project(user, libraries=[folder]).declarations
    assert [unit.__iec__.name for unit in found.units] == ["P"]
    assert found.programs["p"].__iec__.size == 2


def test_all_faults_of_all_files_are_told(folder: Path) -> None:
    (folder / "a.st").write_text("PROGRAM a x := ; END_PROGRAM")
    (folder / "b.st").write_text("TYPE T INT; END_TYPE\nTYPE U INT; END_TYPE")
    (folder / "c.TcPOU").write_text("<a>")
    with pytest.raises(SourceError) as caught:
        load_project(folder)
    assert [str(fault.location) for fault in caught.value.faults] == [
        "a.st:1:16", "b.st:1:8", "b.st:2:8", "c.TcPOU:1:4",
    ]  # fmt: skip


def test_faults_name_file_line_and_column(folder: Path) -> None:
    (folder / "GVLs/GVL.TcGVL").write_text(LIST.replace("ST_X", "ST_Y"))
    with pytest.raises(SourceError) as caught:
        load_project(folder)
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
