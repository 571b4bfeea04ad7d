"""Axes and channels of solutions: parameters, scalings, groups, and what is left out."""

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
from tests.station.configuration.solutions import (
    AXIS,
    SOLUTION,
    solution,
)


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
    parameters = config.axis[0].parameters
    if values.get("encoder_soft_limit_min_enable") or values.get("encoder_soft_limit_max_enable"):
        values.pop("encoder_position_offset", None)
        parameters.pop("encoder_position_offset", None)
    assert {key: parameters[key] for key in values} == values


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
        config = load(
            solution(tmp_path, f'<Axis Id="1"><Name>X</Name>{encoder}</Axis>') / "Line.sln"
        )
    assert ("encoder_position_offset" in config.axis[0].parameters) is taken
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


@given(names=st.lists(st.sampled_from(("A" * 40, "A" * 35, "B")), min_size=2, max_size=6))
def test_axes_whose_names_are_too_long_are_distinguished(
    tmp_path_factory: pytest.TempPathFactory, names: list[str]
) -> None:
    axes = "".join(
        AXIS.replace('Id="3"', f'Id="{number}"').replace(">X<", f">{name}<")
        for number, name in enumerate(names, 1)
    )
    named_axes = load(solution(tmp_path_factory.mktemp("line"), axes) / "Line.sln").axis
    assert len({axis.name for axis in named_axes}) == len(names)
    assert all(axis.name[:1] == name[:1] for axis, name in zip(named_axes, names, strict=True))
