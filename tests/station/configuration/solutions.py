"""A small solution on disk: a .sln, a .tsproj and a PLC project."""

from pathlib import Path

HEAD = "PROGRAM MAIN\nVAR\n    n : INT;\nEND_VAR\n"
MAIN = HEAD + "n := n + 1;\nEND_PROGRAM\n"
POU = f"""<TcPlcObject><POU Name="MAIN"><Declaration><![CDATA[{HEAD}]]></Declaration>
<Implementation><ST><![CDATA[n := n + 1;]]></ST></Implementation></POU></TcPlcObject>"""
PROJECT = """<Project xmlns="http://schemas.microsoft.com/developer/msbuild/2003"><ItemGroup>
<Compile Include="POUs\\MAIN.TcPOU"><SubType>Code</SubType></Compile></ItemGroup></Project>"""
AXIS = """<Axis Id="3" CreateSymbols="true" AxisType="1"><Name>X</Name>
<AxisPara><General UnitName="Degree"/><Dynamic Acceleration="300" Jerk="2000"/>
<Velo Maximum="200" SlowManual="30"/><PositionAreaControl Enable="false"/></AxisPara>
<Encoder Name="Enc" EncType="19"><EncPara ScaleFactorNumerator="5">
<SoftEndMinControl Enable="true" Range="-5"/></EncPara></Encoder></Axis>"""
SOLUTION = """<?xml version="1.0"?><TcSmProject><Project ProjectGUID="{1}"><System/>
<Plc><Project Name="Cell" PrjFilePath="Cell\\Cell.plcproj" AmsPort="853"/>
<Project Name="Old" PrjFilePath="Old\\Old.plcproj" AmsPort="851" Disabled="true"/></Plc>
<Motion><NC><SafTask Priority="4" CycleTime="10000" AmsPort="501"/>AXES</NC></Motion>
</Project></TcSmProject>"""
PLC = "<TcSmProject><Plc><Project PLC/></Plc></TcSmProject>"
NC = "<TcSmProject><Motion><NC/></Motion></TcSmProject>"
LIST = """Microsoft Visual Studio Solution File, Format Version 12.00
Project("{B1E792BE}") = "Cell", "Line\\Line.tsproj", "{1}"
EndProject
Project("{FAE04EC0}") = "Hmi", "Hmi\\Hmi.csproj", "{2}"
EndProject
"""


def solution(folder: Path, axes: str = AXIS) -> Path:
    """A folder with a .sln, a .tsproj and a PLC project of it."""
    (folder / "Line" / "Cell" / "POUs").mkdir(parents=True)
    (folder / "Line.sln").write_text(LIST)
    (folder / "Line" / "Line.tsproj").write_text(SOLUTION.replace("AXES", axes))
    (folder / "Line" / "Cell" / "Cell.plcproj").write_text(PROJECT)
    (folder / "Line" / "Cell" / "POUs" / "MAIN.TcPOU").write_text(POU)
    return folder
