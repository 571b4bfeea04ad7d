"""The buses with drives of a station: errors of their tables, axes beside them, restarts."""

from pathlib import Path
from typing import Any

import pytest

from achse.codes.axis import StartType
from achse.motion import commands
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError
from achse.station.station import Station
from tests.station.drive_stations import AXIS, drive_station, enable_axes


def test_a_restart_brings_axes_and_drives_again() -> None:
    station = drive_station({})
    enable_axes(station)
    station.restart()
    station.advance(2.0)
    enable_axes(station)


def test_an_axis_without_a_drive_stays_simulated() -> None:
    document = {"axis": [{"id": 7, "name": "S", **AXIS}, {"id": 8, "name": "D", **AXIS}],
                "bus": [{}], "drive": [{"axis": "d"}]}  # fmt: skip
    station = Station(parse(document, "test"))
    enable_axes(station)
    assert station.nc is not None
    for axis in station.nc:
        commands.start(axis, StartType.ABSOLUTE, 10.0, 100.0)
    station.advance(2.0)
    for axis in station.nc:
        assert axis.actual_position == pytest.approx(10.0, abs=1e-2)


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"drive": [{"axis": 1}]}, r"drive\[1\]: expected a table \[\[bus\]\]"),
        ({"bus": [{}], "drive": [{"axis": 9}]}, r"drive\[1\].axis: expected an axis"),
        ({"bus": [{}], "drive": [{"axis": "Q"}]}, "expected an axis of the NC, got 'Q'"),
        ({"bus": [{}], "drive": [{"axis": 1}, {"axis": "A"}]}, "has a drive already"),
        ({"bus": [{}], "drive": [{"axis": 1, "bus": "B"}]}, r"drive\[1\].bus: expected one of"),
        ({"bus": [{"name": "a"}, {"name": "a"}]}, "bus.name"),
        ({"bus": [{}], "drive": [{"axis": 1, "outputs": [0x6040]}]}, "csp needs 607Ah"),
    ],
)
def test_what_does_not_fit_is_reported(document: dict[str, Any], message: str) -> None:
    axes = [{"id": 1, "name": "A", **AXIS}]
    with pytest.raises(ConfigError, match=message):
        Station(parse({"axis": axes} | document, "test"))


def test_the_example_moves() -> None:
    station = Station.load(Path(__file__).parents[3] / "examples" / "drives" / "station.toml")
    enable_axes(station)
    assert station.nc is not None
    for axis in station.nc:
        assert commands.start(axis, StartType.ABSOLUTE, 40.0, 100.0) == 0
    station.advance(3.0)
    for axis in station.nc:
        assert axis.actual_position == pytest.approx(40.0, abs=0.1), axis
