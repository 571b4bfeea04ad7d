"""[[channel]] and [[group]] in a station.toml."""

from pathlib import Path
from typing import Any

import pytest

from achse.motion.groups.kinematic import KinematicGroup
from achse.motion.groups.path_group import PathGroup
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse

AXES = [{"id": n, "name": f"A{n}"} for n in (1, 2, 3)]


def station_with(tmp_path: Path, **tables: Any) -> Station:
    return Station(parse({"axis": AXES, **tables}, "here"), base=tmp_path)


def test_a_station_has_the_groups_it_describes(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "NUMBERS = {'ratio': 2.0}\n"
        "def forward(n, a, p):\n    p[0] = n[0] * a[0]\n    return 1\n"
        "def inverse(n, p, a):\n    a[0] = p[0] / n[0]\n    return 1\n"
    )
    station = station_with(
        tmp_path,
        channel=[{"id": 4, "type": "fifo"}, {"id": 5, "type": "kinematic", "name": "Robot"}],
        group=[
            {"id": 20, "type": "fifo", "channel": 4, "dimension": 3, "axes": [1, 0, 2]},
            {
                "id": 21,
                "type": "kinematic",
                "channel": 5,
                "kinematics": "mine.py",
                "numbers": {"ratio": 3.0},
            },
        ],
    )
    assert station.nc is not None
    assert station.nc.groups.group(20).ids == [1, 0, 2]
    group = station.nc.groups.group(21)
    assert isinstance(group, KinematicGroup)
    assert group.forward([2.0] + [0.0] * 7) == [6.0] + [0.0] * 7
    assert station.nc.channels.ids() == [1, 4, 5]
    assert group.channel.name == "Robot"


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"group": [{"id": 20, "channel": 4}]}, "no channel 4"),
        ({"channel": [{"id": 1}], "group": [{"id": 1, "channel": 1}]}, "PTP group"),
        ({"channel": [{"id": 1}, {"id": 1}]}, "channel.id: each once"),
        ({"channel": [{"id": 1}], "group": [{"id": 20, "channel": 1, "kind": "3d"}]}, "no such"),
        (
            {
                "channel": [{"id": 1, "type": "kinematic"}],
                "group": [{"id": 20, "channel": 1, "type": "kinematic", "kinematics": "arm.py"}],
            },
            "arm.py",
        ),
    ],
)
def test_what_cannot_be(tmp_path: Path, tables: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        station_with(tmp_path, **tables)


@pytest.mark.parametrize(("keys", "keep_jerk"), [({}, False), ({"keep_jerk": True}, True)])
def test_group_keeps_jerk_if_its_table_says_so(
    tmp_path: Path, keys: dict[str, bool], keep_jerk: bool
) -> None:
    station = station_with(tmp_path, channel=[{"id": 1}], group=[{"id": 20, "channel": 1, **keys}])
    assert station.nc is not None
    group = station.nc.groups.group(20)
    assert isinstance(group, PathGroup)
    assert group.keep_jerk == group.path_parameters.keep_jerk == keep_jerk


def test_the_demo_station_has_a_channel_with_an_interpreter() -> None:
    station = Station.demo()
    assert station.nc is not None
    channel = station.nc.channels.channel(1)
    assert (channel.type, channel.interpreter_type, channel.group_ids) == (2, 2, [11])
