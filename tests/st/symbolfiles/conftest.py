"""A small project as both kinds of symbol file."""

import pytest

TMC = """<?xml version="1.0"?>
<TcModuleClass GeneratedBy="TwinCAT XAE Plc">
<DataTypes>
<DataType><Name GUID="{5C8FF47F-7F83-4493-8D21-F1FF8A08F75A}" Namespace="PLC">Info</Name>
 <BitSize>64</BitSize>
 <SubItem><Name>ObjId</Name><Type GUID="{18071995-0000-0000-0000-00000000000F}">OTCID</Type>
  <BitSize>32</BitSize><BitOffs>0</BitOffs></SubItem>
 <SubItem><Name>bReady</Name><Type GUID="{18071995-0000-0000-0000-000000000010}">BIT</Type>
  <BitSize>1</BitSize><BitOffs>33</BitOffs></SubItem>
</DataType>
<DataType><Name>E_State</Name><Comment> what it does </Comment><BitSize>16</BitSize>
 <BaseType>UINT</BaseType>
 <EnumInfo><Text>Idle</Text><Enum>0</Enum></EnumInfo>
 <EnumInfo><Text>Busy</Text><Enum>#xA</Enum><Comment>works</Comment></EnumInfo>
</DataType>
<DataType><Name>UINT (2..GVL.MOST)</Name><BitSize>16</BitSize><BaseType>UINT</BaseType>
 <Properties><Property><Name>LowerBorder</Name><Value>2</Value></Property>
 <Property><Name>UpperBorder</Name><Value>100</Value></Property></Properties>
</DataType>
<DataType><Name Namespace="Lib">T_Text</Name><BitSize>128</BitSize><BaseType>STRING(15)</BaseType>
</DataType>
<DataType><Name>ST_Base</Name><BitSize>64</BitSize>
 <SubItem><Name>fPos</Name><Type>LREAL</Type><BitSize>64</BitSize><BitOffs>0</BitOffs>
  <Default><Value>1.5</Value></Default></SubItem>
</DataType>
<DataType><Name>ST_Axis</Name><BitSize>512</BitSize><ExtendsType>ST_Base</ExtendsType>
 <SubItem><Name>aGrid</Name><Type>INT</Type>
  <ArrayInfo Level="0"><LBound>1</LBound><Elements>2</Elements></ArrayInfo>
  <ArrayInfo Level="1"><LBound>-1</LBound><Elements>3</Elements></ArrayInfo>
  <BitSize>96</BitSize><BitOffs>64</BitOffs>
  <Default><SubItem><Name>[2][-1]</Name><Value>7</Value></SubItem></Default></SubItem>
 <SubItem><Name>eState</Name><Type>E_State</Type><BitSize>16</BitSize><BitOffs>160</BitOffs>
  <Default><EnumText>E_State.Busy</EnumText></Default></SubItem>
 <SubItem><Name>sName</Name><Type Namespace="Lib">T_Text</Type><Comment> its name</Comment>
  <BitSize>128</BitSize><BitOffs>176</BitOffs><Default><String>it$'s</String></Default></SubItem>
 <SubItem><Name>pNext</Name><Type PointerTo="1">ST_Axis</Type>
  <BitSize X64="64">32</BitSize><BitOffs>320</BitOffs></SubItem>
 <SubItem><Name>tWait</Name><Type>TIME</Type><BitSize>32</BitSize><BitOffs>384</BitOffs>
  <Default><DateTime>T#1m</DateTime></Default></SubItem>
</DataType>
<DataType><Name>FB_Motor</Name><BitSize>128</BitSize>
 <SubItem><Name>fSpeed</Name><Type>REAL</Type><BitSize>32</BitSize><BitOffs>64</BitOffs>
  <Properties><Property><Name>ItemType</Name><Value>Input</Value></Property>
  <Property><Name>unit</Name><Value>mm/s</Value></Property></Properties></SubItem>
 <SubItem><Name Static="true">nCount</Name><Type>DINT</Type><BitSize>32</BitSize></SubItem>
 <Method><Name RpcEnable="plc" VTableIndex="3">Start</Name>
  <ReturnType RpcDirection="out">BOOL</ReturnType><ReturnBitSize>8</ReturnBitSize>
  <Parameter><Name>fTarget</Name><Type RpcDirection="in">LREAL</Type><BitSize>64</BitSize>
  </Parameter>
  <Parameter><Name>stUsed</Name><Type RpcDirection="out" ReferenceTo="true">ST_Base</Type>
   <BitSize>64</BitSize></Parameter>
 </Method>
 <Method><Name>Inner</Name></Method>
 <Properties><Property><Name>PouType</Name><Value>FunctionBlock</Value></Property></Properties>
</DataType>
<DataType><Name>I_Motor</Name><BitSize X64="64">32</BitSize><Method><Name>Start</Name></Method>
</DataType>
</DataTypes>
<Modules><Module TargetPlatform="TwinCAT RT (x64)"><Name>Plant</Name>
<Contexts>
 <Context><Id>1</Id><Name>FastTask</Name>
  <ManualConfig><Priority>5</Priority><CycleTime>2000000</CycleTime></ManualConfig></Context>
 <Context><Id>0</Id><Name>SlowTask</Name></Context>
</Contexts>
<DataAreas>
<DataArea><AreaNo AreaType="InputDst">16</AreaNo><ContextId>0</ContextId>
 <Symbol><Name>MAIN.fbMotor.bRun</Name><BitSize>8</BitSize><BaseType>BOOL</BaseType>
  <BitOffs>8000</BitOffs></Symbol>
 <Symbol><Name>MAIN.bBit</Name><BitSize>1</BitSize><BaseType>BOOL</BaseType>
  <BitOffs>8011</BitOffs></Symbol>
</DataArea>
<DataArea><AreaNo AreaType="Internal">3</AreaNo><ContextId>1</ContextId>
 <Symbol><Name>GVL.aAxes</Name><Comment> both</Comment><BitSize>1024</BitSize>
  <BaseType>ST_Axis</BaseType>
  <ArrayInfo><LBound>0</LBound><Elements>2</Elements></ArrayInfo>
  <Default><SubItem><Name>[1].fPos</Name><Value>2.5</Value></SubItem>
   <SubItem><Name>[1].eState</Name><EnumText>GVL.nUnknown + 1</EnumText></SubItem></Default>
  <Properties><Property><Name>TcVarGlobal</Name></Property>
  <Property><Name>pytmc</Name><Value>pv: AXES</Value></Property></Properties>
  <BitOffs>4096</BitOffs></Symbol>
 <Symbol><Name>MAIN.fbMotor</Name><BitSize>128</BitSize><BaseType>FB_Motor</BaseType>
  <BitOffs>8192</BitOffs></Symbol>
 <Symbol><Name>MAIN.nLimited</Name><BitSize>16</BitSize><BaseType>UINT (2..GVL.MOST)</BaseType>
  <BitOffs>8320</BitOffs></Symbol>
 <Symbol><Name>MAIN.itf</Name><BitSize>64</BitSize><BaseType>I_Motor</BaseType>
  <BitOffs>8384</BitOffs></Symbol>
 <Symbol><Name>TwinCAT_SystemInfoVarList._AppInfo</Name><BitSize>64</BitSize>
  <BaseType GUID="{5C8FF47F-7F83-4493-8D21-F1FF8A08F75A}">Info</BaseType>
  <BitOffs>8448</BitOffs></Symbol>
</DataArea>
</DataAreas>
<Properties><Property><Name>ApplicationName</Name><Value>Port_853</Value></Property></Properties>
</Module></Modules></TcModuleClass>
"""

TPY = """<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<!-- made by a tool -->
<PlcProjectInfo xmlns:p="http://example.org/desc">
<ProjectInfo><Path>C:\\plants\\Pool.pro</Path></ProjectInfo>
<RoutingInfo><AdsInfo><NetId>192.168.0.1.1.1</NetId><Port>811</Port></AdsInfo></RoutingInfo>
<TaskInfos><TaskInfo><Name>Standard</Name><Priority>3</Priority><CycleTime>20</CycleTime>
 <CycleTimeUs>20000</CycleTimeUs><Calls><ProgramCall>prgMain()</ProgramCall></Calls>
</TaskInfo></TaskInfos>
<DataTypes>
<DataType><Name Decoration="2001">ARRAY [1..4] OF BYTE</Name><Type>BYTE</Type>
 <BitSize>32</BitSize><ArrayInfo><LBound>1</LBound><Elements>4</Elements></ArrayInfo></DataType>
<DataType><Name Decoration="1006">TON</Name><BitSize>144</BitSize>
 <SubItem><Name FbParameter="Input">IN</Name><Type>BOOL</Type>
  <Comment><![CDATA[starts the timer]]></Comment><BitSize>8</BitSize><BitOffs>0</BitOffs></SubItem>
 <SubItem><Name>PT</Name><Type>TIME</Type><BitSize>32</BitSize><BitOffs>16</BitOffs></SubItem>
 <FbInfo><CodeIndex>1</CodeIndex></FbInfo></DataType>
<DataType><Name>E_Mode</Name><Type>INT</Type><BitSize>16</BitSize>
 <EnumInfo><Text>off</Text><Enum>0</Enum></EnumInfo>
 <EnumInfo><Text>heat</Text><Enum>1</Enum></EnumInfo></DataType>
</DataTypes>
<Symbols>
<Symbol><Name Static="MArea">.bPump</Name><Type>BOOL</Type><IGroup>16417</IGroup>
 <IOffset>27</IOffset><BitSize>1</BitSize></Symbol>
<Symbol><Name Static="MArea">.nPower</Name><Type>DINT</Type><IGroup>16416</IGroup>
 <IOffset>6</IOffset><BitSize>32</BitSize></Symbol>
<Symbol><Name>prgMain.fbTimer</Name><Type Decoration="1006">TON</Type><IGroup>16448</IGroup>
 <IOffset>9510</IOffset><BitSize>144</BitSize></Symbol>
<Symbol><Name>prgMain.eMode</Name><Type>E_Mode</Type>
 <Comment><![CDATA[  summer  ]]></Comment><IGroup>61488</IGroup>
 <IOffset>2</IOffset><BitSize>16</BitSize></Symbol>
<Symbol><Name Constant="1">.CODES</Name><Type>ARRAY [1..4] OF BYTE</Type><IGroup>16448</IGroup>
 <IOffset>9600</IOffset><BitSize>32</BitSize></Symbol>
<Symbol><Name>.NOWHERE</Name><Type>INT</Type><BitSize>16</BitSize></Symbol>
</Symbols>
</PlcProjectInfo>
"""


@pytest.fixture
def tmc() -> bytes:
    return TMC.encode()


@pytest.fixture
def tpy() -> bytes:
    return TPY.encode()
