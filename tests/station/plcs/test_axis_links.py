"""Axes and the variables of PLCs: which belong together, and what goes over in each cycle."""

from pathlib import Path
from typing import Any

import pytest

from achse.devices.nc.axes.structures import NC_TO_PLC_TC2, NC_TO_PLC_TC3
from achse.motion import AxisParameters, Nc
from achse.native.backend import compiler_installed
from achse.plc import Area
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.plcs.axis_links import AxisLinks, axis_variables, link_axes

TWO = (
    "PROGRAM MAIN VAR aAxes : ARRAY [1..2] OF AXIS_REF; Z : AXIS_REF; fromNc AT %I* :"
    " NCTOPLC_AXIS_REF; toNc AT %Q* : PLCTONC_AXIS_REF; copy : NCTOPLC_AXIS_REF; n : UDINT; END_VAR"
    " aAxes[2].PlcToNc.ControlDWord.Enable := TRUE; aAxes[2].PlcToNc.Override := 2000000;"
    " toNc.ExtSetDirection := -5; toNc.Override := 5; copy := fromNc; n := n + 1; END_PROGRAM"
)


def _station(folder: Path, text: str, *axes: dict[str, Any]) -> Station:
    (folder / "a.st").write_text(text, encoding="utf-8")
    document = {"plc": [{"sources": "a.st"}], "axis": axes}
    return Station(parse(document, "a.toml"), base=folder)


def test_structures_are_found_where_they_lie(tmp_path: Path) -> None:
    station = _station(tmp_path, TWO, {"id": 1, "name": "A"})
    structures = axis_variables(station.plcs[851].variables)
    assert {(each.owner, each.to_plc, each.size) for each in structures} == {
        (owner, to_plc, 256 if to_plc else 128)
        for owner in ("MAIN.aAxes[1]", "MAIN.aAxes[2]", "MAIN.Z")
        for to_plc in (True, False)
    } | {("MAIN.fromNc", True, 256), ("MAIN.toNc", False, 128)}


def test_named_links_carry_both_structures_and_ranges_hold(tmp_path: Path) -> None:
    station = _station(
        tmp_path,
        TWO,
        {"id": 3, "name": "A", "plc": "main.aaxes[2]"},
        {"id": 9, "name": "B", "plc": ["851:MAIN.fromNc", "MAIN.toNc"]},
        {"id": 4, "name": "z"},
    )
    station.advance(0.05)
    main: Any = station.plcs[851].instance("MAIN")
    assert station.nc is not None
    a, b = station.nc.axis(3), station.nc.axis(9)
    assert (a.control_dword, a.velocity_override) == (1, 1_000_000)
    assert (b.velocity_override, b.external_set_direction) == (5, -1)
    assert [main[name]["AxisId"] for name in ("fromNc", "copy")] == [9, 9]
    assert main["aAxes"][2]["NcToPlc"]["AxisId"] == 3
    assert main["aAxes"][1]["NcToPlc"]["AxisId"] == 0
    assert main["Z"]["NcToPlc"]["AxisId"] == 4


def test_a_write_of_another_client_lasts_a_cycle_and_a_stopped_plc_gives_nothing(
    tmp_path: Path,
) -> None:
    station = _station(tmp_path, TWO, {"id": 3, "name": "A", "plc": "MAIN.aAxes[2]"})
    station.advance(0.05)
    assert station.nc is not None
    axis = station.nc.axis(3)
    axis.control_dword = 7
    station.advance(0.02)
    assert axis.control_dword == 1
    station.plcs[851].stop()
    station.advance(0.02)
    assert (axis.control_dword, axis.velocity_override) == (0, 0)


def test_the_only_axis_belongs_to_the_only_reference(tmp_path: Path) -> None:
    text = "PROGRAM MAIN VAR drive : AXIS_REF; END_VAR END_PROGRAM"
    station = _station(tmp_path, text, {"id": 2, "name": "X"})
    station.advance(0.02)
    main: Any = station.plcs[851].instance("MAIN")
    assert main["drive"]["NcToPlc"]["AxisId"] == 2


def test_what_belongs_to_no_axis_is_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    station = _station(tmp_path, TWO, {"id": 1, "name": "A"})
    assert 'MAIN.aAxes[1], MAIN.aAxes[2], MAIN.Z: no axis; link them by plc = "…"' in caplog.text
    assert station.nc is not None
    assert link_axes(station.nc, station.plcs, ()) == {}


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ([{"plc": "MAIN.aAxes[3]"}], r"axis\[1\]\.plc: no variable of the type AXIS_REF"),
        ([{"plc": "MAIN.Zz"}], "did you mean"),
        ([{"plc": "852:MAIN.Z"}], "expected a PLC before the colon, got '852:MAIN.Z'"),
        ([{"plc": "MAIN.copy"}], "is named 'MAIN.copy'"),
        ([{"plc": "MAIN.Z"}, {"plc": "MAIN.Z"}], "is linked to axis X1 already"),
        ([{"plc": 5}], "plc"),
    ],
)
def test_mistakes(tmp_path: Path, axes: list[dict[str, Any]], message: str) -> None:
    tables = [{"id": n, "name": f"X{n}", **axis} for n, axis in enumerate(axes, 1)]
    with pytest.raises(ConfigError, match=message):
        _station(tmp_path, TWO, *tables)


def test_an_online_change_moves_the_variables(tmp_path: Path) -> None:
    station = _station(tmp_path, TWO, {"id": 3, "name": "A", "plc": "MAIN.aAxes[2]"})
    station.advance(0.05)
    assert station.nc is not None
    axis = station.nc.axis(3)
    more = TWO.replace("MAIN VAR", "MAIN VAR before : ARRAY [1..77] OF LREAL;")
    (tmp_path / "a.st").write_text(more, encoding="utf-8")
    station.online_change(851)
    axis.control_dword = 0
    station.advance(0.05)
    assert axis.control_dword == 1
    (tmp_path / "a.st").write_text("PROGRAM MAIN VAR n : UDINT; END_VAR END_PROGRAM", "utf-8")
    station.online_change(851)
    station.advance(0.05)
    assert axis.control_dword == 0


def test_links_alone(tmp_path: Path) -> None:
    station = _station(tmp_path, TWO, {"id": 3, "name": "A", "plc": "MAIN.Z"})
    assert station.nc is not None
    links = AxisLinks(station.plcs[851], {"MAIN.aAxes[1]": station.nc.axis(3)})
    links.show()
    main: Any = station.plcs[851].instance("MAIN")
    assert main["aAxes"][1]["NcToPlc"]["AxisId"] == 3


@pytest.mark.parametrize("compiled", [False, True])
def test_shown_alike_by_either_form_of_the_nc(tmp_path: Path, compiled: bool) -> None:
    """All linked axes, one of them in two structures, byte for byte."""
    if compiled and not compiler_installed():
        pytest.skip("needs llvmlite")
    plc = _station(tmp_path, TWO, {"id": 1, "name": "A", "plc": "MAIN.Z"}).plcs[851]
    nc = Nc(2_000_000, [AxisParameters(n) for n in (1, 2)], compiled=compiled)
    wanted = {"MAIN.aAxes[1]": nc.axis(2), "MAIN.aAxes[2]": nc.axis(1), "MAIN.Z": nc.axis(2)}
    links = AxisLinks(plc, wanted)
    owners = {name.casefold(): axis for name, axis in wanted.items()}
    linked = [each for each in axis_variables(plc.variables) if each.owner.casefold() in owners]
    for cycle in range(5):
        nc.axis(1).set_position, nc.axis(2).actual_position = 12.5 * cycle, -3.25 * cycle
        nc.axis(2).error_code = 0x4550 + cycle
        links.show()
        for at in linked:
            if at.to_plc:
                expected = NC_TO_PLC_TC3.encode(owners[at.owner.casefold()])
                assert plc.memory[at.area].read(at.offset, at.size) == expected
        nc.cycle()


def test_enables_that_another_client_changed_are_given_again(tmp_path: Path) -> None:
    station = _station(tmp_path, TWO, {"id": 3, "name": "A", "plc": "MAIN.aAxes[2]"})
    station.advance(0.05)
    assert station.nc is not None
    axis = station.nc.axis(3)
    before = axis.control_dword, axis.velocity_override
    axis.velocity_override = 17
    station.advance(0.05)
    assert (axis.control_dword, axis.velocity_override) == before
    axis.control_dword = 6
    station.advance(0.05)
    assert (axis.control_dword, axis.velocity_override) == before


OLD = (
    "PROGRAM MAIN VAR fromNc AT %IB1000 : NCTOPLC_AXLESTRUCT; toNc AT %QB1000 : PLCTONC_AXLESTRUCT"
    " := (nDeCtrlDWord := 7, nOverride := 500000); n : UDINT; END_VAR n := n + 1; END_PROGRAM"
)


def test_structures_of_twincat_2_have_its_128_bytes(tmp_path: Path) -> None:
    """The only pair belongs to the only axis."""
    station = _station(tmp_path, OLD, {"id": 3, "name": "A"})
    station.advance(0.1)
    main: Any = station.plcs[851].instance("MAIN")
    assert station.nc is not None
    axis = station.nc.axis(3)
    axis.actual_position = 12.5
    assert (axis.control_dword, axis.velocity_override) == (7, 500_000)
    assert main["fromNc"]["nAxisId"] == 3
    station.advance(0.01)
    image = station.plcs[851].memory[Area.INPUT].read(1000, 128)
    assert image == NC_TO_PLC_TC2.encode(axis)
    assert main["fromNc"]["fPosIst"] == axis.actual_position


@pytest.mark.parametrize("links", [["%IB1000", "%QB1000"], ["851:%qb1000", "MAIN.fromNc"]])
def test_structures_by_their_place_in_the_process_image(tmp_path: Path, links: list[str]) -> None:
    station = _station(tmp_path, OLD, {"id": 1, "name": "A"}, {"id": 2, "name": "B", "plc": links})
    station.advance(0.05)
    main: Any = station.plcs[851].instance("MAIN")
    assert station.nc is not None
    assert main["fromNc"]["nAxisId"] == 2
    assert [station.nc.axis(n).control_dword for n in (1, 2)] == [0, 7]
    with pytest.raises(ConfigError, match="is named '%IB1004'"):
        _station(tmp_path, OLD, {"id": 1, "name": "A", "plc": "%IB1004"})


def test_loose_structures_of_several_axes_are_reported(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    _station(tmp_path, OLD, {"id": 1, "name": "A"}, {"id": 2, "name": "B"})
    assert "MAIN.fromNc, MAIN.toNc: no axis" in caplog.text


def test_structures_that_a_project_declares_itself(tmp_path: Path) -> None:
    """Shorter or longer ones do not touch their neighbours; gaps decide which layout it is."""
    text = (
        "TYPE NCTOPLC_AXLESTRUCT : STRUCT nStateDWord, nErrorCode, nAxisState : DWORD; END_STRUCT"
        " END_TYPE TYPE PLCTONC_AXLESTRUCT : STRUCT nDeCtrlDWord, nOverride : DWORD; END_STRUCT"
        " END_TYPE PROGRAM MAIN VAR fromNc AT %IB0 : NCTOPLC_AXLESTRUCT; behind AT %IB12 : LWORD"
        " := 16#0102; toNc AT %QB0 : PLCTONC_AXLESTRUCT := (nDeCtrlDWord := 3, nOverride := 9);"
        " after AT %QB8 : LWORD := 16#FFFFFFFFFFFFFFFF; END_VAR END_PROGRAM"
    )
    station = _station(tmp_path, text, {"id": 1, "name": "A"})
    station.advance(0.05)
    main: Any = station.plcs[851].instance("MAIN")
    assert station.nc is not None
    axis = station.nc.axis(1)
    assert main["behind"] == 0x0102
    assert main["fromNc"]["nStateDWord"] == axis.state_dword != 0
    assert (axis.control_dword, axis.velocity_override, axis.operation_mode) == (3, 9, 0)


SOLUTION = """<TcSmProject><Project><Axis Id="9"><Name>Lift</Name></Axis></Project><Mappings>
<OwnerA Name="TIPC^{plc}^{plc} Instance"><OwnerB Name="TINC^NC-Task 1 SAF^Axes^{axis}">
<Link VarA="PlcTask Inputs^MAIN.fromNc" VarB="Outputs^ToPlc"/>
<Link VarA="PlcTask Outputs^MAIN.toNc" VarB="Inputs^FromPlc"/></OwnerB></OwnerA>
</Mappings></TcSmProject>"""


@pytest.mark.parametrize(
    ("axis", "plc", "linked"),
    [("B", "Any", 2), ("Lift", "Any", 9), ("Nobody", "Any", 0), ("B", "user", 2)],
)
def test_the_solution_of_the_sources_links_axes(
    tmp_path: Path, axis: str, plc: str, linked: int
) -> None:
    """By the name of the axis, or by its id there."""
    folder = tmp_path / "user"
    folder.mkdir()
    text = OLD.replace("%IB1000", "%I*").replace("%QB1000", "%Q*")
    (folder / "a.st").write_text(text, encoding="utf-8")
    (tmp_path / "Machine.tsproj").write_text(SOLUTION.format(axis=axis, plc=plc), "utf-8")
    axes = [{"id": 1, "name": "A"}, {"id": 2, "name": "B"}, {"id": 9, "name": "C"}]
    document = {"plc": [{"sources": "user"}], "axis": axes}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    station.advance(0.05)
    main: Any = station.plcs[851].instance("MAIN")
    assert main["fromNc"]["nAxisId"] == linked
    if linked:
        assert station.nc is not None
        assert station.nc.axis(linked).control_dword == 7


def test_what_station_toml_says_counts_more_than_the_solution(tmp_path: Path) -> None:
    (tmp_path / "M.tsproj").write_text(SOLUTION.format(axis="B", plc="p"), "utf-8")
    own = {"id": 1, "name": "A", "plc": ["MAIN.fromNc", "MAIN.toNc"]}
    station = _station(tmp_path, OLD, own, {"id": 2, "name": "B"})
    station.advance(0.05)
    assert station.nc is not None
    assert [station.nc.axis(n).control_dword for n in (1, 2)] == [7, 0]
