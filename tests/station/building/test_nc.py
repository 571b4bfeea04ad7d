"""The NC of a station: parameters, words, tables; what cannot be is located."""

import math
import sys
from pathlib import Path
from typing import Any

import pytest

from achse.motion import commands
from achse.motion.kernel import cycles
from achse.native.compiled import Kernel
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


def test_axis_parameters_reach_the_axis() -> None:
    axis = {"id": 9, "name": "A", "unit": "inch", "modulo": True, "max_velocity": 12.5}
    built = station(axis=[axis])
    assert built.nc is not None
    built_axis = built.nc.axis(9)
    assert (built_axis.name, built_axis.unit, built_axis.max_velocity) == ("A", "inch", 12.5)
    assert built_axis.unit_interpretation == 4


@pytest.mark.parametrize(
    ("values", "period", "begin"),
    [
        ({}, 360.0, -68.0),
        ({"encoder_modulo_factor": 100.0, "simulation_cam_end": 5.0}, 100.0, 0.0),
        ({"simulation_period": 0.0, "simulation_cam_begin": -60.0}, 0.0, -60.0),
    ],
)
def test_the_machine_of_a_modulo_axis_is_a_rotary_table(
    values: dict[str, float], period: float, begin: float
) -> None:
    built = station(axis=[{"id": 1, "name": "C", "unit": "degree", "modulo": True, **values}])
    assert built.nc is not None
    axis = built.nc.axis(1)
    assert (axis.machine.period, axis.machine.cam_begin) == (period, begin)


def test_words_of_enumerations_and_flags() -> None:
    ids = {"encoder_ids": [1, 7], "controller_ids": [1, 7]}
    values = {"override_type": "original", **ids}
    element = {"encoder_count_direction": True, "controller_type": "PID_POSITION"}
    built = station(axis=[{"id": 1, "name": "A", **values, "element": [element]}])
    assert built.nc is not None
    axis = built.nc.axis(1)
    other = axis.encoders[1]
    assert axis.override_type == 2
    assert (other.count_direction, axis.controllers[1].type) == (1, 3)
    assert type(other.count_direction) is int


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"max_velocty": 1.0}, r"axis\[2\]\.max_velocty: no such key; did you mean 'max_velocity'"),
        ({"max_velocity": "fast"}, r"axis\[2\]\.max_velocity: expected a number, got 'fast'"),
        ({"max_velocity": True}, r"axis\[2\]\.max_velocity: expected a number, got True"),
        (
            {"override_type": "fast"},
            r"axis\[2\]\.override_type: expected a number or REDUCED or .*, got 'fast'",
        ),
        ({"encoder_ids": [2, 1]}, r"axis: encoder id 1 is given twice"),
        ({"max_velocity": float("nan")}, r"axis\[2\]: .*max_velocity = nan"),
        ({"max_velocity": -1.0}, r"axis\[2\]: .*max_velocity = -1.0, expected .*mm/s"),
        (
            {"modulo": True, "unit_interpretation": math.inf},
            r"axis\[2\]: .*unit_interpretation = inf",
        ),
        ({"override_type": 1.5}, r"axis\[2\]: .*override_type = 1.5, expected a whole number"),
    ],
)
def test_a_wrong_axis_parameter_is_located(values: dict[str, Any], message: str) -> None:
    axes = [{"id": 1, "name": "A"}, {"id": 2, "name": "B", **values}]
    with pytest.raises(ConfigError, match=message):
        station(axis=axes)


def test_the_compiled_kernel_needs_llvmlite(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.motion.nc.KERNEL", Kernel("fresh", cycles, {}))
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    with pytest.raises(ConfigError, match=r"nc.code: machine needs the extra fast: pip"):
        station(nc={"code": "machine"}, axis=[{"id": 1, "name": "A"}])


def test_the_characteristic_of_a_drive_is_a_table_of_the_configuration() -> None:
    valve = {"id": 7, "name": "valve", "points": [[-1, -1], [0, 0], [0.1, 0.5], [1, 1]]}
    axis = {
        "id": 1, "name": "X", "drive_table_id": 7, "drive_table_interpolation_type": "spline",
        "simulation_table_id": 7,
    }  # fmt: skip
    nc = station(table=[valve], axis=[axis]).nc
    assert nc is not None
    assert nc.tables.find(7).table_name == "valve"
    assert nc.axis(1).drive.curve_count == 4
    assert nc.axis(1).drive.table_interpolation_type == 2
    assert nc.tables.user_count(7) == 2


def test_a_cam_is_a_table_of_the_configuration() -> None:
    points = [[0, 0], [90, 30], [180, 0]]
    cam = {"id": 7, "kind": "cam", "type": "monotonic_cyclic", "points": points}
    ends = {"boundary": "slopes", "begin_slope": 0.5, "end_slope": -0.5}
    nc = station(table=[cam, cam | ends | {"id": 8}], axis=[{"id": 1, "name": "X"}]).nc
    assert nc is not None
    table = nc.tables.find(7)
    assert (table.table_main_type, table.table_sub_type, table.master_period) == (1, 4, 180.0)
    values = nc.tables.characteristic_values(nc.tables.find(8), 1.0)
    assert (values[3], values[8]) == pytest.approx((0.5, -0.5))
    with pytest.raises(ConfigError, match="type 4, expected 1, 3"):
        station(table=[cam | {"kind": "characteristic"}], axis=[{"id": 1, "name": "X"}])


def test_tables_of_files(tmp_path: Path) -> None:
    (tmp_path / "cam.txt").write_text("3\t2\n+0.0\t+0.0\n+90.0\t+30.0\n+180.0\t+0.0\n")
    (tmp_path / "cam.csv").write_text("Master;Slave\n0;0\n90;30,5\n180;0\n")
    (tmp_path / "laws.csv").write_text("master,slave,law\n0,0,12\n180,10,12\n360,0,0\n")
    cam = {"kind": "cam", "type": "equidistant_cyclic"}
    tables = [
        cam | {"id": 1, "file": "cam.txt"},
        cam | {"id": 2, "file": "cam.csv"},
        {"kind": "motion_function", "type": "monotonic_cyclic", "id": 3, "file": "laws.csv"},
    ]
    nc = station(tmp_path, table=tables, axis=[{"id": 1, "name": "X"}]).nc
    assert nc is not None
    assert [nc.tables.find(n).read(45.0)[0] for n in (1, 2)] == [15.0, 15.25]
    assert nc.tables.find(3).read(90.0)[0] == pytest.approx(5.0, abs=1e-12)


@pytest.mark.parametrize(
    ("table", "text", "message"),
    [
        ({"kind": "cam"}, "0 0\n1 x", r"table\[1\]\.file: .*t\.csv:2: expected numbers, got '1 x'"),
        ({"kind": "cam"}, "0 0", r"table\[1\]\.file: .*t\.csv: expected 2 rows or more, got 1"),
        ({"kind": "cam"}, "0 0 1\n1 1 1", r"table\[1\]: cam, expected a file that has rows of 2"),
        ({"kind": "motion_function"}, "0 0\n1 1", r"table\[1\]: motion_function, .*points with"),
        ({}, "0 0\n1 1\n1 2", "table: table 7: its places do not rise"),
        ({"kind": "cam", "file": "u.csv"}, "", r"table\[1\]\.file: .*u\.csv: No such file"),
        ({"kind": "cam", "file": "\0"}, "", r"table\[1\]\.file: .*null"),
        ({"kind": "cam", "file": "."}, "", r"table\[1\]\.file: .*directory"),
        ({"points": [[0, 0], [1, 1]]}, "0 0\n1 1", r"a\.toml: table\[1\]: expected points or file"),
        ({"kind": "motion_function", "file": None, "points": [[0, 0], [1, 1]]}, "",
         r"table\[1\]: motion_function, expected a file that has points with laws"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_table(
    tmp_path: Path, table: dict[str, Any], text: str, message: str
) -> None:
    (tmp_path / "t.csv").write_text(text)
    row = {"id": 7, "file": "t.csv", **table}
    with pytest.raises(ConfigError, match=message):
        station(tmp_path, table=[row], axis=[{"id": 1, "name": "X"}])


@pytest.mark.parametrize(
    ("table", "axis", "message"),
    [
        ({"points": [[0, 0], [0, 1]]}, {}, "table: table 7: its places do not rise"),
        ({"points": [[0, 0]]}, {}, r"a.toml: table\[1\].points: .* at least 2"),
        ({"points": [[0, 0], [float("inf"), 1]]}, {}, "finite number"),
        ({"points": [[0, 0], [1, 1]]}, {"drive_table_id": 8}, "table: no table 8, for axis 1"),
        (
            {"points": [[0, 0], [0.1, 1], [1, 2]], "type": "equidistant_linear"}, {},
            "table: table 7: its steps are not equal",
        ),
    ],
)  # fmt: skip
def test_a_table_that_no_drive_could_use(table: Any, axis: Any, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        station(table=[{"id": 7} | table], axis=[{"id": 1, "name": "X"} | axis])


@pytest.mark.parametrize("start_type", [272, 528, 784])  # slow, fast, rapid
def test_axis_with_a_low_maximum_velocity_accepts_each_jog(start_type: int) -> None:
    enabled = {"control_dword": 7, "velocity_override": 1_000_000}
    table = {"id": 1, "name": "X", "max_velocity": 50.0, **enabled}
    station = Station(parse({"axis": [table]}, "t"))
    assert station.warnings == []
    assert station.nc is not None
    station.advance(0.1)
    assert commands.start(station.nc.axis(1), start_type, 0.0, 0.0) == 0
    station.advance(1.0)
    assert station.nc.axis(1).set_velocity == pytest.approx(50.0)


def test_stored_velocity_above_the_maximum_is_a_warning() -> None:
    table = {"id": 1, "name": "X", "max_velocity": 50.0, "rapid_traverse_velocity": 60.0}
    (warning,) = Station(parse({"axis": [table]}, "t")).warnings
    assert warning == (
        "axis X: rapid_traverse_velocity = 60 mm/s: "
        "expected at most 50 mm/s, such a move is refused"
    )
