"""Worlds around the station of a user, and invariants of the user."""

from pathlib import Path

import pytest

from achse.swarm.play import play
from achse.swarm.project import draw_project_world, load_checks, station_file
from achse.swarm.worlds.world import WorldError

STATION = '[[axis]]\nid = 1\nname = "X"\nmax_velocity = 100.0\n'


def test_world_has_the_axes_of_the_project(tmp_path: Path) -> None:
    (tmp_path / "station.toml").write_text(STATION)
    world = draw_project_world(3, tmp_path)
    assert [axis.name for axis in world.axes] == ["X"]
    assert world.axes[0].values["max_velocity"] == 100.0
    assert world == draw_project_world(3, tmp_path / "station.toml")
    assert world.acts
    assert play(world).violation is None


@pytest.mark.parametrize(
    ("station", "message"),
    [("", "with an axis"), ('[[axis]]\nid = 2\nname = "X"\n', "ids 1, 2")],
)
def test_station_that_does_not_fit_is_refused(tmp_path: Path, station: str, message: str) -> None:
    (tmp_path / "station.toml").write_text(station)
    with pytest.raises(WorldError, match=message):
        draw_project_world(1, tmp_path)


def test_folder_without_a_station_is_refused(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match=r"expected a station\.toml"):
        station_file(tmp_path)


@pytest.mark.parametrize(
    ("name", "source", "message"),
    [
        ("mine.txt", "", "file .py or .st"),
        ("mine.py", "x = 1", "expected functions check_"),
        ("mine.py", "1 / 0", "ZeroDivisionError"),
    ],
)
def test_file_without_checks_is_refused(
    tmp_path: Path, name: str, source: str, message: str
) -> None:
    (tmp_path / name).write_text(source)
    with pytest.raises(WorldError, match=message):
        load_checks(tmp_path / name)


def test_checks_of_a_file_are_its_functions(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "def check_a(station):\n    return 'no'\n\ndef other():\n    pass\n"
    )
    ((name, check),) = load_checks(tmp_path / "mine.py")
    assert (name, check(None)) == ("check_a", "no")  # type: ignore[arg-type]
