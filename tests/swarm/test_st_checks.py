"""Invariants in Structured Text: outputs that are FALSE are reported, mistakes are named."""

from pathlib import Path

import pytest

from achse.motion import commands
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.swarm.project import load_checks
from achse.swarm.worlds.world import WorldError

MINE = """PROGRAM Mine
VAR_INPUT
  Ram_set_velocity : LREAL;
END_VAR
VAR_OUTPUT
  bSlow : BOOL;
  bSeldom : BOOL;
END_VAR
VAR
  nLooks : UDINT;
END_VAR
nLooks := nLooks + 1;
bSlow := ABS(Ram_set_velocity) < 40.0;
bSeldom := nLooks < 3;
END_PROGRAM
"""


def _press() -> Station:
    values = {"velocity_override": 1_000_000, "control_dword": 7, "max_velocity": 100.0}
    station = Station(parse({"axis": [{"id": 1, "name": "Ram", **values}]}, "press"))
    station.advance(0.1)
    return station


def test_outputs_are_checked_with_the_values_of_axes(tmp_path: Path) -> None:
    (tmp_path / "mine.st").write_text(MINE)
    (_, slow), (_, seldom) = checks = load_checks(tmp_path / "mine.st")
    assert [name for name, _ in checks] == ["bSlow", "bSeldom"]
    station = _press()
    assert slow(station) is None
    assert seldom(station) is None
    assert station.nc is not None
    assert commands.universal_start(station.nc.axis(1), 3, 0.0, 90.0) == 0
    station.advance(5.0)
    assert slow(station) == "bSlow is FALSE"
    assert slow(station) == "bSlow is FALSE"
    assert seldom(station) == "bSeldom is FALSE"
    fresh = _press()
    assert slow(fresh) is None
    assert seldom(fresh) is None


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (MINE.replace("PROGRAM Mine", "FUNCTION_BLOCK Mine"), "expected one PROGRAM"),
        (MINE.replace("VAR_OUTPUT", "VAR"), "expected outputs of type BOOL"),
        (MINE.replace("nLooks + 1", "nLooks +"), "mine.st"),
    ],
)
def test_program_that_is_none_is_refused(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "mine.st").write_text(text)
    with pytest.raises(WorldError, match=expected):
        load_checks(tmp_path / "mine.st")


def test_input_without_an_axis_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.st").write_text(MINE.replace("Ram_", "Rum_"))
    ((_, slow), _) = load_checks(tmp_path / "mine.st")
    with pytest.raises(WorldError, match="got Rum_set_velocity"):
        slow(_press())
