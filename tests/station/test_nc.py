"""The NC of a station: parameters, words, tables; what cannot be is located."""

import math
import sys
from pathlib import Path
from typing import Any

import pytest

from achse.motion.kernel import cycles
from achse.native.compiled import Kernel
from achse.station import ConfigError, Station
from achse.station.config import parse


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


def test_axis_parameters_reach_the_axis() -> None:
    axis = {"id": 9, "name": "A", "unit": "inch", "modulo": True, "max_velocity": 12.5}
    built = station(axis=[axis])
    assert built.nc is not None
    made = built.nc.axis(9)
    assert (made.name, made.unit, made.max_velocity) == ("A", "inch", 12.5)
    assert made.unit_interpretation == 4


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
    made = built.nc.axis(1)
    assert (made.machine.period, made.machine.cam_begin) == (period, begin)


def test_words_of_enumerations_and_flags() -> None:
    ids = {"encoder_ids": [1, 7], "controller_ids": [1, 7]}
    values = {"override_type": "original", **ids}
    element = {"encoder_count_direction": True, "controller_type": "PID_POSITION"}
    built = station(axis=[{"id": 1, "name": "A", **values, "element": [element]}])
    assert built.nc is not None
    made = built.nc.axis(1)
    other = made.encoders[1]
    assert made.override_type == 2
    assert (other.count_direction, made.controllers[1].type) == (1, 3)
    assert type(other.count_direction) is int


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"max_velocty": 1.0}, r"axis\[2\]: .*no parameter 'max_velocty'"),
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
    with pytest.raises(ConfigError, match=r"nc\.kernel: compiled needs llvmlite.*achse\[fast\]"):
        station(nc={"kernel": "compiled"}, axis=[{"id": 1, "name": "A"}])


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
