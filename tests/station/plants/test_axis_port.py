"""Axes that units move."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes.axis import StartType
from achse.drive.power import PowerState, state_of
from achse.motion import Axis, commands
from achse.station import Station
from achse.station.plants.axis_port import statusword

FEED = 10.0 / math.tau
"""mm for a radian: 10 mm a turn."""

STATION = """
[nc]
cycle = "1ms"
[[axis]]
id = 1
name = "X"
max_velocity = 500.0
default_acceleration = 2000.0
default_deceleration = 2000.0
default_jerk = 20000.0
[[fmu]]
name = "axis"
file = "{file}"
[[fmu.axis]]
axis = "X"
mode = "{mode}"
command = "{command}"
position = "{position}"
{velocity}
scale = {scale}
{more}
"""

TORQUE = {
    "file": "two_mass.fmu",
    "mode": "torque",
    "command": "motor.torque",
    "position": "motor.phi",
    "velocity": 'velocity = "motor.w"',
    "scale": FEED,
    "more": "rated_torque = 1.0\nvelocity_bandwidth = 40.0\ntorque_per_acceleration = "
    + str(1000.0 * 2e-3 / FEED),
}
POSITION = {
    "file": "wild.fmu",
    "mode": "position",
    "command": "added",
    "position": "value",
    "velocity": "",
    "scale": 1.0,
    "more": "",
}
VELOCITY = {
    "file": "conveyor.fmu",
    "mode": "velocity",
    "command": "speed",
    "position": "position",
    "velocity": "",
    "scale": 1000.0,
    "more": "",
}


def station_with(folder: Path, keys: dict[str, object]) -> Station:
    file = folder / "station.toml"
    file.write_text(STATION.format(**keys))
    return Station.load(file)


def enabled(station: Station) -> Axis:
    """The axis, ready to move."""
    assert station.nc is not None
    axis = station.nc.axis(1)
    station.advance(0.1)
    axis.control_dword, axis.velocity_override = 7, 1_000_000
    station.advance(0.2)
    assert station.missing_condition(1) == ""
    return axis


@pytest.mark.parametrize("keys", [TORQUE, VELOCITY], ids=["torque", "velocity"])
def test_axis_moves_its_unit(put_unit: Callable[..., Path], keys: dict[str, object]) -> None:
    station = station_with(put_unit("two_mass", "conveyor"), keys)
    axis = enabled(station)
    commands.start(axis, StartType.ABSOLUTE, 100.0, 200.0)
    lag = 0.0
    for _ in range(1000):
        station.advance(0.001)
        lag = max(lag, abs(axis.set_position - axis.actual_position))
    assert axis.error_code == 0
    assert 0.0 < lag < 12.0
    assert axis.actual_position == pytest.approx(100.0, abs=0.05)
    plant = station.plants["axis"]
    assert plant.outputs[0] * float(str(keys["scale"])) == pytest.approx(
        axis.actual_position, abs=1e-3
    )


def test_axis_begins_where_its_unit_is(put_unit: Callable[..., Path]) -> None:
    station = station_with(put_unit("conveyor"), VELOCITY | {"more": "offset = 25.0"})
    assert station.nc is not None
    station.advance(0.1)
    assert station.nc.axis(1).actual_position == pytest.approx(25.0)


def test_disabled_drive_has_no_command(put_unit: Callable[..., Path]) -> None:
    station = station_with(put_unit("two_mass"), TORQUE)
    axis = enabled(station)
    commands.start(axis, StartType.ABSOLUTE, 100.0, 200.0)
    station.advance(0.3)
    assert station.plants["axis"].inputs[0] != 0.0
    axis.control_dword = 0
    station.advance(0.5)
    assert station.plants["axis"].inputs[0] == 0.0


def test_failed_unit_is_an_error_of_its_axis(put_unit: Callable[..., Path]) -> None:
    station = station_with(put_unit("conveyor"), VELOCITY)
    axis = enabled(station)
    commands.start(axis, StartType.ABSOLUTE, 100.0, 200.0)
    station.advance(0.2)
    station.plants["axis"]._process._process.kill()
    station.advance(0.1)
    assert axis.error_code == 0x4655  # invalid data of the drive
    why = station.missing_condition(1)
    assert why.startswith("its fmu axis has failed: its process ended by signal 9")
    station.advance(0.5)  # the station goes on


def test_position_that_no_encoder_has_is_an_error_of_its_axis(
    put_unit: Callable[..., Path],
) -> None:
    station = station_with(put_unit("conveyor"), VELOCITY)
    axis = enabled(station)
    plant = station.plants["axis"]
    ask = plant._process.step

    def step(*arguments: Any) -> list[float]:
        return [1e308 for _ in ask(*arguments)]

    plant._process.step = step  # type: ignore[method-assign, assignment]
    station.advance(0.1)
    assert axis.error_code == 0x4655
    assert math.isfinite(axis.actual_position)
    assert "position: expected a position of at most 2^53 increments" in station.missing_condition(
        1
    )
    station.advance(0.1)


def test_equal_stations_have_equal_digests(put_unit: Callable[..., Path]) -> None:
    folder = put_unit("two_mass")
    digests = set()
    for chunk in (0.001, 0.05):
        station = station_with(folder, TORQUE)
        axis = enabled(station)
        commands.start(axis, StartType.ABSOLUTE, 50.0, 200.0)
        for _ in range(round(0.5 / chunk)):
            station.advance(chunk)
        digests.add(station.digest())
    assert len(digests) == 1


def test_restart_begins_with_a_fresh_unit(put_unit: Callable[..., Path]) -> None:
    station = station_with(put_unit("conveyor"), VELOCITY)
    enabled(station)
    first = station.plants["axis"]
    station.restart()
    station.advance(2.0)
    assert station.plants["axis"] is not first
    assert station.plants["axis"].time_ns < first.time_ns + 2_000_000_000
    enabled(station)


@given(st.integers(0, 0xFFFF))
def test_statusword_shows_the_state_that_the_controlword_wants(controlword: int) -> None:
    state = state_of(statusword(controlword))
    low = controlword & 0xF
    expected = {
        0x6: PowerState.READY_TO_SWITCH_ON,
        0xE: PowerState.READY_TO_SWITCH_ON,
        0x7: PowerState.SWITCHED_ON,
        0xF: PowerState.OPERATION_ENABLED,
    }.get(low, PowerState.SWITCH_ON_DISABLED)
    assert state is expected
