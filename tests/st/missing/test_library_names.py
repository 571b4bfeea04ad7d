"""Stubs of libraries that a project references and that are not here."""

from pathlib import Path

import pytest

from achse.plc import PlcRuntime, Task
from achse.st.check import check
from achse.st.project import Project, examine_project, load_project

BLOCK = """<TcModuleClass><DataTypes>
<DataType><Name Namespace="Lib">FB_Lamp</Name><BitSize>192</BitSize>
<SubItem><Name>bOn</Name><Type>BOOL</Type><BitSize>8</BitSize><BitOffs>64</BitOffs>
<Properties><Property><Name>ItemType</Name><Value>Input</Value></Property></Properties></SubItem>
<SubItem><Name>nCount</Name><Type>DINT</Type><BitSize>32</BitSize><BitOffs>96</BitOffs>
<Properties><Property><Name>ItemType</Name><Value>Output</Value></Property></Properties></SubItem>
<Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType></DataTypes><Modules><Module/></Modules></TcModuleClass>"""


OWN = """
VAR_GLOBAL CONSTANT nMost : INT := 4; END_VAR
FUNCTION_BLOCK ListForward END_FUNCTION_BLOCK
INTERFACE I_Own EXTENDS I_Any END_INTERFACE
FUNCTION_BLOCK FB_Own EXTENDS FB_Base IMPLEMENTS I_Own
VAR pData : POINTER TO BYTE; END_VAR
METHOD Grow pData := __NEW(BYTE, 8); fbChild(fbParent := THIS^); SUPER^.Run(0, FALSE); END_METHOD
METHOD Run VAR_INPUT nSpeed : INT; bFast : BOOL; END_VAR END_METHOD
END_FUNCTION_BLOCK
"""


def _examined(folder: Path, text: str, library: str = "Lib") -> tuple[Project, list[str]]:
    (folder / "a.st").write_text(text)
    (folder / "a.plcproj").write_text(
        f'<P><Compile Include="a.st"/><LibraryReference Include="{library},*,v"/></P>'
    )
    project, error = examine_project(folder)
    return project, [] if error is None else [fault.message for fault in error.faults]


@pytest.mark.parametrize(
    "uses",
    [
        "VAR a : FB_Any; END_VAR a(bExecute := TRUE); a.Stop(3);",
        "VAR a : Lib.FB_Any; END_VAR a.sName := 'x';",
        "VAR a : DINT; END_VAR a := F_Sum(1, 2) + Lib.F_Other();",
        "VAR a : E_Any := E_Any.Auto; END_VAR",
        "VAR a : FB_Any(3); b : I_Any; END_VAR b.Run();",
        "VAR a : FB_Any; b : BOOL; END_VAR b := a.Read(nNumber := 3).bDone;",
        "VAR a : FB_Own(3, 'x'); END_VAR",
        "VAR a : ARRAY [1..3] OF INT; b : ARRAY [0..nMost] OF INT; END_VAR F_Sum(a); F_Sum(b);",
        "VAR a : FB_Own := (sName := 'x'); END_VAR a.Run(3, TRUE);",
        "VAR a : I_Any; b : FB_Own; END_VAR b.Grow(); a := b; a.Run(nSpeed := 1, bFast := TRUE);",
        "VAR a : FB_Any; b : FB_Own; END_VAR a(fbOwner := b);",
        "VAR i : I_Forward; END_VAR i.Step();",
    ],
)
def test_names_of_a_missing_library_get_stubs(tmp_path: Path, uses: str) -> None:
    project, faults = _examined(tmp_path, f"PROGRAM P {uses} END_PROGRAM {OWN}")
    assert faults == []
    assert project.stubs
    assert check(project.declarations).faults == ()


def test_names_of_a_known_library_are_known_by_their_form(tmp_path: Path) -> None:
    text = "PROGRAM P VAR a : FB_VN_Image; b : FB_Other; END_VAR END_PROGRAM"
    project, faults = _examined(tmp_path, text, "Tc3_Vision")
    assert faults == ["no type is named 'FB_Other'"]
    assert "FB_VN_Image" in project.stubs["types.st"]


def test_misspelled_name_of_an_own_type_stays_a_fault(tmp_path: Path) -> None:
    text = "TYPE ST_Position : STRUCT x : REAL; END_STRUCT END_TYPE\n"
    text += "PROGRAM P VAR a : ST_Positoin; END_VAR END_PROGRAM"
    project, faults = _examined(tmp_path, text)
    assert faults == ["no type is named 'ST_Positoin'; near: ST_Position"]
    assert project.stubs == {}


def test_instance_that_is_not_declared_stays_a_fault(tmp_path: Path) -> None:
    project, faults = _examined(tmp_path, "PROGRAM P fbMove.Execute := TRUE; END_PROGRAM")
    assert project.stubs == {}
    assert faults == []  # the check of bodies finds it


def test_nothing_is_made_up_if_no_library_is_missing(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text("PROGRAM P VAR a : FB_Any; END_VAR END_PROGRAM")
    _, error = examine_project(tmp_path)
    assert error is not None


def test_block_of_a_symbol_file_gets_the_methods_that_are_called(tmp_path: Path) -> None:
    (tmp_path / "a.tmc").write_text(BLOCK)
    text = "PROGRAM P VAR a : FB_Lamp; n : DINT; END_VAR"
    text += " a(bOn := TRUE, nCount => n); a.Blink(3);"
    text += " n := a.nHours; END_PROGRAM"
    _, faults = _examined(tmp_path, text)
    assert faults == []
    lines = load_project(tmp_path).stubs["types.st"].splitlines()
    assert [line.strip() for line in lines[:12]] == [
        "FUNCTION_BLOCK FB_Lamp",
        "VAR_INPUT",
        "bOn : BOOL;",
        "END_VAR",
        "VAR_OUTPUT",
        "nCount : DINT;",
        "END_VAR",
        "PROPERTY nHours : DINT",
        "GET END_GET",
        "END_PROPERTY",
        "METHOD Blink : BOOL",
        "VAR_INPUT",
    ]


def test_call_of_a_block_inside_a_type_of_a_symbol_file_does_nothing(tmp_path: Path) -> None:
    outer = """<DataType><Name Namespace="Lib">ST_Outer</Name><BitSize>192</BitSize><SubItem>
<Name>fbLamp</Name><Type Namespace="Lib">FB_Lamp</Type><BitSize>192</BitSize><BitOffs>0</BitOffs>
</SubItem></DataType></DataTypes>"""
    (tmp_path / "a.tmc").write_text(BLOCK.replace("</DataTypes>", outer))
    (tmp_path / "a.st").write_text(
        "PROGRAM P VAR s : ST_Outer; n : DINT; END_VAR"
        " s.fbLamp(bOn := TRUE, nCount => n); n := n + 5; END_PROGRAM"
    )
    project = load_project(tmp_path)
    typed = check(project.declarations)
    assert typed.inert == {"lib.fb_lamp"}
    assert [warning.message for warning in typed.warnings] == [
        "no source of Lib.FB_Lamp is here: its calls do nothing"
    ]
    plc = PlcRuntime([Task()], project.declarations.units)
    plc.instance("P")
    assert plc.failure == ""
    refused = check(load_project(tmp_path, unknown="refuse").declarations)
    assert refused.left_out == {"lib.fb_lamp": "no source of Lib.FB_Lamp is here"}


def test_interface_of_a_symbol_file_has_its_methods_if_no_library_is_missing(
    tmp_path: Path,
) -> None:
    (tmp_path / "a.tmc").write_text(
        """<TcModuleClass><DataTypes><DataType>
<Name GUID="{03010098-0000-0000-E000-000000000064}" TcBaseType="true">ITcThing</Name>
<BitSize X64="64">32</BitSize><BaseType>ITcUnknown</BaseType>
<Method><Name>Begin</Name><ReturnType>HRESULT</ReturnType><ReturnBitSize>32</ReturnBitSize>
<Parameter><Name>nPort</Name><Type>UDINT</Type><BitSize>32</BitSize></Parameter></Method>
</DataType></DataTypes><Modules><Module/></Modules></TcModuleClass>"""
    )
    (tmp_path / "a.st").write_text(
        "PROGRAM P VAR ip : ITcThing; hr : HRESULT; END_VAR hr := ip.Begin(nPort := 3); END_PROGRAM"
    )
    project, error = examine_project(tmp_path)
    assert error is None
    assert check(project.declarations).faults == ()
    assert "METHOD Begin : HRESULT" in project.stubs["types.st"]


def test_block_inside_a_block_of_a_symbol_file_gets_its_methods(tmp_path: Path) -> None:
    outer = """<DataType><Name Namespace="Lib">FB_Outer</Name><BitSize>256</BitSize><SubItem>
<Name>fbLamp</Name><Type Namespace="Lib">FB_Lamp</Type><BitSize>192</BitSize><BitOffs>64</BitOffs>
<Properties><Property><Name>ItemType</Name><Value>Output</Value></Property></Properties></SubItem>
<Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType></DataTypes>"""
    (tmp_path / "a.tmc").write_text(BLOCK.replace("</DataTypes>", outer))
    text = "PROGRAM P VAR a : FB_Outer; b : BOOL; END_VAR a.fbLamp.Blink(3); b := a.fbLamp.bOn;"
    project, faults = _examined(tmp_path, f"{text} END_PROGRAM")
    assert faults == []
    assert check(project.declarations).faults == ()


def test_part_of_a_missing_variable_has_the_structure_of_a_symbol_file(tmp_path: Path) -> None:
    """That it goes into, though members of it are used, too."""
    outer = """<DataType><Name Namespace="Lib">ST_Mask</Name><BitSize>32</BitSize><SubItem>
<Name>err</Name><Type>UDINT</Type><BitSize>32</BitSize><BitOffs>0</BitOffs></SubItem></DataType>
</DataTypes>"""
    (tmp_path / "a.tmc").write_text(BLOCK.replace("</DataTypes>", outer))
    mask = "gpChannel.stState.stMask"
    text = f"PROGRAM P VAR own : ST_Mask; n : UDINT; END_VAR own := {mask}; n := {mask}.err;"
    project, faults = _examined(tmp_path, f"{text} END_PROGRAM")
    assert faults == []
    assert check(project.declarations).faults == ()


def test_functions_of_the_runtime_are_not_made_up(tmp_path: Path) -> None:
    text = """PROGRAM P VAR a : FB_Any; b : BOOL; hr : HRESULT; n : DINT; END_VAR
a(bExecute := SUCCEEDED(hr)); b := FAILED(hr); n := GETCURTASKINDEXEX();
IF b THEN F_RaiseException(3); END_IF END_PROGRAM"""
    project, faults = _examined(tmp_path, text)
    assert faults == []
    assert check(project.declarations).faults == ()
    assert "FUNCTION " not in project.stubs["types.st"].replace("FUNCTION_BLOCK", "")


PROJECT = (
    '<P><Compile Include="a.st"/><LibraryReference Include="Tc2_Utilities,*,v"/>'
    '<LibraryReference Include="Tc3_EventLogger,*,v"/>'
    '<LibraryReference Include="VisuElemEventTable,*,v"/></P>'
)


@pytest.mark.parametrize(
    "uses",
    [
        "VAR a : FB_EnumScopeServers; END_VAR a(bExecute := TRUE);",
        "VAR a : Tc2_Utilities.T_OTHER; END_VAR a.nLow := 1;",
        "VAR a : ARRAY [1..9] OF ST_ReadEvent; s : STRING; END_VAR s := a[1].sText;",
        "VAR a : FB_ReadTc3Events; n : DINT; END_VAR a(); n := F_GetThing(3);",
        "VAR a : MDP5001_341_A3044239; n : INT; END_VAR n := a.Value;",
    ],
)
def test_names_that_a_library_of_ours_lacks_get_stubs(tmp_path: Path, uses: str) -> None:
    (tmp_path / "a.st").write_text(f"PROGRAM P {uses} END_PROGRAM")
    (tmp_path / "a.plcproj").write_text(PROJECT)
    project = load_project(tmp_path)
    assert check(project.declarations).faults == ()
    assert project.stubs
    assert "lacks here what is needed by a.st" in str(project.missing[0])
    assert check(examine_project(tmp_path, unknown="refuse")[0].declarations).faults != () or (
        examine_project(tmp_path, unknown="refuse")[1] is not None
    )


@pytest.mark.parametrize(
    "name", ["FB_Mine", "FB_LocalSystmTime", "FB_CTRL_PTn"], ids=["own", "misspelt", "not-named"]
)
def test_other_names_are_faults_where_each_library_is_here(tmp_path: Path, name: str) -> None:
    (tmp_path / "a.st").write_text(f"PROGRAM P VAR a : {name}; END_VAR a(); END_PROGRAM")
    (tmp_path / "a.plcproj").write_text(PROJECT)
    project, error = examine_project(tmp_path)
    assert error is not None
    assert project.missing == ()
    assert project.stubs == {}
