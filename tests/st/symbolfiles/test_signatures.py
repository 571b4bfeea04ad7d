"""Stubs of blocks and interfaces whose bases, methods and properties a `.tmc` has."""

from pathlib import Path

import pytest

from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcRuntime
from achse.plc.system_info import system_info_list
from achse.plc.task import Task
from achse.st.check import check
from achse.st.project import load_project

FILE = """<TcModuleClass><DataTypes>
<DataType><Name Namespace="Lib">I_Lamp</Name><BitSize>64</BitSize>
<ExtendsType GUID="{18071995-0000-0000-0000-000000000018}">PVOID</ExtendsType>
<Method><Name>Blink</Name><ReturnType>DINT</ReturnType><ReturnBitSize>32</ReturnBitSize>
<Parameter><Name>nTimes</Name><Type>UINT</Type><BitSize>16</BitSize></Parameter></Method></DataType>
<DataType><Name Namespace="Lib">ST_Colour</Name><BitSize>32</BitSize>
<SubItem><Name>nRed</Name><Type>DINT</Type><BitSize>32</BitSize><BitOffs>0</BitOffs></SubItem>
</DataType>
<DataType><Name Namespace="Lib">FB_Base</Name><BitSize>128</BitSize>
<Implements Namespace="Lib">I_Lamp</Implements>
<SubItem><Name>nCount</Name><Type>DINT</Type><BitSize>32</BitSize><BitOffs>64</BitOffs>
<Properties><Property><Name>ItemType</Name><Value>Output</Value></Property></Properties></SubItem>
<Method><Name>Blink</Name><ReturnType>DINT</ReturnType><ReturnBitSize>32</ReturnBitSize>
<Parameter><Name>nTimes</Name><Type>UINT</Type><BitSize>16</BitSize></Parameter></Method>
<Method><Name>Paint</Name>
<Parameter><Name>stColour</Name><Type Namespace="Lib">ST_Colour</Type><BitSize>32</BitSize>
</Parameter></Method>
<Method><Name>Sum</Name><ReturnType>LREAL</ReturnType><ReturnBitSize>64</ReturnBitSize>
<Parameter><Name>aValues</Name><Type PointerTo="1">LREAL</Type><BitSize>64</BitSize><Properties>
<Property><Name>variable_length_array</Name></Property>
<Property><Name>Dimensions</Name><Value>1</Value></Property></Properties></Parameter></Method>
<Method><Name>__getsName</Name><ReturnType>STRING(20)</ReturnType><ReturnBitSize>168</ReturnBitSize>
</Method>
<Method><Name>Strange</Name><Parameter><Name>x</Name><Type>ST_Nowhere</Type><BitSize>8</BitSize>
</Parameter></Method>
<Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType>
<DataType><Name Namespace="Lib">FB_Lamp</Name><BitSize>192</BitSize>
<ExtendsType Namespace="Lib">FB_Base</ExtendsType>
<SubItem><Name>bOn</Name><Type>BOOL</Type><BitSize>8</BitSize><BitOffs>128</BitOffs>
<Properties><Property><Name>ItemType</Name><Value>Input</Value></Property></Properties></SubItem>
<Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType></DataTypes><Modules><Module/></Modules></TcModuleClass>"""

OWN = """FUNCTION_BLOCK FB_Own EXTENDS FB_Lamp
VAR nSeen : DINT; END_VAR
nSeen := nCount;
METHOD Blink : DINT
VAR_INPUT nTimes : UINT; END_VAR
Blink := 100 + nTimes;
END_METHOD
METHOD Ask : DINT
VAR iSelf : I_Lamp; END_VAR
iSelf := THIS^; Ask := iSelf.Blink(SUPER^.Blink(7) + 1);
END_METHOD
END_FUNCTION_BLOCK
"""


def _run(folder: Path, text: str, types: str = FILE) -> PlcRuntime:
    (folder / "a.tmc").write_text(types)
    (folder / "a.st").write_text(text)
    (folder / "a.plcproj").write_text(
        '<P><Compile Include="a.st"/><LibraryReference Include="Lib,*,v"/></P>'
    )
    declared = load_project(folder).declarations
    lists = [system_info_list([Task("T")], app_name="", project_name="", port=851, timestamp=0)]
    typed = check(declared, predefined=lists)
    assert typed.faults == ()
    task = Task("T", 10_000_000, [declared.programs["p"]])
    plc = PlcRuntime([task], declared.units, bodies=Bodies(typed, form=CodeForm.PLAIN))
    plc.run_due(10_000_000)
    assert plc.failure == ""
    return plc


@pytest.mark.parametrize(
    "uses",
    [
        "VAR a : FB_Lamp; i : Lib.I_Lamp; n : DINT; END_VAR i := a; n := i.Blink(3);",
        "VAR a : FB_Lamp; i : ARRAY [1..2] OF I_Lamp; END_VAR i[2] := a; i[2].Blink(nTimes := 3);",
        "VAR a : Lib.FB_Lamp; END_VAR a.Paint(stColour := GVL_Lib.stWhite);",
        "VAR a : FB_Lamp; b : REFERENCE TO FB_Base; END_VAR b REF= a; b.Blink(1);",
        "VAR a : FB_Lamp; s : STRING; l : LREAL; x : ARRAY [1..5] OF LREAL; END_VAR"
        " s := a.sName; l := a.Sum(x);",
        "VAR a : FB_Own; n : DINT; END_VAR n := a.Ask(); a();",
    ],
)
def test_block_of_a_symbol_file_has_its_bases_and_parts(tmp_path: Path, uses: str) -> None:
    _run(tmp_path, f"PROGRAM P {uses} END_PROGRAM {OWN}")


def test_override_of_a_stub_is_reached_by_its_interface(tmp_path: Path) -> None:
    uses = "VAR a : FB_Own; i : I_Lamp; n, m : DINT; END_VAR i := a; n := i.Blink(5); m := a.Ask();"
    assert _run(tmp_path, f"PROGRAM P {uses} END_PROGRAM {OWN}").instance("P")["n"] == 105


def test_methods_with_types_that_no_one_has_are_left_out(tmp_path: Path) -> None:
    _run(tmp_path, f"PROGRAM P VAR a : FB_Own; END_VAR END_PROGRAM {OWN}")
    text = load_project(tmp_path).stubs["types.st"]
    assert "METHOD Paint" in text
    assert "Strange" not in text


OLD_AXES = """<TcModuleClass><DataTypes>
<DataType><Name Namespace="Tc2_MC2">AXIS_REF</Name><BitSize>128</BitSize>
<SubItem><Name>n</Name><Type>DINT</Type><BitSize>32</BitSize><BitOffs>64</BitOffs></SubItem>
<Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType>
<DataType><Name Namespace="Lib">ST_Stage</Name><BitSize>192</BitSize>
<SubItem><Name>Axis</Name><Type Namespace="Tc2_MC2">AXIS_REF</Type><BitSize>128</BitSize>
<BitOffs>0</BitOffs></SubItem>
<SubItem><Name>fSpeed</Name><Type>LREAL</Type><BitSize>64</BitSize><BitOffs>128</BitOffs>
<Default><Value>2.5</Value></Default></SubItem></DataType>
</DataTypes><Modules><Module/></Modules></TcModuleClass>"""


def test_structure_with_a_type_of_an_older_library_is_declared_again(tmp_path: Path) -> None:
    own = """PROGRAM P VAR a : ST_Stage; fb : FB_Take; f : LREAL; END_VAR
    fb(Axis := a.Axis); f := a.fSpeed; END_PROGRAM
    FUNCTION_BLOCK FB_Take VAR_IN_OUT Axis : AXIS_REF; END_VAR END_FUNCTION_BLOCK"""
    plc = _run(tmp_path, own, OLD_AXES)
    assert plc.instance("P")["f"] == 2.5
