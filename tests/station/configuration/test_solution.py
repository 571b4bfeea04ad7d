"""Stations of solutions and PLC projects: PLCs with their ports, axes with their parameters."""

import logging
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes.axis import StartType
from achse.motion import commands
from achse.motion.record import FIELDS
from achse.station import Station
from achse.station.configuration.solution import project_document
from achse.station.configuration.solution_nc import PARAMETERS
from achse.station.configuration.station_file import load
from achse.station.configuration.types import ConfigError

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


@pytest.mark.parametrize(
    "path", ["Line.sln", "Line/Line.tsproj", "Line/Cell/Cell.plcproj", ".", "Line"]
)
def test_each_file_of_a_solution_leads_to_its_station(tmp_path: Path, path: str) -> None:
    config = load(solution(tmp_path) / path)
    [plc] = config.plc
    assert plc.port == 853
    assert Path(plc.sources or "") == tmp_path / "Line" / "Cell" / "Cell.plcproj"
    [axis] = config.axis
    assert (axis.id, axis.name, axis.unit, config.nc.cycle) == (3, "X", "Degree", 1_000_000)
    assert axis.parameters == {
        "default_acceleration": 300.0,
        "default_jerk": 2000.0,
        "max_velocity": 200.0,
        "jog_velocity_slow": 30.0,
        "jog_velocity_fast": 200.0,  # the default of 600 is above the maximum
        "rapid_traverse_velocity": 200.0,
        "position_range_monitoring_enable": False,
        "encoder_soft_limit_min_enable": True,
        "encoder_soft_limit_min": -5.0,
        "encoder_scaling_numerator": 5.0,
    }


def test_a_solution_runs(tmp_path: Path) -> None:
    station = Station.load(solution(tmp_path) / "Line.sln")
    station.advance(0.1)
    main: Any = station.plcs[853].instance("MAIN")
    assert main.n == 10
    assert [axis.id for axis in station.config.axis] == [3]


def test_projects_of_a_solution_are_libraries_of_one_another(tmp_path: Path) -> None:
    solution(tmp_path)
    cell, tools = tmp_path / "Line" / "Cell", tmp_path / "Line" / "Tools"
    tools.mkdir()
    (tools / "Tools.plcproj").write_text('<P><Compile Include="f.st"/><Title>Tools</Title></P>')
    (tools / "f.st").write_text("FUNCTION F_Two : INT F_Two := 2; END_FUNCTION")
    (cell / "Cell.plcproj").write_text(
        PROJECT.replace("</ItemGroup>", '<LibraryReference Include="Tools,*,v"/></ItemGroup>')
    )
    (cell / "POUs" / "MAIN.TcPOU").write_text(POU.replace("n + 1", "F_Two()"))
    station = Station.load(tmp_path / "Line.sln")
    station.advance(0.1)
    assert station.plcs[853].instance("MAIN")["n"] == 2


def test_sources_alone_are_a_station(tmp_path: Path) -> None:
    file = tmp_path / "MAIN.st"
    file.write_text(MAIN)
    for path in (file, tmp_path):
        config = load(path)
        assert [(plc.port, plc.sources) for plc in config.plc] == [(851, str(path))]
        assert not config.axis


def test_parts_lie_in_files_of_their_own(tmp_path: Path) -> None:
    folder = solution(tmp_path, "").joinpath("Line")
    text = (folder / "Line.tsproj").read_text()
    start, _, _ = text.partition("<Plc>")
    (folder / "Line.tsproj").write_text(
        start + '<Plc><Project File="Cell.xti"/></Plc><Motion><NC File="NC.xti"/></Motion>'
        "</Project></TcSmProject>"
    )
    config = folder / "_Config"
    (config / "PLC").mkdir(parents=True)
    (config / "NC" / "Axes").mkdir(parents=True)
    (config / "PLC" / "Cell.xti").write_text(
        '<TcSmItem><Project PrjFilePath="..\\..\\Cell\\Cell.plcproj"/></TcSmItem>'
    )
    (config / "NC" / "NC.xti").write_text(
        '<TcSmItem><NC><SafTask CycleTime="20000"/><Axis File="M1 - Y.xti" Id="7"/></NC></TcSmItem>'
    )
    (config / "NC" / "Axes" / "M1 - Y.xti").write_text(
        f"<TcSmItem><DataTypes/>{AXIS.replace('<Name>X', '<Name>__FILENAME__')}</TcSmItem>"
    )
    found = load(folder / "Line.tsproj")
    assert [(plc.port, Path(plc.sources or "").name) for plc in found.plc] == [
        (851, "Cell.plcproj")
    ]
    assert [(axis.id, axis.name) for axis in found.axis] == [(7, "M1 - Y")]
    assert found.nc.cycle == 2_000_000


@given(st.sampled_from(PARAMETERS), st.text(max_size=8) | st.floats().map(str) | st.just("true"))
def test_a_value_out_of_range_is_left_out(
    tmp_path_factory: pytest.TempPathFactory, row: tuple[str, str, str], text: str
) -> None:
    path, attribute, key = row
    tags = path.split("/")
    escaped = "".join(
        f"&#{ord(sign)};" for sign in text if sign.isprintable() and ord(sign) < 0xD800
    )
    inner = f'<{tags[-1]} {attribute}="{escaped}"/>'
    for tag in reversed(tags[:-1]):
        inner = f"<{tag}>{inner}</{tag}>"
    folder = tmp_path_factory.mktemp("solution")
    file = folder / "a.tsproj"
    file.write_text(SOLUTION.replace("AXES", f'<Axis Id="1"><Name>X</Name>{inner}</Axis>'))
    logging.disable()
    try:
        [axis] = project_document(file)["axis"]
    finally:
        logging.disable(logging.NOTSET)
    if key in axis:
        assert FIELDS[key].least <= axis[key] <= FIELDS[key].most


@given(data=st.data())
def test_every_parameter_is_taken_over(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    rows = data.draw(st.lists(st.sampled_from(PARAMETERS), unique_by=lambda row: row.key))
    values: dict[str, float | bool] = {}
    tree: dict[str, Any] = {}
    for row in rows:
        field = FIELDS[row.key]
        least, most = max(field.least, 0.01), min(field.most, 1e6)
        flag = (field.least, field.most) == (0, 1)
        whole = isinstance(field.default, int)
        if flag:
            value: float | bool = data.draw(st.booleans())
            text = str(value).lower()
        elif whole:
            value = data.draw(st.integers(max(int(field.least), 1), int(field.most)))
            text = f"#x{value:08x}"
        else:
            value = data.draw(st.floats(least, most))
            text = repr(value)
        values[row.key] = value
        place = tree
        for tag in row.path.split("/"):
            place = place.setdefault(tag, {})
        place[f"@{row.attribute}"] = text
    axes = f'<Axis Id="1"><Name>X</Name>{_written(tree)}</Axis>'
    config = load(solution(tmp_path_factory.mktemp("solution"), axes) / "Line.sln")
    found = config.axis[0].parameters
    if values.get("encoder_soft_limit_min_enable") or values.get("encoder_soft_limit_max_enable"):
        values.pop("encoder_position_offset", None)
        found.pop("encoder_position_offset", None)
    assert {key: found[key] for key in values} == values


def _written(tree: dict[str, Any]) -> str:
    parts = []
    for tag, inner in tree.items():
        if tag.startswith("@"):
            continue
        said = "".join(f' {key[1:]}="{text}"' for key, text in inner.items() if key[:1] == "@")
        parts.append(f"<{tag}{said}>{_written(inner)}</{tag}>")
    return "".join(parts)


@pytest.mark.parametrize(
    ("offset", "least", "most", "taken"),
    [
        ("-358", 'Enable="true" Range="-5"', "", False),
        ("-4", 'Enable="true" Range="-5"', 'Enable="true" Range="5"', True),
        ("6", "", 'Enable="true" Range="5"', False),
        ("-358", 'Range="-5"', "", True),
    ],
)
def test_an_offset_beyond_a_limit_is_left_out(
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
    offset: str,
    least: str,
    most: str,
    taken: bool,
) -> None:
    limits = f"<SoftEndMinControl {least}/><SoftEndMaxControl {most}/>"
    encoder = f'<Encoder><EncPara Offset="{offset}">{limits}</EncPara></Encoder>'
    with caplog.at_level(logging.INFO):
        found = load(
            solution(tmp_path, f'<Axis Id="1"><Name>X</Name>{encoder}</Axis>') / "Line.sln"
        )
    assert ("encoder_position_offset" in found.axis[0].parameters) is taken
    assert (f"axis X: offset {offset} is left out" in caplog.text) is not taken


def test_the_simulated_machine_counts_with_the_scaling(tmp_path: Path) -> None:
    encoder = '<EncPara ScaleFactorNumerator="5" ScaleFactorDenominator="1000" Inverse="true"'
    axis = f"""<Axis Id="1"><Name>X</Name><Encoder>{encoder} Offset="20" MaxCount="#x0000ffff"/>
    </Encoder><Drive><DrvPara Inverse="true"/></Drive></Axis>"""
    station = Station.load(solution(tmp_path, axis) / "Line.sln")
    station.advance(0.1)
    assert station.nc is not None
    moved = station.nc.axis(1)
    assert moved.encoder.scaling_factor == 0.005
    assert moved.actual_position == pytest.approx(20.0, abs=0.005)
    moved.control_dword, moved.velocity_override = 7, 1_000_000
    station.advance(0.1)
    farther_than_the_counter = 1000.0
    assert commands.start(moved, StartType.ABSOLUTE, farther_than_the_counter, 400.0) == 0
    station.advance(5.0)
    assert moved.error_code == 0
    assert moved.actual_position == pytest.approx(1000.0, abs=0.01)


CHANNEL = """<Channel Id="{id}" ChannelType="{kind}"><Name>{name}</Name>
<Group Id="{group}" GroupType="{type}"><Name>{name}</Name><Parameter ChannelId="{id}"><Fifo
FifoDimension="5" FifoLength="{length}" FifoIpolType="{way}" TimeUnitFifo="{delta}"/><Kinematic
OidKinematicTrafo="#x01010010"/></Parameter></Group>
<Interpreter ProgName="a.nc"><MFunc>05</MFunc></Interpreter></Channel>"""


@given(
    id=st.sampled_from(("2", "3", "255", "0", "256", "x")),
    group=st.sampled_from(("1", "5", "255", "0", "256", "")),
    kind=st.sampled_from((("2", "4"), ("3", "11"), ("4", "12"), ("2", "11"), ("1", "1"), ("", ""))),
    length=st.sampled_from(("1", "60", "10000", "10001", "-1", "")),
    way=st.sampled_from(("0", "1", "4", "2")),
    delta=st.sampled_from(("0.002", "1e-9", "0", "-1", "nan", "inf", "1e308", "x")),
)
def test_channels_and_their_groups(
    tmp_path_factory: pytest.TempPathFactory, kind: tuple[str, str], **said: str
) -> None:
    text = CHANNEL.format(kind=kind[0], type=kind[1], name="Kanal", **said)
    axis = AXIS.replace('Id="3"', 'Id="1"')
    config = load(solution(tmp_path_factory.mktemp("line"), axis + text) / "Line.sln")
    if said["id"] not in ("2", "3", "255") or kind[0] not in ("2", "3", "4"):
        assert not config.channel
        assert not config.group
        return
    [channel] = config.channel
    types = {"2": "interpreter", "3": "fifo", "4": "kinematic"}
    assert (str(channel.id), channel.name, channel.type) == (said["id"], "Kanal", types[kind[0]])
    if kind == ("2", "11"):
        assert not config.group
        return
    [group] = config.group
    assert group.id == (5 if said["group"] == "5" else 255)  # 1 is that of the axis
    assert (group.channel, group.name) == (channel.id, "Kanal")
    if group.type == "fifo":
        assert group.dimension == 5
        assert group.length == (
            int(said["length"]) if said["length"] in ("1", "60", "10000") else 1000
        )
        ways = {"0": "linear", "1": "four_point", "4": "cubic_spline", "2": "linear"}
        assert group.interpolation == ways[said["way"]]
        assert group.time_delta == {"1e-9": 1}.get(said["delta"], 2_000_000)


LINKED = """<Mappings><OwnerA Name="TIPC^Cell^Cell Instance"><OwnerB
Name="TINC^NC-Task 1 SAF^Axes^X"><Link VarA="PlcTask Inputs^MAIN.a" VarB="Outputs^ToPlc"/></OwnerB>
<OwnerB Name="TIID^Device 1^Term 2 (EL1008)"><Link VarA="PlcTask Inputs^MAIN.bSensor"
VarB="Channel 1^Input"/><Link VarA="PlcTask Inputs^MAIN.aIn^In" VarB="Channel 2^Input"/></OwnerB>
</OwnerA></Mappings>"""


def test_one_line_names_what_is_left_out(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    said = {"id": "2", "kind": "4", "type": "12", "group": "9", "name": "K"}
    text = CHANNEL.format(length=1, way=0, delta=1, **said)
    file = solution(tmp_path, AXIS.replace("<EncPara", '<EncPara ReferenceSystem="1"') + text)
    tsproj = file / "Line" / "Line.tsproj"
    tsproj.write_text(tsproj.read_text().replace("</Project></Tc", f"</Project>{LINKED}</Tc"))
    with caplog.at_level(logging.INFO):
        load(tsproj)
    [nc] = [line for line in caplog.messages if "left out of the NC" in line]
    for name in ("Encoder@EncType", "Encoder/EncPara@ReferenceSystem", "Channel/Interpreter/MFunc"):
        assert f"{name} (1)" in nc
    assert "Channel/Group/Parameter/Kinematic (1)" in nc
    [links] = [line for line in caplog.messages if "to hardware" in line]
    assert "2 links of PLC variables to hardware are left out: MAIN.bSensor, MAIN.aIn^In" in links


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings_and_capitals_are_those_of_windows(tmp_path: Path, encoding: str) -> None:
    solution(tmp_path)
    (tmp_path / "Line").rename(tmp_path / "Größe")
    text = LIST.replace("Line\\Line.tsproj", "größe\\LINE.tsproj")
    (tmp_path / "Line.sln").write_text(text, encoding=encoding)
    tsproj = tmp_path / "Größe" / "Line.tsproj"
    tsproj.write_text(tsproj.read_text().replace("Cell\\Cell", "cell\\CELL"))
    [plc] = load(tmp_path / "Line.sln").plc
    assert Path(plc.sources or "").exists()


def test_other_plcs_of_the_solution_may_be_missing(tmp_path: Path) -> None:
    tsproj = solution(tmp_path) / "Line" / "Line.tsproj"
    text = tsproj.read_text()
    missing = '<Plc><Project PrjFilePath="No\\No.plcproj"/>'
    tsproj.write_text(text.replace("<Plc>", missing))
    [plc] = load(tmp_path / "Line" / "Cell" / "Cell.plcproj").plc
    assert plc.port == 853


def test_a_file_is_read_once(tmp_path: Path) -> None:
    axes = solution(tmp_path, '<Axis File="X.xti"/>' * 2) / "Line" / "_Config" / "NC" / "Axes"
    axes.mkdir(parents=True)
    (axes / "X.xti").write_text(f"<TcSmItem>{AXIS}</TcSmItem>")
    with pytest.raises(ConfigError, match="each file once"):
        load(tmp_path / "Line.sln")


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("a.tsproj", "<a", "no well-formed XML"),
        ("a.tsproj", "<!DOCTYPE a><a/>", "DOCTYPE"),
        (
            "a.tsproj",
            PLC.replace("PLC", 'File="..\\..\\..\\..\\x.xti"'),
            "a file of the solution",
        ),
        ("a.tsproj", PLC.replace("PLC", ""), "a.tsproj: PLC : PrjFilePath: expected a .plcproj"),
        ("a.tsproj", "<html/>", "expected <TcSmProject>, got <html>"),
        (
            "a.tsproj",
            NC.replace("NC/", 'NC File="NC.xti"/'),
            "one/_Config/NC/NC.xti:1:1: .*No such",
        ),
        ("a.tsproj", SOLUTION.replace("AXES", "<Axis/>" * 256), "up to 255 axes, got 256"),
        ("a.sln", LIST.replace("Line\\Line", "..\\..\\..\\x"), "a file of the solution"),
        ("a.sln", LIST.replace("Line.tsproj", "Line.vcxproj"), "expected a .tsproj in it"),
        ("a.sln", LIST + LIST.replace("Line.tsproj", "B.tsproj"), "say which"),
        ("empty/notes.txt", "", "or a folder with a .tsproj"),
    ],
)
def test_what_is_no_solution_is_told(tmp_path: Path, name: str, text: str, told: str) -> None:
    file = tmp_path / "one" / name
    file.parent.mkdir(parents=True)
    file.write_text(text)
    with pytest.raises(ConfigError, match=told):
        load(file.parent if name.startswith("empty") else file)


@given(names=st.lists(st.sampled_from(("A" * 40, "A" * 35, "B")), min_size=2, max_size=6))
def test_axes_whose_names_are_too_long_are_told_apart(
    tmp_path_factory: pytest.TempPathFactory, names: list[str]
) -> None:
    axes = "".join(
        AXIS.replace('Id="3"', f'Id="{number}"').replace(">X<", f">{name}<")
        for number, name in enumerate(names, 1)
    )
    found = load(solution(tmp_path_factory.mktemp("line"), axes) / "Line.sln").axis
    assert len({axis.name for axis in found}) == len(names)
    assert all(axis.name[:1] == name[:1] for axis, name in zip(found, names, strict=True))
