"""[[fmu]] of station.toml."""

from typing import Any

import pytest

from achse.motion.servo import ServoMode
from achse.station.configuration.fmu import FmuAxisConfig, FmuConfig
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError

AXIS = {"axis": 1, "command": "u", "position": "y"}


def test_defaults_are_those_of_the_page() -> None:
    unit = FmuConfig(name="tank", file="tank.fmu")
    assert (unit.step, unit.timeout, unit.start, unit.axis) == (None, 10_000_000_000, {}, ())


@pytest.mark.parametrize(
    ("mode", "number"),
    [("position", ServoMode.CSP), ("velocity", ServoMode.CSV), ("torque", ServoMode.CST)],
)
def test_modes_are_those_of_a_servo(mode: str, number: ServoMode) -> None:
    config = FmuAxisConfig.model_validate(AXIS | {"mode": mode, "torque_per_acceleration": 1.0})
    assert config.interface is number
    assert (config.scaling, config.inverted, config.homing) == (1e-5, False, None)


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ({"name": "two words", "file": "x"}, r"fmu\[1\]\.name"),
        ({"name": "x", "file": "x", "steps": "1ms"}, r"fmu\[1\]\.steps: no such key"),
        ({"name": "x", "file": "x", "step": 5}, r"fmu\[1\]\.step: expected a duration"),
        (
            {"name": "x", "file": "x", "axis": [AXIS | {"scale": 0}]},
            "expected a number other than 0",
        ),
        (
            {"name": "x", "file": "x", "axis": [AXIS | {"mode": "torque"}]},
            "torque_per_acceleration: expected beside mode = 'torque'",
        ),
    ],
)
def test_wrong_tables_are_refused(table: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint):
        parse({"fmu": [table]}, "test")


def test_names_are_there_once() -> None:
    table = {"name": "x", "file": "x"}
    with pytest.raises(ConfigError, match=r"fmu\.name"):
        parse({"fmu": [table, table]}, "test")
