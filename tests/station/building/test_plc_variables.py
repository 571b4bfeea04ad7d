"""Variables of a PLC by name."""

import math
from pathlib import Path

import pytest

from achse.devices.plc import PlcDevice
from achse.iec.elementary import BOOL, INT, LREAL, USINT
from achse.iec.strings import StringType
from achse.station import ConfigError, Station
from achse.station.building.plc_variables import (
    encoder_of,
    find_variable,
    is_numeric,
    written_variable,
)


@pytest.fixture
def device(tmp_path: Path) -> PlcDevice:
    (tmp_path / "main.st").write_text(
        "PROGRAM MAIN VAR nLevel : INT; END_VAR VAR CONSTANT cMost : INT := 3; END_VAR END_PROGRAM"
    )
    (tmp_path / "station.toml").write_text('[[plc]]\nsources = "main.st"\n')
    station = Station.load(tmp_path / "station.toml")
    return next(each for each in station.devices if isinstance(each, PlcDevice))


def test_variable_is_found_in_any_case(device: PlcDevice) -> None:
    assert find_variable(device, "main.NLEVEL", "key").name == "MAIN.nLevel"


def test_wrong_names_are_reported_with_their_key(device: PlcDevice) -> None:
    with pytest.raises(ConfigError, match=r"key: expected a variable.*did you mean 'MAIN\.nLevel'"):
        find_variable(device, "MAIN.nLevle", "key")
    with pytest.raises(ConfigError, match=r"key: MAIN\.cMost is a constant"):
        written_variable(device, "MAIN.cMost", "key")


@pytest.mark.parametrize(
    ("value", "encoded"),
    [(3.4, b"\3\0"), (1e9, b"\xff\x7f"), (-math.inf, b"\0\x80"), (32768, b"\0\x80")],
)
def test_numbers_are_rounded_and_kept_within_the_type(value: float, encoded: bytes) -> None:
    if math.isinf(value):
        with pytest.raises(OverflowError):
            encoder_of(INT, "key")(value)
        return
    assert encoder_of(INT, "key")(value) == encoded


def test_other_types_are_refused() -> None:
    assert is_numeric(LREAL)
    assert not is_numeric(StringType(3))
    assert encoder_of(BOOL, "key")(0.5) == b"\1"
    assert encoder_of(USINT, "key")(256) == b"\0"
    with pytest.raises(ConfigError, match="key: expected a number or a BOOL, got a STRING"):
        encoder_of(StringType(3), "key")
