"""Stations of solutions and PLC projects: PLCs with their ports, files of a solution."""

from pathlib import Path
from typing import Any

import pytest

from achse.station import Station
from achse.station.configuration.station_file import load
from achse.station.configuration.types import ConfigError
from tests.station.configuration.solutions import (
    AXIS,
    LIST,
    MAIN,
    NC,
    PLC,
    POU,
    PROJECT,
    SOLUTION,
    solution,
)


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
    loaded = load(folder / "Line.tsproj")
    assert [(plc.port, Path(plc.sources or "").name) for plc in loaded.plc] == [
        (851, "Cell.plcproj")
    ]
    assert [(axis.id, axis.name) for axis in loaded.axis] == [(7, "M1 - Y")]
    assert loaded.nc.cycle == 2_000_000


def test_a_simulated_encoder_follows_the_setpoint(tmp_path: Path) -> None:
    """`EncType` 1: the encoder of an axis without hardware; others have a machine that lags."""
    text = AXIS.replace('EncType="19"', 'EncType="1"')
    [axis] = load(solution(tmp_path, text) / "Line.sln").axis
    assert axis.parameters["simulation_ideal"] is True


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
    ("name", "text", "message"),
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
def test_what_is_no_solution_is_reported(
    tmp_path: Path, name: str, text: str, message: str
) -> None:
    file = tmp_path / "one" / name
    file.parent.mkdir(parents=True)
    file.write_text(text)
    with pytest.raises(ConfigError, match=message):
        load(file.parent if name.startswith("empty") else file)
